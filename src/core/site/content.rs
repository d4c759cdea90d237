//! Hashes of content. In: values. Out: BLAKE3 over them in canonical little-endian form, each list
//! after its length, so that equal content has one hash in whatever order or file it came.

use glam::DVec3;

/// Hasher of the values added so far.
#[derive(Clone, Debug, Default)]
pub struct ContentHasher(blake3::Hasher);

impl ContentHasher {
    /// Begins a hash with the name of the content and its layout.
    pub fn new(layout: &str) -> Self {
        let mut content = ContentHasher::default();
        content.bytes(layout.as_bytes());
        content
    }

    /// Adds the length of a list whose items follow.
    pub fn length(&mut self, length: usize) {
        self.raw(&(length as u64).to_le_bytes());
    }

    /// Adds a string of bytes after its length.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.length(bytes.len());
        self.raw(bytes);
    }

    /// Adds a number; -0.0 counts as 0.0.
    pub fn number(&mut self, number: f64) {
        // + 0.0 turns -0.0 into 0.0.
        self.raw(&(number + 0.0).to_le_bytes());
    }

    /// Adds a point or vector, exact to the bit.
    pub fn point(&mut self, point: &DVec3) {
        point.to_array().iter().for_each(|part| self.raw(&part.to_le_bytes()));
    }

    /// Adds bytes whose length is known from the layout.
    pub fn raw(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// Returns the hash of everything added.
    pub fn finish(&self) -> [u8; 32] {
        *self.0.finalize().as_bytes()
    }
}
