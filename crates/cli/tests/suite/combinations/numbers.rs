//! Independent definitions of the numbers of a contact: counts, means, gradients, patches, flow through a network.

use std::f64::consts::PI;

use super::elastic::{Plane, solve};

pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

pub(crate) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()))
}

/// Returns the root mean square about the mean.
pub(crate) fn deviation(values: &[f64]) -> f64 {
    let middle = mean(values);
    mean(&values.iter().map(|value| (value - middle).powi(2)).collect::<Vec<f64>>()).sqrt()
}

/// Returns the root mean square gradient: by waves for a periodic surface, by differences inside a patch.
pub(crate) fn gradient(plane: Plane, heights: &[f64], is_free: bool) -> f64 {
    if !is_free {
        let modes = plane.transform(heights);
        let square = |place: usize| {
            let ([x, y], [re, im]) = (plane.wave(place), modes[place]);
            (x * x + y * y) * (re * re + im * im)
        };
        return (0..plane.len()).map(square).sum::<f64>().sqrt();
    }
    let ([nx, ny], [dx, dy]) = (plane.n, plane.spacing());
    let at = |i: usize, j: usize| heights[i * ny + j];
    let along_x: Vec<f64> = (0..ny)
        .flat_map(|j| (1..nx).map(move |i| (i, j)))
        .map(|(i, j)| ((at(i, j) - at(i - 1, j)) / dx).powi(2))
        .collect();
    let along_y: Vec<f64> = (0..nx)
        .flat_map(|i| (1..ny).map(move |j| (i, j)))
        .map(|(i, j)| ((at(i, j) - at(i, j - 1)) / dy).powi(2))
        .collect();
    (mean(&along_x) + if along_y.is_empty() { 0.0 } else { mean(&along_y) }).sqrt()
}

/// Returns the largest slope of forward differences that do not cross the seam.
pub(crate) fn steepest(plane: Plane, heights: &[f64]) -> f64 {
    let ([nx, ny], [dx, dy]) = (plane.n, plane.spacing());
    let mut most = 0.0_f64;
    for i in 0..nx {
        for j in 0..ny {
            let here = heights[i * ny + j];
            let x = if i + 1 < nx { (heights[(i + 1) * ny + j] - here) / dx } else { 0.0 };
            let y = if j + 1 < ny { (heights[i * ny + j + 1] - here) / dy } else { 0.0 };
            most = most.max(x.hypot(y));
        }
    }
    most
}

/// Returns the neighbours of a point, with the cell reached by the step.
pub(crate) fn neighbours(plane: Plane, place: usize, is_free: bool) -> Vec<(usize, [i64; 2], usize)> {
    let [nx, ny] = plane.n;
    let at = [place / ny, place % ny];
    let mut all = Vec::new();
    for axis in [0, 1] {
        let n = plane.n[axis];
        if n == 1 {
            continue;
        }
        for step in [1_i64, -1] {
            let next = at[axis] as i64 + step;
            let cell = next.div_euclid(n as i64);
            if cell != 0 && is_free {
                continue;
            }
            let mut there = at;
            there[axis] = next.rem_euclid(n as i64) as usize;
            let mut winds = [0; 2];
            winds[axis] = cell;
            all.push((there[0] * ny + there[1], winds, axis));
        }
    }
    debug_assert!(nx > 0);
    all
}

/// Counts the pairs of neighbours with exactly one point that belongs.
pub(crate) fn links(plane: Plane, belongs: &[bool], is_free: bool) -> usize {
    let ends = |place: usize| neighbours(plane, place, is_free).iter().filter(|(there, ..)| !belongs[*there]).count();
    (0..belongs.len()).filter(|place| belongs[*place]).map(ends).sum()
}

/// Connected set of points.
#[derive(Debug, Default)]
pub(crate) struct Patch {
    pub(crate) points: Vec<usize>,
    pub(crate) percolates: [bool; 2],
}

