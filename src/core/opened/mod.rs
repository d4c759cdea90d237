//! Opened: a site whose archive was checked as a whole. In: blocks and a manifest. Out: settings,
//! materials and mirrors as values in range, and layers of receivers and cells whose references
//! exist. Later code trusts these values and does not check them again. From two sites: the
//! matching of their receivers. Never: light, weather.

mod cell_source;
mod matching;
mod materials;
mod name_index;
mod open_site;
pub(crate) mod receiver_layers;
mod seen_objects;
mod settings;

pub use cell_source::CellSource;
pub use matching::{ReceiverMatching, ReceiverPair, ReceiverPlace, SAME_NORMAL_DEG, SAME_PLACE_M};
pub use name_index::{NameIndex, tiles_within};
pub use open_site::{OpenSite, SiteFacts};
pub use seen_objects::{CellTriangles, SceneObjects, SeenObject, SurfaceOf};
pub use settings::SiteSettings;
