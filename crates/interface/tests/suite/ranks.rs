//! A contact with a law over ranks, played by threads, has the bits of one process.

use std::sync::Arc;

use gfmd_contact::{
    Boundary, Contact, Drive, Equilibrium as _, Fields as _, Hardness, Load, Resumable as _, Solver, Springs,
};
use gfmd_field::{Grid, Share};
use gfmd_green::{Base, Body, Material};
use gfmd_interface::{
    Interface, Parts, Quasistatic as _, QuasistaticContact, QuasistaticState, Sequence, Shear, Squeezed, SqueezedState,
    State, Wear,
};
use gfmd_law::{Exponential, HardWall, Law, Limit, Morse, Npc, Separation};
use gfmd_medium::{Prony, Relaxes};
use gfmd_relax::{Budget, MemoryCheckpoint};
use gfmd_surface::SelfAffine;
use gfmd_vector::ThreadRanks;
use ndarray::{Array2, s};

/// Contact to be made by one process, or by one of several from its rows of the fields.
struct Case<'a> {
    grid: Grid,
    body: &'a Body,
    heights: Array2<f64>,
    law: Arc<dyn Law>,
    hardness: Option<Hardness>,
    springs: Option<Springs>,
    held: bool,
    boundary: Boundary,
}

fn rough(grid: &Grid, seed: u64) -> Array2<f64> {
    let [dx, dy] = grid.spacing();
    let surface = SelfAffine {
        hurst: 0.8,
        longest_wavelength: 0.5,
        shortest_wavelength: 4.0 * dx.max(dy),
        ..SelfAffine::with_rms_gradient(0.1)
    };
    surface.heights(grid, seed).unwrap()
}

impl<'a> Case<'a> {
    fn new(points: [usize; 2], body: &'a Body, law: &Arc<dyn Law>) -> Self {
        let grid = Grid::new(points, [1.0, points[1] as f64 / points[0] as f64]).unwrap();
        let (heights, law, boundary) = (rough(&grid, 3), Arc::clone(law), Boundary::Periodic);
        Self { grid, body, heights, law, hardness: None, springs: None, held: false, boundary }
    }

    fn on(&self, share: &Share) -> Interface {
        let own = |field: &Array2<f64>| field.slice(s![share.rows(), ..]).to_owned();
        let own = |field: &Array2<f64>| if share.is_whole() { field.clone() } else { own(field) };
        let (heights, law) = (&own(&self.heights), Arc::clone(&self.law));
        let mut interface = match self.held {
            true => Interface::held_sideways_over(share, self.body, &self.grid, heights, law).unwrap(),
            false => Interface::with_boundary_over(share, self.boundary, self.body, &self.grid, heights, law).unwrap(),
        };
        interface = match &self.hardness {
            Some(Hardness::Field(field)) => interface.with_hardness(own(field)).unwrap(),
            Some(hardness) => interface.with_hardness(hardness.clone()).unwrap(),
            None => interface,
        };
        match &self.springs {
            Some(Springs::Field(field)) => interface.with_springs(own(field)).unwrap(),
            Some(springs) => interface.with_springs(springs.clone()).unwrap(),
            None => interface,
        }
    }
}

/// Bits of all results of a state: numbers, and the own rows of fields.
type Bits = (Vec<u64>, Vec<Vec<u64>>);

fn bits(state: &State, stiffness: f64) -> Bits {
    let summary = state.summary();
    let numbers = [
        state.mean_pressure,
        state.approach,
        state.elastic_energy,
        state.interface_energy,
        state.contact_fraction,
        state.lowest_curvature,
        summary.area_fraction_corrected,
        summary.kappa_corrected,
        summary.mean_gap,
        summary.max_pressure,
        stiffness,
    ];
    let residuals = state.residual.parts().into_iter().map(|(_, residual)| residual);
    let numbers = numbers.into_iter().chain(residuals).map(f64::to_bits);
    let counts = [state.effort.iterations, summary.contact_nodes, summary.boundary_links];
    let repulsion = state.repulsion();
    let fields = [repulsion.view(), state.pressure().view(), state.displacement_z(), state.gap()]
        .map(|field| field.iter().map(|x| x.to_bits()).collect());
    let depth = state.pressed_in.iter().map(|depth| depth.iter().map(|x| x.to_bits()).collect());
    (numbers.chain(counts).collect(), fields.into_iter().chain(depth).collect())
}

