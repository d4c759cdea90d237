//! Memory that NumPy and Arrow share. In: numbers or texts. Out: a block that NumPy takes as an
//! array and Arrow as a column, without copying.

use arrow_buffer::{ArrowNativeType, Buffer};
use heliotile::{Error, Result};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// Rows of numbers or texts of one type, read-only. `numpy.asarray(block)` is a view that keeps it
/// alive.
#[pyclass(frozen, module = "heliotile._heliotile")]
pub struct Block {
    buffer: Buffer,
    type_name: String,
    shape: Vec<usize>,
}

/// Number type that NumPy knows.
pub trait Plain: ArrowNativeType {
    /// Name of the type for `numpy.dtype`.
    const NAME: &'static str;
}

impl Plain for f32 {
    const NAME: &'static str = "<f4";
}

impl Plain for f64 {
    const NAME: &'static str = "<f8";
}

impl Plain for i64 {
    const NAME: &'static str = "<i8";
}

impl Block {
    /// Takes row-major numbers without copying them.
    pub fn new<T: Plain>(values: Vec<T>, shape: &[usize]) -> Self {
        Block::shared::<T>(Buffer::from_vec(values), shape)
    }

    /// Takes memory that has other owners, too.
    pub fn shared<T: Plain>(buffer: Buffer, shape: &[usize]) -> Self {
        Block { buffer, type_name: T::NAME.to_owned(), shape: shape.to_vec() }
    }
}

/// Texts in one piece of memory, one after the other.
#[derive(Default)]
pub struct Texts {
    all: String,
    /// End of each text, in bytes.
    ends: Vec<usize>,
    /// Length of the longest text, in characters.
    widest: usize,
}

impl Texts {
    pub fn push(&mut self, text: &str) {
        self.all.push_str(text);
        self.ends.push(self.all.len());
        self.widest = self.widest.max(text.chars().count());
    }

    /// Returns the texts in NumPy's layout: each as wide as the longest, 4 bytes a character,
    /// filled with 0 behind its end. Fails if there is not enough memory.
    pub fn block(&self) -> Result<Block> {
        let (count, width) = (self.ends.len(), self.widest.max(1));
        let mut characters: Vec<u32> = Vec::new();
        let room = count.checked_mul(width).filter(|len| characters.try_reserve_exact(*len).is_ok());
        let Some(len) = room else {
            let what = format!("memory for {count} names as wide as the longest, in bytes");
            let value = 4_u64.saturating_mul(count as u64).saturating_mul(width as u64);
            return Err(Error::Limit { what: what.into(), value, max: isize::MAX as u64 });
        };
        characters.resize(len, 0);
        let mut rest = self.all.as_str();
        let mut from = 0;
        for (row, end) in characters.chunks_exact_mut(width).zip(&self.ends) {
            let (text, behind) = rest.split_at(end - from);
            row.iter_mut().zip(text.chars()).for_each(|(to, character)| *to = u32::from(character));
            (rest, from) = (behind, *end);
        }
        Ok(Block { buffer: Buffer::from_vec(characters), type_name: format!("<U{width}"), shape: vec![count] })
    }
}

#[pymethods]
impl Block {
    /// Address, type and shape for NumPy. The array's `base` is this object, which cannot change,
    /// so the memory stays valid.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let about = PyDict::new(py);
        about.set_item("version", 3)?;
        about.set_item("typestr", &self.type_name)?;
        about.set_item("shape", PyTuple::new(py, &self.shape)?)?;
        // Read-only.
        about.set_item("data", (self.buffer.as_ptr().addr(), true))?;
        Ok(about)
    }
}
