//! From plastic strain and pressure to strain and displacement of the surface.

use std::sync::Arc;

use gfmd_field::{Real, Transform, Workspace};
use gfmd_vector::distribute;
use num_complex::Complex;
use rayon::prelude::*;

use crate::lane::{Direction, Lane, Selection};
use crate::sweep::Memory;
use crate::volume::{COMPONENTS, Scale, Volume};

/// Transforms of one level.
struct Level<T: Real> {
    transform: Transform<T>,
    /// Numbers of points and modes of this process.
    points: usize,
    modes: usize,
    /// Cost of a transform, in transforms of the full grid.
    cost: f64,
}

/// Fields of the five components of each cell, one component after the other; empty for a cell without.
pub(crate) type CellFields<T> = Vec<Vec<T>>;

/// Memory for the transforms of one cell at a time: a field, and the memory of each level.
struct Bench<T: Real> {
    field: Vec<T>,
    workspaces: Vec<Workspace<T>>,
}

/// Largest number of cells that are transformed at the same time. The threads share the transforms of each cell, too.
const BENCHES: usize = 4;

/// Operators of one [`Volume`] in one precision, with their memory.
pub(crate) struct Operator<T: Real> {
    pub(crate) volume: Arc<Volume>,
    levels: Vec<Level<T>>,
    /// Spectra of the components of each cell, one after the other: plastic strain, then strain. Cells without take no
    /// memory.
    pub(crate) spectra: Vec<Vec<Complex<T>>>,
    surface: Vec<Complex<T>>,
    benches: Vec<Bench<T>>,
    /// Number of single transforms, in transforms of the full grid.
    pub(crate) singles: f64,
}

impl<T: Real> Operator<T> {
    pub(crate) fn new(volume: &Arc<Volume>) -> Self {
        let grid = volume.mesh.grid;
        let level = |scale: &Scale| Level {
            transform: scale.transform(),
            points: scale.points(),
            modes: scale.modes(),
            cost: scale.grid.len() as f64 / grid.len() as f64,
        };
        let levels: Vec<Level<T>> = volume.scales.iter().map(level).collect();
        let points = levels.iter().map(|level| level.points).max().unwrap_or(0);
        let bench = || Bench {
            field: vec![T::default(); points],
            workspaces: levels.iter().map(|level| level.transform.workspace()).collect(),
        };
        // Several processes transform one cell after another, all of them the same one.
        let most = if volume.mesh.division.surface.is_whole() { BENCHES } else { 1 };
        Self {
            volume: Arc::clone(volume),
            spectra: vec![Vec::new(); volume.levels.len()],
            surface: vec![Complex::default(); levels[0].modes],
            benches: (0..rayon::current_num_threads().min(most)).map(|_| bench()).collect(),
            levels,
            singles: 0.0,
        }
    }

    /// Makes zero spectra of the components of a cell.
    pub(crate) fn zeros(&self, cell: usize) -> Vec<Complex<T>> {
        let Volume { components, levels, scales, .. } = &*self.volume;
        vec![Complex::default(); components.len() * scales[levels[cell]].modes()]
    }

    /// Makes the spectra of a cell, unless they have been made since the last [`Self::release`].
    fn provide(&mut self, cell: usize) {
        if self.spectra[cell].is_empty() {
            self.spectra[cell] = self.zeros(cell);
        }
    }

    /// Frees the spectra.
    pub(crate) fn release(&mut self) {
        self.spectra.iter_mut().for_each(|spectra| *spectra = Vec::new());
    }

    /// Returns the number of transforms so far, in pairs of the full grid.
    pub(crate) fn pairs(&self) -> f64 {
        0.5 * self.singles
    }

    /// Counts the transforms of the components of some cells.
    fn count(&mut self, cells: impl Iterator<Item = usize>) {
        let Volume { components, levels, .. } = &*self.volume;
        let singles = cells.map(|cell| components.len() as f64 * self.levels[levels[cell]].cost);
        self.singles += singles.sum::<f64>();
    }

