#!/usr/bin/env python3
"""Makes the height maps of this folder with programs that are independent of gfmd.

    pip install numpy scipy h5py netCDF4 gwyfile
    python3 make.py

The heights of every file are h[i, j] = (7 i + 3 j) mod 16 - i j / 8 + 1/4, times 1e-6 in files with units of metres,
with 5 points along x and 4 along y. "Holes" are at [1, 2] and [4, 0].
"""

import hashlib
import io
import zipfile
from pathlib import Path

import gwyfile.objects as gwy
import h5py
import netCDF4
import numpy as np
import scipy.io

HERE = Path(__file__).resolve().parent
NX, NY = 5, 4
i, j = np.meshgrid(np.arange(NX), np.arange(NY), indexing="ij")
H = (7 * i + 3 * j) % 16 - i * j / 8 + 0.25
HOLES = np.zeros((NX, NY), dtype=bool)
HOLES[1, 2] = HOLES[4, 0] = True
SIZE = (2.5e-6, 1e-6)


def x3p(name, kind, numbers, increment=None, offset=None, mask=False):
    data = np.ascontiguousarray(numbers.T).astype({"I": "<i2", "L": "<i4", "F": "<f4", "D": "<f8"}[kind]).tobytes()
    valid = np.packbits(~HOLES.T.reshape(-1), bitorder="little").tobytes()
    scale = "".join(f"<{k}>{v!r}</{k}>" for k, v in (("Increment", increment), ("Offset", offset)) if v is not None)
    link = (
        f"<ValidPointsLink>bindata/valid.bin</ValidPointsLink><MD5ChecksumValidPoints>{hashlib.md5(valid).hexdigest()}"
        "</MD5ChecksumValidPoints>"
        if mask
        else ""
    )
    axis = "<C{0}><AxisType>I</AxisType><DataType>D</DataType><Increment>{1!r}</Increment><Offset>0</Offset></C{0}>"
    xml = f"""<?xml version="1.0" encoding="UTF-8"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2">
<Record1><Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType><Axes>
{axis.format("X", SIZE[0] / NX)}{axis.format("Y", SIZE[1] / NY)}
<CZ><AxisType>A</AxisType><DataType>{kind}</DataType>{scale}</CZ></Axes></Record1>
<Record2><Date>2026-11-20T12:00:00</Date><Creator>make.py</Creator>
<Instrument><Manufacturer>nobody</Manufacturer><Model>numpy</Model><Serial>1</Serial>\
<Version>2</Version></Instrument></Record2>
<Record3><MatrixDimension><SizeX>{NX}</SizeX><SizeY>{NY}</SizeY><SizeZ>1</SizeZ></MatrixDimension>
<DataLink><PointDataLink>bindata/data.bin</PointDataLink>\
<MD5ChecksumPointData>{hashlib.md5(data).hexdigest().upper()}</MD5ChecksumPointData>{link}</DataLink></Record3>
<Record4><ChecksumFile>md5checksum.hex</ChecksumFile></Record4>
</p:ISO5436_2>
""".encode()
    write_zip(name, [("bindata/data.bin", data)] + [("bindata/valid.bin", valid)] * mask
              + [("main.xml", xml), ("md5checksum.hex", f"{hashlib.md5(xml).hexdigest()} *main.xml\n".encode())])


def write_zip(name, entries):
    with zipfile.ZipFile(HERE / name, "w", zipfile.ZIP_DEFLATED) as archive:
        for entry, data in entries:
            archive.writestr(zipfile.ZipInfo(entry, (2026, 11, 20, 12, 0, 0)), data, zipfile.ZIP_DEFLATED)


