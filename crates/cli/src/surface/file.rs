//! The file of a surface: a NumPy array, X3P, or HDF5.

use std::path::Path;

use gfmd_field::Grid;
use gfmd_files::{Archive, Dimension, Output, Provenance, Variable, X3p, axes, contiguous, npy};
use gfmd_problem::key;
use gfmd_surface::RadialBin;
use ndarray::{ArrayRef2, Axis};

use super::Report;
use gfmd_input::failure::Failure;
use gfmd_record::Cell;
use gfmd_unit::Units;

/// The output file and its format, claimed before the heights are made.
pub(super) struct Target {
    output: Output,
    format: Format,
}

enum Format {
    Npy,
    X3p,
    Hdf5,
}

impl Target {
    pub(super) fn claim(path: &Path) -> Result<Self, Failure> {
        let format = match path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("npy") => Format::Npy,
            Some("x3p") => Format::X3p,
            Some("h5" | "hdf5") => Format::Hdf5,
            _ => return Err(Failure::value(key("out"), path.display(), "NAME.npy, NAME.x3p or NAME.h5")),
        };
        let output = Output::claim(path).map_err(|error| Failure::input(key("out"), error))?;
        Ok(Self { output, format })
    }

    /// Writes the heights, and to an HDF5 file also the numbers of the report and the spectrum.
    pub(super) fn write(
        &self,
        heights: &ArrayRef2<f64>,
        grid: &Grid,
        spectrum: &[RadialBin],
        report: &Report,
        provenance: &Provenance,
    ) -> Result<(), Failure> {
        match self.format {
            // A profile is a one-dimensional array.
            Format::Npy if grid.is_line() => npy::write(&self.output, heights.index_axis(Axis(1), 0).into_dyn())?,
            Format::Npy => npy::write(&self.output, heights.view().into_dyn())?,
            Format::X3p => self.write_x3p(heights, grid, report, provenance)?,
            Format::Hdf5 => self.write_hdf5(heights, grid, spectrum, report, provenance)?,
        }
        Ok(())
    }

    fn write_x3p(
        &self,
        heights: &ArrayRef2<f64>,
        grid: &Grid,
        report: &Report,
        provenance: &Provenance,
    ) -> Result<(), Failure> {
        let creator = format!("{} {}", provenance.program, provenance.version);
        let comment = match report.scan.as_ref().and_then(|scan| scan.conversion.as_ref()) {
            Some(conversion) => format!("{}; {conversion}", report.source),
            None => report.source.clone(),
        };
        let x3p = X3p {
            heights,
            lengths: grid.lengths(),
            unit: report.unit.as_deref(),
            date: &provenance.created,
            creator: &creator,
            comment: &comment,
        };
        if let Some(note) = x3p.write(&self.output)? {
            tracing::info!("{}: {note}", self.output.path().display());
        }
        Ok(())
    }

    fn write_hdf5(
        &self,
        heights: &ArrayRef2<f64>,
        grid: &Grid,
        spectrum: &[RadialBin],
        report: &Report,
        provenance: &Provenance,
    ) -> Result<(), Failure> {
        let unit = report.unit_of(1);
        let mut archive = Archive::create(&self.output, provenance)?;
        let [x, y] = axes(grid, &unit);
        let dimensions: &[&Dimension] = if grid.is_line() { &[&x] } else { &[&x, &y] };
        let height =
            Variable { dimensions, units: &unit, long_name: "height of the rigid surface, peaks towards the body" };
        archive.write("/surface/height", &height, &contiguous(heights))?;
        archive.attribute("/surface", "source", report.source.as_str())?;
        report.scan.iter().try_for_each(|scan| scan.write(&mut archive, "/surface"))?;
        let units = Units::new(report.unit.as_deref(), None);
        for (column, cell) in report.numbers.cells() {
            let (units, path) = (units.name(column.unit), format!("/statistics/{}", column.name));
            let long_name = column.meaning(&report.facts);
            archive.write(&path, &Variable { dimensions: &[], units: &units, long_name }, &[cell.number()])?;
            if let Cell::Undefined(reason) = cell {
                archive.attribute(&path, "undefined", &**reason)?;
            }
        }
        let wavenumbers = spectrum.iter().map(|bin| bin.wavenumber).collect();
        let per_length = report.unit_of(-1);
        let q = Dimension::values("wavenumber", wavenumbers, &per_length, "mean wavenumber of the ring, rad/length");
        let units = report.unit_of(if grid.is_line() { 3 } else { 4 });
        let density =
            Variable { dimensions: &[&q], units: &units, long_name: "radially averaged power spectral density" };
        archive.write("/spectrum/density", &density, &spectrum.iter().map(|bin| bin.density).collect::<Vec<_>>())?;
        let modes =
            Variable { dimensions: &[&q], units: "1", long_name: "number of modes in the ring, of the full spectrum" };
        archive.write("/spectrum/modes", &modes, &spectrum.iter().map(|bin| bin.modes).collect::<Vec<_>>())?;
        if let Some(curves) = &report.curves {
            curves.write(&mut archive, &unit)?;
            archive.attribute("/autocorrelation", "boundary", report.boundary.unwrap_or_default())?;
            archive.attribute("/statistics", "wolf", report.wolf.unwrap_or(f64::NAN))?;
            archive.attribute("/statistics", "motif_edges", report.motif_edges.unwrap_or_default())?;
        }
        archive.finish()?;
        Ok(())
    }
}