/// Solves loads one after the other, with the second one from a restored copy of the first state.
fn solve(interface: &Interface, loads: [Load; 2]) -> [Bits; 2] {
    let budget = Budget::default();
    let reach = |load: Load, start: Option<&State>| {
        let state = interface.equilibrate(load.into(), Solver::Auto, &budget, start, &mut ()).unwrap();
        let stiffness = interface.stiffness(&state, 1e-9).map_or(f64::NAN, |stiffness| stiffness.value);
        let found = bits(&state, stiffness);
        (state, found)
    };
    let (mut first, found) = reach(loads[0], None);
    let mut kept = MemoryCheckpoint::default();
    interface.keep(&mut first, &mut kept);
    kept.rewind();
    let restored = interface.restore(loads[0].into(), &mut kept).unwrap();
    assert_eq!(bits(&restored, 0.0), bits(&first, 0.0));
    let (_, then) = reach(loads[1], Some(&restored));
    [found, then]
}

fn compare(case: &Case, loads: [Load; 2], size: usize) {
    let [nx, ny] = case.grid.points();
    let alone = solve(&case.on(&Share::whole(nx, ny)), loads);
    let each = ThreadRanks::of(size, |ranks| solve(&case.on(&Contact::share(ranks, &case.grid).unwrap()), loads));
    for (step, (numbers, fields)) in alone.iter().enumerate() {
        let different = |found: &[Bits; 2]| (0..numbers.len()).find(|k| found[step].0[*k] != numbers[*k]);
        assert_eq!(each.iter().find_map(different), None, "number that differs: step {step}, {loads:?} on {size}");
        for (place, field) in fields.iter().enumerate() {
            let rows = each.iter().flat_map(|found| &found[step].1[place]);
            assert!(rows.eq(field), "field {place} of step {step}, {loads:?} on {size}");
        }
    }
}

#[test]
fn a_law_over_ranks_has_the_bits_of_one_process() {
    let wall = Exponential::new(2e-4, 4e-3).unwrap().into_shared();
    let smooth = Morse::new(2e-4, 4e-3).unwrap().into_shared();
    let material = Material::from_contact_modulus(1.0, 0.3).unwrap();
    let (half_space, slab) = (Body::half_space(material), Body::slab(material, 0.2).unwrap());
    let pressed = [Load::MeanPressure(0.004), Load::MeanPressure(-0.0005)];
    compare(&Case::new([128, 128], &half_space, &wall), pressed, 3);
    compare(&Case::new([96, 128], &half_space, &smooth), pressed, 2);
    // The approach of a half-space holds its mean.
    let moved = [Load::Approach(0.006), Load::Approach(0.004)];
    compare(&Case::new([128, 64], &half_space, &wall), moved, 4);
    compare(&Case { held: true, ..Case::new([128, 64], &slab, &smooth) }, moved, 2);
}

