"""Opens result files with h5py, xarray over h5netcdf, and netCDF4, and compares what they see.

    python check.py [--expect EXPECTED.json] FILE.h5 ...

For every file, whatever it contains:
- the root has its attributes and the configuration is TOML;
- every variable has `units` and `long_name`, and one dimension scale per dimension, in its own group, of the right
  length;
- xarray and netCDF4 find in each group the same dimension names, coordinates, attributes and values as h5py.

With --expect, a JSON object {"/group/name": {"dims": ["load", "x"], "units": "stress", "values": [...]}, ...} is
compared with the (single) file as well; "dims", "units", "long_name" and "values" (flattened, row-major) are all
optional.

Needs: h5py xarray h5netcdf netCDF4 numpy. Exit status 0 if all is well; otherwise the first difference, and 1.
"""

import argparse
import json
import sys
import tomllib

import h5py
import netCDF4
import numpy as np
import xarray as xr

ROOT = ["schema_version", "program", "version", "git_commit", "command", "created", "config", "machine", "threads"]


def plain(values):
    """Numbers and text as arrays that compare."""
    values = np.asarray(values)
    if values.dtype.kind in "OSUT":
        decode = lambda v: v.decode() if isinstance(v, bytes) else str(v)
        return np.array([decode(v) for v in values.ravel()], dtype=object).reshape(values.shape)
    return values


def same(where, found, expected):
    found, expected = plain(found), plain(expected)
    assert found.shape == expected.shape, f"{where}: shape {found.shape}, expected {expected.shape}"
    if expected.dtype == object:
        assert (found == expected).all(), f"{where}: {found} differs from {expected}"
    else:
        np.testing.assert_array_equal(found, expected, err_msg=where)


def seen_by_h5py(path):
    """{group: {variable: (dimension names, attributes, values)}}, every attribute and scale checked on the way."""
    groups = {}
    with h5py.File(path) as file:
        missing = [name for name in ROOT if name not in file.attrs]
        assert not missing, f"{path}: the root has no attribute {missing}"
        tomllib.loads(file.attrs["config"])

        def visit(name, item):
            if not isinstance(item, h5py.Dataset):
                return
            group, where = item.parent.name, f"{path}: {item.name}"
            for attribute in ("units", "long_name"):
                text = item.attrs.get(attribute)
                assert isinstance(text, str) and text, f"{where}: {attribute} is {text!r}"
            if item.is_scale:
                assert item.ndim == 1, f"{where}: a scale with {item.ndim} dimensions"
                dims = (item.name.rsplit("/", 1)[1],)
                for reference, position in item.attrs.get("REFERENCE_LIST", []):
                    user = file[reference]
                    assert item == user.dims[position][0], f"{where}: {user.name} does not use it at {position}"
            else:
                for dimension in item.dims:
                    assert len(dimension) == 1, f"{where}: {len(dimension)} scales on a dimension"
                scales = [dimension[0] for dimension in item.dims]
                for scale, length in zip(scales, item.shape):
                    assert scale.parent.name == group, f"{where}: its scale {scale.name} is in another group"
                    assert scale.shape == (length,), f"{where}: {length} entries along {scale.name} of {scale.shape}"
                dims = tuple(scale.name.rsplit("/", 1)[1] for scale in scales)
            attributes = {key: item.attrs[key] for key in ("units", "long_name")}
            groups.setdefault(group, {})[name.rsplit("/", 1)[-1]] = (dims, attributes, item[()])

        file.visititems(visit)
    assert groups, f"{path}: no variables"
    return groups


def check_xarray(path, group, variables):
    with xr.open_dataset(path, group=group, engine="h5netcdf", decode_times=False) as dataset:
        assert set(dataset.variables) == set(variables), f"{path}: {group}: xarray sees {sorted(dataset.variables)}"
        for name, (dims, attributes, values) in variables.items():
            where, seen = f"{path}: {group}/{name} in xarray", dataset[name]
            assert seen.dims == dims, f"{where}: dimensions {seen.dims}, expected {dims}"
            for key, text in attributes.items():
                assert seen.attrs.get(key) == text, f"{where}: {key} {seen.attrs.get(key)!r}, expected {text!r}"
            missing = [dim for dim in dims if dim not in dataset.coords]
            assert not missing, f"{where}: no coordinates along {missing}"
            same(where, seen.values, values)


def check_netcdf(path, group, variables):
    with netCDF4.Dataset(path) as file:
        dataset = file[group] if group != "/" else file
        dataset.set_auto_mask(False)
        assert set(dataset.variables) == set(variables), f"{path}: {group}: netCDF4 sees {sorted(dataset.variables)}"
        for name, (dims, attributes, values) in variables.items():
            where, seen = f"{path}: {group}/{name} in netCDF4", dataset.variables[name]
            assert seen.dimensions == dims, f"{where}: dimensions {seen.dimensions}, expected {dims}"
            for key, text in attributes.items():
                assert seen.getncattr(key) == text, f"{where}: {key} {seen.getncattr(key)!r}, expected {text!r}"
            same(where, seen[...], values)


def check_expected(path, groups, expected):
    for full, wanted in expected.items():
        group, name = full.rsplit("/", 1)
        assert name in groups.get(group or "/", {}), f"{path}: no {full}"
        dims, attributes, values = groups[group or "/"][name]
        assert list(dims) == wanted.get("dims", list(dims)), f"{path}: {full}: dimensions {dims}"
        for key in attributes:
            assert attributes[key] == wanted.get(key, attributes[key]), f"{path}: {full}: {key} {attributes[key]!r}"
        if "values" in wanted:
            values = plain(values)
            wanted = np.array([np.nan if v is None else v for v in wanted["values"]], dtype=values.dtype)
            same(f"{path}: {full}", values.ravel(), wanted)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--expect", help="JSON file with what one file must contain")
    parser.add_argument("files", nargs="+")
    arguments = parser.parse_args()
    for path in arguments.files:
        groups = seen_by_h5py(path)
        for group, variables in groups.items():
            check_xarray(path, group, variables)
            check_netcdf(path, group, variables)
        if arguments.expect:
            with open(arguments.expect) as file:
                check_expected(path, groups, json.load(file))
        print(f"{path}: {sum(map(len, groups.values()))} variables in {len(groups)} groups agree")


if __name__ == "__main__":
    try:
        main()
    except AssertionError as error:
        sys.exit(str(error))
