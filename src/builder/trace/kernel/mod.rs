//! Kernel: rays against triangles. In: a mesh, rays. Out: the first hit of each ray, or only if it
//! hits anything. Packets of sixteen rays traverse the tree together; single rays are their
//! reference.

pub(crate) mod beam;
mod candidates;
pub(crate) mod fan;
pub mod lanes;
pub(crate) mod packet;
mod planes;
pub mod ray;
pub mod rays;
pub(crate) mod scan;
pub(crate) mod tree;
mod triangle;
mod walk;
