//! The waves of one lane of the half spectrum.

use gfmd_field::Real;
use multiversion::multiversion;
use num_complex::Complex;

use crate::cells::Cell;
use crate::pack::{Pack, WIDTH};
use crate::sweep::{self, Memory, Strain, Waves};
use crate::volume::{COMPONENTS, Flipped, Places, Scale, Volume, WavePack};

/// Result of a pass over the waves.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Direction {
    /// Displacement of the surface, from plastic strain.
    Up,
    /// Strain, from plastic strain and the traction on the surface.
    Down,
}

/// Cells whose plastic strain is not zero, and cells whose strain is wanted.
#[derive(Clone, Debug)]
pub(crate) struct Selection {
    pub(crate) plastic: Vec<bool>,
    pub(crate) strain: Vec<bool>,
}

/// One lane of the half spectrum: waves with one number along the halved axis.
pub(crate) struct Lane<'a, T: Real> {
    pub(crate) volume: &'a Volume,
    pub(crate) selection: &'a Selection,
    /// Number of the lane among all.
    pub(crate) lane: usize,
    /// Traction or displacement of the surface.
    pub(crate) surface: &'a mut [Complex<T>],
    /// Rows of cells and components; none if the grid of a cell ends before.
    pub(crate) rows: Vec<Option<&'a mut [Complex<T>]>>,
    /// Number of components of a cell.
    pub(crate) count: usize,
    /// Sums of squares of unbalanced and of all nodal forces, without the uniform and the Nyquist waves, if wanted.
    pub(crate) balance: Option<&'a mut [f64; 2]>,
}

impl<T: Real> Lane<'_, T> {
    pub(crate) fn solve(&mut self, direction: Direction, memory: &mut Memory) {
        let grid = self.volume.mesh.grid;
        let [_, positions] = grid.spectrum_shape();
        let per_lane = positions.div_ceil(WIDTH);
        let weight = grid.mode(self.lane, 0).weight;
        self.drop_nyquist();
        for pack in 0..per_lane {
            let WavePack { depth, support, waves, flipped } =
                &self.volume.packs[(self.lane - self.volume.lanes.start) * per_lane + pack];
            let cells = &self.volume.mesh.cells[..*depth];
            load(self, pack, &mut memory.plastic[..*depth]);
            let traction = self.traction(pack);
            if direction == Direction::Down {
                memory.strain[..*depth].fill([[Pack::ZERO; 2]; COMPONENTS]);
            }
            let mut displacement = [Pack::ZERO; 2];
            let mut lowest = [[Pack::ZERO; 3]; 2];
            let mut add = |waves: &Waves, share: &Pack| {
                let forces = sweep::up(cells, waves, support, memory);
                match direction {
                    Direction::Up => {
                        let one = sweep::normal_displacement(&forces.0, &forces.1);
                        displacement.iter_mut().zip(one).for_each(|(sum, one)| *sum += one * *share);
                    }
                    Direction::Down => lowest = sweep::down(cells, waves, &forces, &traction, share, memory),
                }
            };
            match flipped.as_deref() {
                None => add(waves, &Pack::all(1.0)),
                Some(Flipped { waves: reversed, shares }) => {
                    add(waves, &shares[0]);
                    add(reversed, &shares[1]);
                }
            }
            let is_uniform = self.lane == 0 && pack == 0;
            if let Some(balance) = self.balance.as_deref_mut() {
                // The strain of a wave that the grid cannot distinguish from another is a mean over both.
                let alone = |share: f64| f64::from(share == 1.0);
                let mut weights =
                    flipped.as_deref().map_or(Pack::all(1.0), |flipped| Pack(flipped.shares[0].0.map(alone)));
                if is_uniform {
                    weights.0[0] = 0.0;
                }
                let sums = sweep::balance(cells, waves, support, &traction, &lowest, &weights, memory);
                balance.iter_mut().zip(sums).for_each(|(balance, sum)| *balance += weight * sum);
            }
            match direction {
                Direction::Up => {
                    let first = pack * WIDTH;
                    for (k, value) in self.surface[first..].iter_mut().take(WIDTH).enumerate() {
                        *value = Complex::new(T::nearest(displacement[0].0[k]), T::nearest(displacement[1].0[k]));
                    }
                    if is_uniform {
                        self.surface[0] = Complex::new(T::nearest(self.uniform_displacement(memory)), T::default());
                    }
                }
                Direction::Down => {
                    if is_uniform {
                        self.set_uniform_strain(traction[0].0[0], memory);
                    }
                    store(self, pack, &memory.strain[..*depth]);
                }
            }
        }
    }

    /// Sets the Nyquist modes of coarser grids to zero.
    fn drop_nyquist(&mut self) {
        for (level, rows) in self.volume.levels.iter().zip(self.rows.chunks_exact_mut(self.count)) {
            let Scale { grid, lanes, .. } = &self.volume.scales[*level];
            if *level == 0 {
                continue;
            }
            let [points, _] = grid.points();
            for row in rows.iter_mut().flatten() {
                if self.lane >= *lanes {
                    row.fill(Complex::default());
                } else if points.is_multiple_of(2) {
                    row[points / 2] = Complex::default();
                }
            }
        }
    }

    /// Returns Σ h τ_zz/C11 of the uniform mode.
    fn uniform_displacement(&self, memory: &Memory) -> f64 {
        let cells = self.volume.mesh.cells.iter().zip(&memory.plastic);
        cells.map(|(cell, plastic)| cell.thickness * normal_strain(cell, plastic[0][0].0[0], 0.0)).sum()
    }

    /// Sets the strain of the uniform mode, which has no lateral part: ε_zz = (t_z + τ_zz)/C11, γ_xz = τ_xz/μ.
    fn set_uniform_strain(&self, traction: f64, memory: &mut Memory) {
        let cells = self.volume.mesh.cells.iter().zip(&memory.plastic).zip(&mut memory.strain);
        for ((cell, plastic), strain) in cells {
            let components = [
                (2.0_f64 / 3.0).sqrt() * normal_strain(cell, plastic[0][0].0[0], traction),
                0.0,
                0.0,
                plastic[3][0].0[0],
                plastic[4][0].0[0],
            ];
            for (strain, component) in strain.iter_mut().zip(components) {
                strain[0].0[0] = component;
                strain[1].0[0] = 0.0;
            }
        }
    }

    /// Returns −p of a pack.
    fn traction(&self, pack: usize) -> [Pack; 2] {
        let mut traction = [Pack::ZERO; 2];
        for (k, value) in self.surface[pack * WIDTH..].iter().take(WIDTH).enumerate() {
            traction[0].0[k] = -value.re.widened();
            traction[1].0[k] = -value.im.widened();
        }
        traction
    }

    /// Returns the places of the pack in the rows of a cell; none if its grid has no wave of the lane.
    fn places(&self, cell: usize, pack: usize) -> Option<&Places> {
        let scale = &self.volume.scales[self.volume.levels[cell]];
        (self.lane < scale.lanes).then(|| &scale.places[pack])
    }
}

