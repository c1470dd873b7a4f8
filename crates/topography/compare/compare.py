#!/usr/bin/env python3
"""Compares the readers of gfmd with those of SurfaceTopography, file by file and point by point.

    python3 crates/topography/compare/compare.py --examples FOLDER [FOLDER ...] [--made] [--markdown]

makes a virtual environment (in the target folder of Cargo, or in --environment), installs SurfaceTopography 1.27.1 or
later, builds the example program `heights`, and reads every file of the folders with both. `--made` adds the files of
`make_examples.py` and those of `crates/topography/tests/data`. The programs agree on a height map if

- the shapes are equal, and each point is undefined in both or in neither;
- the sizes agree within 4 units in the last place (1e-15), after conversion to one unit;
- each height has the same bits; or, where one of them has been converted to another unit, agrees within 1e-15 of
  itself: the order of the factors is then not the same. The table says which of the two it was.

Exit status 1 if a file differs and is not listed in EXPLAINED, or if nothing was compared.
"""

import argparse
import collections
import fnmatch
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
REQUIREMENT = "SurfaceTopography>=1.27.1"
TOLERANCE = 1e-15

# Differences with their reason: patterns of the file's name, pattern of the result, reason.
EXPLAINED = [
    (
        ["sur-compressed.sur", "sur-streams.sur", "test_RGBSURFACE.sur"],
        "read here*",
        "it does not read compressed files",
    ),
    (["sur-series.sur"], "no such*", "it reads the first object of a series only"),
    (["sur-series.sur"], "a height map there*", "it reads the first object of a series only"),
    (["*-version2.ibw", "*-double.ibw"], "read here*", "it does not read waves before version 5"),
    (["*-zeroPointWave.ibw"], "refused*", "the wave has no point"),
    (
        ["*.jpk", "*.jpk-qi-image", "*.stp", "*.top", "*.bcrf", "*.tiff", "*.frt", "*.xlsx", "*.mnt", "*.nms", "*.tmd"],
        "refused: the format is unknown*",
        "a format that is not read here",
    ),
    (
        ["*.h5-jpk", "*.topostats", "*.h5"],
        "no such*",
        "here every dataset of numbers is listed, also those of integers and lines",
    ),
    (["*.h5-jpk"], "differs: unit*", "it does not look at the attribute `unit`"),
    (
        ["*.h5-jpk", "*.topostats"],
        "a height map there*",
        "datasets of three dimensions, and of one line, are not listed here",
    ),
    (["csv-1.csv"], "read here*", "its distances are equal within the digits that it gives"),
    (["csv-2.csv", "csv-3.csv"], "differs: unit*", "it does not find the unit in the title of the column"),
    (
        ["test.yaml"],
        "read here*",
        "lines that begin with a dash look like a matrix with undefined points, which are refused later",
    ),
    (["container.zip"], "read here*", "it refuses the whole container, since one of its files is no height map"),
    (["four.nc"], "*", "it reads NetCDF-4 as HDF5 of any program, without the mask"),
    (["compressed.mat"], "a height map there*", "complex numbers are no heights"),
    (["small.mat"], "a height map there*", "one number is no height map"),
    (["small.mat"], "differs: shape*", "a line is a profile [n, 1]"),
    (
        ["container-2.zip"],
        "differs: 262144*",
        "it multiplies by the factor of meta.yml and by the same factor of the data file",
    ),
]

# Formats whose maps begin with the top line in SurfaceTopography; here y points up.
TOP_FIRST = {
    "Gwyddion",
    "Gwyddion simple field",
    "Digital Surf",
    "Nanoscope",
    "Wyko OPD",
    "Dektak OPDx",
    "Alicona AL3D",
    "Zygo MetroPro",
    "Zygo Mx",
    "Igor binary wave",
    "Molecular Imaging",
    "Nanosurf",
    "Sensofar PLUX",
    "Sensofar PLu",
}

UNITS = {"m": 1.0, "km": 1e3, "cm": 1e-2, "mm": 1e-3, "µm": 1e-6, "um": 1e-6, "nm": 1e-9, "Å": 1e-10, "pm": 1e-12}


def environment(folder):
    """The Python of a virtual environment with SurfaceTopography; made if it is not there."""
    python = folder / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
        subprocess.run([str(python), "-m", "pip", "install", "--quiet", REQUIREMENT], check=True)
    return python


def program():
    """The example program that writes the heights, built."""
    build = ["cargo", "build", "--quiet", "-p", "gfmd-files", "--example", "heights", "--message-format", "json"]
    lines = subprocess.run(build, check=True, capture_output=True, text=True, cwd=ROOT).stdout.splitlines()
    messages = (json.loads(line) for line in lines)
    return next(m["executable"] for m in messages if m.get("executable") and m["target"]["name"] == "heights")


