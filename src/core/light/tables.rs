//! Data that responses are derived from. In: a site that was opened. Out: its settings, the optics
//! of its materials and mirrors, and its cells, which stay in their blocks until they are needed.

use crate::error::Result;
use crate::light::mirrors::MirrorTable;
use crate::light::reflector::Reflector;
use crate::opened::{CellSource, OpenSite, SiteSettings};

/// Settings, materials, mirrors and cells of a site.
pub struct Tables<'a> {
    /// Sides of textures, rays of cells, the closed level.
    pub settings: SiteSettings,
    /// Orientations of the mirrors, and reflectances of the materials.
    pub mirrors: MirrorTable,
    /// The cells that receivers see.
    pub probes: CellSource<'a>,
    /// The coarser cells that probes and bounce cells see.
    pub bounces: CellSource<'a>,
}

impl<'a> Tables<'a> {
    /// Returns the tables of a site; reads the indices of its cells.
    pub fn new(site: &OpenSite<'a>) -> Result<Self> {
        Ok(Tables {
            settings: *site.settings(),
            mirrors: MirrorTable::new(site),
            probes: CellSource::probes(site)?,
            bounces: CellSource::bounces(site)?,
        })
    }

    /// Returns the tables with mirrors that reflect nothing.
    pub fn without_mirrors(mut self) -> Self {
        self.mirrors.reflectors.iter_mut().for_each(|reflector| {
            *reflector = Reflector { specular: 0.0, panes: 0, ..*reflector };
        });
        self
    }
}
