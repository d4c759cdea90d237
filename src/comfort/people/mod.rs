//! People of an archive. In: receivers with their names and skies, the light of each, the air of an
//! hour. Out: mean radiant temperature, UTCI and PET of each point, as the results and the page
//! show them.
//!
//! | file | content |
//! | --- | --- |
//! | `columns` | columns of results of a point |
//! | `points` | receivers that are the six planes of a point |
//! | `views` | surroundings that each plane sees |
//! | `surfaces` | materials that each plane sees |
//! | `model` | model of people and surfaces, equal in all hours |
//! | `climate` | air and surroundings of an hour, and the indices of that hour |
//! | `periods` | means, highest values and hours above thresholds of days and longer |
//! | `light` | radiation at a point, and its values in each hour |

pub mod climate;
pub mod columns;
pub mod light;
pub mod model;
pub mod periods;
pub mod points;
pub mod surfaces;
pub mod views;
