//! TIFF files: of JPK, Park and LEXT, and images with and without a size.

use super::{Bytes, POINTS, deflated, is_undefined, joined, lines, lines_upwards};

/// Value of a tag.
enum Value {
    Short(u16),
    Long(u32),
    Doubles(Vec<f64>),
    Shorts(Vec<u16>),
    Ratio(u32, u32),
    Text(String),
    Bytes(Vec<u8>),
    Page(Page),
}

use Value::{Doubles, Long, Ratio, Short, Shorts, Text};

/// Page of tags, with the strips or tiles of its image.
#[derive(Default)]
struct Page {
    tags: Vec<(u16, Value)>,
    parts: Vec<Vec<u8>>,
}

impl Page {
    fn tag(mut self, tag: u16, value: Value) -> Self {
        self.tags.push((tag, value));
        self
    }

    fn text(self, tag: u16, text: &str) -> Self {
        self.tag(tag, Text(text.to_owned()))
    }
}

/// Returns the tags of an image of `lines` lines a strip.
fn image(bits: u16, kind: u16, lines: u32, parts: Vec<Vec<u8>>) -> Page {
    let [nx, ny] = POINTS.map(|n| n as u32);
    let page = Page { tags: vec![], parts }.tag(256, Long(nx)).tag(257, Long(ny)).tag(258, Short(bits));
    page.tag(277, Short(1)).tag(278, Long(lines)).tag(339, Short(kind))
}

/// Writes pages in either byte order.
struct Writer {
    bytes: Vec<u8>,
    is_big: bool,
}

impl Writer {
    fn short(&self, value: u16) -> [u8; 2] {
        if self.is_big { value.to_be_bytes() } else { value.to_le_bytes() }
    }

    fn long(&self, value: u32) -> [u8; 4] {
        if self.is_big { value.to_be_bytes() } else { value.to_le_bytes() }
    }

    /// Returns the type of a value, the number of its entries, and its bytes.
    fn value(&mut self, value: &Value) -> (u16, usize, Vec<u8>) {
        let double = |value: &f64| if self.is_big { value.to_be_bytes() } else { value.to_le_bytes() };
        match value {
            Short(value) => (3, 1, self.short(*value).to_vec()),
            Long(value) => (4, 1, self.long(*value).to_vec()),
            Doubles(values) => (12, values.len(), joined(values.iter().map(double))),
            Shorts(values) => (3, values.len(), joined(values.iter().map(|value| self.short(*value)))),
            Ratio(above, below) => (5, 1, [self.long(*above), self.long(*below)].concat()),
            Text(text) => (2, text.len() + 1, [text.as_bytes(), &[0]].concat()),
            Value::Bytes(bytes) => (7, bytes.len(), bytes.clone()),
            Value::Page(page) => {
                let at = self.page(page).0 as u32;
                (4, 1, self.long(at).to_vec())
            }
        }
    }

    /// Writes a page. Returns its position and the position of the link to the next page.
    fn page(&mut self, page: &Page) -> (usize, usize) {
        let place = |part: &Vec<u8>, bytes: &mut Vec<u8>| {
            bytes.extend(part);
            [(bytes.len() - part.len()) as u32, part.len() as u32]
        };
        let places: Vec<[u32; 2]> = page.parts.iter().map(|part| place(part, &mut self.bytes)).collect();
        let mut values: Vec<(u16, u16, usize, Vec<u8>)> = vec![];
        for (tag, value) in &page.tags {
            let (kind, count, bytes) = self.value(value);
            values.push((*tag, kind, count, bytes));
        }
        let is_tiled = page.tags.iter().any(|(tag, _)| *tag == 322);
        for (index, tag) in if is_tiled { [324, 325] } else { [273, 279] }.into_iter().enumerate() {
            let bytes = joined(places.iter().map(|place| self.long(place[index])));
            values.push((tag, 4, places.len(), bytes));
        }
        values.sort_by_key(|(tag, ..)| *tag);
        let mut directory = self.short(values.len() as u16).to_vec();
        for (tag, kind, count, mut bytes) in values {
            directory.extend([self.short(tag), self.short(kind)].concat());
            directory.extend(self.long(count as u32));
            if bytes.len() > 4 {
                directory.extend(self.long(self.bytes.len() as u32));
                self.bytes.extend(bytes);
            } else {
                bytes.resize(4, 0);
                directory.extend(bytes);
            }
        }
        let at = self.bytes.len();
        self.bytes.extend(directory);
        self.bytes.extend([0; 4]);
        (at, self.bytes.len() - 4)
    }
}

