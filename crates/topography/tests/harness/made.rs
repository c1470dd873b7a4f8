//! Small files of every format, built here from the published descriptions, not with the readers or their inverse.
//!
//! The heights of every map are given by [`height`], in the unit named by the file, unless stated otherwise.

#[path = "made/grids.rs"]
pub(crate) mod grids;
#[path = "made/keyence.rs"]
pub(crate) mod keyence;
#[path = "made/mnt.rs"]
pub(crate) mod mnt;
#[path = "made/olympus.rs"]
pub(crate) mod olympus;
#[path = "made/others.rs"]
pub(crate) mod others;
#[path = "made/probes.rs"]
pub(crate) mod probes;
#[path = "made/tiff.rs"]
pub(crate) mod tiff;
#[path = "made/xlsx.rs"]
pub(crate) mod xlsx;

use std::io::{Cursor, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use hdf5::types::{VarLenArray, VarLenAscii};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Number of points along x and y.
pub(crate) const POINTS: [usize; 2] = [5, 4];

/// Point without a height, in files that can have one.
pub(crate) const UNDEFINED: [usize; 2] = [2, 1];

/// Returns the integer of a point: different at each point, with either sign.
pub(crate) fn height(x: usize, y: usize) -> i16 {
    (100 * x + 7 * y) as i16 - 150
}

/// Returns the integers line by line: x runs fastest.
fn lines() -> impl Iterator<Item = i16> {
    (0..POINTS[1]).flat_map(|y| (0..POINTS[0]).map(move |x| height(x, y)))
}

/// Returns the integers line by line from the last line to the first.
fn lines_upwards() -> impl Iterator<Item = i16> {
    (0..POINTS[1]).rev().flat_map(|y| (0..POINTS[0]).map(move |x| height(x, y)))
}

fn is_undefined(index: usize) -> bool {
    index == UNDEFINED[1] * POINTS[0] + UNDEFINED[0]
}

fn joined<const N: usize>(values: impl Iterator<Item = [u8; N]>) -> Vec<u8> {
    values.flatten().collect()
}

/// Returns a text in a field of `size` bytes, padded with zeros.
fn fixed(text: &str, size: usize) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(size, 0);
    bytes
}

/// Bytes written one field after the other.
#[derive(Default)]
struct Bytes(Vec<u8>);

impl Bytes {
    fn add(mut self, bytes: impl AsRef<[u8]>) -> Self {
        self.0.extend_from_slice(bytes.as_ref());
        self
    }

    fn zeros(mut self, count: usize) -> Self {
        self.0.resize(self.0.len() + count, 0);
        self
    }

    fn shorts(self, values: &[i16]) -> Self {
        self.add(joined(values.iter().map(|value| value.to_le_bytes())))
    }

    fn ints(self, values: &[i32]) -> Self {
        self.add(joined(values.iter().map(|value| value.to_le_bytes())))
    }

    fn floats(self, values: &[f32]) -> Self {
        self.add(joined(values.iter().map(|value| value.to_le_bytes())))
    }

    fn doubles(self, values: &[f64]) -> Self {
        self.add(joined(values.iter().map(|value| value.to_le_bytes())))
    }
}

