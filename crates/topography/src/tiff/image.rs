//! Numbers of the image of a page: strips or tiles, plain or compressed.

use std::io::Read;

use flate2::read::ZlibDecoder;
use ndarray::Array2;

use super::Page;
use crate::bytes::{Order, Sample, count};

/// Tags of an image.
const SIZE: [u16; 2] = [256, 257];
const BITS: u16 = 258;
const COMPRESSION: u16 = 259;
const PHOTOMETRIC: u16 = 262;
const ORIENTATION: u16 = 274;
const SAMPLES: u16 = 277;
const LINES: u16 = 278;
const STRIPS: [u16; 2] = [273, 279];
const PREDICTOR: u16 = 317;
const TILE: [u16; 2] = [322, 323];
const TILES: [u16; 2] = [324, 325];
const SAMPLE_FORMAT: u16 = 339;

/// Largest ratio of compression by deflate.
const LARGEST_RATIO: u64 = 1032;

/// Largest number of columns of a tile beyond the image.
const MOST_BEYOND: usize = 4096;

/// Change of the numbers before they are compressed.
#[derive(Clone, Copy, PartialEq)]
enum Predictor {
    None,
    /// Differences of neighbours.
    Differences,
    /// Differences of the bytes of floats, sorted by their weight.
    Floats,
}

/// Strip or tile: its place, its points, and its bytes.
struct Part<'a> {
    at: [usize; 2],
    points: [usize; 2],
    data: &'a [u8],
}

/// Image of one number for each point.
pub(super) struct Image<'a> {
    pub(super) points: [usize; 2],
    pub(super) bits: usize,
    kind: usize,
    order: Order,
    is_compressed: bool,
    predictor: Predictor,
    parts: Vec<Part<'a>>,
}

impl<'a> Image<'a> {
    /// Reads the tags of the image of a page.
    ///
    /// # Errors
    /// Colours, an unknown compression, parts that are too short for the points.
    pub(super) fn of(page: &Page<'a>) -> Result<Self, String> {
        let points = [
            count("the number of columns", page.whole(SIZE[0], 0)?)?,
            count("the number of lines", page.whole(SIZE[1], 0)?)?,
        ];
        let samples = page.whole(SAMPLES, 1)?;
        let photometric = page.whole(PHOTOMETRIC, 1)?;
        if samples != 1 || !matches!(photometric, 0 | 1 | 4) {
            let what = if samples == 1 { "a palette".to_owned() } else { format!("{samples} numbers a pixel") };
            return Err(format!(
                "the image has {what}, as colours have; heights must have one number a pixel, without a palette"
            ));
        }
        if photometric == 0 {
            return Err("the image says that white is zero; heights must say that black is zero".into());
        }
        let orientation = page.whole(ORIENTATION, 1)?;
        if orientation != 1 {
            return Err(format!("the orientation has number {orientation}; it must be 1, the top line first"));
        }
        let is_compressed = match page.whole(COMPRESSION, 1)? {
            1 => false,
            8 | 32946 => true,
            5 => {
                return Err(
                    "the image is compressed by LZW, which is not read; save it without, or with deflate (ZIP)".into(),
                );
            }
            other => {
                return Err(format!(
                    "the compression has number {other}; the image must be saved without, or with deflate"
                ));
            }
        };
        let predictor = match page.whole(PREDICTOR, 1)? {
            1 => Predictor::None,
            2 => Predictor::Differences,
            3 => Predictor::Floats,
            other => return Err(format!("the predictor has number {other}; it must be 1, 2 or 3")),
        };
        let (bits, kind) = (page.whole(BITS, 1)?, page.whole(SAMPLE_FORMAT, 1)?);
        let mut image = Self { points, bits, kind, order: page.order, is_compressed, predictor, parts: Vec::new() };
        image.divide(page)?;
        Ok(image)
    }

    /// Reads the strips or tiles.
    fn divide(&mut self, page: &Page<'a>) -> Result<(), String> {
        let [nx, ny] = self.points;
        let is_tiled = page.has(TILE[0]);
        let [width, lines] = match is_tiled {
            true => [
                count("the width of a tile", page.whole(TILE[0], 0)?)?,
                count("the lines of a tile", page.whole(TILE[1], 0)?)?,
            ],
            false => [nx, count("the lines of a strip", page.whole(LINES, ny)?)?.min(ny)],
        };
        if width > nx + MOST_BEYOND {
            return Err(format!(
                "a tile has {width} columns, the image {nx}; a tile must have at most {MOST_BEYOND} more"
            ));
        }
        let tags = if is_tiled { TILES } else { STRIPS };
        let mut places = page.numbers(tags[0])?.zip(page.numbers(tags[1])?);
        for y in (0..ny).step_by(lines) {
            for x in (0..nx).step_by(width) {
                let Some((start, length)) = places.next() else {
                    let found = self.parts.len();
                    return Err(format!("the image has {found} parts for {nx} by {ny} points; it must have more"));
                };
                let points = [width, if is_tiled { lines } else { lines.min(ny - y) }];
                self.parts.push(self.part(page.all, [x, y], points, [start, length])?);
            }
        }
        Ok(())
    }