def ours(program, file, folder):
    """The height maps that gfmd finds, and the error if there is one."""
    import numpy as np

    found = subprocess.run([program, str(file), folder], capture_output=True, text=True)
    if found.returncode not in (0, 1):
        return [], f"exit status {found.returncode}: {found.stderr}"
    maps, error = [], None
    for line in found.stdout.splitlines():
        line = json.loads(line)
        if "error" in line:
            error = line["error"].split(": ", 1)[-1]
        else:
            heights = np.load(os.path.join(folder, f"{line['number']}.npy"))
            if line["data_format"] in TOP_FIRST:
                heights = heights[:, ::-1]
            maps.append(dict(line, heights=heights, mask=np.isnan(heights)))
    return maps, error


def theirs(file):
    """The height maps that SurfaceTopography finds, and the error if there is one."""
    import numpy as np
    from SurfaceTopography.Container.IO import read_container
    from SurfaceTopography.IO import open_topography

    def topographies():
        """Name, height map, and True if it has a size."""
        if zipfile.is_zipfile(file) and "meta.yml" in zipfile.ZipFile(file).namelist():
            for container in read_container(str(file)):
                for topography in container:
                    # The container asks to remove a trend; gfmd leaves that to its flag --detrend.
                    while type(topography).__name__.startswith("Detrended"):
                        topography = topography.parent_topography
                    yield None, topography, True
            return
        for channel in open_topography(str(file)).channels:
            if channel.is_height_channel and not isinstance(channel.unit, tuple):
                sizes = {} if channel.physical_sizes else {"physical_sizes": (1.0,) * (channel.dim or 2)}
                yield channel.name.lstrip("/"), channel.topography(**sizes), not sizes

    try:
        maps = []
        for name, topography, has_size in topographies():
            heights = topography.heights()
            mask = np.ma.getmaskarray(heights)
            heights = np.array(np.ma.getdata(heights), dtype=float)
            lengths = [float(size) for size in topography.physical_sizes] if has_size else None
            if not topography.is_uniform:
                # Points of a profile: on a grid if their distances are equal.
                x = topography.positions()
                spacing = (x[-1] - x[0]) / (len(x) - 1)
                if np.abs(np.diff(x) - spacing).max() > 1e-6 * abs(spacing):
                    continue
                lengths = [len(x) * spacing]
            if heights.ndim == 1:
                heights, mask = heights[:, None], mask[:, None]
                lengths = lengths and lengths + [1.0]
            maps.append({"name": name, "heights": heights, "mask": mask | ~np.isfinite(heights),
                         "lengths": lengths, "unit": topography.unit})
        return maps, None if maps else "no height map on a grid"
    except Exception as error:  # any error of a reader is a result of the comparison
        return [], f"{type(error).__name__}: {error}"


def difference(mine, other):
    """The difference of two height maps, or None; and the words for the agreement of the heights."""
    import numpy as np

    if mine["heights"].shape != other["heights"].shape:
        return f"shape {mine['heights'].shape}, {other['heights'].shape} there", None
    wrong = int((mine["mask"] != other["mask"]).sum())
    if wrong:
        return f"{mine['mask'].sum()} undefined points, {other['mask'].sum()} there; {wrong} differ", None
    factor = 1.0
    if mine["unit"] != other["unit"]:
        if mine["unit"] not in UNITS or other["unit"] not in UNITS:
            return f"unit {mine['unit']}, {other['unit']} there", None
        factor = UNITS[other["unit"]] / UNITS[mine["unit"]]
        power = round(np.log10(factor))
        factor = 10.0**power if abs(factor / 10.0**power - 1) < 1e-12 else factor
    if (mine["lengths"] is None) != (other["lengths"] is None):
        return f"sizes {mine['lengths']}, {other['lengths']} there", None
    if mine["lengths"]:
        both = [(a, b * factor) for a, b in zip(mine["lengths"], other["lengths"])]
        both = both[:1] if mine["heights"].shape[1] == 1 else both
        if any(abs(a - b) > TOLERANCE * abs(b) for a, b in both):
            return f"sizes {mine['lengths']}, {other['lengths']} {other['unit']} there", None
    a, b = mine["heights"][~mine["mask"]], other["heights"][~other["mask"]]
    if factor == 1.0 and np.array_equal(a, b):
        return None, "same bits"
    b = b * factor
    largest = float((np.abs(a - b) / np.maximum(np.abs(b), np.finfo(float).tiny)).max(initial=0.0))
    if largest > TOLERANCE:
        count = int((np.abs(a - b) > TOLERANCE * np.abs(b)).sum())
        return f"{count} heights differ, by up to {largest:.1e} of themselves", None
    return None, f"within {largest:.0e}" if largest else "same bits"


