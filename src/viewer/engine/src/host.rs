//! Bytes of the archive, which the host holds: a server, a file, memory. In: ranges. Out: their bytes, or an error; why, the host keeps.

use std::io;

use heliotile_core::archive::ReadAt;

#[link(wasm_import_module = "host")]
unsafe extern "C" {
    /// Writes `length` bytes of the archive from `offset` on to `to`, in this memory: 0, or 1 if they cannot be had.
    safe fn read(offset: f64, to: *mut u8, length: usize) -> u32;
}

/// The archive of the host.
#[derive(Debug)]
pub struct HostBytes {
    length: u64,
}

impl HostBytes {
    /// Of so many bytes.
    pub fn new(length: u64) -> Self {
        HostBytes { length }
    }
}

impl ReadAt for HostBytes {
    fn length(&self) -> u64 {
        self.length
    }

    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        // Exact up to 2^53, more than hosts can count.
        match read(offset as f64, bytes.as_mut_ptr(), bytes.len()) {
            0 => Ok(()),
            _ => Err(io::Error::other("the bytes could not be had")),
        }
    }
}
