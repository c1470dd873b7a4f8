//! Record of every step of a search (`--history`): residual, energy, and chosen modes and points of the displacement.

use std::f64::consts::TAU;
use std::str::FromStr;

use clap::Args;
use gfmd_field::Grid;
use gfmd_files::{Archive, Dimension, FileError, Reader, Variable};
use gfmd_problem::{key, words};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use gfmd_input::failure::Failure;
use gfmd_problem::options::{Kinds, Options};

/// Flags of the record.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Long runs")]
pub struct TraceArgs {
    /// Record residual and energy of every step, in the JSON and in /history of --out
    #[arg(long)]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    history: bool,
    /// Also record the Fourier amplitude of this mode of a displacement component; repeatable (dynamics only)
    #[arg(long, value_name = "M,N,COMPONENT", requires = "history", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    history_mode: Vec<ModeOf>,
    /// Also record the displacement component at the point nearest to this position; repeatable (dynamics only)
    #[arg(long, value_name = "X,Y,COMPONENT", requires = "history", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::list(&[&["length", "length", "1"]]))]
    history_point: Vec<PointOf>,
}

/// Mode of a component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeOf {
    numbers: [i32; 2],
    axis: usize,
}

/// Position, with a component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointOf {
    position: [f64; 2],
    axis: usize,
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// Splits `A,B,COMPONENT`.
fn split<T: FromStr>(text: &str) -> Option<([T; 2], usize)> {
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let [a, b, component] = parts[..] else { return None };
    let axis = AXES.iter().position(|axis| *axis == component)?;
    Some(([a.parse().ok()?, b.parse().ok()?], axis))
}

impl FromStr for ModeOf {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = split(text).map(|(numbers, axis)| Self { numbers, axis });
        found.ok_or_else(|| "it must be M,N,COMPONENT: two whole numbers, and x, y or z".into())
    }
}

impl FromStr for PointOf {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = split(text).filter(|(position, _)| position.iter().all(|x: &f64| x.is_finite()));
        let found = found.map(|(position, axis)| Self { position, axis });
        found.ok_or_else(|| "it must be X,Y,COMPONENT: two lengths, and x, y or z".into())
    }
}

impl Serialize for ModeOf {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (self.numbers[0], self.numbers[1], AXES[self.axis]).serialize(serializer)
    }
}

impl Serialize for PointOf {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (self.position[0], self.position[1], AXES[self.axis]).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for ModeOf {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (m, n, component) = <(i32, i32, String)>::deserialize(deserializer)?;
        format!("{m},{n},{component}").parse().map_err(D::Error::custom)
    }
}

impl<'de> Deserialize<'de> for PointOf {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (x, y, component) = <(f64, f64, String)>::deserialize(deserializer)?;
        format!("{x:?},{y:?},{component}").parse().map_err(D::Error::custom)
    }
}

/// Numbers of every step; NaN, in JSON `null`, where the method does not move the displacement.
#[derive(Clone, Debug, Default, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Trace {
    pub iteration: Vec<u64>,
    pub residual: Vec<f64>,
    /// Elastic energy less the work of prescribed tractions, per area.
    pub energy: Vec<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub modes: Vec<ModeTrace>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<PointTrace>,
}

/// Amplitude ⟨u exp(−i q·r)⟩ of one mode.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct ModeTrace {
    pub mode: [i32; 2],
    pub component: &'static str,
    pub re: Vec<f64>,
    pub im: Vec<f64>,
}

/// Displacement of one point.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct PointTrace {
    /// Position of the point.
    pub point: [f64; 2],
    pub component: &'static str,
    pub u: Vec<f64>,
}

/// Recorder of one search.
pub struct Tracer {
    trace: Trace,
    grid: Grid,
    /// Places of the components of the modes, and their waves, filled by the first displacement.
    waves: Vec<(usize, Vec<[f64; 2]>)>,
    /// Entries of the points.
    entries: Vec<usize>,
}

impl TraceArgs {
    /// Returns true if a record is requested.
    pub fn is_wanted(&self) -> bool {
        self.history
    }

    /// Returns a recorder of displacements on `grid` with components along `axes`, if requested.
    pub fn tracer(&self, grid: &Grid, axes: &[usize]) -> Result<Option<Tracer>, Failure> {
        if !self.history {
            let given =
                [("history_mode", !self.history_mode.is_empty()), ("history_point", !self.history_point.is_empty())];
            return match given.into_iter().find(|(_, given)| *given) {
                Some((option, _)) => {
                    Err(Failure::value(key(option), "given", words!["left out without ", key("history")]))
                }
                None => Ok(None),
            };
        }
        let place = |option: &str, axis: usize| {
            let names: Vec<&str> = axes.iter().map(|axis| AXES[*axis]).collect();
            let found = axes.iter().position(|of| *of == axis);
            found.ok_or_else(|| {
                Failure::value(key(option), AXES[axis], format!("a component that moves: {}", names.join(", ")))
            })
        };
        let ([nx, ny], lengths) = (grid.points(), grid.lengths());
        let mut tracer = Tracer { trace: Trace::default(), grid: *grid, waves: Vec::new(), entries: Vec::new() };
        for ModeOf { numbers, axis } in &self.history_mode {
            tracer.waves.push((place("history_mode", *axis)?, Vec::new()));
            let (mode, component) = (*numbers, AXES[*axis]);
            tracer.trace.modes.push(ModeTrace { mode, component, re: Vec::new(), im: Vec::new() });
        }
        for PointOf { position, axis } in &self.history_point {
            let nearest = |axis: usize| {
                let spacing = grid.spacing()[axis];
                (position[axis].rem_euclid(lengths[axis]) / spacing).round() as usize % [nx, ny][axis]
            };
            let (i, j) = (nearest(0), nearest(1));
            tracer.entries.push(place("history_point", *axis)? * grid.len() + i * ny + j);
            let point = [i as f64 * grid.spacing()[0], j as f64 * grid.spacing()[1]];
            tracer.trace.points.push(PointTrace { point, component: AXES[*axis], u: Vec::new() });
        }
        Ok(Some(tracer))
    }
}