/// Returns the connected sets of points, by flood fill; a set that meets itself in another cell winds around the cell.
pub(crate) fn patches(plane: Plane, belongs: &[bool], is_free: bool) -> Vec<Patch> {
    let mut cells: Vec<Option<[i64; 2]>> = vec![None; belongs.len()];
    let mut all = Vec::new();
    for start in 0..belongs.len() {
        if !belongs[start] || cells[start].is_some() {
            continue;
        }
        let mut patch = Patch::default();
        cells[start] = Some([0, 0]);
        let mut open = vec![start];
        while let Some(place) = open.pop() {
            patch.points.push(place);
            let here = cells[place].unwrap();
            for (there, winds, _) in neighbours(plane, place, is_free) {
                let cell = [here[0] + winds[0], here[1] + winds[1]];
                match cells[there] {
                    _ if !belongs[there] => {}
                    None => {
                        cells[there] = Some(cell);
                        open.push(there);
                    }
                    Some(known) => {
                        for axis in [0, 1] {
                            patch.percolates[axis] |= known[axis] != cell[axis];
                        }
                    }
                }
            }
        }
        if is_free {
            let ny = plane.n[1];
            let reaches =
                |axis: usize, index: usize| patch.points.iter().any(|place| [place / ny, place % ny][axis] == index);
            patch.percolates =
                [0, 1].map(|axis| plane.n[axis] > 1 && reaches(axis, 0) && reaches(axis, plane.n[axis] - 1));
        }
        all.push(patch);
    }
    all
}

/// Returns the mean flux along x and y (rows) for a unit mean gradient along x and y (columns) through cells with these
/// conductivities and their harmonic means on the faces, by elimination. An axis without a channel has no flow.
pub(crate) fn flow(plane: Plane, conductivity: &[f64], is_free: bool) -> [[f64; 2]; 2] {
    let [dx, dy] = plane.spacing();
    let open: Vec<bool> = conductivity.iter().map(|k| *k > 0.0).collect();
    let found = patches(plane, &open, is_free);
    let mut fluxes = [[0.0; 2]; 2];
    for axis in [0, 1] {
        for patch in found.iter().filter(|patch| patch.percolates[axis]) {
            let number = |place: usize| patch.points.iter().position(|other| *other == place);
            let numbers: Vec<Option<usize>> = (0..conductivity.len()).map(number).collect();
            let size = patch.points.len();
            let (mut rows, mut right) = (vec![vec![0.0; size]; size], vec![0.0; size]);
            // Each face: cell, cell beyond or none, conductance, drop of the mean gradient, axis.
            let mut faces: Vec<(usize, Option<usize>, f64, f64, usize)> = Vec::new();
            for (k, place) in patch.points.iter().enumerate() {
                for along in [0, 1] {
                    let (distance, width) = if along == 0 { (dx, dy) } else { (dy, dx) };
                    let index = [place / plane.n[1], place % plane.n[1]][along];
                    let n = plane.n[along];
                    if is_free && along == axis {
                        for edge in [0, n - 1] {
                            if index == edge {
                                let sign = if edge == 0 { -0.5 } else { 0.5 };
                                faces.push((
                                    k,
                                    None,
                                    2.0 * conductivity[*place] * width / distance,
                                    sign * distance,
                                    along,
                                ));
                            }
                        }
                    }
                    if index + 1 == n && (is_free || n == 1) {
                        continue;
                    }
                    let mut there = [place / plane.n[1], place % plane.n[1]];
                    there[along] = (index + 1) % n;
                    let beside = there[0] * plane.n[1] + there[1];
                    let (a, b) = (conductivity[*place], conductivity[beside]);
                    if let (Some(other), true) = (numbers[beside], b > 0.0) {
                        let drop = if along == axis { distance } else { 0.0 };
                        faces.push((k, Some(other), 2.0 * a * b / (a + b) * width / distance, drop, along));
                    }
                }
            }
            for (here, there, conductance, drop, _) in &faces {
                rows[*here][*here] += conductance;
                right[*here] -= conductance * drop;
                if let Some(there) = there {
                    rows[*there][*there] += conductance;
                    rows[*here][*there] -= conductance;
                    rows[*there][*here] -= conductance;
                    right[*there] += conductance * drop;
                }
            }
            if !is_free {
                // The level is arbitrary.
                rows[0].iter_mut().for_each(|value| *value = 0.0);
                rows[0][0] = conductivity[patch.points[0]];
                right[0] = 0.0;
            }
            let potential = solve(rows, right);
            for (here, there, conductance, drop, along) in &faces {
                let beyond = there.map_or(0.0, |there| potential[there]);
                let flux = conductance * (potential[*here] - beyond + drop);
                let distance = match there {
                    Some(_) => {
                        if *along == 0 {
                            dx
                        } else {
                            dy
                        }
                    }
                    None => *drop,
                };
                fluxes[*along][axis] += flux * distance / (plane.length[0] * plane.length[1]);
            }
        }
    }
    fluxes
}

/// Returns (pi - 1 + ln 2)/24, the excess of a counted area per pixel edge (Yastrebov and others 2017).
pub(crate) fn excess() -> f64 {
    (PI - 1.0 + 2.0_f64.ln()) / 24.0
}