def compare(file, program):
    """The results of a file: rows of format, name of the map, points, result."""
    with tempfile.TemporaryDirectory() as folder:
        mine, error = ours(program, file, folder)
    other, other_error = theirs(file)
    if not mine and not other:
        return [("-", "-", "-", f"refused by both: {error}" + (f" / {other_error}" if other_error else ""))]
    if not mine:
        return [("-", "-", "-", f"refused: {error}; SurfaceTopography reads it")]
    rows = []
    if not other:
        reason = f"read here, refused there: {other_error}"
    elif len(mine) != len(other):
        reason = f"{len(mine)} height maps, {len(other)} there: {', '.join(m['name'] for m in other)}"
    else:
        reason = None
    used = []
    for number, one in enumerate(mine):
        same_name = [m for m in other if m["name"] == one["name"].lstrip("/")]
        partner = same_name[0] if len(same_name) == 1 else other[number] if len(mine) == len(other) else None
        if partner is None:
            result = reason if len(mine) == len(other) or not other else "no such height map there"
        else:
            used.append(id(partner))
            found, words = difference(one, partner)
            result = found and f"differs: {found}" or words
        shape = "x".join(str(n) for n in one["heights"].shape)
        undefined = f", {one['undefined']} undefined" if one["undefined"] else ""
        rows.append((one["format"], one["name"], shape + undefined, result))
    for one in other:
        if id(one) not in used:
            rows.append((mine[0]["format"], one["name"], "-", "a height map there, none here"))
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--examples", nargs="+", type=pathlib.Path, default=[], metavar="FOLDER")
    parser.add_argument(
        "--made", action="store_true", help="add the files of make_examples.py and of crates/topography/tests/data"
    )
    parser.add_argument("--environment", type=pathlib.Path, help="folder of the virtual environment")
    parser.add_argument("--program", help="the example program, built")
    parser.add_argument("--markdown", action="store_true", help="print the table as Markdown")
    arguments = parser.parse_args()
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    python = environment((arguments.environment or target / "compare-environment").absolute())
    if pathlib.Path(sys.prefix).resolve() != python.parents[1].resolve():
        os.execv(python, [str(python), *sys.argv])

    import SurfaceTopography

    executable = arguments.program or program()
    files = sorted({f.resolve() for folder in arguments.examples for f in folder.rglob("*") if f.is_file()})
    with tempfile.TemporaryDirectory() as made:
        if arguments.made:
            subprocess.run([sys.executable, str(HERE / "make_examples.py"), made], check=True)
            files += sorted(pathlib.Path(made).iterdir()) + sorted((ROOT / "crates/topography/tests/data").iterdir())
        counts, bad = collections.Counter(), 0
        print(f"gfmd against SurfaceTopography {SurfaceTopography.__version__}\n")
        columns = ("file", "format", "height map", "points", "result")
        if arguments.markdown:
            print("| " + " | ".join(columns) + " |\n|" + "---|" * len(columns))
        for file in files:
            for row in compare(file, executable):
                result = row[-1]
                agrees = result == "same bits" or result.startswith("within") or result.startswith("refused by both")
                reason = next(
                    (
                        why
                        for names, what, why in EXPLAINED
                        if any(fnmatch.fnmatch(file.name, name) for name in names) and fnmatch.fnmatch(result, what)
                    ),
                    None,
                )
                kind = "refused by both" if result.startswith("refused by both") else (
                    "agree" if agrees else "explained" if reason else "NOT EXPLAINED")
                counts[kind] += 1
                bad += kind == "NOT EXPLAINED"
                cells = (
                    f"{file.parent.name}/{file.name}" if file.parent != pathlib.Path(made) else f"made/{file.name}",
                    *row[:-1],
                    result if agrees or not reason else f"{result} [{reason}]",
                )
                if not agrees and not reason:
                    cells = (*cells[:-1], "NOT EXPLAINED: " + cells[-1])
                cells = tuple(str(cell).replace("\n", " ").replace("|", "/")[:300] for cell in cells)
                print("| " + " | ".join(cells) + " |" if arguments.markdown else "  ".join(cells))
    print(f"\n{len(files)} files: " + ", ".join(f"{count} {kind}" for kind, count in sorted(counts.items())))
    sys.exit(1 if bad or not counts["agree"] else 0)


if __name__ == "__main__":
    main()
