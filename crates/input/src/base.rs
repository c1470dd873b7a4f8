//! Moved base of a body, from flags.

use clap::Args;
use gfmd_body::{BaseField, Interior, InteriorError};
use gfmd_field::{Grid, Share};
use gfmd_files::{Archive, Checksum, Dimension, Reader, Variable, split_dataset};
use gfmd_green::Body;
use gfmd_problem::{MovedBase as Moved, key};
use gfmd_surface::{Interpolation, finer};
use gfmd_unit::Units;
use ndarray::{ArcArray2, Array2, ArrayD, Axis, IxDyn};
use serde::{Deserialize, Serialize};

use crate::array::{self, Quantity};
use crate::failure::Failure;
use crate::rows;
use gfmd_problem::options::Options;
use gfmd_problem::options::given::ArrayOption;

/// Flags of a base that moves.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Base")]
pub struct BaseArgs {
    /// Displacement of a bonded or sliding base, FILE.npy or FILE.h5:/dataset: u_z of shape [nx, ny], or [nx, ny, 3];
    /// for a profile n values or [n, 2]
    #[arg(long, value_name = "FILE", conflicts_with = "base_traction")]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(array)]
    pub base_displacement: Option<ArrayOption>,
    /// Traction of zero mean on the lower face of a plate (--base free), in the same form
    #[arg(long, value_name = "FILE")]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(array)]
    pub base_traction: Option<ArrayOption>,
}

/// Moved base, with its effect on the surface.
#[derive(Clone, Debug)]
pub struct MovedBase {
    kind: Prescribed,
    /// Field `[x, y, component]`; of several processes only the first one has it.
    field: ArrayD<f64>,
    /// u_z of the unloaded surface, rows of this process.
    pub lift: Array2<f64>,
    /// u_x and u_y (u_x of a profile) of the unloaded surface; only if no other process has rows.
    pub sideways: Vec<Array2<f64>>,
}

/// Prescribed quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Prescribed {
    Displacement,
    Traction,
}

/// Datasets of a file, by kind, with their options.
const STORED: [(Prescribed, &str, &str); 2] = [
    (Prescribed::Displacement, "base_displacement", "/base/displacement"),
    (Prescribed::Traction, "base_traction", "/base/traction"),
];

impl BaseArgs {
    /// Keys of these flags in a configuration.
    pub const NAMES: [&'static str; 2] = ["base_displacement", "base_traction"];

    /// Returns the motion of the base; `None` at rest.
    pub fn fact(&self) -> Option<Moved> {
        match (&self.base_displacement, &self.base_traction) {
            (Some(_), _) => Some(Moved::Displacement),
            (_, Some(_)) => Some(Moved::Traction),
            _ => None,
        }
    }

    /// Returns true if the base is moved.
    pub fn is_given(&self) -> bool {
        self.base_displacement.is_some() || self.base_traction.is_some()
    }

    /// Reads the field for a body with a surface on this `grid`, which has `times` as many points along each side as
    /// the field; `unit` is the unit of its lengths, if it has one. Values in between follow from the waves. The
    /// surface may be held sideways.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read, has another shape or quantity, or is for another base.
    pub fn read(
        &self,
        body: &Body,
        grid: &Grid,
        times: usize,
        unit: Option<&str>,
        is_held: bool,
    ) -> Result<Option<MovedBase>, Failure> {
        let given = [&self.base_displacement, &self.base_traction];
        let Some((name, (kind, option, _))) =
            given.into_iter().zip(STORED).find_map(|(name, stored)| Some((name.as_ref()?, stored)))
        else {
            return Ok(None);
        };
        let refuse = |reason: String| Failure::input(key(option), format!("{name}: {reason}"));
        let quantity = if kind == Prescribed::Displacement { Quantity::Length(unit) } else { Quantity::Stress };
        let found = array::read(name, quantity).map_err(refuse)?;
        let coarse = |points: usize| (points / times).max(1);
        let [nx, ny] = grid.points().map(coarse);
        let grid = &Grid::new([nx, ny], grid.lengths()).map_err(|error| Failure::input(key("size"), error))?;
        let (all, allowed) = if grid.is_line() { (2, "[n], [n, 1] or [n, 2]") } else { (3, "[nx, ny] or [nx, ny, 3]") };
        let components = match *found.shape() {
            [n] | [n, 1] if grid.is_line() && n == nx => 1,
            [n, 2] | [n, 1, 2] if grid.is_line() && n == nx => 2,
            [n, m] if [n, m] == [nx, ny] => 1,
            [n, m, 3] if [n, m] == [nx, ny] && !grid.is_line() => 3,
            _ => {
                let shape = found.shape();
                return Err(refuse(format!(
                    "the shape is {shape:?}; it must be {allowed} with the points {nx} x {ny}"
                )));
            }
        };
        let points = grid.len();
        let mut values = vec![0.0; all * points];
        for (index, value) in found.iter().enumerate() {
            let (point, component) = (index / components, index % components);
            // A single component is z, the last one.
            values[(if components == 1 { all - 1 } else { component }) * points + point] = *value;
        }
        let field = ArrayD::from_shape_fn(IxDyn(&[nx, ny, all]), |at| values[at[2] * points + at[0] * ny + at[1]]);
        let base = if kind == Prescribed::Displacement {
            BaseField::Displacement(values)
        } else {
            BaseField::Traction(values)
        };
        let moved = if is_held { base.held_displacement(body, *grid) } else { base.surface_displacement(body, *grid) };
        let moved = moved.map_err(|error| Failure::input(key(option), error))?;
        let on_grid = |component: &[f64]| {
            let coarse = Array2::from_shape_fn((nx, ny), |(i, j)| component[i * ny + j]);
            match times {
                1 => Ok(coarse),
                // The displacement has no other waves.
                times => finer(&coarse, grid, times, Interpolation::Waves)
                    .map(|(fine, _)| fine)
                    .map_err(|error| Failure::input(key(option), error)),
            }
        };
        let mut sideways = moved.chunks_exact(points).map(on_grid).collect::<Result<Vec<_>, Failure>>()?;
        // The normal component is the last.
        let Some(lift) = sideways.pop() else { return Ok(None) };
        Ok(Some(MovedBase { kind, field, lift, sideways }))
    }
}

impl MovedBase {
    /// Returns the SHA-256 of the field.
    pub fn checksum(&self) -> String {
        Checksum::of_numbers(self.field.iter().copied())
    }

