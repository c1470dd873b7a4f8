//! Reading of compound values, such as attributes of other programs whose fields are texts and arrays.

use std::ffi::CStr;
use std::os::raw::{c_char, c_void};

use hdf5::types::{FloatSize, IntSize, TypeDescriptor};
use hdf5::{Container, Datatype};
use hdf5_sys::h5a::H5Aread;
use hdf5_sys::h5d::{H5Dread, H5Dvlen_reclaim};
use hdf5_sys::h5p::H5P_DEFAULT;
use hdf5_sys::h5s::H5S_ALL;
use hdf5_sys::h5t::hvl_t;

/// Largest number of bytes of all records together, and of characters of a field. Records describe others.
const MOST: usize = 1 << 20;

/// Largest number of numbers of a field that are kept.
const MOST_NUMBERS: usize = 1 << 12;

/// A field of a compound value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Field {
    /// A text.
    Text(String),
    /// A number or an array of numbers.
    Numbers(Vec<f64>),
    /// A field of another type.
    Other,
}

/// Reads all values of a dataset or attribute of compound type as their fields in the order of the file.
pub(super) fn read(container: &Container, is_attribute: bool) -> Result<Vec<Vec<Field>>, hdf5::Error> {
    let TypeDescriptor::Compound(stored) = container.dtype()?.to_descriptor()? else {
        return Err("the type is not compound".into());
    };
    let layout = stored.to_c_repr();
    let kind = Datatype::from_descriptor(&TypeDescriptor::Compound(layout.clone()))?;
    let size = layout.size;
    let space = container.space()?;
    let bytes = space.size().checked_mul(size).filter(|&bytes| bytes > 0 && bytes <= MOST);
    let bytes = bytes.ok_or("the compound values are empty or too large")?;
    // Words instead of bytes, so that pointers in the values are aligned.
    let mut buffer = vec![0_u64; bytes.div_ceil(8)];
    let start = buffer.as_mut_ptr().cast::<c_void>();
    hdf5::sync::sync(|| {
        #[allow(
            unsafe_code,
            reason = "the `hdf5` crate reads no compound value whose fields have names known only at run time"
        )]
        // SAFETY: the buffer has the bytes of all values in `kind`'s layout and outlives the calls; ids are of live objects.
        let status = unsafe {
            if is_attribute {
                H5Aread(container.id(), kind.id(), start)
            } else {
                H5Dread(container.id(), kind.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, start)
            }
        };
        if status < 0 {
            return Err(hdf5::Error::query()?);
        }
        let record = |index: usize| {
            let fields = layout.fields.iter().map(|field| {
                #[allow(unsafe_code, reason = "the library returns texts and arrays as pointers")]
                // SAFETY: the library has filled the buffer, so that each field has a valid value of its type at its offset.
                unsafe {
                    decode(start.cast::<u8>().add(index * size + field.offset), &field.ty)
                }
            });
            fields.collect()
        };
        let records = (0..space.size()).map(record).collect();
        #[allow(unsafe_code, reason = "the library allocated the texts and arrays")]
        #[allow(deprecated, reason = "its successor is missing from libraries before 1.12")]
        // SAFETY: type, space and buffer are those of the read above; nothing points into the values any more.
        unsafe {
            H5Dvlen_reclaim(kind.id(), space.id(), H5P_DEFAULT, start);
        }
        Ok(records)
    })
}

/// Decodes the value at `at`.
///
/// # Safety
/// A valid value of type `kind` lies there, as the library writes it.
#[allow(unsafe_code, reason = "the library returns texts and arrays as pointers")]
unsafe fn decode(at: *const u8, kind: &TypeDescriptor) -> Field {
    match kind {
        TypeDescriptor::VarLenAscii | TypeDescriptor::VarLenUnicode => {
            // SAFETY: the value is a pointer to a text that ends with zero, or null.
            let text = unsafe { at.cast::<*const c_char>().read_unaligned() };
            if text.is_null() {
                return Field::Text(String::new());
            }
            // SAFETY: as above; it is copied at once.
            let text = unsafe { CStr::from_ptr(text) };
            Field::Text(String::from_utf8_lossy(&text.to_bytes()[..text.count_bytes().min(MOST)]).into_owned())
        }
        TypeDescriptor::FixedAscii(length) | TypeDescriptor::FixedUnicode(length) => {
            // SAFETY: the value has so many bytes.
            let bytes = unsafe { std::slice::from_raw_parts(at, *length) };
            let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
            Field::Text(String::from_utf8_lossy(&bytes[..end]).into_owned())
        }
        TypeDescriptor::VarLenArray(element) => {
            // SAFETY: the value is a number of elements and a pointer to them.
            let array = unsafe { at.cast::<hvl_t>().read_unaligned() };
            let count = if array.p.is_null() { 0 } else { array.len.min(MOST_NUMBERS) };
            // SAFETY: so many elements lie there.
            unsafe { numbers(array.p.cast(), element, count) }
        }
        // SAFETY: the value is so many elements.
        TypeDescriptor::FixedArray(element, count) => unsafe { numbers(at, element, *count) },
        // SAFETY: the value is one number, or of another type.
        _ => unsafe { numbers(at, kind, 1) },
    }
}

/// Decodes `count` numbers of type `kind` that start at `at`.
///
/// # Safety
/// So many valid values lie there.
#[allow(unsafe_code, reason = "the library returns texts and arrays as pointers")]
unsafe fn numbers(at: *const u8, kind: &TypeDescriptor, count: usize) -> Field {
    let number = |index: usize| {
        // SAFETY: the caller promises the value.
        unsafe {
            match kind {
                TypeDescriptor::Float(FloatSize::U8) => Some(at.cast::<f64>().add(index).read_unaligned()),
                TypeDescriptor::Float(FloatSize::U4) => Some(at.cast::<f32>().add(index).read_unaligned().into()),
                TypeDescriptor::Integer(IntSize::U4) => Some(at.cast::<i32>().add(index).read_unaligned().into()),
                TypeDescriptor::Unsigned(IntSize::U4) => Some(at.cast::<u32>().add(index).read_unaligned().into()),
                TypeDescriptor::Integer(IntSize::U8) => Some(at.cast::<i64>().add(index).read_unaligned() as f64),
                _ => None,
            }
        }
    };
    (0..count).map(number).collect::<Option<Vec<f64>>>().map_or(Field::Other, Field::Numbers)
}
