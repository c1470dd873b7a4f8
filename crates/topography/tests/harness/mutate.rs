//! Reproducible damage to files: equal numbers give equal damage.

use super::made;
use zip::CompressionMethod;

/// Valid file to start from.
#[derive(Clone)]
pub(crate) enum Seed {
    Bytes(Vec<u8>),
    /// Entries of a zip archive, which are damaged before they are packed, since a checksum guards them afterwards.
    Zip(Vec<(String, Vec<u8>)>),
}

impl Seed {
    pub(crate) fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Bytes(bytes) => bytes.clone(),
            Self::Zip(entries) => pack(entries, CompressionMethod::Deflated),
        }
    }
}

fn pack(entries: &[(String, Vec<u8>)], method: CompressionMethod) -> Vec<u8> {
    let entries: Vec<(&str, Vec<u8>)> = entries.iter().map(|(name, bytes)| (name.as_str(), bytes.clone())).collect();
    made::zipped(&entries, method)
}

/// Random numbers (SplitMix64).
pub(crate) struct Random(pub u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a number below `end`, or 0 if `end` is 0.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        if end == 0 { 0 } else { (self.next() % end as u64) as usize }
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }
}

/// Numbers that often make programs fail.
const WORDS: [u64; 22] = [
    0,
    1,
    2,
    0x7f,
    0x80,
    0xff,
    0x7fff,
    0x8000,
    0xffff,
    0x1_0000,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x1_0000_0000,
    1 << 40,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    u64::MAX,
    0x7ff0_0000_0000_0000, // infinity
    0x7ff8_0000_0000_0000, // NaN
    0x7fc0_0000,           // 32-bit NaN
    0x0000_0001_0000_0001,
];

/// Numbers in text that often make programs fail.
const TEXTS: [&str; 18] = [
    "",
    "0",
    "-1",
    "1",
    "2",
    "65536",
    "4294967296",
    "1099511627776",
    "18446744073709551616",
    "99999999999999999999999",
    "1e308",
    "1e-320",
    "-1e400",
    "nan",
    "inf",
    ".",
    "1e",
    "3.5",
];

/// Returns a damaged copy of one of several valid files of a format.
pub(crate) fn damaged(seeds: &[Seed], random: &mut Random) -> Vec<u8> {
    let chosen = random.below(seeds.len());
    let mut bytes = match &seeds[chosen] {
        // Most damage inside an archive would only invalidate the checksum of an entry.
        Seed::Zip(entries) if random.below(4) > 0 => {
            let mut entries = entries.clone();
            for _ in 0..=random.below(3) {
                let entry = random.below(entries.len());
                if random.below(16) == 0 {
                    let (name, bytes) = entries[entry].clone();
                    entries.push((format!("{name}{:x}", random.next()), bytes));
                } else if random.below(16) == 0 && entries.len() > 1 {
                    entries.remove(entry);
                } else {
                    change(&mut entries[entry].1, &[], random);
                }
            }
            return pack(&entries, random.pick(&[CompressionMethod::Stored, CompressionMethod::Deflated]));
        }
        seed => seed.bytes(),
    };
    let other = seeds[random.below(seeds.len())].bytes();
    for _ in 0..=random.below(4) {
        change(&mut bytes, &other, random);
    }
    bytes
}

/// Changes some bytes in one of many ways; parts are taken from the file `other`.
fn change(bytes: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    let length = bytes.len();
    if length == 0 {
        bytes.extend_from_slice(other);
        return;
    }
    // Headers are at the start, directories of archives at the end.
    let at = match random.below(8) {
        0..4 => random.below(length.min(512)),
        4 => length - 1 - random.below(length.min(64)),
        _ => random.below(length),
    };
    let range = at..(at + 1 + random.below(64)).min(length);
    match random.below(12) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => bytes[at] = random.pick(&[0, 1, 0x20, 0x7f, 0x80, 0xff, b'-', b'9', b'\n', b'"', b'<', b'[']),
        2 | 3 => {
            let size = random.pick(&[2_usize, 4, 4, 8]);
            let word = match random.below(4) {
                0 => random.next(),
                1 => (length + random.below(5)).wrapping_sub(2) as u64,
                _ => random.pick(&WORDS),
            };
            let word = if random.below(2) == 0 { word.to_le_bytes() } else { (word << (64 - 8 * size)).to_be_bytes() };
            let end = (at + size).min(length);
            bytes[at..end].copy_from_slice(&word[..end - at]);
        }
        4 | 5 => digits(bytes, at, random),
        6 => bytes.truncate(at),
        7 => {
            let copy = bytes[range].to_vec();
            for _ in 0..=random.below(4) {
                bytes.splice(at..at, copy.iter().copied());
            }
        }
        8 => {
            let from = random.below(other.len());
            let to = (from + random.below(256)).min(other.len());
            bytes.splice(range, other[from..to].iter().copied());
        }
        9 => {
            bytes.drain(range);
        }
        10 => {
            let fill = random.pick(&[0_u8, 0xff, b' ', b'9']);
            bytes.splice(at..at, std::iter::repeat_n(fill, random.below(128)));
        }
        _ => {
            let with = random.below(length);
            bytes.swap(at, with);
        }
    }
}

/// Replaces the number in text that follows `at`, if any.
fn digits(bytes: &mut Vec<u8>, at: usize, random: &mut Random) {
    let is_part = |byte: u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-');
    let Some(start) = bytes[at..].iter().position(|&byte| byte.is_ascii_digit()).map(|offset| at + offset) else {
        return;
    };
    let end = bytes[start..].iter().position(|&byte| !is_part(byte)).map_or(bytes.len(), |offset| start + offset);
    bytes.splice(start..end, random.pick(&TEXTS).bytes());
}
