//! Solar envelope: the largest building on a plot that leaves the places around it their sun. In:
//! an archive of the site with an empty plot, hours or rules. Out: heights on a grid of the plot,
//! as a table and as a mesh.
//!
//! No ray is traced. The archive says when each place sees the sun. Of these minutes a place keeps
//! as many as are asked for, those that cost the building least; the planes of the sun's rays of
//! the kept minutes are the envelope (R. L. Knowles, "The solar envelope: its meaning for energy
//! and buildings", Energy and Buildings 35, 2003, pages 15 to 25).

mod choice;
mod day_steps;
mod grid;
mod request;
mod solid;

pub use request::{EnvelopeDone, EnvelopeRequest};
