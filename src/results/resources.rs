//! What a computation may use, and whom it tells.

use heliotile_builder::spill::SystemTemp;
use heliotile_core::light::scratch::ScratchSpace;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::{Observer, Silent};
use heliotile_core::weather::formats::schedule_csv::ReadFile;
use heliotile_scene::input;

/// What a computation may use, and whom it tells.
#[derive(Clone, Copy)]
pub struct Resources<'a> {
    /// Bytes to work in.
    pub memory: MemoryBudget,
    /// Room for what does not fit into memory.
    pub storage: &'a dyn ScratchSpace,
    /// How the bytes of files are read.
    pub files: ReadFile<'a>,
    /// Whom warnings and progress are told, and who may stop the work.
    pub observer: &'a dyn Observer,
}

impl Resources<'static> {
    /// 4 GiB, the system's folder for temporary files, and nobody to tell.
    pub fn usual() -> Self {
        Resources { memory: MemoryBudget::DEFAULT, storage: &SystemTemp, files: &input::read, observer: &Silent }
    }
}
