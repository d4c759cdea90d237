//! Study: scenes with known answers, and maps of the hemisphere that heliotile does not use. In: a wall, a number of rays. Out: its form
//! factor, traced and in closed form. For `study` only.

pub mod form_factor;
pub mod mapping;
pub mod wall;