    /// Transforms the components of the plastic strain of selected cells; `fill(cell, component, field)` writes them
    /// into a field of zeros.
    pub(crate) fn analyse(&mut self, selected: &[bool], fill: impl Fn(usize, usize, &mut [T]) + Sync) {
        let cells = || (0..selected.len()).filter(|cell| selected[*cell]);
        cells().for_each(|cell| self.provide(cell));
        self.count(cells());
        let Self { volume, levels, spectra, benches, .. } = self;
        let spectra = spectra.iter_mut().enumerate().filter(|(cell, _)| selected[*cell]);
        distribute(benches, spectra, |(cell, spectra), Bench { field, workspaces }| {
            let (workspace, Level { transform, points, modes, .. }) = at(volume.levels[cell], levels, workspaces);
            let field = &mut field[..*points];
            for (spectrum, component) in parts_mut(spectra, *modes).zip(&volume.components) {
                field.fill(T::default());
                fill(cell, *component, field);
                transform.forward(field, spectrum, workspace).expect("fields and spectra have the sizes of the grid");
            }
        });
    }

    /// Computes the normal displacement of the surface, without traction on it.
    pub(crate) fn surface_displacement(&mut self, plastic: &[bool], displacement: &mut [T]) {
        let selection = Selection { plastic: plastic.to_vec(), strain: vec![false; plastic.len()] };
        self.pass(Direction::Up, &selection, &mut []);
        let Self { levels, surface, benches, singles, .. } = self;
        let (transform, workspace) = (&levels[0].transform, &mut benches[0].workspaces[0]);
        transform.inverse(surface, displacement, workspace).expect("fields and spectra have the sizes of the grid");
        *singles += 1.0;
    }

    /// Computes the spectra of the strain of selected cells, under a pressure on the surface.
    pub(crate) fn strain(&mut self, pressure: &[T], selection: &Selection) {
        self.go_down(pressure, selection, &mut []);
    }

    /// Computes the spectra of the strain as [`Self::strain`] does, and returns the root mean square of the unbalanced
    /// forces on nodes, recomputed from the strain, divided by the root mean square of the forces on them. The uniform
    /// wave, and waves that the grid cannot distinguish, are left out.
    pub(crate) fn strain_in_balance(&mut self, pressure: &[T], selection: &Selection) -> f64 {
        let mut balances = vec![[0.0; 2]; self.volume.lanes.len()];
        self.go_down(pressure, selection, &mut balances);
        let share = &self.volume.mesh.division.surface;
        let balances = share.collect(&balances, &share.each(balances.len()));
        let [unbalanced, all] = balances.into_iter().fold([0.0; 2], gfmd_vector::add);
        if all == 0.0 { 0.0 } else { (unbalanced / all).sqrt() }
    }

    fn go_down(&mut self, pressure: &[T], selection: &Selection, balances: &mut [[f64; 2]]) {
        (0..selection.strain.len()).filter(|cell| selection.strain[*cell]).for_each(|cell| self.provide(cell));
        let Self { levels, surface, benches, singles, .. } = self;
        let (transform, workspace) = (&levels[0].transform, &mut benches[0].workspaces[0]);
        transform.forward(pressure, surface, workspace).expect("fields and spectra have the sizes of the grid");
        *singles += 1.0;
        self.pass(Direction::Down, selection, balances);
    }

    /// Transforms the strain of some cells back; `take(output, component, field)` gets each component for the output of
    /// its cell.
    pub(crate) fn synthesise<O: Send>(&mut self, outputs: Vec<(usize, O)>, take: impl Fn(&mut O, usize, &[T]) + Sync) {
        self.count(outputs.iter().map(|(cell, _)| *cell));
        let Self { volume, levels, spectra, benches, .. } = self;
        distribute(benches, outputs.into_iter(), |(cell, mut output), Bench { field, workspaces }| {
            let (workspace, Level { transform, points, modes, .. }) = at(volume.levels[cell], levels, workspaces);
            let field = &mut field[..*points];
            for (spectrum, component) in parts(&spectra[cell], *modes).zip(&volume.components) {
                transform.inverse(spectrum, field, workspace).expect("spectra and fields have the sizes of the grid");
                take(&mut output, *component, field);
            }
        });
    }

