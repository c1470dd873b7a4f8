//! A body that yields over ranks, played by threads, has the bits of one process.

use gfmd_contact::{MemoryCheckpoint, Progress, Resumable as _, Visit, Watch};
use gfmd_field::Share;
use gfmd_green::Base;
use gfmd_plasticity::ndarray::{Array2, s};
use gfmd_plasticity::{
    Body, Budget, Cells, Contact, Fields as _, Grid, Hardening, Load, Material, PlasticState, YieldingContact,
};
use gfmd_vector::ThreadRanks;
use std::ops::ControlFlow;

/// Contact to be made by one process, or by one of several from its rows of the heights.
struct Case {
    body: Body,
    hardening: Vec<Option<Hardening>>,
    cells: Cells,
    loads: [Load; 3],
}

fn rough(grid: &Grid) -> Array2<f64> {
    let surface = gfmd_surface::SelfAffine {
        hurst: 0.8,
        longest_wavelength: 0.5,
        shortest_wavelength: 0.1,
        ..gfmd_surface::SelfAffine::with_rms_gradient(0.1)
    };
    surface.heights(grid, 3).unwrap()
}

/// Bits of all results of a state: numbers, own rows of the surface, and own rows of each component of the cells.
type Bits = (Vec<u64>, Vec<Vec<u64>>);

fn bits_of(state: &PlasticState, stiffness: f64) -> Bits {
    let (summary, displacement) = (state.summary(), state.plastic_displacement_measures());
    let numbers = [
        state.mean_pressure(),
        state.approach(),
        state.elastic_energy,
        state.hardening_energy,
        state.dissipated,
        state.work_imbalance,
        state.plastic_strain_integral(),
        state.yielded_volume(),
        state.yield_depth(),
        state.max_plastic_strain(),
        displacement.mean,
        displacement.rms,
        displacement.min,
        summary.area_fraction_corrected,
        summary.mean_gap,
        stiffness,
        state.effort().transform_pairs,
        f64::from(state.yields_at_bottom()),
    ];
    let residuals = state.residuals().into_iter().map(|(_, residual)| residual);
    let numbers = numbers.into_iter().chain(residuals).map(f64::to_bits).chain([state.operators]);
    let bits = |values: &mut dyn Iterator<Item = &f64>| values.map(|x| x.to_bits()).collect::<Vec<u64>>();
    let (pressure, plastic) = (state.pressure(), &state.plastic_displacement);
    let surface = [pressure.view(), state.displacement_z(), state.gap(), plastic.view()];
    let mut fields: Vec<Vec<u64>> = surface.iter().map(|field| bits(&mut field.iter())).collect();
    for cell in 0..state.cells().len() {
        for plastic in [&state.plastic, &state.plastic_before] {
            fields.extend(state.strain_of(plastic, cell).outer_iter().map(|field| bits(&mut field.iter())));
            fields.push(bits(&mut state.equivalent_of(plastic, cell).iter()));
        }
    }
    (numbers.collect(), fields)
}

/// Watcher that stops a step after a number of checkpoints, or continues one.
struct Stops {
    copies: usize,
    kept: MemoryCheckpoint,
    resumes: bool,
}