/// Returns cos q·r and −sin q·r at the points of a grid, for the mode with these numbers.
fn wave_on(grid: &Grid, numbers: [i32; 2]) -> Vec<[f64; 2]> {
    let [nx, ny] = grid.points();
    let phase = |number: i32, i: usize, n: usize| (i64::from(number) * i as i64).rem_euclid(n as i64) as f64 / n as f64;
    let wave = |index: usize| {
        let turns = phase(numbers[0], index / ny, nx) + phase(numbers[1], index % ny, ny);
        let (sin, cos) = (TAU * turns).sin_cos();
        [cos, -sin]
    };
    (0..grid.len()).map(wave).collect()
}

impl Tracer {
    /// Records an iteration; a repeated one replaces the earlier one. A search that begins anew has a new record.
    pub fn see(&mut self, iteration: u64, residual: f64) {
        let trace = &mut self.trace;
        if trace.iteration.last().is_some_and(|last| iteration < *last) {
            trace.clear();
        }
        let is_again = trace.iteration.last() == Some(&iteration);
        if !is_again {
            trace.iteration.push(iteration);
        }
        let note = |values: &mut Vec<f64>, value: f64| {
            if is_again {
                values.pop();
            }
            values.push(value);
        };
        note(&mut trace.residual, residual);
        note(&mut trace.energy, f64::NAN);
        trace.modes.iter_mut().for_each(|mode| {
            note(&mut mode.re, f64::NAN);
            note(&mut mode.im, f64::NAN);
        });
        trace.points.iter_mut().for_each(|point| note(&mut point.u, f64::NAN));
    }

    /// Records the energy, summed over all points, and the displacement of the last iteration.
    pub fn layer(&mut self, energy: f64, u: &[f64]) {
        fn last(values: &mut [f64], value: f64) {
            if let Some(last) = values.last_mut() {
                *last = value;
            }
        }
        let points = self.grid.len();
        last(&mut self.trace.energy, energy / points as f64);
        for (mode, (place, wave)) in self.trace.modes.iter_mut().zip(&mut self.waves) {
            if wave.is_empty() {
                *wave = wave_on(&self.grid, mode.mode);
            }
            let component = u.get(*place * points..(*place + 1) * points).unwrap_or_default();
            let sum = |part: usize| component.iter().zip(&*wave).map(|(u, wave)| u * wave[part]).sum::<f64>();
            last(&mut mode.re, sum(0) / points as f64);
            last(&mut mode.im, sum(1) / points as f64);
        }
        for (point, entry) in self.trace.points.iter_mut().zip(&self.entries) {
            last(&mut point.u, u.get(*entry).copied().unwrap_or(f64::NAN));
        }
    }

    /// Returns the record.
    pub fn trace(self) -> Trace {
        self.trace
    }
}

impl Trace {
    fn clear(&mut self) {
        let Self { iteration, residual, energy, modes, points } = self;
        iteration.clear();
        let modes = modes.iter_mut().flat_map(|mode| [&mut mode.re, &mut mode.im]);
        let points = points.iter_mut().map(|point| &mut point.u);
        [residual, energy].into_iter().chain(modes).chain(points).for_each(Vec::clear);
    }

    /// Reads the group `/history`; `None` if the file has none.
    ///
    /// # Errors
    /// Returns an error for a group without the numbers of its samples.
    pub fn read(reader: &Reader) -> Result<Option<Self>, FileError> {
        let path = |name: &str| format!("/history/{name}");
        let values = |name: &str| reader.values::<f64>(&path(name));
        let names = |name: &str| reader.texts(&path(name)).unwrap_or_default();
        if !reader.contains(&path("iteration")) {
            return Ok(None);
        }
        let iteration: Vec<u64> = values("iteration")?.into_iter().map(|iteration| iteration as u64).collect();
        let samples = iteration.len().max(1);
        let rows = |name: &str, names: &[String]| match names {
            [] => Ok(Vec::new()),
            _ => values(name).map(|values| values.chunks(samples).map(<[f64]>::to_vec).collect::<Vec<_>>()),
        };
        let (modes, points) = (names("mode"), names("point"));
        let parts = rows("mode_re", &modes)?.into_iter().zip(rows("mode_im", &modes)?);
        let mode = |(name, (re, im)): (&String, (Vec<f64>, Vec<f64>))| {
            let ModeOf { numbers, axis } = name.parse().ok()?;
            Some(ModeTrace { mode: numbers, component: AXES[axis], re, im })
        };
        let point = |(name, u): (&String, Vec<f64>)| {
            let PointOf { position, axis } = name.parse().ok()?;
            Some(PointTrace { point: position, component: AXES[axis], u })
        };
        Ok(Some(Self {
            iteration,
            residual: values("residual")?,
            energy: values("energy")?,
            modes: modes.iter().zip(parts).filter_map(mode).collect(),
            points: points.iter().zip(rows("point_u", &points)?).filter_map(point).collect(),
        }))
    }