    /// Transforms the strain of selected cells back into fields, and frees their spectra one after the other.
    /// Components that vanish in plane strain are zero.
    pub(crate) fn fields(&mut self, selected: &[bool]) -> CellFields<T> {
        self.count((0..selected.len()).filter(|cell| selected[*cell]));
        let Self { volume, levels, spectra, benches, .. } = self;
        let mut all = vec![Vec::new(); selected.len()];
        let cells = spectra.iter_mut().zip(&mut all).enumerate().filter(|(cell, _)| selected[*cell]);
        distribute(benches, cells, |(cell, (spectra, fields)), Bench { workspaces, .. }| {
            let (workspace, Level { transform, points, modes, .. }) = at(volume.levels[cell], levels, workspaces);
            fields.resize(COMPONENTS * points, T::default());
            for (spectrum, component) in parts(&std::mem::take(spectra), *modes).zip(&volume.components) {
                let field = &mut fields[component * points..(component + 1) * points];
                transform.inverse(spectrum, field, workspace).expect("spectra and fields have the sizes of the grid");
            }
        });
        all
    }

    /// Passes once over all waves, lane by lane. The sums of squares of forces are added to `balances`, which has one
    /// entry per lane or none.
    fn pass(&mut self, direction: Direction, selection: &Selection, balances: &mut [[f64; 2]]) {
        let Self { volume, levels, spectra, surface, .. } = self;
        let volume = &**volume;
        let [_, positions] = volume.mesh.grid.spectrum_shape();
        let count = volume.components.len();
        // The rows of all spectra in one lane, in the order of cells and components.
        let mut rows: Vec<_> = spectra
            .iter_mut()
            .zip(&volume.levels)
            .flat_map(|(spectrum, level)| {
                let coarse = levels[*level].transform.grid();
                let [_, positions] = coarse.spectrum_shape();
                // Cells without spectra, and processes without lanes of a coarser grid, have empty rows.
                let mut parts = spectrum.chunks_exact_mut(levels[*level].modes.max(1));
                (0..count).map(move |_| parts.next().unwrap_or_default().chunks_exact_mut(positions))
            })
            .collect();
        let mut balances = balances.iter_mut();
        let lanes = surface.chunks_exact_mut(positions).zip(volume.lanes.clone()).map(|(surface, lane)| {
            let rows: Vec<Option<&mut [Complex<T>]>> = rows.iter_mut().map(Iterator::next).collect();
            Lane { volume, selection, lane, surface, rows, count, balance: balances.next() }
        });
        let work = |memory: &mut Memory, mut lane: Lane<T>| lane.solve(direction, memory);
        let cells = volume.mesh.cells.len();
        if rayon::current_num_threads() == 1 {
            let mut memory = Memory::new(cells);
            lanes.for_each(|lane| work(&mut memory, lane));
        } else {
            // Each lane owns the memory that it writes, so that the result does not depend on the threads.
            let lanes: Vec<Lane<T>> = lanes.collect();
            lanes.into_par_iter().with_min_len(4).for_each_init(|| Memory::new(cells), work);
        }
    }
}

/// Returns the transforms of a level, with their memory.
fn at<'a, T: Real>(
    level: usize,
    levels: &'a [Level<T>],
    workspaces: &'a mut [Workspace<T>],
) -> (&'a mut Workspace<T>, &'a Level<T>) {
    (&mut workspaces[level], &levels[level])
}

/// Iterates over the spectra of the components of a cell. A process that has none of the modes makes the same calls.
fn parts<T>(spectra: &[T], modes: usize) -> impl Iterator<Item = &[T]> {
    (0..COMPONENTS).map(move |k| spectra.get(k * modes..(k + 1) * modes).unwrap_or_default())
}