#[test]
fn a_law_on_a_patch_over_ranks_has_the_bits_of_one_process() {
    let wall = Exponential::new(2e-4, 4e-3).unwrap().into_shared();
    let smooth = Morse::new(2e-4, 4e-3).unwrap().into_shared();
    let material = Material::from_contact_modulus(1.0, 0.3).unwrap();
    let (half_space, slab) = (Body::half_space(material), Body::slab(material, 0.2).unwrap());
    let boundary = Boundary::Free;
    let pressed = [Load::MeanPressure(0.004), Load::MeanPressure(-0.0005)];
    compare(&Case { boundary, ..Case::new([128, 64], &half_space, &wall) }, pressed, 4);
    compare(&Case { boundary, ..Case::new([112, 64], &slab, &smooth) }, pressed, 3);
    let moved = [Load::Approach(0.006), Load::Approach(0.004)];
    compare(&Case { boundary, ..Case::new([96, 64], &half_space, &wall) }, moved, 2);
    let field = |unit: f64| Array2::from_shape_fn((96, 64), |(i, j)| unit * (1.0 + 0.2 * ((i + 2 * j) % 5) as f64));
    let case = Case { boundary, ..Case::new([96, 64], &half_space, &wall) };
    let hardness = Some(Hardness::Field(field(0.05)));
    compare(&Case { hardness, springs: Some(Springs::Field(field(0.1))), ..case }, moved, 3);
}

#[test]
fn a_wall_that_gives_way_below_a_law_has_the_bits_of_one_process() {
    let wall = Exponential::new(2e-4, 4e-3).unwrap().into_shared();
    let half_space = Body::half_space(Material::from_contact_modulus(1.0, 0.3).unwrap());
    let case = || Case::new([128, 64], &half_space, &wall);
    let field = |unit: f64| Array2::from_shape_fn((128, 64), |(i, j)| unit * (1.0 + 0.2 * ((i + 2 * j) % 5) as f64));
    let loads = [Load::MeanPressure(0.004), Load::MeanPressure(0.008)];
    compare(&Case { hardness: Some(Hardness::Field(field(0.05))), ..case() }, loads, 3);
    compare(&Case { springs: Some(Springs::Field(field(0.1))), ..case() }, loads, 3);
    let both = Case { hardness: Some(0.06.into()), springs: Some(Springs::Uniform(0.2)), ..case() };
    compare(&both, [Load::Approach(0.01), Load::Approach(0.03)], 2);
}

/// Solves loads on both faces of a slab, the second one from a restored copy of the first state.
fn squeeze(contact: &Squeezed, drives: &[Drive], bits: impl Fn(&QuasistaticState) -> Bits) -> Vec<[Bits; 2]> {
    let mut last = None;
    let reach = |drive: &Drive| {
        let start = last.take();
        let solved = contact.equilibrate(*drive, Solver::Auto, &Budget::default(), start.as_ref(), &mut ());
        let mut state: SqueezedState = solved.unwrap();
        let mut kept = MemoryCheckpoint::default();
        contact.keep(&mut state, &mut kept);
        kept.rewind();
        let restored = contact.restore(*drive, &mut kept).unwrap();
        let stiffness = contact.stiffness(&state, 1e-8).map_or(f64::NAN, |stiffness| stiffness.value);
        let found = [&state.upper, &state.lower].map(|face| {
            let (mut numbers, fields) = bits(face);
            numbers.extend([state.approach, stiffness].map(f64::to_bits));
            (numbers, fields)
        });
        assert_eq!(
            [&restored.upper, &restored.lower].map(|face| bits(face).1),
            [&found[0].1, &found[1].1].map(Vec::clone)
        );
        last = Some(restored);
        found
    };
    drives.iter().map(reach).collect()
}

/// Compares both faces on several ranks with one process.
fn compare_faces(grid: &Grid, size: usize, solve: impl Fn(&Share) -> Vec<[Bits; 2]> + Sync) {
    let alone = solve(&grid.whole());
    let each = ThreadRanks::of(size, |ranks| solve(&Contact::share(ranks, grid).unwrap()));
    for (step, faces) in alone.iter().enumerate() {
        for (face, (numbers, fields)) in faces.iter().enumerate() {
            let different =
                |found: &Vec<[Bits; 2]>| (0..numbers.len()).find(|k| found[step][face].0[*k] != numbers[*k]);
            let different = each.iter().find_map(different);
            assert_eq!(different, None, "number that differs: face {face}, step {step} on {size}");
            for (place, field) in fields.iter().enumerate() {
                let rows = each.iter().flat_map(|found| &found[step][face].1[place]);
                assert!(rows.eq(field), "field {place} of face {face}, step {step} on {size}");
            }
        }
    }
}

