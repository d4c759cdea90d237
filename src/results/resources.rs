//! Resources of a computation: memory, temporary storage, access to files, and the observer.

use std::path::Path;

use heliotile_core::error::Result;
use heliotile_core::light::scratch::ScratchSpace;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::{Observer, Silent};
use heliotile_core::replay::schedule_csv::ReadFile;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_files::input;
use heliotile_files::input::weather::weather_files;
use heliotile_files::spill::SystemTemp;
use heliotile_weather::formats::weather_file::{ScenePlace, parse_weather_as};
use heliotile_weather::series::Weather;

/// Memory, temporary storage, access to files, and the observer of a computation.
#[derive(Clone, Copy)]
pub struct Resources<'a> {
    /// Limit of working memory.
    pub memory: MemoryBudget,
    /// Temporary storage for what does not fit into memory.
    pub storage: &'a dyn ScratchSpace,
    /// Function that reads the bytes of a file.
    pub files: ReadFile<'a>,
    /// Receiver of warnings and progress, which may also stop the work.
    pub observer: &'a dyn Observer,
}

impl Resources<'static> {
    /// Returns 4 GiB of memory, the system's folder for temporary files, and an observer that
    /// ignores all messages.
    pub fn usual() -> Self {
        Resources::new(MemoryBudget::DEFAULT, &Silent)
    }
}

impl<'a> Resources<'a> {
    /// Reads a weather file, or the files in a folder as one series, and warns of doubtful values.
    /// `place` is the place of the scene, which is used if a file states none.
    pub fn weather(&self, path: &Path, options: &WeatherOptions, place: ScenePlace) -> Result<Weather> {
        let mut read = |path: &Path| parse_weather_as(path, &(self.files)(path)?, options, &mut *place);
        let weather = match path.is_dir() {
            true => {
                let files = weather_files(path)?.into_iter();
                Weather::joined(files.map(|file| Ok((file.clone(), read(&file)?))).collect::<Result<_>>()?)?
            }
            false => read(path)?,
        };
        weather.report.warnings.iter().for_each(|text| self.observer.warn(text));
        Ok(weather)
    }

    /// Returns resources on this machine: memory, temporary files of the system, files on disk.
    pub fn new(memory: MemoryBudget, observer: &'a dyn Observer) -> Self {
        Resources { memory, storage: &SystemTemp, files: &input::read, observer }
    }
}
