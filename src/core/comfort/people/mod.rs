//! People of an archive. In: receivers with their names and skies, the light of each, the air of an hour. Out: mean radiant temperature, UTCI and PET of
//! each point, as the results and the page show them.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `columns` | what can be asked of a point |
//! | `points` | which receivers are the six planes of a point |
//! | `views` | what each plane sees of the heat around it |
//! | `surfaces` | which materials each plane sees |
//! | `model` | how people and surfaces are taken: the same in all hours |
//! | `climate` | air and surroundings of an hour, and the indices of that hour |
//! | `periods` | means, highest values and hours above thresholds of days and longer |
//! | `light` | the light of a point, and its numbers in each hour |

pub mod climate;
pub mod columns;
pub mod light;
pub mod model;
pub mod periods;
pub mod points;
pub mod surfaces;
pub mod views;