#[test]
fn slabs_between_two_surfaces_over_ranks_have_the_bits_of_one_process() {
    let grid = Grid::new([128, 64], [1.0, 0.5]).unwrap();
    let (upper, lower) = (rough(&grid, 5), rough(&grid, 6) * 0.7);
    let slab = Body::slab(Material::from_contact_modulus(1.0, 0.3).unwrap(), 0.1).unwrap();
    let law = || Exponential::new(2e-4, 4e-3).unwrap().into_shared();
    let field = Array2::from_shape_fn((128, 64), |(i, j)| 0.05 * (1.0 + 0.1 * ((i + 2 * j) % 5) as f64));
    let own = |share: &Share, field: &Array2<f64>| {
        if share.is_whole() { field.clone() } else { field.slice(s![share.rows(), ..]).to_owned() }
    };
    let loads = [Load::MeanPressure(0.004), Load::MeanPressure(-0.0003), Load::Approach(0.01)].map(Drive::from);
    fn under_loads<'a>(body: &'a Body, grid: &'a Grid, [upper, lower]: &'a [Array2<f64>; 2]) -> Parts<'a> {
        Parts { sequence: Sequence::Loads, lower: Some(lower.into()), ..Parts::new(body, grid, upper) }
    }
    compare_faces(&grid, 3, |share| {
        let faces = [&upper, &lower].map(|heights| own(share, heights));
        let parts = Parts { share: Some(share), law: Some(law()), ..under_loads(&slab, &grid, &faces) };
        squeeze(&Squeezed::new(&parts).unwrap(), &loads, |state| bits(state.law().unwrap(), 0.0))
    });
    compare_faces(&grid, 2, |share| {
        let faces = [&upper, &lower].map(|heights| own(share, heights));
        let (held, hardness) = (true, Some(own(share, &field).into()));
        let parts = under_loads(&slab, &grid, &faces);
        let parts = Parts { share: Some(share), law: Some(law()), held, hardness, ..parts };
        squeeze(&Squeezed::new(&parts).unwrap(), &loads[..1], |state| bits(state.law().unwrap(), 0.0))
    });
    // Along a path: a hard wall, a hardness, wear and relaxation.
    let prony = Prony::from_fractions(&[(0.3, 0.2), (2.0, 0.4)]).unwrap();
    for (with_law, with_hardness) in [(false, false), (false, true), (true, true)] {
        compare_faces(&grid, 3, |share| {
            let faces = [&upper, &lower].map(|heights| own(share, heights));
            let parts = Parts {
                share: Some(share),
                lower: Some((&faces[1]).into()),
                law: with_law.then(law),
                hardness: with_hardness.then(|| Hardness::Field(own(share, &field))),
                wear: Some(Wear { by_distance: 1.0, by_slip: 0.0 }),
                relaxation: with_law.then_some((&prony, Relaxes::Both)),
                ..Parts::new(&slab, &grid, &faces[0])
            };
            let contact = Squeezed::new(&parts).unwrap();
            let drives = drives().map(|drive| Drive { lateral: [0.0; 2], ..drive });
            squeeze(&contact, &drives, |state: &QuasistaticState| {
                let summary = state.summary();
                let (worn, deepest) = state.wear_volume_and_depth().unwrap_or_default();
                let numbers = [
                    state.mean_pressure(),
                    state.approach(),
                    state.elastic_energy(),
                    state.losses.total(),
                    state.work_imbalance,
                    state.plastic_fraction,
                    state.plastic_volume().unwrap_or_default(),
                    worn,
                    deepest,
                    summary.area_fraction_corrected,
                    summary.mean_gap,
                ];
                let residuals = state.residuals().into_iter().map(|(_, residual)| residual);
                let depths = state.wear_depth().into_iter().chain(state.plastic_depth()).cloned();
                let fields = [state.pressure().into_owned(), state.displacement_z().to_owned(), state.gap().to_owned()];
                let all = fields.into_iter().chain(depths).chain(state.memory().unwrap_or_default());
                (
                    numbers.into_iter().chain(residuals).map(f64::to_bits).collect(),
                    all.map(|field| field.iter().map(|x| x.to_bits()).collect()).collect(),
                )
            })
        });
    }
}