/// Creates a zip archive of entries.
pub(crate) fn zipped(entries: &[(&str, Vec<u8>)], method: CompressionMethod) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(vec![]));
    for (name, bytes) in entries {
        zip.start_file(*name, SimpleFileOptions::default().compression_method(method)).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// Compresses bytes with a zlib header.
pub(crate) fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(vec![], Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// Digital Surf: pixels of 0.5 and 0.25 mm, heights of 0.125 µm per unit, in `streams` compressed parts if not 0.
pub(crate) fn sur(bits: i16, streams: usize, inversion: i16) -> Vec<u8> {
    let [nx, ny] = POINTS.map(|n| n as i32);
    let integer = |(index, value)| if is_undefined(index) { -202 } else { i32::from(value) };
    let data: Vec<u8> = match bits {
        16 => joined(lines().enumerate().map(integer).map(|value| (value as i16).to_le_bytes())),
        _ => joined(lines().enumerate().map(integer).map(i32::to_le_bytes)),
    };
    let body = if streams == 0 {
        data
    } else {
        let parts: Vec<&[u8]> = data.chunks(data.len().div_ceil(streams)).collect();
        let packed: Vec<Vec<u8>> = parts.iter().map(|part| deflated(part)).collect();
        let sizes: Vec<i32> = parts.iter().zip(&packed).flat_map(|(a, b)| [a.len() as i32, b.len() as i32]).collect();
        Bytes::default().ints(&[parts.len() as i32]).ints(&sizes).add(packed.concat()).0
    };
    let names = ["X", "Y", "Z", "mm", "mm", "\u{b5}m", "mm", "mm", "nm"];
    Bytes::default()
        .add(if streams == 0 { b"DIGITAL SURF" } else { b"DSCOMPRESSED" })
        .shorts(&[0, 1, 1, 2])
        .add(fixed("plate", 30))
        .add(fixed("nobody", 30))
        .shorts(&[1, 9, 0, 1, 0])
        .zeros(8)
        .shorts(&[bits])
        .ints(&[-200, 300, nx, ny, nx * ny])
        .floats(&[0.5, 0.25, 0.125])
        .add(names.iter().flat_map(|name| fixed(name, 16)).collect::<Vec<u8>>())
        .floats(&[1.0, 1.0, 1.0])
        .shorts(&[0, inversion, 0])
        .zeros(12)
        .shorts(&[6, 5, 4, 3, 2, 2021, 3])
        .zeros(4)
        .ints(&[body.len() as i32])
        .zeros(6)
        .shorts(&[12, 3])
        .zeros(128)
        .floats(&[0.0, 0.0, 17.5])
        .zeros(34)
        .add("made by hand")
        .add("abc")
        .add(body)
        .0
}

/// Nanoscope: 10 by 5 µm, heights of 2 nm per unit.
pub(crate) fn nanoscope(bytes: usize) -> Vec<u8> {
    let [nx, ny] = POINTS;
    let data: Vec<u8> = match bytes {
        2 => joined(lines_upwards().map(i16::to_le_bytes)),
        _ => joined(lines_upwards().map(|value| (i32::from(value) << 16).to_le_bytes())),
    };
    let header = format!(
        "\\*File list\r\n\\Version: 0x05120130\r\n\\Date: 10:11:12 AM Tue Mar 4 2014\r\n\\*Equipment list\r\n\
         \\Microscope: Test\r\n\\*Scanner list\r\n\\@Sens. Zsens: V 16.0 nm/V\r\n\\*Ciao scan list\r\n\
         \\Operating mode: Image\r\n\\*Ciao image list\r\n\\Data offset: 1024\r\n\\Data length: {}\r\n\
         \\Bytes/pixel: {bytes}\r\n\
         \\Samps/line: {nx}\r\n\\Number of lines: {ny}\r\n\\Scan size: 10 5 ~m\r\n\
         \\@2:Image Data: S [Height] \"Height\"\r\n\\@2:Z scale: V [Sens. Zsens] (0.125 V/LSB) 8192.0 V\r\n\
         \\*File list end\r\n\x1a",
        data.len()
    );
    Bytes::default().add(fixed(&header, 1024)).add(data).0
}

/// Wyko: pixels of 0.5 by 1 mm, heights of 100 nm per unit.
pub(crate) fn opd(bytes: usize) -> Vec<u8> {
    let [nx, ny] = POINTS;
    // Column by column, each from the last line to the first.
    let points: Vec<[usize; 2]> = (0..nx).flat_map(|x| (0..ny).rev().map(move |y| [x, y])).collect();
    let data: Vec<u8> = match bytes {
        2 => joined(points.iter().map(|&p| if p == UNDEFINED { 32767 } else { height(p[0], p[1]) }.to_le_bytes())),
        _ => joined(
            points.iter().map(|&p| if p == UNDEFINED { 1e38 } else { f32::from(height(p[0], p[1])) }.to_le_bytes()),
        ),
    };
    let raster = Bytes::default().shorts(&[nx as i16, ny as i16, bytes as i16]).add(data).0;
    let blocks: [(&str, i16, Vec<u8>); 7] = [
        ("RAW_DATA", 3, raster),
        ("Image", 3, Bytes::default().shorts(&[2, 2, 1]).zeros(4).0),
        ("Title", 5, fixed("made by hand", 20)),
        ("Wavelength", 7, 800_f32.to_le_bytes().to_vec()),
        ("Mult", 6, 8_i16.to_le_bytes().to_vec()),
        ("Aspect", 7, 2_f32.to_le_bytes().to_vec()),
        ("Pixel_size", 7, 0.5_f32.to_le_bytes().to_vec()),
    ];
    let entry = |name: &str, kind: i16, length: usize| {
        Bytes::default().add(fixed(name, 16)).shorts(&[kind]).ints(&[length as i32]).shorts(&[-1]).0
    };
    let mut file = Bytes::default().shorts(&[1]).add(entry("Directory", 1, 24 * (blocks.len() + 1)));
    for (name, kind, body) in &blocks {
        file = file.add(entry(name, *kind, body.len()));
    }
    file.add(blocks.map(|(_, _, body)| body).concat()).0
}

/// Dektak: 3 mm by 4 mm between the first and last points, heights of 1.5 µm per unit.
pub(crate) fn opdx(is_map: bool) -> Vec<u8> {
    fn name(text: &str) -> Vec<u8> {
        Bytes::default().ints(&[text.len() as i32]).add(text).0
    }
    fn block(body: Vec<u8>) -> Vec<u8> {
        Bytes::default().add([4]).ints(&[body.len() as i32]).add(body).0
    }
    fn item(key: &str, kind: u8, body: Vec<u8>) -> Vec<u8> {
        Bytes::default().add(name(key)).add([kind]).add(body).0
    }
    fn container(key: &str, items: &[Vec<u8>]) -> Vec<u8> {
        item(key, 0x7d, block(Bytes::default().add(items.concat()).add(name("")).add([0x7f, 0xff, 0xff]).0))
    }
    fn quantity(key: &str, value: f64, symbol: &str) -> Vec<u8> {
        item(key, 0x13, block(Bytes::default().add(value.to_le_bytes()).add(name("unit")).add(name(symbol)).0))
    }
    fn text(key: &str, value: &str) -> Vec<u8> {
        item(key, 0x12, block(value.as_bytes().to_vec()))
    }
    let [nx, ny] = POINTS.map(|n| n as i32);
    let value = |(index, value)| if is_undefined(index) { f32::NAN } else { f32::from(value) };
    let number = |key: &str, value: i32| item(key, 6, value.to_le_bytes().to_vec());
    let matrix = Bytes::default().ints(&[ny, nx]).add(joined(lines().enumerate().map(value).map(f32::to_le_bytes))).0;
    let matrix = Bytes::default().add(name("type")).ints(&[1]).add(name("Matrix")).add(block(matrix)).0;
    let array = Bytes::default().zeros(5).add(joined((0..POINTS[0]).map(|x| f64::from(height(x, 0)).to_le_bytes()))).0;
    let array = Bytes::default().add(name("Array")).add(block(array)).0;
    let names = Bytes::default().add(name("list")).add(block(name("Raw"))).0;
    let (group, channels) = if is_map { ("2D_Data", "2D_Channels") } else { ("1D_Data", "1D_Channels") };
    let meta = [
        text("DataKind", "Surface Height"),
        text("Date", "2020-02-03"),
        item("Stamp", 0x15, vec![0; 9]),
        container(channels, &[item("Height", 0x42, names)]),
    ];
    let scale = quantity("DataScale", 1.5, "um");
    let map = [
        scale.clone(),
        number("Dimension1Points", ny),
        quantity("Dimension1Extent", 3.0, "mm"),
        number("Dimension2Points", nx),
        quantity("Dimension2Extent", 4.0, "mm"),
        item("Matrix", 0, matrix),
    ];
    let profile = [scale, number("NumPoints", nx), quantity("Extent", 4.0, "mm"), item("Array", 0x40, array)];
    let data = container("Raw", if is_map { &map } else { &profile });
    Bytes::default()
        .add(b"VCA DATA\x01\0\0\x55")
        .add(container("MetaData", &meta))
        .add(container(group, &[data]))
        .add(name(""))
        .add([0x7f])
        .0
}

/// Alicona: pixels of 0.5 by 0.25 m, heights in m; lines with an odd number of points are padded.
pub(crate) fn al3d() -> Vec<u8> {
    let [nx, ny] = POINTS;
    let tags = [
        ("Version", "1".to_owned()),
        ("TagCount", "7".into()),
        ("Cols", nx.to_string()),
        ("Rows", ny.to_string()),
        ("DepthImageOffset", "640".into()),
        ("InvalidPixelValue", "1e10".into()),
        ("PixelSizeXMeter", "0.5".into()),
        ("PixelSizeYMeter", "0.25".into()),
        ("CreatingApplication", "by hand".into()),
    ];
    let mut head = b"AliconaImaging\0\r\n".to_vec();
    for (key, value) in tags {
        head.extend([fixed(key, 20), fixed(&value, 30), b"\r\n".to_vec()].concat());
    }
    head.resize(640, 0);
    let value = |(index, value)| if is_undefined(index) { 1e10 } else { f32::from(value) };
    let values: Vec<f32> = lines().enumerate().map(value).collect();
    let padded =
        values.chunks(nx).flat_map(|line| [joined(line.iter().map(|value| value.to_le_bytes())), vec![0; 4]].concat());
    head.extend(padded);
    head
}

/// MetroPro: pixels of 0.5 m, heights of 2^-15 m per unit of phase.
pub(crate) fn metropro(version: u32, intensities: u16) -> Vec<u8> {
    let [nx, ny] = POINTS.map(|n| n as u16);
    let size = if version == 3 { 4096 } else { 834 };
    let mut head = vec![0; size as usize];
    let mut put = |at: usize, bytes: &[u8]| head[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &(0x881b_036e + version).to_be_bytes());
    put(6, &(size as u32).to_be_bytes());
    put(52, &[4_u16, 3, intensities].map(u16::to_be_bytes).concat());
    put(68, &[nx, ny].map(u16::to_be_bytes).concat());
    put(80, b"made by hand");
    put(164, &[0.5_f32, 2.0].map(f32::to_be_bytes).concat());
    put(176, &1_f32.to_be_bytes());
    put(184, &0.5_f32.to_be_bytes());
    put(218, &1_i16.to_be_bytes());
    let value = |(index, value)| if is_undefined(index) { 2_147_483_640 } else { i32::from(value) };
    head.resize(head.len() + 2 * 4 * 3 * usize::from(intensities), 0);
    head.extend(joined(lines().enumerate().map(value).map(i32::to_be_bytes)));
    head
}

/// Igor wave of version 5 with two channels, one of them a height: pixels of 0.5 by 0.25 m, heights in m.
pub(crate) fn ibw(is_big: bool) -> Vec<u8> {
    let short = |value: i16| if is_big { value.to_be_bytes() } else { value.to_le_bytes() };
    let int = |value: i32| if is_big { value.to_be_bytes() } else { value.to_le_bytes() };
    let float = |value: f32| if is_big { value.to_be_bytes() } else { value.to_le_bytes() };
    let double = |value: f64| if is_big { value.to_be_bytes() } else { value.to_le_bytes() };
    let data = joined(lines_upwards().chain(lines_upwards()).map(|value| float(value.into())));
    let note = "MicroscopeModel: Test\rDate: 2020-02-03\r";
    let labels = [fixed("", 32), fixed("PhaseTrace", 32), fixed("HeightTrace", 32)].concat();
    let [nx, ny] = POINTS.map(|n| n as i32);
    let mut head = vec![0; 64 + 320];
    let mut put = |at: usize, bytes: &[u8]| head[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &short(5));
    put(4, &[320 + data.len() as i32, 0, note.len() as i32].map(int).concat());
    put(36 + 8, &int(labels.len() as i32));
    put(64 + 12, &int(2 * nx * ny));
    put(64 + 16, &short(2));
    put(64 + 68, &[nx, ny, 2].map(int).concat());
    put(64 + 84, &[0.5, 0.25].map(double).concat());
    put(64 + 148, b"m\0\0\0m\0\0\0m\0\0\0");
    let word = |pair: &[u8]| {
        if is_big { i16::from_be_bytes([pair[0], pair[1]]) } else { i16::from_le_bytes([pair[0], pair[1]]) }
    };
    let sum = head.chunks(2).map(word).fold(0, i16::wrapping_add);
    head[2..4].copy_from_slice(&short(sum.wrapping_neg()));
    [head, data, note.as_bytes().to_vec(), labels].concat()
}

/// Igor wave of version 2: a profile with a spacing of 0.5 m, heights in m.
pub(crate) fn ibw_profile() -> Vec<u8> {
    let data = joined((0..POINTS[0]).map(|x| f64::from(height(x, 0)).to_be_bytes()));
    let mut head = vec![0; 16 + 110];
    let mut put = |at: usize, bytes: &[u8]| head[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &2_i16.to_be_bytes());
    put(2, &(110 + 16 + data.len() as i32).to_be_bytes());
    put(16, &4_i16.to_be_bytes());
    put(16 + 34, b"m\0\0\0m\0\0\0");
    put(16 + 42, &(POINTS[0] as i32).to_be_bytes());
    put(16 + 48, &0.5_f64.to_be_bytes());
    [head, data, vec![0; 16]].concat()
}

/// Entries of a Sensofar file: pixels of 0.5 by 0.25 µm, heights in µm.
pub(crate) fn plux() -> Vec<(&'static str, Vec<u8>)> {
    let [nx, ny] = POINTS;
    let index = format!(
        "<?xml version='1.0' encoding='UTF-8'?><xml><GENERAL><DATE>2022-03-04</DATE><IMAGE_SIZE_X>{nx}</IMAGE_SIZE_X>\
         <IMAGE_SIZE_Y>{ny}</IMAGE_SIZE_Y><FOV_X>0.5</FOV_X><FOV_Y>0.25</FOV_Y></GENERAL>\
         <INFO><ITEM_0><NAME>Device</NAME><VALUE>Test</VALUE></ITEM_0></INFO>\
         <LAYER_0><FILENAME_Z>LAYER_0.raw</FILENAME_Z></LAYER_0></xml>"
    );
    let value = |(index, value)| if is_undefined(index) { f32::NAN } else { f32::from(value) };
    let data = joined(lines().enumerate().map(value).map(f32::to_le_bytes));
    vec![("index.xml", index.into_bytes()), ("LAYER_0.raw", data)]
}

/// Sensofar PLu: pixels of 0.5 by 0.25 µm, heights in µm; two layers with an image each.
pub(crate) fn plu() -> Vec<u8> {
    let [nx, ny] = POINTS.map(|n| n as i32);
    let value = |(index, value)| if is_undefined(index) { 1_000_001.0 } else { f32::from(value) };
    let data = joined(lines().enumerate().map(value).map(f32::to_le_bytes));
    let layer = Bytes::default().ints(&[ny, nx]).add(data).floats(&[-1.0, 1.0]).zeros(3 * POINTS[0] * POINTS[1]).0;
    Bytes::default()
        .add(fixed("Fri Mar 10 16:35:59 2023", 128))
        .zeros(4)
        .add(fixed("made by hand", 256))
        .ints(&[ny, nx, nx])
        .floats(&[1.0, 0.5, 0.25])
        .zeros(4 * 4)
        .ints(&[3, 0, 0, 14, 3])
        .zeros(40)
        .add([0, 2, 0xfb, 6, 1, 0, 0, 0])
        .ints(&[1])
        .add(&layer)
        .add(&layer)
        .0
}

/// Molecular Imaging: 10 by 5 µm, heights of 2^-10 µm per unit; the first of two channels is not a height.
pub(crate) fn mi(bits: usize) -> Vec<u8> {
    let data: Vec<u8> = match bits {
        16 => joined(lines_upwards().chain(lines_upwards()).map(i16::to_le_bytes)),
        _ => joined(lines_upwards().chain(lines_upwards()).map(|value| (i32::from(value) << 16).to_le_bytes())),
    };
    let kind = if bits == 16 { "BINARY" } else { "BINARY_32" };
    let header = format!(
        "fileType      Image\nversion       hand\nmode          Contact AFM\nxPixels       {}\nyPixels       {}\n\
         xLength       1e-05\nyLength       5e-06\nbufferLabel   Friction\nbufferRange   10\nbufferUnit    V\n\
         bufferLabel   Topography\nbufferRange   32\nbufferUnit    um\ndata          {kind}\n",
        POINTS[0], POINTS[1]
    );
    [header.into_bytes(), data].concat()
}

/// Nanosurf: 10 by 5 µm, heights of 2^-20 m per unit, a range from -1/32 m; the first of two channels is not a height.
pub(crate) fn nanosurf() -> Vec<u8> {
    let section = |number: usize, name: &str, unit: &str| {
        format!(
            "[DataSet-0:{number}]\r\nPoints={}\r\nLines={}\r\nFrame=Scan forward\r\nDim0Unit=m\r\nDim0Range=1e-05\r\n\
             Dim1Unit=m\r\nDim1Range=5e-06\r\nDim2Name={name}\r\nDim2Unit={unit}\r\nDim2Range=0.0625\r\n\
             Dim2Min=-0.03125\r\n\
             SaveMode=Binary\r\nSaveBits=16\r\nSaveSign=Signed\r\nSaveOrder=Intel\r\n",
            POINTS[0], POINTS[1]
        )
    };
    let header = format!(
        "[DataSet]\r\nVersion=2\r\nGroupCount=1\r\nGr0-Count=8\r\nGr0-Ch0=DataSet-0:0\r\nGr0-Ch7=DataSet-0:7\r\n\
         [DataSet-Info]\r\nHead type=Test\r\n{}{}#!",
        section(0, "Deflection", "N"),
        section(7, "Z-Axis", "m")
    );
    [header.into_bytes(), joined(lines_upwards().chain(lines_upwards()).map(i16::to_le_bytes))].concat()
}

/// Link in Zygo metadata.
#[derive(Clone, hdf5::H5Type)]
#[repr(C)]
struct Link {
    source: VarLenAscii,
    link: VarLenAscii,
    destination: VarLenAscii,
}

/// Converter of Zygo.
#[derive(Clone, hdf5::H5Type)]
#[repr(C)]
struct Converter {
    category: VarLenAscii,
    base_unit: VarLenAscii,
    parameters: VarLenArray<f64>,
}

/// Zygo Mx: pixels of 0.5 by 0.25 m, heights in nm.
pub(crate) fn datx(path: &Path) {
    let text = |text: &str| VarLenAscii::from_ascii(text).unwrap();
    let file = hdf5::File::create(path).unwrap();
    let links = [("Root", "Measurement", "{m}"), ("{m}", "Surface", "{s}"), ("{s}", "Path", "/Data/Surface/{s}")];
    let links = links.map(|(a, b, c)| Link { source: text(a), link: text(b), destination: text(c) });
    file.new_dataset_builder().with_data(&links).create("MetaData").unwrap();
    let value = |(index, value)| if is_undefined(index) { f64::MAX } else { f64::from(value) };
    let values = lines().enumerate().map(value).collect::<Vec<f64>>();
    file.create_group("Data").unwrap().create_group("Surface").unwrap();
    let surface = file.new_dataset::<f64>().shape([POINTS[1], POINTS[0]]).create("/Data/Surface/{s}").unwrap();
    surface.write_raw(&values).unwrap();
    surface.new_attr::<f64>().shape(1).create("No Data").unwrap().write_raw(&[f64::MAX]).unwrap();
    surface.new_attr::<VarLenAscii>().shape(1).create("Unit").unwrap().write_raw(&[text("NanoMeters")]).unwrap();
    for (name, category, unit, step) in [
        ("X Converter", "LateralCat", "Pixels", 0.5),
        ("Y Converter", "LateralCat", "Pixels", 0.25),
        ("Z Converter", "HeightCat", "NanoMeters", 1.0),
    ] {
        let parameters = VarLenArray::from_slice(&[0.0, step, 1.0, 1.0, 0.0]);
        let converter = Converter { category: text(category), base_unit: text(unit), parameters };
        surface.new_attr::<Converter>().shape(1).create(name).unwrap().write_raw(&[converter]).unwrap();
    }
}