    /// Writes the group `/history`.
    pub fn write(&self, archive: &mut Archive, unit: &str) -> Result<(), Failure> {
        let steps: Vec<f64> = self.iteration.iter().map(|iteration| *iteration as f64).collect();
        let sample = Dimension::values("iteration", steps, "1", "iteration, or time step");
        for (name, units, long_name, values) in [
            ("residual", "1", "residual in the method's own stopping criterion", &self.residual),
            ("energy", "stress*length", "elastic energy per area minus the work of given tractions", &self.energy),
        ] {
            archive.write(
                &format!("/history/{name}"),
                &Variable { dimensions: &[&sample], units, long_name },
                values,
            )?;
        }
        if !self.modes.is_empty() {
            let names: Vec<String> =
                self.modes.iter().map(|mode| format!("{},{},{}", mode.mode[0], mode.mode[1], mode.component)).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let mode = Dimension::labels("mode", &names, "mode numbers along x and y, component");
            let long_name = "mode amplitude, the mean of u exp(-iqr)";
            for (name, part) in [("mode_re", 0), ("mode_im", 1)] {
                let values: Vec<f64> =
                    self.modes.iter().flat_map(|mode| if part == 0 { &mode.re } else { &mode.im }).copied().collect();
                let variable = Variable { dimensions: &[&mode, &sample], units: unit, long_name };
                archive.write(&format!("/history/{name}"), &variable, &values)?;
            }
        }
        if !self.points.is_empty() {
            let names: Vec<String> = self
                .points
                .iter()
                .map(|point| format!("{:?},{:?},{}", point.point[0], point.point[1], point.component))
                .collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let point = Dimension::labels("point", &names, "position of the point, component");
            let values: Vec<f64> = self.points.iter().flat_map(|point| &point.u).copied().collect();
            let variable =
                Variable { dimensions: &[&point, &sample], units: unit, long_name: "displacement of a point" };
            archive.write("/history/point_u", &variable, &values)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_and_points_are_those_of_the_field() {
        let grid = Grid::new([8, 4], [2.0, 1.0]).unwrap();
        let args = TraceArgs {
            history: true,
            history_mode: vec!["1,-1,z".parse().unwrap()],
            history_point: vec!["1.9,0.26,x".parse().unwrap()],
        };
        let mut tracer = args.tracer(&grid, &[0, 2]).unwrap().unwrap();
        let turns = |index: usize| (index / 4) as f64 / 8.0 - (index % 4) as f64 / 4.0;
        let field: Vec<f64> = (0..64)
            .map(|i| if i < 32 { i as f64 } else { 3.0 * (TAU * turns(i - 32)).cos() - (TAU * turns(i - 32)).sin() })
            .collect();
        tracer.see(0, 1.0);
        tracer.see(1, 0.5);
        tracer.see(1, 0.4);
        tracer.layer(64.0, &field);
        let trace = tracer.trace();
        assert_eq!((trace.iteration, &trace.residual[..]), (vec![0, 1], &[1.0, 0.4][..]));
        assert!(trace.energy[0].is_nan() && trace.energy[1] == 2.0);
        let mode = &trace.modes[0];
        assert!((mode.re[1] - 1.5).abs() < 1e-14 && (mode.im[1] - 0.5).abs() < 1e-14, "{mode:?}");
        // 1.9 is nearest to 2.0, which is 0; 0.26 is nearest to 0.25.
        assert_eq!((trace.points[0].point, trace.points[0].u[1]), ([0.0, 0.25], 1.0));
        assert!(args.tracer(&grid, &[2]).is_err());
        let mut again = args.tracer(&grid, &[0, 2]).unwrap().unwrap();
        for (iteration, residual) in [(0, 1.0), (1, 0.5), (2, 0.2), (0, 0.1)] {
            again.see(iteration, residual);
        }
        let trace = again.trace();
        assert_eq!((trace.iteration, trace.residual, trace.points[0].u.len()), (vec![0], vec![0.1], 1));
        for text in ["", "1,2", "1,2,w", "a,2,z", "1.5,2,z"] {
            assert!(text.parse::<ModeOf>().is_err(), "{text}");
        }
        assert!("inf,0,z".parse::<PointOf>().is_err());
    }
}