/// Iterates over spectra as [`parts`] does.
fn parts_mut<T>(mut spectra: &mut [T], modes: usize) -> impl Iterator<Item = &mut [T]> {
    (0..COMPONENTS).map(move |_| {
        let rest = std::mem::take(&mut spectra);
        let (part, rest) = rest.split_at_mut(modes.min(rest.len()));
        spectra = rest;
        part
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use gfmd_field::Grid;
    use gfmd_green::{Base, Body, Material};

    use super::*;
    use crate::cells::Mesh;
    use crate::sweep;
    use crate::volume::WavePack;
    use crate::{Cell, Cells, Hardening};

    fn material(young: f64, poisson: f64) -> Material {
        Material::from_young(young, poisson).unwrap()
    }

    /// Bodies with half-space, slab, sliding and free base, and layers below the cells; the cells fill the second slab.
    fn bodies() -> Vec<Body> {
        let slab = |height| Body::slab(material(1.0, 0.3), height).unwrap();
        vec![
            Body::half_space(material(1.0, 0.3)),
            slab(0.7),
            slab(0.3),
            slab(0.3).on(Base::SLIDING).unwrap(),
            slab(0.5).on(Base::FREE).unwrap(),
            slab(0.3).bonded_to(Body::slab(material(3.0, 0.2), 0.4).unwrap()).unwrap(),
            slab(0.4).bonded_to(Body::half_space(material(0.5, 0.45))).unwrap(),
        ]
    }

    fn volume(body: &Body, grid: Grid, thicknesses: Vec<f64>, coarsenings: Vec<usize>) -> Arc<Volume> {
        let below = matches!(body.base(), Base::Elastic(_));
        let steel = Some(Hardening::new(0.01).unwrap());
        let all = if below { vec![steel, None] } else { vec![steel] };
        Arc::new(Volume::new(Cells::List { thicknesses, coarsenings }.mesh(body, &grid, &all).unwrap()))
    }

    /// Returns random numbers between −1 and 1, zero for components that vanish in plane strain.
    fn random(volume: &Volume, seed: u64) -> CellFields<f64> {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(1);
        let mut all = zeros(volume);
        for fields in &mut all {
            let points = fields.len() / COMPONENTS;
            for component in &volume.components {
                for value in &mut fields[component * points..(component + 1) * points] {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    *value = (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
                }
            }
        }
        all
    }

    fn zeros(volume: &Volume) -> CellFields<f64> {
        let Mesh { cells, grid, .. } = &*volume.mesh;
        cells.iter().map(|cell| vec![0.0; COMPONENTS * cell.grid(grid).len()]).collect()
    }

    /// Returns strain and displacement of the surface, by plastic strain and pressure.
    fn apply(volume: &Arc<Volume>, plastic: &CellFields<f64>, pressure: &[f64]) -> (CellFields<f64>, Vec<f64>) {
        let mut operator = Operator::<f64>::new(volume);
        let all = vec![true; volume.mesh.cells.len()];
        operator.analyse(&all, |cell, c, field| {
            let points = field.len();
            field.copy_from_slice(&plastic[cell][c * points..(c + 1) * points]);
        });
        let mut displacement = vec![0.0; pressure.len()];
        operator.surface_displacement(&all, &mut displacement);
        let unbalanced = operator.strain_in_balance(pressure, &Selection { plastic: all.clone(), strain: all.clone() });
        assert!(unbalanced < 1e-13, "{unbalanced}");
        (operator.fields(&all), displacement)
    }

    /// Returns Σ h ⟨2μ a:b⟩.
    fn product(volume: &Volume, a: &CellFields<f64>, b: &CellFields<f64>) -> f64 {
        let of_cell = |((cell, a), b): ((&Cell, &Vec<f64>), &Vec<f64>)| {
            let sum: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
            2.0 * cell.shear_modulus * cell.thickness * sum * COMPONENTS as f64 / a.len() as f64
        };
        volume.mesh.cells.iter().zip(a).zip(b).map(of_cell).sum()
    }

    #[test]
    fn stress_and_displacement_are_reciprocal_on_every_body_and_grid() {
        let grids = [
            Grid::new([16, 16], [1.0, 1.0]),
            Grid::new([15, 11], [1.0, 0.8]),
            Grid::new([16, 24], [1.2, 0.7]),
            Grid::line(32, 1.0),
        ];
        for grid in grids.map(Result::unwrap) {
            for body in bodies() {
                let coarsest = if grid.points().contains(&11) { 2 } else { 4 };
                let volume = volume(&body, grid, vec![0.03, 0.07, 0.1, 0.1], vec![1, 2, 1, coarsest]);
                let (a, b) = (random(&volume, 1), random(&volume, 2));
                let none = vec![0.0; grid.len()];
                let pressure: Vec<f64> = (0..grid.len()).map(|i| (i as f64 * 1.7).sin() + 0.3).collect();
                let (of_a, _) = apply(&volume, &a, &none);
                let (of_b, displacement) = apply(&volume, &b, &none);
                let [ab, ba, aa] = [(&a, &of_b), (&b, &of_a), (&a, &of_a)].map(|(x, y)| product(&volume, x, y));
                let all = product(&volume, &a, &a);
                assert!((ab - ba).abs() < 1e-14 * all, "{ab} {ba} {body:?}");
                assert!(aa > 0.0 && aa < all, "{aa} {all}");
                // A pressure works on plastic strain as plastic strain on the pressure.
                let (by_pressure, _) = apply(&volume, &zeros(&volume), &pressure);
                let work = product(&volume, &b, &by_pressure);
                let other = pressure.iter().zip(&displacement).map(|(p, u)| -p * u).sum::<f64>() / grid.len() as f64;
                assert!((work - other).abs() < 1e-13 * all, "{work} {other} {body:?}");
            }
        }
    }

    #[test]
    fn cells_have_the_compliance_of_the_body_to_second_order() {
        let q = 5.0;
        for body in bodies() {
            let blocks = body.stiffness_blocks(q);
            let exact = [blocks.longitudinal, blocks.coupling[0], blocks.normal, blocks.transverse];
            let error = |count: usize| {
                let cells = vec![0.3 / count as f64; count];
                let volume = volume(&body, Grid::square(4, TAU / q).unwrap(), cells, Vec::new());
                // The first wave along x is the second mode of the first lane.
                let WavePack { support, depth, waves, .. } = &volume.packs[0];
                let found = sweep::stiffness(&volume.mesh.cells[..*depth], waves.wavenumber, support);
                (0..4).map(|k| (found[k].0[1] - exact[k]).abs()).fold(0.0, f64::max) / exact[2]
            };
            let [coarse, fine] = [error(16), error(32)];
            // Waves that decay as in a half-space below keep its stiffness, whatever the thickness of the cells.
            let exact = body.height() == gfmd_green::Height::Infinite && coarse < 1e-12;
            assert!(exact || fine < 1e-2 && (3.5..4.5).contains(&(coarse / fine)), "{coarse} {fine} {body:?}");
        }
    }

    #[test]
    fn uniform_plastic_strain_thins_every_cell_alone() {
        let grid = Grid::square(8, 1.0).unwrap();
        let volume = volume(&Body::half_space(material(1.0, 0.3)), grid, vec![0.1, 0.2], Vec::new());
        let mut plastic = zeros(&volume);
        plastic[0][..64].fill(-0.01);
        let pressure = vec![0.002; 64];
        let (strain, displacement) = apply(&volume, &plastic, &pressure);
        let (shear, wave) = (1.0 / 2.6, 0.7 / (1.3 * 0.4));
        let factor = (2.0_f64 / 3.0).sqrt();
        let normal = 2.0 * shear * factor * -0.01 / wave;
        assert!(displacement.iter().all(|u| (u - 0.1 * normal).abs() < 1e-17));
        assert!(strain[0][..64].iter().all(|e| (e - factor * (normal - 0.002 / wave)).abs() < 1e-17));
    }
}
