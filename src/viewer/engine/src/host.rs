//! Bytes of the archive, which the host holds: a server, a file, memory. In: ranges. Out: their
//! bytes, or an error. The host keeps the reason of an error.

use std::io;

use heliotile_core::archive::ReadAt;
use heliotile_core::archive::format::Entry;

/// Largest gap between two blocks that are announced as one range, bytes.
const GAP: u64 = 1 << 16;

#[link(wasm_import_module = "host")]
unsafe extern "C" {
    /// Writes `length` bytes of the archive from `offset` on to `to`, in this memory. Returns 0, or
    /// 1 if the host cannot provide them.
    safe fn read(offset: f64, to: *mut u8, length: usize) -> u32;
    /// Announces bytes of the archive that will be read soon.
    safe fn expect(offset: f64, length: f64);
}

/// Archive of the host.
#[derive(Debug)]
pub struct HostBytes {
    length: u64,
}

impl HostBytes {
    /// Makes the archive of a host that holds `length` bytes.
    pub fn new(length: u64) -> Self {
        HostBytes { length }
    }
}

impl ReadAt for HostBytes {
    fn length(&self) -> u64 {
        self.length
    }

    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        // An f64 is exact up to 2^53, more than hosts can count.
        match read(offset as f64, bytes.as_mut_ptr(), bytes.len()) {
            0 => Ok(()),
            _ => Err(io::Error::other("the bytes could not be had")),
        }
    }

    fn expect(&self, blocks: &[Entry]) {
        let mut ranges: Vec<(u64, u64)> =
            blocks.iter().map(|block| (block.offset, block.offset.saturating_add(block.stored.into()))).collect();
        ranges.sort_unstable();
        ranges.dedup_by(|next, before| {
            let joins = next.0 <= before.1.saturating_add(GAP);
            if joins {
                before.1 = before.1.max(next.1);
            }
            joins
        });
        for (start, end) in ranges {
            expect(start as f64, (end - start) as f64);
        }
    }
}
