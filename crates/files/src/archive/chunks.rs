//! Compressed chunks. The filters of the HDF5 library run on one thread; here chunks are compressed on all threads and
//! passed to the library complete.

use std::ffi::c_void;
use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use gfmd_field::contiguous;
use hdf5::types::TypeDescriptor;
use hdf5::{Dataset, H5Type, Hyperslab, SliceOrIndex};
use hdf5_sys::h5::{herr_t, hsize_t};
use hdf5_sys::h5i::hid_t;
use hdf5_sys::h5p::H5P_DEFAULT;
use ndarray::{ArrayD, ArrayViewD, Axis, Dimension, IxDyn, Slice, indices};
use rayon::prelude::*;

use super::DEFLATE;

/// Writes a box of `lengths` entries starting at `first`, row-major.
pub(super) fn write<T: H5Type + Copy + Default + Sync>(
    dataset: &Dataset,
    first: &[usize],
    lengths: &[usize],
    values: &[T],
) -> Result<(), hdf5::Error> {
    let values = ArrayViewD::from_shape(lengths, values)?;
    let (shape, chunk) = (dataset.shape(), dataset.chunk().unwrap_or_default());
    let is_number = matches!(
        T::type_descriptor(),
        TypeDescriptor::Float(_) | TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_)
    );
    let axes = || first.iter().zip(lengths).zip(chunk.iter().zip(&shape));
    let has_whole_chunks = axes().all(|((first, length), (chunk, all))| {
        let end = first + length;
        first % chunk == 0 && (end % chunk == 0 || end == *all)
    });
    if chunk.is_empty() || !is_number || !has_whole_chunks {
        let along = |(first, length): (&usize, &usize)| SliceOrIndex::from(*first..first + length);
        let selection: Vec<SliceOrIndex> = first.iter().zip(lengths).map(along).collect();
        return dataset.write_slice(values, Hyperslab::from(selection));
    }
    let counts: Vec<usize> = axes().map(|((_, length), (chunk, _))| length.div_ceil(*chunk)).collect();
    let chunk_length = chunk.iter().product::<usize>();
    // First entry of each chunk, relative to the box.
    let corner = |place: IxDyn| place.slice().iter().zip(&chunk).map(|(at, chunk)| at * chunk).collect();
    let corners: Vec<Vec<usize>> = indices(&counts[..]).into_iter().map(corner).collect();
    for corners in corners.chunks(rayon::current_num_threads()) {
        let compressed = |corner: &Vec<usize>| {
            let part = values.slice_each_axis(|axis| {
                let Axis(axis) = axis.axis;
                Slice::from(corner[axis]..(corner[axis] + chunk[axis]).min(lengths[axis]))
            });
            let offset = first.iter().zip(corner).map(|(first, corner)| (first + corner) as hsize_t);
            let compressed = match part.as_slice().filter(|part| part.len() == chunk_length) {
                Some(part) => compress(bytes(part), size_of::<T>()),
                // Chunks at the edges are stored whole.
                None => {
                    let mut whole = ArrayD::from_elem(&chunk[..], T::default());
                    whole.slice_each_axis_mut(|axis| Slice::from(..part.len_of(axis.axis))).assign(&part);
                    compress(bytes(&contiguous(&whole)), size_of::<T>())
                }
            };
            (offset.collect::<Vec<_>>(), compressed)
        };
        let block: Vec<_> = corners.par_iter().map(compressed).collect();
        for (offset, bytes) in block {
            put(dataset, &offset, &bytes.map_err(|error| error.to_string())?)?;
        }
    }
    Ok(())
}

/// Applies the filters "shuffle" (the first bytes of all numbers, then the second bytes, and so on) and "deflate".
fn compress(bytes: &[u8], size: usize) -> std::io::Result<Vec<u8>> {
    let count = bytes.len() / size;
    let mut shuffled = vec![0; bytes.len()];
    for (place, number) in bytes.chunks_exact(size).enumerate() {
        for (byte, plane) in number.iter().zip(shuffled.chunks_exact_mut(count)) {
            plane[place] = *byte;
        }
    }
    let mut encoder = ZlibEncoder::new(Vec::with_capacity(bytes.len() / 2), Compression::new(DEFLATE.into()));
    encoder.write_all(&shuffled)?;
    encoder.finish()
}

/// Returns the bytes of numbers.
fn bytes<T: H5Type>(values: &[T]) -> &[u8] {
    #[allow(unsafe_code, reason = "numbers in memory are their own bytes")]
    // SAFETY: `write` calls this for integers and real numbers only, which have no padding; bytes need no alignment.
    unsafe {
        std::slice::from_raw_parts(values.as_ptr().cast(), size_of_val(values))
    }
}

#[allow(unsafe_code, reason = "the `hdf5` crate does not declare this function, which HDF5 has since 1.10.3")]
unsafe extern "C" {
    fn H5Dwrite_chunk(
        dataset: hid_t,
        transfer: hid_t,
        skipped_filters: u32,
        offset: *const hsize_t,
        size: usize,
        bytes: *const c_void,
    ) -> herr_t;
}

/// Passes a compressed chunk to the library.
fn put(dataset: &Dataset, offset: &[hsize_t], bytes: &[u8]) -> Result<(), hdf5::Error> {
    let status = hdf5::sync::sync(|| {
        #[allow(unsafe_code, reason = "the `hdf5` crate does not write compressed chunks")]
        // SAFETY: `dataset` is open, `offset` has a number for each of its dimensions, the size is the length of
        // `bytes`, and all of them outlive the call; `sync` holds the library's lock.
        unsafe {
            H5Dwrite_chunk(dataset.id(), H5P_DEFAULT, 0, offset.as_ptr(), bytes.len(), bytes.as_ptr().cast())
        }
    });
    if status < 0 { Err(hdf5::Error::query()?) } else { Ok(()) }
}
