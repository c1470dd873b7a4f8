//! Documents of MountainsMap.

use super::{Bytes, POINTS, deflated, fixed, is_undefined, joined, lines};

/// Number of the part with the inherited parts of an object.
const BASE: u16 = 0xffff;

/// Returns a part: its number, its length, and its body, which is joined.
fn part(number: u16, body: &[Vec<u8>]) -> Vec<u8> {
    let body = body.concat();
    let head = Bytes::default().shorts(&[number as i16]).ints(&[body.len() as i32, 0]);
    head.add(body).0
}

fn whole(number: u16, value: i32) -> Vec<u8> {
    part(number, &[value.to_le_bytes().to_vec()])
}

fn double(number: u16, value: f64) -> Vec<u8> {
    part(number, &[value.to_le_bytes().to_vec()])
}

fn text(number: u16, text: &str) -> Vec<u8> {
    part(number, &[vec![4], joined(text.encode_utf16().map(u16::to_le_bytes))])
}

fn class(number: i32) -> Vec<u8> {
    part(1, &[whole(1, number)])
}

/// Returns an array of elements in two blocks, the second first.
fn array(kind: i32, elements: &[u8], size: usize) -> Vec<u8> {
    let count = elements.len() / size;
    let half = count / 2;
    let block = |first: usize, elements: &[u8]| {
        let packed = deflated(elements);
        let counts = [first as i32, 0, (elements.len() / size) as i32, packed.len() as i32];
        Bytes::default().ints(&counts).add(packed).0
    };
    let blocks = [block(half, &elements[half * size..]), block(0, &elements[..half * size])].concat();
    let data = Bytes::default().ints(&[elements.len() as i32, 0]).add(blocks).0;
    [class(kind), part(2, &[whole(1, count as i32), part(2, &[data])])].concat()
}

/// MountainsMap: pixels of 0.5 and 0.25 µm, heights of 125 nm per count, shown in µm; a point was not measured if it
/// has a mask.
pub(crate) fn mnt(has_mask: bool) -> Vec<u8> {
    let [nx, ny] = POINTS;
    let axis = |number: u16, step: f64, unit: &str| {
        let body = [double(1, step), text(2, unit), text(3, "\u{b5}m"), double(5, 0.0)];
        part(number, &body)
    };
    let lateral = |number: u16, step: f64, count: usize| {
        part(number, &[part(BASE, &[axis(BASE, step, "\u{b5}m"), whole(1, count as i32)])])
    };
    let mut mask = vec![9; (nx + 2) * (ny + 2)];
    for index in (0..nx * ny).filter(|index| is_undefined(*index)) {
        mask[(index / nx + 1) * (nx + 2) + index % nx + 1] = 22;
    }
    let mask = match has_mask {
        true => part(3, &[class(9056), part(2, &[part(5, &[array(9048, &mask, 1)])])]),
        false => part(3, &[class(0)]),
    };
    let name = part(BASE, &[part(BASE, &[text(1, "Plate")])]);
    let grid = part(BASE, &[name, lateral(1, 0.5, nx), lateral(2, 0.25, ny), mask]);
    let counts = joined(lines().map(|height| i32::from(height).to_le_bytes()));
    let heights = part(2, &[axis(BASE, 125.0, "nm"), whole(1, -150), whole(2, 271)]);
    let surface = part(BASE, &[grid, part(1, &[array(9049, &counts, 4)]), heights]);
    let body = part(2, &[part(1, &[class(9062), part(2, &[surface])])]);
    let entry = |object: &[Vec<u8>]| [vec![0; 8], part(1, object)].concat();
    let entries = part(1, &[entry(&[class(1234)]), entry(&[class(9012), body])]);
    let tree = part(1, &[part(0x2bd, &[part(2, &[entries])])]);
    let mut stream = Bytes::default().ints(&[tree.len() as i32, 0]).add(tree).0;
    stream.resize(stream.len().max(4096).next_multiple_of(512), 0);
    compound("ScopedContents", &stream)
}

/// Returns a compound file with one stream, in sectors of 512 bytes.
fn compound(name: &str, stream: &[u8]) -> Vec<u8> {
    let sectors = stream.len() / 512;
    let name_bytes = joined(name.encode_utf16().map(u16::to_le_bytes));
    let mut field = name_bytes.clone();
    field.resize(64, 0);
    let entry = Bytes::default().add(field).shorts(&[name_bytes.len() as i16 + 2]).add([2, 1]).zeros(48);
    let entry = entry.ints(&[0, stream.len() as i32, 0]).0;
    let folder = [fixed("", 128), entry, fixed("", 256)].concat();
    let chain = (1..sectors as i32).chain([-2, -2, -3]).collect::<Vec<i32>>();
    let mut table = Bytes::default().ints(&chain).0;
    table.resize(512, 0xff);
    let head = Bytes::default().add(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1").zeros(16).shorts(&[62, 3, -2, 9, 6]).zeros(10);
    let head = head.ints(&[1, sectors as i32, 0, 4096, -2, 0, -2, 0, sectors as i32 + 1]);
    let mut head = head.0;
    head.resize(512, 0xff);
    [head, stream.to_vec(), folder, table].concat()
}