/// Writes a file of pages.
fn written(pages: &[Page], is_big: bool) -> Vec<u8> {
    let start: &[u8] = if is_big { b"MM\0*\0\0\0\0" } else { b"II*\0\0\0\0\0" };
    let (mut writer, mut link) = (Writer { bytes: start.to_vec(), is_big }, 4);
    for page in pages {
        let (at, next) = writer.page(page);
        let at = writer.long(at as u32);
        writer.bytes[link..link + 4].copy_from_slice(&at);
        link = next;
    }
    writer.bytes
}

/// JPK: 2.5 by 1 m, heights of 0.125 m per count in the default of four slots; a channel in volts, and a retrace.
pub(crate) fn jpk(is_big: bool, is_reflected: bool) -> Vec<u8> {
    let counts: Vec<i16> = if is_reflected { lines().collect() } else { lines_upwards().collect() };
    let order = |count: &i32| if is_big { count.to_be_bytes() } else { count.to_le_bytes() };
    let channel = |name: &str, shown: &str, retrace: u16, default: &str, factor: i32| {
        let data = joined(counts.iter().map(|count| order(&(factor * i32::from(*count)))));
        let mut page = image(32, 2, 4, vec![data]).text(0x8050, name).tag(0x8051, Short(retrace)).text(0x8052, shown);
        page = page.tag(0x8080, Short(4)).text(0x8081, default);
        for (k, (slot, unit, scale)) in
            [("volts", "V", 7.0), ("nominal", "m", 3.0), ("calibrated", "m", 0.125)].into_iter().enumerate()
        {
            let first = 0x8090 + 0x30 * (k as u16 + 1);
            page = page.text(first, slot).text(first + 0x12, unit).text(first + 0x13, "LinearScaling");
            page = page.tag(first + 0x14, Doubles(vec![scale])).tag(first + 0x15, Doubles(vec![0.0]));
        }
        page = page.text(0x8090, "raw").text(0x80a3, "NullScaling");
        if is_reflected { page.tag(0x8045, Short(1)) } else { page }
    };
    let first =
        Page::default().tag(0x8042, Doubles(vec![2.5])).tag(0x8043, Doubles(vec![1.0])).text(0x8003, "2024-02-29");
    let pages = [
        first,
        channel("vDeflection", "Vertical Deflection", 0, "volts", 1),
        channel("height", "Height", 0, "calibrated", 1),
        channel("height", "Height", 1, "calibrated", 2),
    ];
    written(&pages, is_big)
}

/// Park: 2.5 by 1 µm, heights of 0.125 µm per number, of the first version or the second.
pub(crate) fn park(is_second: bool, unit: &str) -> Vec<u8> {
    let wide = |text: &str, count: usize| {
        let mut units: Vec<u16> = text.encode_utf16().collect();
        units.resize(count, 0);
        joined(units.into_iter().map(u16::to_le_bytes))
    };
    let [nx, ny] = POINTS.map(|n| n as i32);
    let mut header =
        Bytes::default().ints(&[0]).add(wide("Topography", 32)).add(wide("NCM", 8)).zeros(16).ints(&[nx, ny]);
    header = header.zeros(32).doubles(&[2.5, 1.0]).zeros(64).doubles(&[-0.125, -1.0, 0.0]).add(wide(unit, 8)).zeros(24);
    header = if is_second { header.zeros(64).ints(&[2]) } else { header.zeros(64) };
    let data = match is_second {
        true => joined(lines_upwards().map(|height| f32::from(height).to_le_bytes())),
        false => joined(lines_upwards().map(i16::to_le_bytes)),
    };
    let page = image(8, 1, 4, vec![vec![0; 20]]).tag(50432, Long(0x0e03_1301));
    let page = page.tag(50433, Long(if is_second { 0x0100_0002 } else { 0x0100_0001 }));
    written(&[page.tag(50434, Value::Bytes(data)).tag(50435, Value::Bytes(header.0))], is_second)
}

/// LEXT: pixels of 0.5 and 0.25 µm, heights of 0.125 µm per count above 150; a point was not measured.
pub(crate) fn lext() -> Vec<u8> {
    let number = |key: &str, axis: char, value: u32| format!("<{key}{axis}>{value}</{key}{axis}>");
    let sizes =
        [('X', 500_000), ('Y', 500_000), ('Z', 125_000)].map(|(axis, size)| number("HeightDataPerPixel", axis, size));
    let factors = [('X', 1_000_000), ('Y', 500_000), ('Z', 1_000_000)]
        .map(|(axis, factor)| number("MakerCalibrationValue", axis, factor));
    let factors = format!(
        "<ExifTagDescData><ImageCommonSettingsInfo>{}</ImageCommonSettingsInfo></ExifTagDescData>",
        factors.concat()
    );
    let first = image(8, 1, 4, vec![vec![0; 20]]);
    let first =
        first.text(270, &format!("<TiffTagDescData><HeightInfo>{}</HeightInfo></TiffTagDescData>", sizes.concat()));
    let first = first.tag(34665, Value::Page(Page::default().text(0xa40b, &factors)));
    let counts = joined(lines().map(|height| (height as u16).wrapping_add(150).to_le_bytes()));
    let mask: Vec<u8> = (0..POINTS[1])
        .map(|y| (0..8).fold(0, |row, x| row << 1 | u8::from(x < 5 && is_undefined(5 * y + x))))
        .collect();
    let heights = image(16, 1, 4, vec![counts]).text(270, "HEIGHT");
    written(&[first, image(1, 1, 4, vec![mask]).tag(262, Short(4)).text(270, "INVALID"), heights], false)
}

