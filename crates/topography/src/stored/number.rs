//! Decoding of numbers.

use hdf5_reader::error::{ByteOrder, Error};
use hdf5_reader::{Datatype, H5Type, dtype_element_size};

/// Number read from a file: `f64` from every integer and float, `u64` and `i64` from integers within their range.
pub trait Number: Decode {}

impl Number for f64 {}
impl Number for u64 {}
impl Number for i64 {}

/// Part of [`Number`] that other crates cannot implement.
pub trait Decode: Copy + Send {
    #[doc(hidden)]
    fn decode(bytes: &[u8], kind: &Datatype) -> Result<Self, Error>;

    #[doc(hidden)]
    fn decode_all(_bytes: &[u8], _kind: &Datatype, _count: usize) -> Option<Result<Vec<Self>, Error>> {
        None
    }
}

impl Decode for f64 {
    fn decode(bytes: &[u8], kind: &Datatype) -> Result<Self, Error> {
        match kind {
            Datatype::FloatingPoint { size: 8, .. } => Self::from_bytes(bytes, kind),
            Datatype::FloatingPoint { size: 4, .. } => f32::from_bytes(bytes, kind).map(Self::from),
            Datatype::FloatingPoint { size: 2, byte_order } => half(bytes, *byte_order),
            _ => integer(bytes, kind).map(|integer| integer as Self),
        }
    }

    fn decode_all(bytes: &[u8], kind: &Datatype, count: usize) -> Option<Result<Vec<Self>, Error>> {
        match kind {
            Datatype::FloatingPoint { size: 8, .. } => <Self as H5Type>::decode_vec(bytes, kind, count),
            _ => None,
        }
    }
}

impl Decode for u64 {
    fn decode(bytes: &[u8], kind: &Datatype) -> Result<Self, Error> {
        Self::try_from(integer(bytes, kind)?).map_err(|_| mismatch("an integer of at least 0", kind))
    }
}

impl Decode for i64 {
    fn decode(bytes: &[u8], kind: &Datatype) -> Result<Self, Error> {
        Self::try_from(integer(bytes, kind)?).map_err(|_| mismatch("an integer below 2^63", kind))
    }
}

/// Number as a type of the HDF5 reader library.
#[derive(Clone)]
pub(super) struct Stored<T>(pub(super) T);

impl<T: Number> H5Type for Stored<T> {
    fn hdf5_type() -> Datatype {
        f64::hdf5_type()
    }

    fn from_bytes(bytes: &[u8], kind: &Datatype) -> Result<Self, Error> {
        T::decode(bytes, kind).map(Self)
    }

    fn element_size(kind: &Datatype) -> usize {
        // A type without a size cannot be decoded either, which gives the error.
        dtype_element_size(kind).unwrap_or(0)
    }

    fn decode_vec(bytes: &[u8], kind: &Datatype, count: usize) -> Option<Result<Vec<Self>, Error>> {
        T::decode_all(bytes, kind, count).map(|values| Ok(values?.into_iter().map(Self).collect()))
    }
}

/// Decodes an integer of any width.
fn integer(bytes: &[u8], kind: &Datatype) -> Result<i128, Error> {
    match kind {
        Datatype::FixedPoint { size: 1, signed: true, .. } => i8::from_bytes(bytes, kind).map(i128::from),
        Datatype::FixedPoint { size: 1, .. } => u8::from_bytes(bytes, kind).map(i128::from),
        Datatype::FixedPoint { size: 2, signed: true, .. } => i16::from_bytes(bytes, kind).map(i128::from),
        Datatype::FixedPoint { size: 2, .. } => u16::from_bytes(bytes, kind).map(i128::from),
        Datatype::FixedPoint { size: 4, signed: true, .. } => i32::from_bytes(bytes, kind).map(i128::from),
        Datatype::FixedPoint { size: 4, .. } => u32::from_bytes(bytes, kind).map(i128::from),
        Datatype::FixedPoint { size: 8, signed: true, .. } => i64::from_bytes(bytes, kind).map(i128::from),
        Datatype::FixedPoint { size: 8, .. } => u64::from_bytes(bytes, kind).map(i128::from),
        other => Err(mismatch("a real number", other)),
    }
}

fn mismatch(expected: &str, found: &Datatype) -> Error {
    Error::TypeMismatch { expected: expected.into(), actual: format!("{found:?}") }
}

/// Decodes a 16-bit float (IEEE 754).
fn half(bytes: &[u8], order: ByteOrder) -> Result<f64, Error> {
    let kind = Datatype::FixedPoint { size: 2, signed: false, byte_order: order };
    let bits = u16::from_bytes(bytes, &kind)?;
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023) / 1024.0);
    let magnitude = match exponent {
        0 => fraction * 2_f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction) * 2_f64.powi(exponent - 15),
    };
    Ok(if bits >> 15 == 1 { -magnitude } else { magnitude })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_those_of_the_standard() {
        let value = |bits: u16| half(&bits.to_le_bytes(), ByteOrder::LittleEndian).unwrap();
        let expected =
            [(0x3c00, 1.0), (0xc000, -2.0), (0x7bff, 65504.0), (0x0001, 2_f64.powi(-24)), (0x3555, 0.333_251_953_125)];
        assert!(expected.iter().all(|(bits, number)| value(*bits) == *number));
        assert!(value(0x7c00) == f64::INFINITY && value(0x7e00).is_nan());
    }
}
