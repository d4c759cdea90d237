//! Memory that NumPy and Arrow share. In: numbers. Out: a block that NumPy takes as an array without copying, and Arrow as a column.

use arrow_buffer::{ArrowNativeType, Buffer};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// Numbers of one type in rows, read-only: `numpy.asarray(block)` is a view that keeps it alive.
#[pyclass(frozen, module = "heliotile._heliotile")]
pub struct Block {
    buffer: Buffer,
    type_name: &'static str,
    shape: Vec<usize>,
}

/// Numbers that NumPy knows.
pub trait Plain: ArrowNativeType {
    /// As `numpy.dtype` writes it.
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
    /// Of some numbers, row-major; they are not copied.
    pub fn of<T: Plain>(values: Vec<T>, shape: &[usize]) -> Self {
        Block::shared::<T>(Buffer::from_vec(values), shape)
    }

    /// Of memory that others hold too.
    pub fn shared<T: Plain>(buffer: Buffer, shape: &[usize]) -> Self {
        Block { buffer, type_name: T::NAME, shape: shape.to_vec() }
    }
}

#[pymethods]
impl Block {
    /// Where NumPy finds the numbers. The array's `base` is this object, which nobody can change, so that they stay where they are.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let about = PyDict::new(py);
        about.set_item("version", 3)?;
        about.set_item("typestr", self.type_name)?;
        about.set_item("shape", PyTuple::new(py, &self.shape)?)?;
        // Read-only.
        about.set_item("data", (self.buffer.as_ptr().addr(), true))?;
        Ok(about)
    }
}
