#!/usr/bin/env python3
"""Writes small files of instruments' formats into a folder, for `compare.py`: variants of which no example is at hand.

    python3 make_examples.py FOLDER

The layouts are the published ones (the notes of each reader in crates/topography/src name them); nothing here is
taken from the readers. Needs numpy and h5py.
"""

import io
import pathlib
import struct
import sys
import zipfile
import zlib

import h5py
import numpy as np

RNG = np.random.default_rng(20261120)


def integers(shape, kind):
    limits = np.iinfo(kind)
    return RNG.integers(limits.min // 4, limits.max // 4, shape, dtype=kind)


def fixed(text, size):
    return text.encode("latin-1").ljust(size, b"\0")


# Digital Surf


def sur(bits=32, compressed=False, inversion=0, units=("mm", "mm", "µm"), shape=(7, 5), special=0, streams=1, kind=2,
        objects=1):
    """Lines from the top; the second line has an undefined point if there are special points."""
    ny, nx = shape
    file = b""
    for _ in range(objects):
        data = integers(shape, f"<i{bits // 8}")
        smallest = int(data.min())
        if special:
            data[1, 2] = smallest - 2
        raw, body = data.tobytes(), b""
        if compressed:
            cuts = np.linspace(0, len(raw), streams + 1).astype(int)
            parts = [raw[a:b] for a, b in zip(cuts[:-1], cuts[1:])]
            packed = [zlib.compress(part) for part in parts]
            body = struct.pack("<I", streams)
            body += b"".join(struct.pack("<II", len(p), len(z)) for p, z in zip(parts, packed)) + b"".join(packed)
        else:
            body = raw
        comment = b"made by hand"
        header = b"DSCOMPRESSED" if compressed else b"DIGITAL SURF"
        header += struct.pack("<4H", 0, objects, 1, kind) + fixed("plate", 30) + fixed("nobody", 30)
        header += struct.pack("<5H", 1, 9, 0, special, 0) + bytes(8) + struct.pack("<H", bits)
        header += struct.pack("<5i", smallest, int(data.max()), nx, ny, nx * ny)
        header += struct.pack("<3f", 0.25, 0.5, 1.0 / 3)
        header += b"".join(fixed(name, 16) for name in ("X", "Y", "Z"))
        header += 2 * b"".join(fixed(unit, 16) for unit in units)
        header += struct.pack("<3f", 1, 1, 1) + struct.pack("<3H", 0, inversion, 0) + bytes(12)
        header += struct.pack("<7H", 6, 5, 4, 3, 2, 2021, 3) + bytes(4) + struct.pack("<I", len(body)) + bytes(6)
        header += struct.pack("<2H", len(comment), 3) + bytes(128) + struct.pack("<3f", 0, 0, 17.5) + bytes(34)
        assert len(header) == 512
        file += header + comment + b"abc" + body
    return file


# Nanoscope


def nanoscope(
    size=2,
    version="0x05120130",
    bits=None,
    sensitivity="V 12.5 nm/V",
    scale="V [Sens. Zsens] (0.006 V/LSB) 440.0 V",
    scan="10 5 ~m",
    more="",
    points=(6, 4),
):
    nx, ny = points
    stored = bits or 8 * size
    data = integers((ny, nx), f"<i{stored // 8}")
    start = 4096

    def header(offset):
        lines = [
            "\\*File list",
            f"\\Version: {version}",
            "\\Date: 10:11:12 AM Tue Mar 4 2014",
            "\\*Equipment list",
            "\\Microscope: Test",
            "\\*Scanner list",
            f"\\@Sens. Zsens: {sensitivity}",
            "\\*Ciao scan list",
            "\\Operating mode: Image",
            f"\\Samps/line: {nx}",
            f"\\Lines: {ny}",
            *more.split("|"),
            "\\*Ciao image list",
            f"\\Data offset: {offset}",
            f"\\Data length: {data.nbytes}",
            f"\\Bytes/pixel: {size}",
            f"\\Samps/line: {nx}",
            f"\\Number of lines: {ny}",
            f"\\Scan size: {scan}",
            "\\Aspect ratio: 1:1",
            '\\@2:Image Data: S [Height] "Height"',
            f"\\@2:Z scale: {scale}",
            "\\*File list end",
            "",
        ]
        return "\r\n".join(line for line in lines if line is not None and line != "\\").encode("latin-1")

    head = b"\r\n".join(line for line in header(start).split(b"\r\n") if line)
    return (head + b"\r\n\x1a").ljust(start, b"\0") + data.tobytes()


# Wyko


def opd(kind="<i2", undefined=32767, aspect=1.25, name="RAW_DATA", mult=8):
    data = integers((5, 7), "<i2").astype(kind)
    data[2, 3] = undefined
    raster = struct.pack("<3H", 5, 7, data.itemsize) + data.tobytes()
    blocks = [
        (name, 3, raster),
        ("Image", 3, struct.pack("<3H", 5, 7, 1) + bytes(35)),
        ("Title", 5, fixed("made by hand", 20)),
        ("Wavelength", 7, struct.pack("<f", 632.8)),
        ("Mult", 6, struct.pack("<h", mult)),
        ("Aspect", 7, struct.pack("<f", aspect)),
        ("Pixel_size", 7, struct.pack("<f", 0.00125)),
    ]
    entries = [("Directory", 1, 24 * (len(blocks) + 1))] + [(name, kind, len(body)) for name, kind, body in blocks]
    directory = b"".join(fixed(name, 16) + struct.pack("<hlH", kind, length, 0xFFFF) for name, kind, length in entries)
    return b"\x01\x00" + directory + b"".join(body for _, _, body in blocks)


# Dektak


def opdx(units=("mm", "mm", "um"), anonymous=False):
    def name(text):
        return struct.pack("<I", len(text.encode())) + text.encode()

    def block(body):
        return struct.pack("<BH", 2, len(body)) + body if len(body) < 60000 else struct.pack("<BI", 4, len(body)) + body

    def item(key, kind, body):
        return name(key) + bytes([kind]) + body

    def container(key, kind, *items):
        return item(key, kind, block(b"".join(items) + name("") + b"\x7f" + b"\xff\xff"))

    def quantity(key, value, symbol):
        return item(key, 0x13, block(struct.pack("<d", value) + name("unit") + name(symbol)))

    def text(key, value):
        return item(key, 0x12, block(value.encode()))

    def names(key, *values):
        return item(key, 0x42, name("string list") + block(b"".join(name(value) for value in values)))

    def matrix(data):
        body = block(struct.pack("<II", *data.shape) + data.tobytes())
        if anonymous:
            return item("Matrix", 0x45, name("Matrix<float>") + body)
        return item("Matrix", 0x00, name("type") + struct.pack("<I", 1) + name("Matrix<float>") + body)

    def data(key, shape):
        heights = RNG.normal(size=shape).astype("<f4")
        heights[1, 1] = np.nan
        return container(
            key, 0x47, text("DataKind", "Surface Height"), quantity("DataScale", 1.25, units[2]),
            item("Dimension1Points", 7, struct.pack("<I", shape[0])), quantity("Dimension1Extent", 3.5, units[1]),
            item("Dimension2Points", 7, struct.pack("<I", shape[1])), quantity("Dimension2Extent", 4.25, units[0]),
            matrix(heights))

    meta = container(
        "MetaData", 0x7D, text("DataKind", "Surface Height"), text("Date", "2020-02-03"), text("Time", "04:05:06"),
        item("Stamp", 0x15, bytes(9)), text("PrimaryData2D", "Second"),
        container("2D_Channels", 0x7D, names("Height", "Raw", "Second")),
        container("MeasurementSettings", 0x7D, text("InstrumentName", "Test")))
    return (
        b"VCA DATA\x01\x00\x00\x55"
        + meta
        + container("2D_Data", 0x7D, data("Raw", (5, 6)), data("Second", (4, 3)))
        + name("")
        + b"\x7f"
    )


# Alicona


def al3d(shape=(4, 5), invalid="1e10"):
    ny, nx = shape
    data = (RNG.normal(size=shape) * 1e-6).astype("<f4")
    data[1, 2] = float(invalid)
    tags = [
        ("Cols", nx),
        ("Rows", ny),
        ("DepthImageOffset", 2048),
        ("TextureImageOffset", 0),
        ("IconOffset", 0),
        ("NumberOfPlanes", 0),
        ("InvalidPixelValue", invalid),
        ("PixelSizeXMeter", 4.5e-7),
        ("PixelSizeYMeter", 5.5e-7),
        ("CreatingApplication", "by hand"),
    ]
    tags = [("Version", 1), ("TagCount", len(tags)), *tags]
    head = b"AliconaImaging\0\r\n" + b"".join(fixed(key, 20) + fixed(str(value), 30) + b"\r\n" for key, value in tags)
    padding = bytes(-4 * nx % 8)
    return head.ljust(2048, b"\0") + b"".join(line.tobytes() + padding for line in data)


# MetroPro


def metropro(version=3, sign=0, resolution=2, intensities=0, lateral=2e-6):
    header = bytearray(4096 if version == 3 else 834)
    header[:4] = struct.pack(">I", 0x881B036E + version)

    def put(at, form, *values):
        struct.pack_into(">" + form, header, at, *values)

    put(4, "HI", version, len(header))
    put(52, "HHH", 4, 3, intensities)
    put(68, "HH", 5, 4)
    header[80:92] = b"made by hand"
    put(164, "fff", 0.5, 6.328e-7, 0.1)
    put(176, "fff", 0.97, 10.0, lateral)
    put(218, "h", resolution)
    put(232, "h", sign)
    data = integers((4, 5), "<i4").astype(">i4")
    data[2, 1] = 2147483640
    return bytes(header) + bytes(2 * 4 * 3 * intensities) + data.tobytes()


# Igor


def ibw(order="<", shape=(6, 4, 3), kind="f4", labels=("HeightTrace", "PhaseTrace", "ZSensorRetrace"), unit="m",
        sides=("m", "m"), note="MicroscopeModel: Test\rVersion: 11\r"):
    code = {"f4": 2, "f8": 4, "i2": 0x10}[kind]
    data = integers(shape, "<i2") if kind == "i2" else RNG.normal(size=shape) * 1e-7
    body = np.asfortranarray(data).astype(order + kind).tobytes(order="F")
    label = b"".join(fixed(text, 32) for text in ("", *labels)) if labels else b""
    dims = [*shape, 0, 0, 0, 0][:4]
    axis = 2 if len(shape) == 3 else 1
    wave = struct.pack(order + "III", 0, 0, 0) + struct.pack(order + "ihh", int(np.prod(shape)), code, 0) + bytes(6)
    wave += struct.pack(order + "h", 1) + fixed("wave", 32) + bytes(8) + struct.pack(order + "4i", *dims)
    wave += struct.pack(order + "8d", 2.5e-8, 3.5e-8, 1, 1, 0, 0, 0, 0)
    wave += fixed(unit, 4) + fixed(sides[0], 4) + fixed(sides[1], 4) + bytes(8)
    wave = wave.ljust(320, b"\0")
    sizes = [0, 0, 0, 0]
    sizes[axis] = len(label)
    head = struct.pack(order + "hhiiii", 5, 0, 320 + len(body), 0, len(note), 0) + bytes(16)
    head += struct.pack(order + "4i", *sizes) + struct.pack(order + "3i", 0, 0, 0)
    assert len(head) == 64 and len(wave) == 320
    total = int(np.frombuffer(head + wave, order + "i2").sum(dtype=np.int64))
    head = head[:2] + struct.pack(order + "h", (-total + 0x8000) % 0x10000 - 0x8000) + head[4:]
    return head + wave + body + note.encode("latin-1") + label


# Sensofar


def plux(layers=1, method=zipfile.ZIP_DEFLATED):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as archive:
        entries = "".join(f"<LAYER_{k}><FILENAME_Z>LAYER_{k}.raw</FILENAME_Z></LAYER_{k}>" for k in range(layers))
        archive.writestr(
            "index.xml",
            "<?xml version='1.0' encoding='UTF-8'?><xml><GENERAL><DATE>2022-03-04 05:06:07</DATE>"
            "<IMAGE_SIZE_X>6</IMAGE_SIZE_X><IMAGE_SIZE_Y>5</IMAGE_SIZE_Y>"
            "<FOV_X>0.645</FOV_X><FOV_Y>0.75</FOV_Y></GENERAL>"
            f"<INFO><ITEM_0><NAME>Device</NAME><VALUE>S neox</VALUE></ITEM_0></INFO>{entries}</xml>")
        archive.writestr("recipe.txt", "<?xml version='1.0'?><xml><RECIPE>none</RECIPE></xml>")
        for k in range(layers):
            data = RNG.normal(size=(5, 6)).astype("<f4")
            data[3, 4] = np.nan
            archive.writestr(f"LAYER_{k}.raw", data.tobytes())
    return file.getvalue()


# Zygo Mx


def datx(path, kind="<f8", variable=False, compression=None):
    text = h5py.string_dtype("ascii")
    parameters = ("Parameters", h5py.vlen_dtype("f8")) if variable else ("Parameters", "f8", (5,))
    converter = np.dtype([("Category", text), ("BaseUnit", text), parameters])
    with h5py.File(path, "w") as file:
        links = [("Root", "Measurement", "{m}"), ("{m}", "Surface", "{s}"), ("{s}", "Path", "/Data/Surface/{s}")]
        kinds = np.dtype([("Source", text), ("Link", text), ("Destination", text)])
        file.create_dataset("MetaData", data=np.array(links, dtype=kinds))
        data = (RNG.normal(size=(5, 6)) * 100).astype(kind)
        none = float(np.finfo(kind).max)
        data[1, 4] = none
        surface = file.create_dataset("/Data/Surface/{s}", data=data, compression=compression)
        surface.attrs.create("No Data", [none])
        surface.attrs.create("Unit", [b"NanoMeters"], dtype=text)
        for name, category, unit, values in [("X Converter", "LateralCat", "Pixels", [0, 1.25e-6, 1, 1, 0]),
                                             ("Y Converter", "LateralCat", "Pixels", [0, 1.5e-6, 1, 1, 0]),
                                             ("Z Converter", "HeightCat", "NanoMeters", [0, 1, 1, 1, 0])]:
            values = np.array(values, dtype="f8")
            value = np.empty(1, dtype=converter)
            value[0] = (category, unit, values)
            surface.attrs.create(name, value, dtype=converter)


def main():
    folder = pathlib.Path(sys.argv[1])
    files = {
        "sur-16.sur": sur(bits=16),
        "sur-32.sur": sur(units=("nm", "\xb5m", "m")),
        "sur-undefined.sur": sur(special=1),
        "sur-inverted.sur": sur(inversion=1),
        "sur-flipped.sur": sur(inversion=2),
        "sur-flopped.sur": sur(inversion=3, bits=16),
        "sur-units.sur": sur(units=("\xe6m", "\xe6m", "nm")),
        "sur-compressed.sur": sur(compressed=True, special=1),
        "sur-streams.sur": sur(compressed=True, bits=16, streams=3),
        "sur-series.sur": sur(kind=5, objects=3),
        "sur-profile.pro": sur(kind=1, shape=(1, 9)),
        "di-16.spm": nanoscope(),
        "di-32.spm": nanoscope(size=4),
        "di-9.2.spm": nanoscope(version="0x09200103", bits=32),
        "di-mV.spm": nanoscope(scale="V [Sens. Zsens] (0.006 V/LSB) 440.0 mV"),
        "di-slow.spm": nanoscope(more="\\Scan Size: 10 ~m|\\Slow Axis Size: 2500 nm"),
        "di-square.spm": nanoscope(scan="10 nm"),
        "di-angstrom.spm": nanoscope(sensitivity="V 12.5 A/V", scan="100 80 A"),
        "opd-16.opd": opd(),
        "opd-float.opd": opd(kind="<f4", undefined=1e38, mult=1),
        "opd-nan.opd": opd(kind="<f4", undefined=np.nan),
        "opd-bytes.opd": opd(kind="u1", undefined=255, name="OPD"),
        "opd-32766.opd": opd(undefined=32766, name="SAMPLE_DATA"),
        "opdx-2d.opdx": opdx(),
        "opdx-units.opdx": opdx(units=("um", "mm", "nm"), anonymous=True),
        "al3d-odd.al3d": al3d(),
        "al3d-even.al3d": al3d(shape=(3, 4), invalid="-1e10"),
        "al3d-nan.al3d": al3d(invalid="nan"),
        "metropro-3.dat": metropro(),
        "metropro-2.dat": metropro(version=2, sign=1, resolution=1, intensities=2),
        "metropro-1.dat": metropro(version=1, resolution=0),
        "metropro-lateral.dat": metropro(lateral=0.0),
        "ibw-little.ibw": ibw(),
        "ibw-big.ibw": ibw(order=">"),
        "ibw-double.ibw": ibw(kind="f8", order=">", labels=(), note=""),
        "ibw-integers.ibw": ibw(kind="i2", shape=(5, 5), labels=(), note="", sides=("um", "um"), unit="nm"),
        "ibw-curves.ibw": ibw(shape=(7, 2), labels=("Height", "ZSensor"), sides=("m", "")),
        "plux-1.plux": plux(),
        "plux-2.plux": plux(layers=2, method=zipfile.ZIP_STORED),
    }
    for name, content in files.items():
        (folder / name).write_bytes(content)
    datx(folder / "datx-double.datx")
    datx(folder / "datx-single.datx", kind="<f4", compression="gzip")
    datx(folder / "datx-variable.datx", variable=True)


if __name__ == "__main__":
    main()
