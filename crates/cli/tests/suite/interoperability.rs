//! Files of the program open in h5py, xarray, netCDF4 and VTK, installed into a fresh virtual environment, and in
//! h5dump if it is installed.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::json;

fn succeeds(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {text}");
    text
}

/// Returns the Python of the virtual environment, kept between test runs because installing takes longer than testing.
fn python() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("interoperability");
    let python = folder.join("bin/python");
    let packages = ["h5py", "xarray", "h5netcdf", "netCDF4", "numpy"];
    // The dependencies of VTK serve windows and figures, which these tests do not open.
    let alone = ["vtk"];
    let installed = format!("{packages:?} {alone:?}");
    let record = folder.join("complete");
    if std::fs::read_to_string(&record).ok().as_ref() != Some(&installed) {
        succeeds(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder));
        let install = || -> Command {
            let mut pip = Command::new(&python);
            pip.args(["-m", "pip", "install", "--quiet"]);
            pip
        };
        succeeds(install().args(packages));
        succeeds(install().arg("--no-deps").args(alone));
        std::fs::write(record, installed).unwrap();
    }
    python
}

#[test]
fn files_open_in_h5py_xarray_netcdf4_and_h5dump() {
    let folder = tempfile::tempdir().unwrap();
    let run = |flags: &str| json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
    run("contact --n 32 --p-star 0.05,0.2 --json --out contact.h5");
    run("contact --n 64 --dim 2 --p-star 0.05 --json --out line.h5");
    run("surface --n 32 --json --out surface.h5");
    std::fs::write(
        folder.path().join("sweep.toml"),
        "[points]\neps_t_inv = [2.0]\neps_f_inv = [4.0]\neps_c_inv = [4.0, 8.0]\ncentre = [2.0, 4.0, 4.0]\n\
         [statistics]\nrealisations = 3\n[fit]\nalpha_c = 1.0\nresamples = 50\n",
    )
    .unwrap();
    run("kappa-sweep --config sweep.toml --out sweep.h5 --json -q");

    let body = "body --surface contact.h5 --levels 5 --deepest 0.4 --json";
    run(&format!("{body} --out body.h5"));
    run(&format!("{body} --out body.vti"));
    run(&format!("{body} --slice x=0.25 --out slice.h5"));

    for ending in ["vti", "vtp"] {
        run(&format!(
            "contact --n 32 --size 2,1 --finite-slope --p-star 0.05,0.2 --json --out last.h5 --vtk last.{ending}"
        ));
    }
    run("contact --n 64 --dim 2 --p-star 0.05 --json --vtk line.vtp");
    run("punch --n 16 --json --out punch.h5");
    run("punch --n 16 --dim 2 --json --out strip.h5");

    let names = "contact line surface sweep body slice punch strip".split(' ').map(|name| name.to_owned() + ".h5");
    let files: Vec<_> = names.map(|name| folder.path().join(name)).collect();
    let check = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/interoperability/check.py");
    succeeds(Command::new(python()).arg(check).args(&files));

    // Names used in scripts, read with a common reader.
    let script = "
import sys, xarray
folder = sys.argv[1]
fields = xarray.open_dataset(folder + '/contact.h5', group='fields', engine='h5netcdf')
assert fields.pressure.dims == ('load', 'x', 'y') and fields.pressure.shape == (2, 32, 32)
assert fields.gap.units == 'length' and fields.displacement_z.long_name
loads = xarray.open_dataset(folder + '/contact.h5', group='loads', engine='h5netcdf')
assert abs(float(fields.pressure[1].mean()) - float(loads.mean_pressure[1])) < 1e-12
surface = xarray.open_dataset(folder + '/contact.h5', group='surface', engine='h5netcdf')
assert surface.height.dims == ('x', 'y')
points = xarray.open_dataset(folder + '/sweep.h5', group='points', engine='h5netcdf')
runs = xarray.open_dataset(folder + '/sweep.h5', group='runs', engine='h5netcdf')
assert points.kappa.dims == ('point',) and runs.kappa.dims == ('run',) and runs.seed.long_name
chosen = runs.kappa[(runs.p_star_asked == 0.02) & (runs.eps_c_inv == 8)]
assert abs(float(chosen.mean()) - float(points.kappa[(points.p_star == 0.02) & (points.eps_c_inv == 8)][0])) < 1e-12
punch = xarray.open_dataset(folder + '/punch.h5', group='fields', engine='h5netcdf')
assert punch.traction.dims == ('x', 'y', 'component') and list(punch.component) == ['x', 'y', 'z']
mean = xarray.open_dataset(folder + '/punch.h5', group='punch', engine='h5netcdf').mean_pressure
assert abs(float(punch.traction.sel(component='z').mean()) + float(mean)) < 1e-12
root = xarray.open_dataset(folder + '/sweep.h5', engine='h5netcdf')
for name in 'schema_version program version git_commit command created config machine threads'.split():
    assert name in root.attrs, name
";
    succeeds(Command::new(python()).args(["-c", script]).arg(folder.path()));
    let script = "
import sys, numpy, xarray
from vtkmodules.vtkCommonCore import vtkDataArray
from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLPolyDataReader
from vtkmodules.util.numpy_support import vtk_to_numpy
fields = xarray.open_dataset(sys.argv[1] + '/body.h5', group='fields', engine='h5netcdf')
assert fields.displacement.dims == ('depth', 'x', 'y', 'component') and list(fields.component) == ['x', 'y', 'z']
assert fields.stress.sel(tensor='zz').dims == ('depth', 'x', 'y') and fields.stress.units == 'stress'
reader = vtkXMLImageDataReader()
reader.SetFileName(sys.argv[1] + '/body.vti')
reader.Update()
image = reader.GetOutput()
assert image.GetDimensions() == (32, 32, 5), image.GetDimensions()
numpy.testing.assert_allclose(image.GetSpacing(), (1 / 32, 1 / 32, 0.1), rtol=1e-15)
numpy.testing.assert_allclose(image.GetOrigin(), (0, 0, -0.4), rtol=1e-15)
data = image.GetPointData()
names = [data.GetArrayName(k) for k in range(data.GetNumberOfArrays())]
assert names == ['displacement', 'strain', 'stress', 'von_mises', 'energy_density'], names
order = {3: ['x', 'y', 'z'], 6: ['xx', 'yy', 'zz', 'xy', 'yz', 'xz']}
for name in names:
    array = data.GetArray(name)
    seen = vtk_to_numpy(array).reshape(5, 32, 32, -1)
    labels = order.get(array.GetNumberOfComponents(), [])
    assert [array.GetComponentName(k) for k in range(len(labels))] == [label.upper() for label in labels]
    wanted = fields[name].transpose('depth', 'y', 'x', ...)[::-1]
    wanted = wanted.sel({wanted.dims[-1]: labels}) if labels else wanted
    numpy.testing.assert_array_equal(seen, wanted.values.reshape(seen.shape), err_msg=name)
assert data.GetScalars().GetName() == 'von_mises'
assert data.GetArray('displacement').GetInformation().Get(vtkDataArray.UNITS_LABEL()) == 'length'
last = xarray.open_dataset(sys.argv[1] + '/last.h5', group='fields', engine='h5netcdf').isel(load=-1)
height = xarray.open_dataset(sys.argv[1] + '/last.h5', group='surface', engine='h5netcdf').height
for kind, ending in [(vtkXMLImageDataReader, 'vti'), (vtkXMLPolyDataReader, 'vtp')]:
    reader = kind()
    reader.SetFileName(sys.argv[1] + '/last.' + ending)
    reader.Update()
    surface = reader.GetOutput()
    assert surface.GetNumberOfPoints() == 32 * 32
    assert surface.GetNumberOfCells() == 31 * 31 and surface.GetCellType(0) == {'vti': 8, 'vtp': 9}[ending]
    data = surface.GetPointData()
    names = [data.GetArrayName(k) for k in range(data.GetNumberOfArrays())]
    wanted = ['pressure', 'displacement_z', 'gap', 'displacement_x', 'displacement_y', 'height', 'contact']
    assert names == wanted, names
    assert data.GetScalars().GetName() == 'pressure'
    values = {name: vtk_to_numpy(data.GetArray(name)).reshape(32, 32).T for name in names}
    for name in names[:5]:
        numpy.testing.assert_array_equal(values[name], last[name].values, err_msg=name)
        unit = data.GetArray(name).GetInformation().Get(vtkDataArray.UNITS_LABEL())
        assert unit == last[name].units, unit
    numpy.testing.assert_array_equal(values['height'], height.values)
    numpy.testing.assert_array_equal(values['contact'], values['pressure'] > 0)
    points = numpy.array([surface.GetPoint(k) for k in range(32 * 32)]).reshape(32, 32, 3)
    x, y = numpy.meshgrid(numpy.arange(32) / 16, numpy.arange(32) / 32)
    if ending == 'vtp':
        moved = [values[name].T for name in ('displacement_x', 'displacement_y', 'displacement_z')]
        numpy.testing.assert_allclose(points, numpy.stack([x + moved[0], y + moved[1], moved[2]], axis=-1), atol=1e-15)
    else:
        numpy.testing.assert_allclose(points, numpy.stack([x, y, 0 * x], axis=-1), atol=1e-15)
reader = vtkXMLPolyDataReader()
reader.SetFileName(sys.argv[1] + '/line.vtp')
reader.Update()
line = reader.GetOutput()
assert (line.GetNumberOfPoints(), line.GetNumberOfLines(), line.GetNumberOfPolys()) == (64, 1, 0)
assert line.GetCell(0).GetNumberOfPoints() == 64
slice = xarray.open_dataset(sys.argv[1] + '/slice.h5', group='fields', engine='h5netcdf')
assert slice.stress.dims == ('depth', 'y', 'tensor')
numpy.testing.assert_array_equal(slice.stress.values, fields.stress.sel(x=0.25).values)
";
    succeeds(Command::new(python()).args(["-c", script]).arg(folder.path()));
    if Command::new("h5dump").arg("--version").output().is_ok() {
        let text = succeeds(Command::new("h5dump").arg("-H").arg(&files[0]));
        assert!(text.contains("DIMENSION_LIST") && text.contains("long_name"));
    }
}
