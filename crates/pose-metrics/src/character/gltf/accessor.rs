//! Reads the numbers of an accessor with bounds checks, which the crate's own readers lack.

use ::gltf::Accessor;
use ::gltf::accessor::{DataType, Dimensions};
use glam::DMat4;

use super::Buffers;
use crate::character::error::{Refusal, refuse};

/// The elements of an accessor, all of them within its buffer.
pub(super) struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
    data_type: DataType,
    /// Number of values in an element.
    width: usize,
}

impl<'a> Elements<'a> {
    /// Reads the elements of an accessor of one of these types.
    ///
    /// # Errors
    /// [`Refusal`] if the accessor is of another type, sparse, or not within its buffer.
    pub(super) fn new(
        accessor: &Accessor<'_>,
        buffers: &'a Buffers,
        dimensions: Dimensions,
        data_types: &[DataType],
    ) -> Result<Self, Refusal> {
        let item = || format!("accessor {}", accessor.index());
        let (data_type, found) = (accessor.data_type(), accessor.dimensions());
        if found != dimensions || !data_types.contains(&data_type) {
            let expected = format!("{dimensions:?} of {data_types:?}");
            return Err(refuse(item(), expected, format!("{found:?} of {data_type:?}")));
        }
        let view = accessor.view().filter(|_| accessor.sparse().is_none());
        let view = view.ok_or_else(|| refuse(item(), "numbers in a buffer view", "sparse ones"))?;
        let (stride, count) = (view.stride().unwrap_or(accessor.size()), accessor.count());
        let end = |first: usize, length: usize| first.checked_add(length);
        let length =
            (count.saturating_sub(1)).checked_mul(stride).and_then(|l| end(l, accessor.size()));
        let length = if count == 0 { Some(0) } else { length };
        let bytes = buffers
            .get(view.buffer().index())
            .get(view.offset()..end(view.offset(), view.length()).unwrap_or(0))
            .and_then(|view| view.get(accessor.offset()..end(accessor.offset(), length?)?));
        let bytes = bytes.ok_or_else(|| {
            let expected = format!("{count} elements within buffer {}", view.buffer().index());
            refuse(item(), expected, "its end before theirs")
        })?;
        Ok(Self { bytes, stride, count, data_type, width: dimensions.multiplicity() })
    }

    /// Reads an accessor of 4 by 4 matrices.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub(super) fn matrices(accessor: &Accessor<'_>, buffers: &'a Buffers) -> Result<Self, Refusal> {
        Self::new(accessor, buffers, Dimensions::Mat4, &[DataType::F32])
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Returns the values of an element, whose index must be below [`Self::count`]. Integers are not normalized.
    pub(super) fn numbers(&self, element: usize) -> impl Iterator<Item = f64> + '_ {
        let size = self.data_type.size();
        let bytes = &self.bytes[element * self.stride..][..self.width * size];
        bytes.chunks_exact(size).map(|number| match (self.data_type, number) {
            (DataType::I8, &[a]) => f64::from(i8::from_le_bytes([a])),
            (DataType::I16, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
            (DataType::U8, &[a]) => f64::from(a),
            (DataType::U16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
            (DataType::U32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
            (DataType::F32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
            // No other size is possible: each value has the size of its type.
            _ => f64::NAN,
        })
    }

    /// Returns the values of an element as indices.
    pub(super) fn indices(&self, element: usize) -> impl Iterator<Item = usize> + '_ {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "whole numbers of at most 32 bits"
        )]
        self.numbers(element).map(|number| number as usize)
    }

    /// Returns the integer that represents 1 if the accessor is normalized; 1 for floats.
    pub(super) fn one(&self) -> f64 {
        match self.data_type {
            DataType::I8 => f64::from(i8::MAX),
            DataType::I16 => f64::from(i16::MAX),
            DataType::U8 => f64::from(u8::MAX),
            DataType::U16 => f64::from(u16::MAX),
            _ => 1.0,
        }
    }

    /// Returns an element of [`Self::matrices`].
    pub(super) fn matrix(&self, element: usize) -> DMat4 {
        let mut columns = [0.0; 16];
        for (column, number) in columns.iter_mut().zip(self.numbers(element)) {
            *column = number;
        }
        DMat4::from_cols_array(&columns)
    }
}
