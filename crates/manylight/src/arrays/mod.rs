//! Named arrays of numbers: what files keep of sums and of virtual lights.

mod records;

pub use records::FoundArray;
pub(crate) use records::{
    Fields, Record, arrays_of_records, read_floats, read_words, records_of_arrays,
};

use std::fmt;

/// Values of an array, in row order.
#[derive(Clone, Debug, PartialEq)]
pub enum ArrayValues {
    /// Floating-point numbers of 64 bits.
    F64(Vec<f64>),
    /// Floating-point numbers of 32 bits.
    F32(Vec<f32>),
    /// Counts and ids.
    U32(Vec<u32>),
}

/// A named array. Its values are made when they are asked for, so that a file can be written with
/// few of them in memory.
pub struct NamedArray<'a> {
    /// Name.
    pub name: String,
    /// Length of each dimension.
    pub shape: Vec<usize>,
    values: Source<'a>,
}

/// What makes the values of an array.
enum Source<'a> {
    F64(Box<dyn Fn() -> Vec<f64> + 'a>),
    F32(Box<dyn Fn() -> Vec<f32> + 'a>),
    U32(Box<dyn Fn() -> Vec<u32> + 'a>),
}

/// The type of the values of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArrayKind {
    /// [`ArrayValues::F64`].
    F64,
    /// [`ArrayValues::F32`].
    F32,
    /// [`ArrayValues::U32`].
    U32,
}

/// Arrays that cannot be used: the name of one, and what is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InvalidArray {
    /// Name of the array.
    pub name: String,
    /// What was found and what was expected.
    pub message: String,
}

impl<'a> NamedArray<'a> {
    /// An array of doubles.
    pub fn doubles<I: IntoIterator<Item = f64>>(
        name: impl Into<String>,
        shape: impl Into<Vec<usize>>,
        values: impl Fn() -> I + 'a,
    ) -> Self {
        let values = Box::new(move || values().into_iter().collect());
        NamedArray::new(name, shape, Source::F64(values))
    }

    /// An array of floats.
    pub fn floats<I: IntoIterator<Item = f32>>(
        name: impl Into<String>,
        shape: impl Into<Vec<usize>>,
        values: impl Fn() -> I + 'a,
    ) -> Self {
        let values = Box::new(move || values().into_iter().collect());
        NamedArray::new(name, shape, Source::F32(values))
    }

    /// An array of counts or ids.
    pub fn words<I: IntoIterator<Item = u32>>(
        name: impl Into<String>,
        shape: impl Into<Vec<usize>>,
        values: impl Fn() -> I + 'a,
    ) -> Self {
        let values = Box::new(move || values().into_iter().collect());
        NamedArray::new(name, shape, Source::U32(values))
    }

    fn new(name: impl Into<String>, shape: impl Into<Vec<usize>>, values: Source<'a>) -> Self {
        NamedArray {
            name: name.into(),
            shape: shape.into(),
            values,
        }
    }

    /// The values.
    pub fn values(&self) -> ArrayValues {
        match &self.values {
            Source::F64(values) => ArrayValues::F64(values()),
            Source::F32(values) => ArrayValues::F32(values()),
            Source::U32(values) => ArrayValues::U32(values()),
        }
    }

    /// The type of the values.
    pub fn kind(&self) -> ArrayKind {
        match self.values {
            Source::F64(_) => ArrayKind::F64,
            Source::F32(_) => ArrayKind::F32,
            Source::U32(_) => ArrayKind::U32,
        }
    }

    /// Number of values.
    pub fn count(&self) -> usize {
        self.shape.iter().product()
    }
}

impl ArrayValues {
    /// Number of values.
    pub fn count(&self) -> usize {
        match self {
            ArrayValues::F64(values) => values.len(),
            ArrayValues::F32(values) => values.len(),
            ArrayValues::U32(values) => values.len(),
        }
    }

    /// The type.
    pub fn kind(&self) -> ArrayKind {
        match self {
            ArrayValues::F64(_) => ArrayKind::F64,
            ArrayValues::F32(_) => ArrayKind::F32,
            ArrayValues::U32(_) => ArrayKind::U32,
        }
    }
}

impl InvalidArray {
    /// What is wrong with the array `name`.
    pub fn new(name: impl Into<String>, message: impl Into<String>) -> Self {
        InvalidArray {
            name: name.into(),
            message: message.into(),
        }
    }

    /// Other values than `count` of `kind`.
    pub(crate) fn unexpected(
        name: &str,
        found: &ArrayValues,
        kind: ArrayKind,
        count: usize,
    ) -> Self {
        let (found_count, found_kind) = (found.count(), found.kind());
        let message = format!("found {found_count} {found_kind}, expected {count} {kind}");
        InvalidArray::new(name, message)
    }
}

impl ArrayKind {
    /// Bytes of a value.
    pub fn bytes(self) -> usize {
        match self {
            ArrayKind::F64 => size_of::<f64>(),
            ArrayKind::F32 => size_of::<f32>(),
            ArrayKind::U32 => size_of::<u32>(),
        }
    }
}

impl fmt::Display for ArrayKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ArrayKind::F64 => "floating-point numbers of 64 bits",
            ArrayKind::F32 => "floating-point numbers of 32 bits",
            ArrayKind::U32 => "whole numbers",
        })
    }
}

impl fmt::Debug for NamedArray<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {:?}", self.name, self.shape)
    }
}

impl fmt::Display for InvalidArray {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "array {}: {}", self.name, self.message)
    }
}

impl std::error::Error for InvalidArray {}
