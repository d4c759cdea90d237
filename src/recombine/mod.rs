//! Recombination: what `query`, `replay` and the Python package are made of. In: an archive, and suns or weather. Out: tiles of irradiance, and
//! labels of what they hold. Never: the command line, what is printed, files of results.

mod chosen;
mod doubts;
mod factors;
mod series;
mod streamed;

pub use chosen::{Chosen, ChosenPart, ChosenTile};
pub use doubts::{dated_rows, left_out, mean_ground, no_longwave};
pub use factors::FactorRows;
pub use series::{Series, WeatherReading};
pub use streamed::{Recombination, Streamed, replay_of};

pub use crate::outputs::periods::Every;
pub use crate::outputs::provenance::Provenance;
pub use crate::outputs::pv::hourly::{ONE_SIDE, SideHours};
pub use crate::outputs::tables::arrow::{ArrowRows, schema};
pub use crate::outputs::tables::layout::{By, Fact, Labels, Layout};
pub use crate::outputs::tables::row_labels::{Instants, Precision, RowLabels};
