//! An open archive, or the open archives of an atlas. In: a path. Out: receivers, their light under
//! weather or conditions, and shading factors over the sun's position.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Frame, Gathered, Recombined};
use crate::asked::{Keywords, Memory};
use crate::errors::raised;
use crate::lazy::LazyReplay;
use crate::memory::Block;
use crate::selection::{PySelection, bounds_of};
use crate::table::columns_of;
use crate::work;
use heliotile::archive::{Archive, format};
use heliotile::atlas::check_square;
use heliotile::cases::{Extract, Factors, Replay};
use heliotile::names::by_name;
use heliotile::{
    Access, ExtractContent, FACTORS, FactorRows, LightSource, PartReceivers, Provenance, ReceiverChoice, Resources,
    Result, Selection, Site, SiteOptions, SiteReplay,
};

/// An open archive, or open parts of an atlas, with the choice of which way is north. Several
/// threads may read it at once.
#[pyclass(frozen, module = "heliotile._heliotile")]
pub struct ArchiveHandle {
    site: Site,
}

/// Name, diffuse and specular reflectance, transmittance, group, class.
type MaterialRow = (String, f64, f64, Option<f64>, Option<String>, String);

/// Names, azimuths and altitudes in degrees, and the values of each factor.
type FactorColumns = (Vec<String>, Vec<f64>, Vec<f64>, Vec<(&'static str, Block)>);

#[pymethods]
impl ArchiveHandle {
    /// Opens an archive; `access` is `map` or `pread`.
    #[staticmethod]
    fn open(py: Python<'_>, place: PathBuf, access: &str, grid_north: bool) -> PyResult<Self> {
        let access: Access = by_name("access", access).map_err(|error| raised(py, error))?;
        let receivers = ReceiverChoice { selection: None, grid_north };
        let options = SiteOptions { access: Some(access), receivers, ..SiteOptions::default() };
        work::run(py, None, |_| Ok(ArchiveHandle { site: Site::open_with(place, options)? }))
    }

    /// Opens the parts of an atlas that a box `xmin, ymin, xmax, ymax[, zmin, zmax]` touches, or
    /// all parts if there is no box.
    #[staticmethod]
    #[pyo3(signature = (atlas, bbox=None, grid_north=false))]
    fn open_atlas(py: Python<'_>, atlas: PathBuf, bbox: Option<Vec<f64>>, grid_north: bool) -> PyResult<Self> {
        work::run(py, None, |_| {
            let selection = bbox.map(bounds_of).transpose()?.map(Selection::Bounds);
            let receivers = ReceiverChoice { selection, grid_north };
            let site = Site::open_with(atlas, SiteOptions { receivers, ..SiteOptions::default() })?;
            Ok(ArchiveHandle { site: site.select(None) })
        })
    }

    /// Checks that the archive is that of the part with this name and square.
    fn check_square(
        &self,
        py: Python<'_>,
        part: &str,
        low: (f64, f64),
        high: (f64, f64),
        reach_m: f64,
    ) -> PyResult<()> {
        work::run(py, None, |_| check_square(self.archive(), part, low.into(), high.into(), reach_m))
    }

    /// Returns the ids of the selected receivers of each archive in turn; `None` if all receivers
    /// of an archive are selected.
    #[pyo3(name = "chosen", signature = (receivers, memory))]
    fn chosen_ids(&self, py: Python<'_>, receivers: PySelection, memory: Memory) -> PyResult<Vec<Option<Vec<String>>>> {
        work::run(py, None, |_| {
            let site = self.chosen(Some(receivers))?;
            let chosen = site.receivers(Path::new("-"), memory.0)?;
            let ids = |part: &PartReceivers| {
                let all = part.count() == part.site.receivers();
                (!all).then(|| part.rows::<()>().map(|row| Ok(row?.receiver.id)).collect()).transpose()
            };
            chosen.parts().iter().map(ids).collect()
        })
    }

    #[getter]
    fn root(&self) -> String {
        format::hex(&self.archive().root())
    }

    #[getter]
    fn tiles(&self) -> u32 {
        self.site.archives().iter().map(Archive::tiles).sum()
    }

    #[getter]
    fn count(&self) -> u64 {
        self.site.count()
    }

    /// Latitude, longitude and convergence of the grid, in degrees, and the EPSG number.
    #[getter]
    fn place(&self) -> Option<(f64, f64, f64, Option<u32>)> {
        let place = self.archive().manifest().place.as_ref()?;
        Some((place.latitude_deg, place.longitude_deg, place.convergence_deg, place.epsg))
    }

    /// Settings of the build and their numbers, the quality first.
    #[getter]
    fn settings(&self) -> Vec<(String, String)> {
        let settings = &self.archive().manifest().settings;
        let quality = ("quality".to_owned(), settings.quality.clone());
        let numbers = settings.numbers().map(|(setting, number)| (setting.name.to_owned(), number.to_string()));
        std::iter::once(quality).chain(numbers).collect()
    }

    /// Returns name, diffuse and specular reflectance, transmittance, group and class of each
    /// material.
    fn materials(&self, py: Python<'_>) -> PyResult<Vec<MaterialRow>> {
        let row = |m: &heliotile::Material| {
            let class = format!("{:?}", m.class).to_lowercase();
            (m.name.clone(), m.diffuse, m.specular, m.transmittance, m.group.clone(), class)
        };
        work::run(py, None, |_| Ok(self.site.materials()?.iter().map(row).collect()))
    }

    /// Returns columns of all or of some receivers, in the order of results.
    #[pyo3(signature = (receivers, memory))]
    fn receivers<'py>(
        &self,
        py: Python<'py>,
        receivers: Option<PySelection>,
        memory: Memory,
    ) -> PyResult<Bound<'py, PyDict>> {
        let columns = work::run(py, None, |_| {
            let site = self.chosen(receivers)?;
            columns_of(site.receivers(Path::new("-"), memory.0)?.rows())
        })?;
        let table = PyDict::new(py);
        columns.into_iter().try_for_each(|(name, column)| table.set_item(name, column))?;
        Ok(table)
    }

    /// Computes irradiance under weather or conditions, all in memory.
    #[pyo3(signature = (asked, receivers, progress))]
    fn replay(
        &self,
        py: Python<'_>,
        asked: Keywords,
        receivers: Option<PySelection>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Recombined> {
        asked.run::<Replay, _>(py, ARCHIVE, progress.as_ref(), |args, about, resources| {
            self.recombined(&args.under()?, receivers, about, resources)
        })
    }

    /// Writes an archive of some receivers and opens it.
    #[pyo3(signature = (asked, receivers, progress))]
    fn extract(
        &self,
        py: Python<'_>,
        asked: Keywords,
        receivers: Option<PySelection>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<ArchiveHandle> {
        asked.run::<Extract, _>(py, &["archive", "receivers"], progress.as_ref(), |args, _, resources| {
            let site = self.chosen(receivers)?;
            let content = ExtractContent { scene: !args.no_scene, replay_only: args.replay_only };
            site.extract(&args.output, content, resources.memory, resources.observer)?;
            ArchiveHandle::just_written(&args.output)
        })
    }

    /// Returns a replay that computes tiles on demand and keeps up to `cache` bytes of them.
    fn lazy(&self, py: Python<'_>, asked: Keywords, cache: usize) -> PyResult<LazyReplay> {
        asked.run::<Replay, _>(py, ARCHIVE, None, |args, about, resources| {
            self.site.only()?;
            let site = self.site.stating(about);
            let replay = site.under(&args.under()?, Path::new("-"), resources)?;
            LazyReplay::new(&self.site, &replay, Frame::new(&replay, self.site.count() as usize), cache)
        })
    }

    /// Computes the five factors over the sun's position. Returns names, azimuths, altitudes, and
    /// `[name][azimuth][altitude]` for each factor. Writes them to a table, if one is named.
    #[pyo3(signature = (asked, receivers, progress))]
    fn factors(
        &self,
        py: Python<'_>,
        asked: Keywords,
        receivers: Option<PySelection>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<FactorColumns> {
        let (names, grid, columns) =
            asked.run::<Factors, _>(py, ARCHIVE, progress.as_ref(), |args, about, resources| {
                let (site, request) = (self.chosen(receivers)?.stating(about), &args.request);
                if request.output != Path::new("-") {
                    site.factors(request, resources)?;
                }
                let chosen = site.receivers(Path::new("-"), resources.memory)?;
                let steps = (request.azimuth_step_deg, request.altitude_step_deg);
                let rows = FactorRows::new(&chosen, steps, request.by, resources)?;
                let grid = *rows.grid();
                let (mut names, mut columns) = (Vec::new(), vec![Vec::new(); FACTORS.len()]);
                rows.each(resources.observer, |name, factors| {
                    names.push(name.to_owned());
                    for sun in factors {
                        columns.iter_mut().zip(sun).for_each(|(column, factor)| column.push(factor));
                    }
                    Ok(true)
                })?;
                work::count_tiles(chosen.parts().iter().map(|part| part.tiles().len()).sum());
                Ok((names, grid, columns))
            })?;
        let (azimuths, altitudes) = (grid.azimuths_deg(), grid.altitudes_deg());
        let shape = [names.len(), azimuths.len(), altitudes.len()];
        let columns = FACTORS.into_iter().zip(columns).map(|(name, values)| (name, Block::new::<f64>(values, &shape)));
        Ok((names, azimuths, altitudes, columns.collect()))
    }
}

/// Field that an open archive fills.
pub const ARCHIVE: &[&str] = &["archive"];

impl ArchiveHandle {
    /// Returns the archive; of an atlas, the first one.
    pub fn archive(&self) -> &Archive {
        self.site.archives().first()
    }

    /// Opens an archive that was just written.
    pub fn just_written(path: &Path) -> Result<Self> {
        let options = SiteOptions { access: Some(Access::default()), ..SiteOptions::default() };
        Ok(ArchiveHandle { site: Site::open_with(path, options)? })
    }

    /// Returns the site with the selected receivers.
    pub fn chosen(&self, receivers: Option<PySelection>) -> Result<Site> {
        Ok(self.site.select(receivers.map(|wanted| wanted.selection()).transpose()?))
    }

    fn recombined(
        &self,
        under: &LightSource,
        receivers: Option<PySelection>,
        about: Provenance,
        resources: &Resources,
    ) -> Result<Recombined> {
        let site = self.chosen(receivers)?.stating(about);
        let replay: SiteReplay = site.under(under, Path::new("-"), resources)?;
        let names = replay.receivers().names()?;
        let frame = Frame::new(&replay, names.len());
        let mut gathered = Gathered::new(&frame);
        replay.stream().feed(&mut gathered)?;
        let columns = gathered.columns();
        Ok(Recombined::new(frame, names, columns))
    }
}
