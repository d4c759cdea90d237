//! The Python package's own module, `heliotile._heliotile`. In: arguments that `heliotile/*.py` has
//! converted to plain types. Out: archives, results and tables, in memory that NumPy and Arrow
//! share. Every number comes from the crates that the program's commands call.
//! | file | in | out |
//! | --- | --- | --- |
//! | `work` | long work | its result, without Python's lock, with progress and Ctrl-C |
//! | `errors` | errors of the engine | exceptions of `heliotile.errors`, with the engine's text |
//! | `memory` | numbers | views of them for NumPy and Arrow |
//! | `asked` | keywords as texts | requests of the library |
//! | `archive` | a file | receivers, results, factors |
//! | `selection` | ids, a file, names or a box | selections of the library |
//! | `questions` | a site, keywords | files, and a summary as JSON |
//! | `arrays` | tiles | columns, Arrow, pvlib's names |
//! | `lazy` | an archive and conditions | rows of single receivers, computed tile by tile |
//! | `atlas` | a folder of parts, arguments of the command line | parts; the program |
//! | `studies` | requests | folders of results, archives, problems of archives |
//! | `scene` | files, receivers | a scene; an archive |

mod archive;
mod arrays;
mod asked;
mod atlas;
mod errors;
mod lazy;
mod memory;
mod questions;
mod scene;
mod selection;
mod studies;
mod table;
mod work;

use pyo3::prelude::*;

#[pymodule]
mod _heliotile {
    #[pymodule_export]
    use super::archive::ArchiveHandle;
    #[pymodule_export]
    use super::arrays::FrameHandle;
    #[pymodule_export]
    use super::arrays::Recombined;
    #[pymodule_export]
    use super::atlas::atlas_parts;
    #[pymodule_export]
    use super::atlas::build_part;
    #[pymodule_export]
    use super::atlas::program;
    #[pymodule_export]
    use super::atlas::shown;
    #[pymodule_export]
    use super::lazy::LazyReplay;
    #[pymodule_export]
    use super::memory::Block;
    #[pymodule_export]
    use super::questions::ask;
    #[pymodule_export]
    use super::scene::SceneHandle;
    #[pymodule_export]
    use super::studies::audit;
    #[pymodule_export]
    use super::studies::catalogue;
    #[pymodule_export]
    use super::studies::comfort;
    #[pymodule_export]
    use super::studies::diff;
    #[pymodule_export]
    use super::studies::energyplus;
    #[pymodule_export]
    use super::studies::export;
    #[pymodule_export]
    use super::studies::merge;
    #[pymodule_export]
    use super::studies::partition;
    #[pymodule_export]
    use super::studies::plan;
    #[pymodule_export]
    use super::studies::pv;
    #[pymodule_export]
    use super::studies::receivers;
    #[pymodule_export]
    use super::studies::repair;
    #[pymodule_export]
    use super::studies::report;
    #[pymodule_export]
    use super::studies::run;
    #[pymodule_export]
    use super::studies::tradeoff;
    #[pymodule_export]
    use super::studies::update;
    #[pymodule_export]
    use super::studies::verify;
    #[pymodule_export]
    use super::studies::view;
    #[pymodule_export]
    use super::work::tiles_computed;
    #[pymodule_export]
    use super::work::use_threads;

    use super::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