    /// Returns a part if its bytes suffice for its points.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole numbers of 32 bits")]
    fn part(
        &self,
        all: &'a [u8],
        at: [usize; 2],
        points: [usize; 2],
        [start, length]: [f64; 2],
    ) -> Result<Part<'a>, String> {
        let (start, length) = (start as usize, length as usize);
        let data = start.checked_add(length).and_then(|end| all.get(start..end)).ok_or_else(|| {
            let all = all.len();
            format!("a part has {length} bytes from byte {start} on; they must lie within the {all} bytes of the file")
        })?;
        let needed = self.row(points[0]) as u64 * points[1] as u64;
        let most = if self.is_compressed { length as u64 * LARGEST_RATIO } else { length as u64 };
        if needed > most {
            let [nx, ny] = points;
            return Err(format!(
                "a part of {nx} by {ny} points has {length} bytes, which hold at most {most}; it needs {needed}"
            ));
        }
        Ok(Part { at, points, data })
    }

    /// Returns the number of bytes of a line of `points`.
    fn row(&self, points: usize) -> usize {
        points.saturating_mul(self.bits).div_ceil(8)
    }

    /// Returns the type of the numbers.
    pub(super) fn sample(&self) -> Result<Sample, String> {
        Ok(match (self.kind, self.bits) {
            (1, 8) => Sample::U8,
            (1, 16) => Sample::U16,
            (1, 32) => Sample::U32,
            (2, 8) => Sample::I8,
            (2, 16) => Sample::I16,
            (2, 32) => Sample::I32,
            (3, 32) => Sample::F32,
            (3, 64) => Sample::F64,
            (kind, bits) => {
                return Err(format!(
                    "a number has {bits} bits of type {kind}; it must be an integer or float of 8 to 64 bits"
                ));
            }
        })
    }

    /// Reads the numbers as heights `[x, y]`, each converted by `height`.
    pub(super) fn read(&self, height: impl Fn(f64) -> f64) -> Result<Array2<f64>, String> {
        let (sample, [nx, ny]) = (self.sample()?, self.points);
        let order = if self.predictor == Predictor::Floats { Order::Big } else { self.order };
        let mut heights = Vec::new();
        heights
            .try_reserve_exact(nx * ny)
            .map_err(|_| format!("the grid has {nx} by {ny} points; they must fit into the memory"))?;
        heights.resize(nx * ny, 0.0);
        self.rows(|[x, y], row| {
            self.restore(row, sample.size());
            for (k, number) in row.chunks_exact(sample.size()).enumerate().take(nx - x) {
                heights[(x + k) * ny + y] = height(sample.decode(number, order));
            }
        })?;
        Array2::from_shape_vec((nx, ny), heights).map_err(|error| error.to_string())
    }

    /// Calls `found` with the place of each point of an image of one bit that is set.
    pub(super) fn bits(&self, mut found: impl FnMut([usize; 2])) -> Result<(), String> {
        let nx = self.points[0];
        self.rows(|[x, y], row| {
            let set = (0..nx - x).filter(|k| row.get(k / 8).is_some_and(|byte| byte & (0x80 >> (k % 8)) != 0));
            set.for_each(|k| found([x + k, y]));
        })
    }

    /// Calls `found` with the place and the bytes of each line of each part within the image.
    fn rows(&self, mut found: impl FnMut([usize; 2], &mut [u8])) -> Result<(), String> {
        for Part { at: [x, y], points, data } in &self.parts {
            let mut row = vec![0; self.row(points[0])];
            let (mut plain, mut packed) = (*data, ZlibDecoder::new(*data));
            for line in (*y..self.points[1]).take(points[1]) {
                let stream: &mut dyn Read = if self.is_compressed { &mut packed } else { &mut plain };
                stream.read_exact(&mut row).map_err(|error| format!("line {line} of the image is damaged: {error}"))?;
                found([*x, line], &mut row);
            }
        }
        Ok(())
    }

    /// Undoes the predictor in a line.
    fn restore(&self, row: &mut [u8], size: usize) {
        match self.predictor {
            Predictor::None => {}
            Predictor::Differences => sum(row, size, self.order),
            Predictor::Floats => {
                sum(row, 1, self.order);
                let planes = row.to_vec();
                let points = row.len() / size;
                for (k, byte) in row.iter_mut().enumerate() {
                    *byte = planes[k % size * points + k / size];
                }
            }
        }
    }
}

/// Adds to each integer of a line the one before it.
fn sum(row: &mut [u8], size: usize, order: Order) {
    let mut last = 0_u64;
    for number in row.chunks_exact_mut(size) {
        let mut word = [0; 8];
        word[..size].copy_from_slice(number);
        if order == Order::Big {
            word[..size].reverse();
        }
        last = last.wrapping_add(u64::from_le_bytes(word));
        let mut word = last.to_le_bytes();
        if order == Order::Big {
            word[..size].reverse();
        }
        number.copy_from_slice(&word[..size]);
    }
}
