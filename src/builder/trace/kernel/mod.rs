//! The kernel: rays against triangles. In: a mesh, rays. Out: what they meet first, or whether they meet anything. Packets of sixteen rays
//! walk the tree together; single rays are the reference that they are judged by.

pub(crate) mod beam;
mod candidates;
pub(crate) mod fan;
pub mod lanes;
pub(crate) mod packet;
mod planes;
pub mod rays;
pub(crate) mod scan;
pub(crate) mod tree;
mod triangle;
mod walk;