/// Drives of a path: mean pressure, lateral displacement, time, distance.
fn drives() -> [Drive; 3] {
    let all = [(0.004, [0.0, 0.0], 0.0, 0.0), (0.004, [1e-3, 0.0], 0.5, 0.02), (0.002, [2e-3, 1e-3], 2.0, 0.03)];
    all.map(|(mean, lateral, time, distance)| Drive { lateral, time, distance, ..Load::MeanPressure(mean).into() })
}

/// Follows a path of parts, each step from a restored copy of the state before; returns bits of numbers and fields.
fn follow(parts: &Parts) -> Vec<Bits> {
    let contact = QuasistaticContact::new(parts).unwrap();
    let mut last: Option<QuasistaticState> = None;
    let step = |drive: Drive| {
        let start = last.take();
        let solved = contact.equilibrate(drive, Solver::Auto, &Budget::default(), start.as_ref(), &mut ());
        let mut state = solved.unwrap();
        let changes = start.as_ref().map_or([0.0; 2], |start| {
            let change = contact.change(None, start, &state);
            [change, f64::from(contact.depends_on_division(Some(start), &state, 1e-6))]
        });
        let mut kept = MemoryCheckpoint::default();
        contact.keep(&mut state, &mut kept);
        kept.rewind();
        let restored = contact.restore(drive, &mut kept).unwrap();
        let of = |state: &QuasistaticState| {
            let (summary, losses) = (state.summary(), state.losses);
            let (worn, deepest) = state.wear_volume_and_depth().unwrap_or_default();
            let numbers = [
                state.mean_pressure(),
                state.approach(),
                state.elastic_energy(),
                state.interface_energy(),
                losses.total(),
                state.work_imbalance,
                state.plastic_fraction,
                state.plastic_volume().unwrap_or_default(),
                worn,
                deepest,
                summary.area_fraction_corrected,
                summary.mean_gap,
                contact.stiffness(state, 1e-8).map_or(f64::NAN, |stiffness| stiffness.value),
                state.mean_shear[0],
                state.mean_shear[1],
                losses.friction,
                state.stick_fraction().unwrap_or_default(),
                state.law().map_or(0.0, |law| law.lowest_curvature),
                changes[0],
                changes[1],
            ];
            let residuals = state.residuals().into_iter().map(|(_, residual)| residual);
            let numbers = numbers.into_iter().chain(residuals).map(f64::to_bits).collect();
            let depths = state.wear_depth().into_iter().chain(state.plastic_depth()).cloned();
            let fields = [state.pressure().into_owned(), state.displacement_z().to_owned(), state.gap().to_owned()];
            let memory = state.memory().unwrap_or_default();
            let shears = [0, 1].into_iter().flat_map(|axis| state.shear(axis).into_iter().chain(state.slip(axis)));
            let shears = shears.map(|field| field.to_owned());
            let all = fields.into_iter().chain(depths).chain(memory).chain(shears);
            (numbers, all.map(|field| field.iter().map(|x| x.to_bits()).collect()).collect())
        };
        let found: Bits = of(&state);
        assert_eq!(of(&restored), found);
        last = Some(restored);
        found
    };
    drives().map(step).into()
}