/// Loads a pack of the plastic strain of the upper cells.
#[multiversion(targets = "simd")]
fn load<T: Real>(lane: &Lane<'_, T>, pack: usize, plastic: &mut [Strain]) {
    let Lane { volume, selection, rows, count, .. } = lane;
    for (cell, plastic) in plastic.iter_mut().enumerate() {
        *plastic = [[Pack::ZERO; 2]; COMPONENTS];
        let places = lane.places(cell, pack).filter(|_| selection.plastic[cell]);
        let Some(places) = places else { continue };
        for (row, component) in rows[cell * count..].iter().zip(&volume.components) {
            let Some(row) = row else { continue };
            let [re, im] = &mut plastic[*component];
            match places {
                Places::From(first) => {
                    for (k, value) in row[*first..first + WIDTH].iter().enumerate() {
                        re.0[k] = value.re.widened();
                        im.0[k] = value.im.widened();
                    }
                }
                Places::Each(places) => {
                    for (k, place) in places.iter().enumerate() {
                        if let Some(value) = row.get(*place as usize) {
                            re.0[k] = value.re.widened();
                            im.0[k] = value.im.widened();
                        }
                    }
                }
            }
        }
    }
}

/// Stores a pack of the strain of the upper cells. Modes that the grid of a cell does not have are zero.
#[multiversion(targets = "simd")]
fn store<T: Real>(lane: &mut Lane<'_, T>, pack: usize, strain: &[Strain]) {
    let Lane { volume, selection, rows, count, lane, .. } = lane;
    for (cell, strain) in strain.iter().enumerate().filter(|(cell, _)| selection.strain[*cell]) {
        let scale = &volume.scales[volume.levels[cell]];
        if *lane >= scale.lanes {
            continue;
        }
        for (row, component) in rows[cell * *count..].iter_mut().zip(&volume.components) {
            let Some(row) = row else { continue };
            let [re, im] = &strain[*component];
            let value = |k: usize| Complex::new(T::nearest(re.0[k]), T::nearest(im.0[k]));
            match &scale.places[pack] {
                Places::From(first) => {
                    row[*first..first + WIDTH].iter_mut().enumerate().for_each(|(k, to)| *to = value(k));
                }
                Places::Each(places) => {
                    for (k, place) in places.iter().enumerate() {
                        if let Some(to) = row.get_mut(*place as usize) {
                            *to = value(k);
                        }
                    }
                }
            }
        }
    }
}

/// Returns ε_zz = (t_z + τ_zz)/C11 of a cell without lateral strain, from the first component of its plastic strain.
fn normal_strain(cell: &Cell, plastic: f64, traction: f64) -> f64 {
    (traction + 2.0 * cell.shear_modulus * (2.0_f64 / 3.0).sqrt() * plastic) / cell.p_wave_modulus
}