/// Image of 16-bit integers, two lines a strip, deflated as differences, big-endian.
pub(crate) fn deflated_strips() -> Vec<u8> {
    let heights: Vec<i16> = lines().collect();
    let difference = |line: &[i16], x: usize| line[x].wrapping_sub(if x == 0 { 0 } else { line[x - 1] }).to_be_bytes();
    let strip =
        |strip: &[i16]| deflated(&joined(strip.chunks(5).flat_map(|line| (0..5).map(move |x| difference(line, x)))));
    let parts = heights.chunks(10).map(strip).collect();
    written(&[image(16, 2, 2, parts).tag(259, Short(8)).tag(317, Short(2))], true)
}

/// Image of floats in tiles of 4 by 3 points, deflated as differences of sorted bytes.
pub(crate) fn float_tiles() -> Vec<u8> {
    let heights: Vec<i16> = lines().collect();
    let tile = |[x, y]: [usize; 2]| {
        let row = |y: usize| {
            let point = |k: usize| if x + k < 5 && y < 4 { f32::from(heights[5 * y + x + k]) } else { 0.0 };
            let planes: Vec<u8> = (0..16).map(|k| point(k % 4).to_be_bytes()[k / 4]).collect();
            (0..16).map(move |k| planes[k].wrapping_sub(if k == 0 { 0 } else { planes[k - 1] }))
        };
        deflated(&(y..y + 3).flat_map(row).collect::<Vec<u8>>())
    };
    let parts = [[0, 0], [4, 0], [0, 3], [4, 3]].map(tile).to_vec();
    let page = image(32, 3, 4, parts).tag(259, Short(8)).tag(317, Short(3)).tag(322, Short(4)).tag(323, Short(3));
    written(&[page], false)
}

/// Image of plain floats.
fn floats() -> Page {
    image(32, 3, 4, vec![joined(lines().map(|height| f32::from(height).to_le_bytes()))])
}

/// Image of ImageJ: pixels of 0.5 and 0.25 µm, and heights in nm if they have a scale.
pub(crate) fn imagej(is_scaled: bool) -> Vec<u8> {
    let scale = if is_scaled { "c0=0\nc1=0.125\nvunit=nm\n" } else { "" };
    let page = floats().text(270, &format!("ImageJ=1.54f\nunit=\\u00B5m\n{scale}")).tag(282, Ratio(4, 2));
    written(&[page.tag(283, Ratio(4, 1)), floats()], false)
}

/// Image of OME: pixels of 0.5 and 0.25 µm.
pub(crate) fn ome() -> Vec<u8> {
    let text =
        "<OME><Image><Pixels PhysicalSizeX=\"0.5\" PhysicalSizeY=\"250\" PhysicalSizeYUnit=\"nm\"/></Image></OME>";
    written(&[floats().text(270, text)], false)
}

/// Image of the ground: pixels of 0.5 and 0.25 m, heights of 0.125 m, a missing point; in degrees with `model` 2.
pub(crate) fn ground(model: u16) -> Vec<u8> {
    let height = |(index, height)| if is_undefined(index) { -9999.0 } else { f32::from(height) };
    let data = joined(lines().enumerate().map(height).map(f32::to_le_bytes));
    let metadata = "<GDALMetadata><Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.125</Item></GDALMetadata>";
    let keys = vec![1, 1, 0, 2, 1024, 0, 1, model, 3076, 0, 1, 9001];
    let page = image(32, 3, 4, vec![data]).tag(33550, Doubles(vec![0.5, 0.25, 0.0])).tag(34735, Shorts(keys));
    written(&[page.text(42112, metadata).text(42113, "-9999")], false)
}

/// GeoTIFF whose matrix of coordinates has these elements for a step along a line and for the next line.
pub(crate) fn ground_with_matrix([along_x, turn, along_y]: [f64; 3]) -> Vec<u8> {
    let data = joined(lines().map(f32::from).map(f32::to_le_bytes));
    let mut matrix = vec![0.0; 16];
    (matrix[0], matrix[1], matrix[5], matrix[15]) = (along_x, turn, along_y, 1.0);
    written(&[image(32, 3, 4, vec![data]).tag(34264, Doubles(matrix))], false)
}
