//! Names of content: BLAKE3 over values in canonical little-endian form, each list after its length, so that equal content has one
//! name whatever order or file it came in.

use glam::DVec3;

/// What has been taken so far.
#[derive(Clone, Debug, Default)]
pub struct ContentHasher(blake3::Hasher);

impl ContentHasher {
    /// Begins with the name of what is hashed and of its layout.
    pub fn new(layout: &str) -> Self {
        let mut content = ContentHasher::default();
        content.bytes(layout.as_bytes());
        content
    }

    /// The length of a list whose items follow.
    pub fn length(&mut self, length: usize) {
        self.raw(&(length as u64).to_le_bytes());
    }

    /// A string of bytes after its length.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.length(bytes.len());
        self.raw(bytes);
    }

    /// A number; -0.0 counts as 0.0.
    pub fn number(&mut self, number: f64) {
        // + 0.0 turns -0.0 into 0.0.
        self.raw(&(number + 0.0).to_le_bytes());
    }

    /// A point or vector, to the bit.
    pub fn point(&mut self, point: &DVec3) {
        point.to_array().iter().for_each(|part| self.raw(&part.to_le_bytes()));
    }

    /// Bytes of a length that is known.
    pub fn raw(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// The name.
    pub fn finish(&self) -> [u8; 32] {
        *self.0.finalize().as_bytes()
    }
}