def netcdf3(heights, mask=None):
    buffer = io.BytesIO()
    with scipy.io.netcdf_file(buffer, "w", version=2) as file:
        file.createDimension("x", NX)
        file.createDimension("y", NY)
        for name, count, size in (("x", NX, 2.5), ("y", NY, 1.0)):
            axis = file.createVariable(name, "f8", (name,))
            axis.length, axis.periodic, axis.unit = size, 1, "um"
            axis[:] = np.arange(count) / count * size
        variable = file.createVariable("heights", "f8", ("x", "y"))
        variable[:] = heights
        variable.unit = "um"
        if mask is not None:
            file.createVariable("mask", "b", ("x", "y"))[:] = mask
        file.flush()
        return buffer.getvalue()


# Gwyddion: two channels, of which one is heights in m and one a voltage; the heights have a mask.
field = gwy.GwyDataField(np.ascontiguousarray(H.T) * 1e-6, xreal=SIZE[0], yreal=SIZE[1], si_unit_xy="m", si_unit_z="m")
volts = gwy.GwyDataField(np.ascontiguousarray(H.T), xreal=SIZE[0], yreal=SIZE[1], si_unit_xy="m", si_unit_z="V")
mask = gwy.GwyDataField(np.ascontiguousarray(HOLES.T).astype(float), xreal=SIZE[0], yreal=SIZE[1])
root = gwy.GwyContainer()
root["/0/data/title"], root["/0/data"] = "Phase", volts
root["/1/data/title"], root["/1/data"], root["/1/mask"] = "Topography", field, mask
root["/1/meta"] = gwy.GwyContainer({"Instrument": "nothing"})
root.tofile(str(HERE / "two.gwy"))

# X3P: each type; whole numbers with increment and offset; validity.
x3p("double.x3p", "D", H * 1e-6)
x3p("single.x3p", "F", H * 2**-20)
x3p("int16.x3p", "I", H * 8 - 40, 2.0**-23, 2.0**-18, mask=True)
x3p("int32.x3p", "L", H * 8 - 40, 2.0**-23, mask=True)

scipy.io.savemat(
    HERE / "small.mat", {"heights": H, "single": H.astype("f4"), "text": "no matrix", "one": 1.0, "line": H[:, 0]}
)
scipy.io.savemat(
    HERE / "compressed.mat", {"heights": H, "whole": (8 * H).astype("i2"), "complex": H * 1j}, do_compression=True
)
np.savez(HERE / "two.npz", first=H, second=np.asfortranarray(H.astype(">f4")), cube=np.zeros((2, 2, 2)))
np.savez_compressed(HERE / "compressed.npz", heights=H)
(HERE / "holes.nc").write_bytes(netcdf3(H, HOLES))
with netCDF4.Dataset(HERE / "four.nc", "w", format="NETCDF4") as file:
    for name, count, size in (("x", NX, 2.5), ("y", NY, 1.0)):
        file.createDimension(name, count)
        axis = file.createVariable(name, "f8", (name,))
        axis.length, axis.periodic, axis.unit = size, 0, "um"
        axis[:] = np.arange(count) / count * size
    file.createVariable("heights", "f8", ("x", "y"))[:] = H
    file["heights"].unit = "um"
    file.createVariable("mask", "i1", ("x", "y"))[:] = HOLES
with h5py.File(HERE / "challenge.h5", "w") as file:
    file["surface"] = H
    file["other"] = np.zeros((2, 2))
text = "\n".join(" ".join(repr(float(h)) for h in row) for row in H.T)
meta = """surfaces:
- name: Sample
  topographies:
  - name: first
    datafile:
      original: heights.txt
    size: !!python/tuple
    - 2.5
    - 1.0
    unit: µm
    height_scale: 2.0
    is_periodic: false
  - name: second
    datafile:
      squeezed-netcdf: topography1.nc
  - name: unknown
    datafile:
      original: notes.txt
versions:
  topobank: 1.0.0
"""
write_zip(
    "container.zip",
    [
        ("heights.txt", text.encode()),
        ("topography1.nc", netcdf3(H)),
        ("notes.txt", b"nothing here"),
        ("meta.yml", meta.encode()),
    ],
)