impl Watch for Stops {
    fn see(&mut self, _: &Progress) -> ControlFlow<()> {
        if self.copies == 0 && !self.resumes { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) {
        if self.copies > 0 {
            self.copies -= 1;
            self.kept = MemoryCheckpoint::default();
            variables(&mut self.kept);
        }
    }

    fn recall(&mut self) -> Option<&mut dyn Visit> {
        self.resumes.then(|| {
            self.kept.rewind();
            &mut self.kept as &mut dyn Visit
        })
    }
}

/// Follows the loads, each from a restored copy of the state before. The first step is also stopped and continued.
fn follow(case: &Case, grid: &Grid, share: &Share) -> Vec<Bits> {
    let Case { body, hardening, cells, loads } = case;
    let heights = rough(grid);
    let own = if share.is_whole() { heights } else { heights.slice(s![share.rows(), ..]).to_owned() };
    let contact = YieldingContact::distributed(share, body, grid, &own, hardening, cells).unwrap();
    let mut state = contact.rest().unwrap();
    let stiffness = |state: &PlasticState| contact.stiffness(state, 1e-8).map_or(f64::NAN, |stiffness| stiffness.value);
    let mut all = Vec::new();
    for (step, load) in loads.iter().enumerate() {
        let mut next = contact.step(&state, *load, &Budget::default(), &mut ()).unwrap();
        let found = bits_of(&next, stiffness(&next));
        if step == 0 {
            let mut watch = Stops { copies: 1, kept: MemoryCheckpoint::default(), resumes: false };
            contact.step(&state, *load, &Budget::default(), &mut watch).unwrap_err();
            watch.resumes = true;
            let continued = contact.step(&state, *load, &Budget::default(), &mut watch).unwrap();
            assert_eq!(bits_of(&continued, stiffness(&continued)), found);
        }
        let mut kept = MemoryCheckpoint::default();
        contact.keep(&mut next, &mut kept);
        kept.rewind();
        state = contact.restore((*load).into(), &mut kept).unwrap();
        assert_eq!(bits_of(&state, stiffness(&state)).1, found.1);
        all.push(found);
    }
    all
}

#[test]
fn steps_over_ranks_have_the_bits_of_one_process() {
    let material = |young| Material::from_young(young, 0.3).unwrap();
    let steel = |stress: f64| Some(Hardening::new(stress).unwrap().isotropic(0.02).unwrap());
    let loads = [0.01, 0.02, 0.002].map(Load::MeanPressure);
    let slab = |young, height| Body::slab(material(young), height).unwrap();
    let cases = [
        // Graded cells, with coarser grids than processes can divide into whole leaves.
        Case { body: Body::half_space(material(1.0)), hardening: vec![steel(0.03)], cells: Cells::default(), loads },
        Case {
            body: slab(1.0, 0.1).on(Base::SLIDING).unwrap(),
            hardening: vec![Some(Hardening::new(0.02).unwrap().kinematic(0.05).unwrap())],
            cells: Cells::Uniform { count: 3, depth: 0.1 },
            loads: [Load::Approach(0.01), Load::Approach(0.015), Load::Approach(0.002)],
        },
        Case {
            body: slab(1.0, 0.04).bonded_to(Body::half_space(material(0.5))).unwrap(),
            hardening: vec![steel(0.02), steel(0.03)],
            cells: Cells::List { thicknesses: vec![0.02, 0.02, 0.1], coarsenings: vec![1, 2, 16] },
            loads,
        },
    ];
    let grid = Grid::new([128, 64], [1.0, 0.5]).unwrap();
    for (number, case) in cases.iter().enumerate() {
        let alone = follow(case, &grid, &grid.whole());
        assert!(f64::from_bits(alone[0].0[6]) > 0.0, "something yields");
        // Each case for one number of processes; in the long tests (`.ci/long`) for all.
        let is_long = std::env::var_os("GFMD_LONG").is_some();
        for size in [2, 3, 4].into_iter().filter(|size| is_long || *size == 4 - number) {
            let each = ThreadRanks::of(size, |ranks| follow(case, &grid, &Contact::share(ranks, &grid).unwrap()));
            for (step, (numbers, fields)) in alone.iter().enumerate() {
                let different = |found: &Vec<Bits>| (0..numbers.len()).find(|k| found[step].0[*k] != numbers[*k]);
                let different = each.iter().find_map(different);
                assert_eq!(different, None, "number that differs: case {number}, step {step} on {size}");
                for (place, field) in fields.iter().enumerate() {
                    let rows = each.iter().flat_map(|found| &found[step].1[place]);
                    assert!(rows.eq(field), "field {place} of case {number}, step {step} on {size}");
                }
            }
        }
    }
}