    /// Returns the heights of the contact that has the same gap over a base at rest (theory.md, section 4.2).
    pub fn under(base: Option<&Self>, heights: &ArcArray2<f64>) -> ArcArray2<f64> {
        match base {
            Some(base) => (heights + &base.lift).into_shared(),
            None => heights.clone(),
        }
    }

    /// Writes the group `/base` of a file; only the writing process has an `archive`.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn write(
        &self,
        mut archive: Option<&mut Archive>,
        share: &Share,
        axes: [&Dimension; 2],
        units: &Units,
    ) -> Result<(), Failure> {
        let [x, y] = axes;
        let component =
            Dimension::index("component", self.field.len_of(Axis(2)), "component: x, y, z, of a profile x, z");
        let (kind, long_name) = match self.kind {
            Prescribed::Displacement => ("length", "displacement of the base"),
            Prescribed::Traction => ("stress", "traction on the lower face"),
        };
        let unit = &*units.name("length");
        let units = &*units.name(kind);
        let path = STORED.iter().find(|(kind, ..)| *kind == self.kind).map_or("", |(.., path)| path);
        let values: Vec<f64> = self.field.iter().copied().collect();
        let whole = archive.as_mut().map_or(Ok(()), |archive| {
            archive.write(path, &Variable { dimensions: &[x, y, &component], units, long_name }, &values)
        });
        let long_name = "normal surface displacement due to the base alone, included in displacement_z";
        let variable = Variable { dimensions: &[x, y], units: unit, long_name };
        let written = rows::write_all(share, self.lift.view(), archive, "/base/lift", &variable);
        whole?;
        written
    }

    /// Distributes the rows of the base that the first process has read; the other processes give `None`.
    pub fn handed_out(base: Option<Self>, grid: &Grid, share: &Share) -> Self {
        let own = |field: Option<&Array2<f64>>| rows::handed_out(share, field, grid.points()[1]);
        let lift = own(base.as_ref().map(|base| &base.lift));
        let components = share.each(base.as_ref().map_or(0, |base| base.sideways.len()));
        let components = components.into_iter().max().unwrap_or(0);
        let sideways = (0..components).map(|c| own(base.as_ref().and_then(|base| base.sideways.get(c)))).collect();
        let nothing = || Self {
            kind: Prescribed::Displacement,
            field: ArrayD::zeros(IxDyn(&[0, 0, 0])),
            lift: Array2::zeros([0, 0]),
            sideways: Vec::new(),
        };
        Self { lift, sideways, ..base.unwrap_or_else(nothing) }
    }
}

/// Returns the key of the base in a file, and the name to read it from there.
pub fn stored_base(reader: &Reader) -> Option<(&'static str, String)> {
    let found = BaseArgs::NAMES.into_iter().zip(STORED).find(|(_, (.., path))| reader.contains(path));
    found.map(|(key, (.., path))| (key, format!("{}:{path}", reader.path().display())))
}

/// Computes the fields inside a body over the base of the contact in the file `name`. `of_load` computes the fields of
/// the load over a base at rest; it gets u_z of the unloaded surface, length. A surface that is held sideways stays in
/// place as the base moves; any other one moves with it.
///
/// # Errors
/// Returns an error if the file cannot be read, or for a traction on a plate or a stack of layers (not available).
pub fn inside(
    name: &str,
    grid: &Grid,
    is_held: bool,
    of_load: impl FnOnce(&[f64]) -> Result<Interior, InteriorError>,
) -> Result<Interior, String> {
    let words = |error: gfmd_files::FileError| error.to_string();
    let path = split_dataset(name).map_or(name, |(path, _)| path);
    let reader = Reader::open(path).map_err(words)?;
    let [(.., moved), _] = STORED;
    if !reader.contains(moved) {
        return Err("the contact has a traction on its base; the fields below its surface are not available".into());
    }
    let components = if grid.is_line() { 2 } else { 3 };
    let stored: Vec<f64> = reader.values(moved).map_err(words)?;
    let lift: Vec<f64> = reader.values("/base/lift").map_err(words)?;
    if stored.len() != components * grid.len() || lift.len() != grid.len() {
        return Err("the base has another grid than the surface".into());
    }
    let base: Vec<f64> = (0..components).flat_map(|c| stored.iter().skip(c).step_by(components).copied()).collect();
    let interior = of_load(&lift);
    let interior =
        interior.and_then(|interior| if is_held { interior.with_base(&base) } else { interior.over_base(&base) });
    interior.map_err(|error| error.to_string())
}
