//! The content of an archive and its replay, with every formula of both.
//!
//! # Map
//!
//! The modules below stand from left to right. None imports one to its right, and no two import
//! each other (a test reads the imports).
//!
//! ```text
//! error units text named memory hemisphere | observer | dome | orientation | site | layers | archive
//!   | opened weather | sky | light | replay
//! ```
//!
//! | module | in | out |
//! | --- | --- | --- |
//! | [`orientation`] | limits of tilt and azimuth, results of some orientations of a surface | orientations to try, and the best one |
//! | [`site`] | numbers of readers and archives | the nouns: cell keys, materials, receivers, chains of mirrors, the place |
//! | [`layers`] | bits, keys, vectors | raw bytes of a tile's blocks, and back |
//! | [`archive`] | bytes of a file, of memory or of a remote | checked blocks by (kind, tile), the manifest, the settings |
//! | [`opened`] | an archive, or blocks that are being written | a site that was checked once: settings, materials, mirrors, layers of tiles |
//! | [`dome`] | bytes of tables and matrices of the sky, pixels of photographs | values of the sky's patches by row, on any subdivision |
//! | [`weather`] | rows, times, places | conditions with the sun's positions |
//! | [`sky`] | a condition, a model | radiances of the sky's patches and texels |
//! | [`light`] | layers and tables of an open site, reflectances | responses: light that arrives by way of surfaces, one vector a sky texel |
//! | [`replay`] | an open site, conditions | irradiance of each receiver by component |
//!
//! # What never happens
//!
//! - No ray is cast: the crate has no ray tracer.
//! - Nothing is printed. Only [`archive::Archive::open`] and [`archive::verify()`] open files:
//!   bytes of archives come through [`archive::ReadAt`], weather and conditions come as bytes, and
//!   the caller gives the temporary storage ([`light::scratch`]).
//! - Nothing is allocated from a number that was not checked. A changed byte is an error that names
//!   the block.
//! - An opened site is checked once ([`opened::OpenSite`]) and trusted from then on.
//! - Results do not depend on the number of threads. Without threads everything runs on one.
//!
//! # Ten words
//!
//! - **receiver**: a point with a normal that gets irradiance.
//! - **cell**: the surfaces of one material that face one way inside one voxel; its key is its
//!   name.
//! - **probe**: the record of a cell that receivers see: which part of the sky it sees, and which
//!   cells around it.
//! - **bounce cell**: a coarser cell that probes see; the closed system of radiosity is made of
//!   them.
//! - **texture**: a square map of a hemisphere, Shirley-Chiu, texels of equal solid angle.
//! - **layer**: one kind of texture; **tile**: 64 neighbouring receivers, whose layers are
//!   compressed together.
//! - **response**: one vector a sky texel; its product with a direction is the diffuse light that a
//!   receiver gets from that texel.
//! - **condition**: the sun's direction, DNI, DHI and the other inputs of an hour; **weather**: a
//!   series of conditions.
//! - **component**: one light path, a column of results; the six components add up to `total`.
//! - **state**: one set of reflectances and transmittances; conditions of one state share a
//!   response.
//! # Features
//!
//! `zstd` (default) reads and writes blocks with the C library; without it `ruzstd` reads them.
//! `mmap` (default) opens files through a mapping. Without both the crate needs no C compiler and
//! builds for `wasm32-unknown-unknown`.

#![deny(missing_docs)]

pub mod archive;
pub mod dome;
pub mod error;
pub mod hemisphere;
pub mod layers;
pub mod light;
pub mod memory;
pub mod named;
pub mod observer;
pub mod opened;
pub mod orientation;
pub mod replay;
pub mod site;
pub mod sky;
pub mod text;
pub mod units;
pub mod weather;