#[test]
fn paths_over_ranks_have_the_bits_of_one_process() {
    let grid = Grid::new([128, 64], [1.0, 0.5]).unwrap();
    let heights = rough(&grid, 5);
    let body = Body::half_space(Material::from_contact_modulus(1.0, 0.3).unwrap());
    let prony = Prony::from_fractions(&[(0.3, 0.2), (2.0, 0.4)]).unwrap();
    let law = Exponential::new(2e-4, 4e-3).unwrap().into_shared();
    let wall = HardWall.into_shared();
    let separation =
        Separation { normal_work: 1e-4, tangential_work: 1e-4, normal_length: 0.01, tangential_length: 0.01 };
    let shearing = Npc::new(separation).unwrap().into_shared();
    let hardness = Array2::from_shape_fn((128, 64), |(i, j)| 0.05 * (1.0 + 0.1 * ((i + 2 * j) % 5) as f64));
    let wear = Some(Wear { by_distance: 1.0, by_slip: 0.0 });
    let relaxation = Some((&prony, Relaxes::Both));
    let slips = Some(Wear { by_distance: 0.5, by_slip: 1.0 });
    let shear = Some(Shear::from(Limit::Coulomb(0.3)));
    let strength = Some(Shear::from(Limit::Orowan { coefficient: 0.3, strength: 0.01 }));
    let plain = Parts::new(&body, &grid, &heights);
    let cases = [
        Parts { law: Some(wall), ..plain.clone() },
        Parts { wear, ..plain.clone() },
        Parts { relaxation, hardness: Some(Hardness::Field(hardness.clone())), ..plain.clone() },
        Parts { law: Some(Arc::clone(&law)), relaxation, wear, ..plain.clone() },
        Parts {
            law: Some(Arc::clone(&law)),
            hardness: Some(Hardness::Field(hardness.clone())),
            wear,
            held: true,
            ..plain.clone()
        },
        Parts { shear, ..plain.clone() },
        Parts { shear: strength, relaxation, wear: slips, ..plain.clone() },
        Parts {
            shear,
            law: Some(Arc::clone(&law)),
            hardness: Some(Hardness::Field(hardness.clone())),
            relaxation,
            ..plain.clone()
        },
        Parts { law: Some(shearing), all_components: true, relaxation, ..plain.clone() },
    ];
    // Waves that relax by their own branches: of a slab, of a pair, below a hardness, a law and wear.
    let slab = Body::slab(Material::from_contact_modulus(1.0, 0.3).unwrap(), 0.2).unwrap();
    let elastic = Body::half_space(Material::from_contact_modulus(2.0, 0.2).unwrap());
    let loose = slab.clone().on(Base::SLIDING).unwrap();
    let pair = slab.clone().against(elastic);
    let unlike = Some((&prony, Relaxes::Shear));
    let waves = [
        Parts { relaxation: unlike, body: &slab, ..plain.clone() },
        Parts { relaxation: unlike, body: &slab, law: Some(Arc::clone(&law)), wear, ..plain.clone() },
        Parts {
            relaxation: unlike,
            body: &loose,
            hardness: Some(Hardness::Field(hardness.clone())),
            wear,
            ..plain.clone()
        },
        Parts { relaxation, body: &pair, ..plain.clone() },
    ];
    let patches =
        cases.iter().filter(|parts| !parts.held).map(|parts| Parts { boundary: Boundary::Free, ..parts.clone() });
    for (number, parts) in cases.iter().cloned().chain(waves).chain(patches).enumerate() {
        let parts = &parts;
        let alone = follow(parts);
        // Each path for one number of processes; in the long tests (`.ci/long`) for both.
        let is_long = std::env::var_os("GFMD_LONG").is_some();
        for size in [2, 3].into_iter().filter(|size| is_long || size % 2 == number % 2) {
            let each = ThreadRanks::of(size, |ranks| {
                let share = Contact::share(ranks, &grid).unwrap();
                let own = |field: &Array2<f64>| field.slice(s![share.rows(), ..]).to_owned();
                let hardness = parts.hardness.clone().map(|hardness| match hardness {
                    Hardness::Field(field) => Hardness::Field(own(&field)),
                    uniform => uniform,
                });
                follow(&Parts { share: Some(&share), heights: (&own(&heights)).into(), hardness, ..parts.clone() })
            });
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
