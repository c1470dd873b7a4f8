//! Waves that displace a surface.

use std::f64::consts::TAU;
use std::fmt;
use std::str::FromStr;

use gfmd_field::Grid;
use gfmd_problem::key;
use gfmd_response::Components;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::quantity::AXES;
use gfmd_input::failure::Failure;

/// Displacement a cos 2π(m x/Lx + n y/Ly) of one component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Wave numbers m and n.
    numbers: [i32; 2],
    /// Displaced component: 0 is x, 1 is y, 2 is z.
    axis: usize,
    /// Amplitude a, length.
    amplitude: f64,
}

impl FromStr for Wave {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts: Vec<&str> = text.split(',').map(str::trim).collect();
        let allowed = "it must be M,N,COMPONENT,AMPLITUDE: two whole numbers, x, y or z, and a length";
        let [m, n, component, amplitude] = parts[..] else { return Err(allowed.into()) };
        let wave = || {
            let axis = AXES.iter().position(|axis| *axis == component)?;
            let amplitude = amplitude.parse().ok().filter(|amplitude: &f64| amplitude.is_finite())?;
            Some(Self { numbers: [m.parse().ok()?, n.parse().ok()?], axis, amplitude })
        };
        wave().ok_or_else(|| allowed.into())
    }
}

impl fmt::Display for Wave {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { numbers: [m, n], axis, amplitude } = self;
        write!(f, "{m},{n},{},{amplitude:?}", AXES[*axis])
    }
}

impl Serialize for Wave {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { numbers: [m, n], axis, amplitude } = self;
        (m, n, AXES[*axis], amplitude).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Wave {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (m, n, component, amplitude) = <(i32, i32, String, f64)>::deserialize(deserializer)?;
        format!("{m},{n},{component},{amplitude:?}").parse().map_err(D::Error::custom)
    }
}

/// Returns the displacement of the surface by all `waves`, component after component.
pub(super) fn displacement(waves: &[Wave], grid: &Grid) -> Result<Vec<f64>, Failure> {
    let [nx, ny] = grid.points();
    let axes = Components::of(grid).axes();
    let mut field = vec![0.0; axes.len() * grid.len()];
    for wave in waves {
        let component = axes.iter().position(|axis| *axis == wave.axis);
        let component = component.ok_or_else(|| Failure::value(key("wave"), wave, "a wave of x or z on a line"))?;
        let least = |points: usize| if points == 1 { 0 } else { points as u64 / 2 };
        let resolved = |(number, points): (i32, usize)| {
            let number = u64::from(number.unsigned_abs());
            number == 0 || 2 * number < points as u64
        };
        if !wave.numbers.into_iter().zip([nx, ny]).all(resolved) {
            let [x, y] = [least(nx), least(ny)];
            let below = format!("a wave with |M| below {x}, half the points along x, and |N| below {y}");
            let allowed =
                if ny == 1 { format!("a wave with |M| below {x}, half the points, and N = 0") } else { below };
            return Err(Failure::value(key("wave"), wave, allowed));
        }
        let turns = |number: i32, i: usize, points: usize| {
            // Leave out whole turns, so that equal values have equal bits.
            let step = i64::from(number) * i as i64;
            step.rem_euclid(points as i64) as f64 / points as f64
        };
        for (index, value) in field[component * grid.len()..][..grid.len()].iter_mut().enumerate() {
            let [x, y] = [turns(wave.numbers[0], index / ny, nx), turns(wave.numbers[1], index % ny, ny)];
            *value += wave.amplitude * (TAU * (x + y)).cos();
        }
    }
    Ok(field)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_add_up_to_a_product_of_cosines() {
        let grid = Grid::new([8, 12], [1.0, 2.0]).unwrap();
        let waves: Vec<Wave> =
            ["1,1,z,0.5", "1,-1,z,0.5", "0,0,x,-3"].iter().map(|text| text.parse().unwrap()).collect();
        let field = displacement(&waves, &grid).unwrap();
        for (index, value) in field[2 * 96..].iter().enumerate() {
            let expected = (TAU * (index / 12) as f64 / 8.0).cos() * (TAU * (index % 12) as f64 / 12.0).cos();
            assert!((value - expected).abs() < 1e-15, "{index}: {value} {expected}");
        }
        assert!(field[..96].iter().all(|u| *u == -3.0) && field[96..192].iter().all(|u| *u == 0.0));
        assert_eq!(waves[1].to_string(), "1,-1,z,0.5");
    }

    #[test]
    fn waves_that_the_grid_does_not_resolve_are_refused() {
        let (plane, line) = (Grid::square(8, 1.0).unwrap(), Grid::line(8, 1.0).unwrap());
        for (wave, grid) in [("4,0,z,1", plane), ("0,-4,x,1", plane), ("1,1,z,1", line), ("1,0,y,1", line)] {
            assert!(displacement(&[wave.parse().unwrap()], &grid).is_err(), "{wave}");
        }
        for wave in ["3,-3,y,1", "-3,3,x,1"] {
            assert!(displacement(&[wave.parse().unwrap()], &plane).is_ok(), "{wave}");
        }
        for text in ["", "1,1,z", "1,1,w,1", "1.5,1,z,1", "1,1,z,inf", "1,1,z,1,1"] {
            assert!(text.parse::<Wave>().unwrap_err().contains("M,N,COMPONENT,AMPLITUDE"), "{text}");
        }
    }
}
