//! Reading of numbers and texts from the bytes of a file; each read is checked against the end.

use std::io::Read;

use ndarray::Array2;

/// Order of the bytes of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// Lowest byte first.
    Little,
    /// Highest byte first.
    Big,
}

/// Position in the bytes of a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
    order: Order,
}

macro_rules! number {
    ($($name:ident),*) => {$(
        pub(crate) fn $name(&mut self) -> Result<$name, String> {
            let mut bytes = [0; size_of::<$name>()];
            bytes.copy_from_slice(self.take(size_of::<$name>())?);
            Ok(match self.order {
                Order::Little => $name::from_le_bytes(bytes),
                Order::Big => $name::from_be_bytes(bytes),
            })
        }
    )*};
}

impl<'a> Bytes<'a> {
    /// Creates a position at the start of `all`, which has numbers of the given byte order.
    pub(crate) fn new(all: &'a [u8], order: Order) -> Self {
        Self { all, at: 0, order }
    }

    /// Returns the order of the bytes of a number.
    pub(crate) fn order(&self) -> Order {
        self.order
    }

    /// Returns the number of bytes before the position.
    pub(crate) fn at(&self) -> usize {
        self.at
    }

    /// Returns the number of bytes from the position to the end.
    pub(crate) fn left(&self) -> usize {
        self.all.len() - self.at
    }

    /// Moves to `at`, counted from the start.
    pub(crate) fn seek(&mut self, at: usize) -> Result<(), String> {
        if at > self.all.len() {
            return Err(format!("a block starts at byte {at}; it must lie within the {} bytes", self.all.len()));
        }
        self.at = at;
        Ok(())
    }

    /// Returns the next `count` bytes.
    pub(crate) fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        if count > self.left() {
            return Err(format!(
                "a block of {count} bytes starts at byte {}; it must lie within the {} bytes of the file",
                self.at,
                self.all.len()
            ));
        }
        let taken = &self.all[self.at..self.at + count];
        self.at += count;
        Ok(taken)
    }

    pub(crate) fn skip(&mut self, count: usize) -> Result<(), String> {
        self.take(count).map(|_| ())
    }

    /// Returns the text in the next `count` bytes, up to the first zero byte and without surrounding blanks.
    pub(crate) fn text(&mut self, count: usize) -> Result<String, String> {
        self.take(count).map(text)
    }

    number!(u8, u16, i16, u32, i32, u64, i64, f32, f64);
}

/// Largest number of height maps of a file, since each needs more memory than its entry in the file.
pub(crate) const MOST_CHANNELS: usize = 1000;

/// Decodes bytes up to the first zero byte, as UTF-8 if they are valid, otherwise as Latin-1.
pub(crate) fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    match std::str::from_utf8(&bytes[..end]) {
        Ok(text) => text.trim().to_owned(),
        Err(_) => bytes[..end].iter().copied().map(char::from).collect::<String>().trim().to_owned(),
    }
}

/// Kind of the numbers of a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sample {
    U8,
    I8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Sample {
    /// Returns the number of bytes of one number.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Decodes the number in `bytes`, which must have the length `size`.
    #[expect(clippy::cast_possible_truncation, reason = "the lowest bits of a word are the number")]
    pub(crate) fn decode(self, bytes: &[u8], order: Order) -> f64 {
        let mut word = [0; 8];
        let size = bytes.len();
        word[..size].copy_from_slice(bytes);
        if order == Order::Big {
            word[..size].reverse();
        }
        let bits = u64::from_le_bytes(word);
        match self {
            Self::U8 | Self::U16 | Self::U32 | Self::U64 => bits as f64,
            Self::I8 => f64::from(bits as i8),
            Self::I16 => f64::from(bits as i16),
            Self::I32 => f64::from(bits as i32),
            Self::I64 => bits as i64 as f64,
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
        }
    }
}

/// Order of the numbers of a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Layout {
    /// Line by line: x runs fastest.
    Lines,
    /// Column by column: y runs fastest.
    Columns,
}

/// Grid of numbers as stored in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Grid {
    /// Number of points along x and y.
    pub(crate) points: [usize; 2],
    pub(crate) sample: Sample,
    pub(crate) order: Order,
    pub(crate) layout: Layout,
    /// True for an axis that the file stores backwards.
    pub(crate) backwards: [bool; 2],
}

impl Grid {
    /// Creates a grid of lines from left to right, in the order of the lines of the map.
    pub(crate) fn lines(points: [usize; 2], sample: Sample, order: Order) -> Self {
        Self { points, sample, order, layout: Layout::Lines, backwards: [false; 2] }
    }

    /// Returns the number of bytes of all numbers.
    pub(crate) fn bytes(&self) -> Result<usize, String> {
        let [nx, ny] = self.points;
        if nx == 0 || ny == 0 {
            return Err(format!("the grid has {nx} by {ny} points; it must have at least one point"));
        }
        nx.checked_mul(ny)
            .and_then(|points| points.checked_mul(8).map(|_| points * self.sample.size()))
            .ok_or_else(|| format!("the grid has {nx} by {ny} points; they must fit into the memory"))
    }

