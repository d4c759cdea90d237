//! Outputs: one model of rows for all tables, as CSV, Parquet, Arrow or NumPy arrays; pictures of a
//! receiver's layers; curves.
//!
//! In: receivers, labels (conditions, hours or periods) and f32 values of each pair, one a column;
//! maps of a receiver. Out: a file, complete or not there at all, or CSV on standard output. Never:
//! physics, except the conversion of means over hours to sums of energy.

pub mod annual;
pub mod area_means;
pub mod buildings;
pub mod city_model;
pub mod factors;
pub mod groups;
pub mod honeybee;
pub mod kinds_and_sides;
pub mod markup;
pub mod page;
pub mod periods;
pub mod pictures;
pub mod provenance;
pub mod pv;
pub mod quantities;
pub mod receivers;
pub mod result_file;
pub mod row_maker;
pub mod shading;
pub mod shapes;
pub mod sink;
pub mod stac;
pub mod tables;
pub mod view_factors;
pub mod viewer_page;
