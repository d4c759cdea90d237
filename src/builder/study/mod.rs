//! Study: scenes with known answers, and hemisphere maps that archives do not use. In: a wall, a
//! number of rays. Out: its form factor, traced and in closed form. For `study` only.

pub mod form_factor;
pub mod mapping;
pub mod wall;