    /// Reads the grid from the start of `bytes` as heights `[x, y]`, each converted by `height`.
    pub(crate) fn read(&self, bytes: &[u8], height: impl Fn(f64) -> f64) -> Result<Array2<f64>, String> {
        let needed = self.bytes()?;
        if needed > bytes.len() {
            let [nx, ny] = self.points;
            return Err(format!(
                "the heights of {nx} by {ny} points have {} bytes; they must have {needed}",
                bytes.len()
            ));
        }
        self.decode(bytes, height)
    }

    /// Reads the grid from a compressed stream of `compressed` bytes as heights `[x, y]`, each converted by `height`.
    ///
    /// The stream must hold exactly the numbers of the grid. Nothing is allocated for a grid that is too large for a
    /// stream of `compressed` bytes.
    pub(crate) fn inflate(
        &self,
        compressed: usize,
        mut stream: impl Read,
        height: impl Fn(f64) -> f64,
    ) -> Result<Array2<f64>, String> {
        // Deflate expands a byte to at most 1032 bytes.
        const LARGEST_RATIO: usize = 1032;
        let needed = self.bytes()?;
        let most = compressed.saturating_mul(LARGEST_RATIO);
        if needed > most {
            let [nx, ny] = self.points;
            return Err(format!(
                "the grid has {nx} by {ny} points; {compressed} compressed bytes hold at most {} of them",
                most / self.sample.size()
            ));
        }
        let heights = self.decode(&mut stream, height)?;
        match stream.read(&mut [0]) {
            Ok(0) => Ok(heights),
            Ok(_) => Err(format!("the compressed heights have more than {needed} bytes; they must have {needed}")),
            Err(error) => Err(format!("the compressed heights are damaged: {error}")),
        }
    }

    /// Reads the grid from a stream with all its bytes as heights `[x, y]`, each converted by `height`.
    pub(crate) fn decode(&self, mut stream: impl Read, height: impl Fn(f64) -> f64) -> Result<Array2<f64>, String> {
        let ([nx, ny], size) = (self.points, self.sample.size());
        let mut heights = Vec::new();
        heights
            .try_reserve_exact(nx * ny)
            .map_err(|_| format!("the grid has {nx} by {ny} points; they must fit into the memory"))?;
        heights.resize(nx * ny, 0.0);
        let [back_x, back_y] = self.backwards;
        let mut buffer = [0; 4096];
        let row = if self.layout == Layout::Lines { nx } else { ny };
        let (mut point, mut outer, mut inner) = (0, 0, 0);
        while point < nx * ny {
            let count = (nx * ny - point).min(buffer.len() / size);
            let part = &mut buffer[..count * size];
            stream.read_exact(part).map_err(|error| match error.kind() {
                std::io::ErrorKind::UnexpectedEof => {
                    format!("the heights end before point {} of {}; all must be there", point + count, nx * ny)
                }
                _ => format!("the heights are damaged: {error}"),
            })?;
            for bytes in part.chunks_exact(size) {
                let [x, y] = match self.layout {
                    Layout::Lines => [inner, outer],
                    Layout::Columns => [outer, inner],
                };
                let x = if back_x { nx - 1 - x } else { x };
                let y = if back_y { ny - 1 - y } else { y };
                heights[x * ny + y] = height(self.sample.decode(bytes, self.order));
                inner += 1;
                if inner == row {
                    (outer, inner) = (outer + 1, 0);
                }
            }
            point += count;
        }
        Array2::from_shape_vec((nx, ny), heights).map_err(|error| error.to_string())
    }
}

/// Returns the first characters of a text, for messages.
pub(crate) fn clip(text: &str) -> String {
    text.chars().take(40).collect()
}

/// Returns `value` if it is a positive finite number, otherwise an error with its name.
pub(crate) fn positive(name: &str, value: f64) -> Result<f64, String> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(format!("{name} is {value}; it must be positive and finite"))
    }
}

/// Returns `value` if it is finite and not zero, otherwise an error with its name.
pub(crate) fn factor(name: &str, value: f64) -> Result<f64, String> {
    if value != 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(format!("{name} is {value}; it must be finite and not zero"))
    }
}

/// Returns the position of `mark` in `bytes`.
pub(crate) fn find(bytes: &[u8], mark: &[u8]) -> Option<usize> {
    bytes.windows(mark.len()).position(|window| window == mark)
}

/// Returns `value` as the number of points along a side of a grid if it is positive, otherwise an error with its name.
pub(crate) fn count(name: &str, value: impl TryInto<usize> + Copy + std::fmt::Display) -> Result<usize, String> {
    value.try_into().ok().filter(|&count| count > 0).ok_or_else(|| format!("{name} is {value}; it must be at least 1"))
}

/// Splits a text into lines, which end with LF, CR LF, or CR.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let (line, end) =
            rest.split_at(rest.bytes().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(rest.len()));
        rest = end.strip_prefix("\r\n").or_else(|| end.get(1..)).unwrap_or_default();
        Some(line)
    })
}
