//! All combinations of parts: each is refused by the table, or posed and solved. A posed problem equals its kind bit by
//! bit.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use crate::parts::{HARDNESS, Parts, all_facts};
use gfmd_contact::{
    Boundary, Contact, Drive, Equilibrium, Fields, Load, Refusal, Resumable as _, SolveError, SqueezedContact,
    SteepContact, Visit,
};
use gfmd_green::BaseKind;
use gfmd_interface::{
    Interface, Path, QuasistaticContact, QuasistaticState, Refinement, Sequence, Squeezed, StoredFields, Wear,
};
use gfmd_law::LawKind;
use gfmd_problem::{AnyState, Facts, Friction, Lower, Part, RULES, Rule, Support, Unknown, WearBy, pose, rules_of};
use gfmd_problem::{rules_of_sliding, table};
use gfmd_relax::Budget;

fn same(a: &impl Fields, b: &impl Fields) {
    let bits = |state: &dyn Fn() -> Vec<f64>| state().into_iter().map(f64::to_bits).collect::<Vec<_>>();
    assert_eq!(bits(&|| a.pressure().iter().copied().collect()), bits(&|| b.pressure().iter().copied().collect()));
    assert_eq!(bits(&|| a.gap().iter().copied().collect()), bits(&|| b.gap().iter().copied().collect()));
    assert_eq!(a.effort().iterations, b.effort().iterations);
    assert_eq!(a.worst().to_bits(), b.worst().to_bits());
}

#[test]
fn a_posed_problem_has_the_bits_of_its_kind() {
    let load = Load::MeanPressure(0.01);
    let solved = |facts: Facts| Parts::of(facts).pose().unwrap().press(load).solve().unwrap();
    let plain = Facts::default();
    let Parts { grid, body, heights, .. } = Parts::of(plain);
    let wall = || Contact::new(&body, &grid, &heights).unwrap();
    same(&solved(plain), &wall().press(load).solve().unwrap());
    let facts = Facts { hardness: true, ..plain };
    same(&solved(facts), &wall().with_hardness(HARDNESS).unwrap().press(load).solve().unwrap());
    let facts = Facts { law: LawKind::Exponential, ..plain };
    let law = Parts::of(facts);
    let interface = Interface::new(&law.body, &law.grid, &law.heights, Arc::clone(&law.law)).unwrap();
    same(&solved(facts), &interface.press(load).solve().unwrap());
    let facts = Facts { finite_slope: true, ..plain };
    same(&solved(facts), &SteepContact::new(&body, &grid, &heights).unwrap().press(load).solve().unwrap());
    let facts = Facts { lower: Some(Lower::Surface), support: Support::Slab(BaseKind::Bonded), ..plain };
    let slab = Parts::of(facts);
    let lower = slab.lower.as_ref().unwrap();
    let squeezed = SqueezedContact::new(&slab.body, &slab.grid, &slab.heights, lower).unwrap();
    let state = solved(facts);
    same(&state, &squeezed.press(load).solve().unwrap());
    let hard = squeezed.with_hardness(HARDNESS).unwrap().press(load).solve().unwrap();
    same(&solved(Facts { hardness: true, ..facts }), &hard);
    let held = SqueezedContact::held_sideways(&slab.body, &slab.grid, &slab.heights, lower).unwrap();
    same(&solved(Facts { unknown: Unknown::Held, ..facts }), &held.press(load).solve().unwrap());
    let facts = Facts { law: LawKind::Exponential, ..facts };
    let law = || Arc::clone(&Parts::of(facts).law);
    let parts = gfmd_interface::Parts::new(&slab.body, &slab.grid, &slab.heights);
    let lower = Some(&**lower);
    let parts =
        gfmd_interface::Parts { sequence: Sequence::Loads, law: Some(law()), lower: lower.map(Into::into), ..parts };
    let glued = |parts| Squeezed::new(&parts).unwrap().press(load).solve().unwrap();
    same(&solved(facts), &glued(parts.clone()));
    let hard = gfmd_interface::Parts { hardness: Some(HARDNESS.into()), ..parts.clone() };
    same(&solved(Facts { hardness: true, ..facts }), &glued(hard));
    let held = gfmd_interface::Parts { held: true, ..parts };
    same(&solved(Facts { unknown: Unknown::Held, ..facts }), &glued(held));
    assert!(solved(facts).law().is_some() && solved(facts).lower_law().is_some());
    assert!(state.lower().is_some());
    assert!(state.steep().is_none());
    assert!(state.plastic_depth().is_none());
}

#[test]
fn parts_are_those_of_the_facts() {
    let with = Facts { hardness: true, sequence: Sequence::Path, ..Facts::default() };
    let parts = [Parts::of(with), Parts::of(Facts { hardness: false, ..with })];
    for facts in [&parts[0].facts, &parts[1].facts] {
        for given in [parts[0].parts(), parts[1].parts()] {
            let posed = pose(facts, &given, None);
            match facts.hardness == given.hardness.is_some() {
                true => assert!(posed.is_ok()),
                false => assert!(matches!(posed, Err(Refusal::Part { part: "hardness" }))),
            }
        }
    }
}

/// Checkpoint in memory, written and read in the same order.
#[derive(Default)]
struct MemoryCheckpoint(Vec<u64>, usize);

struct Writing<'a>(&'a mut MemoryCheckpoint);
struct Reading<'a>(&'a mut MemoryCheckpoint);

impl Visit for Writing<'_> {
    fn number(&mut self, value: &mut f64) {
        self.0.0.push(value.to_bits());
    }

    fn count(&mut self, value: &mut u64) {
        self.0.0.push(*value);
    }

    fn field(&mut self, values: &mut [f64]) {
        self.0.0.extend(values.iter().map(|value| value.to_bits()));
    }
}

impl Reading<'_> {
    fn next(&mut self) -> u64 {
        self.0.1 += 1;
        self.0.0[self.0.1 - 1]
    }
}

impl Visit for Reading<'_> {
    fn number(&mut self, value: &mut f64) {
        *value = f64::from_bits(self.next());
    }

    fn count(&mut self, value: &mut u64) {
        *value = self.next();
    }

    fn field(&mut self, values: &mut [f64]) {
        values.iter_mut().for_each(|value| *value = f64::from_bits(self.next()));
    }
}

#[test]
fn a_path_of_posed_problems_has_the_bits_of_its_kind_and_goes_on_where_it_was_kept() {
    let drive = |pressure: f64| Drive {
        load: Load::MeanPressure(pressure),
        lateral: [0.0; 2],
        time: 0.0,
        distance: (100.0 * pressure).powi(2),
    };
    let drives = [0.004, 0.01, 0.02].map(drive);
    let on_path = Facts { sequence: Sequence::Path, ..Facts::default() };
    let between = Facts { lower: Some(Lower::Seed), support: Support::Slab(BaseKind::Bonded), ..on_path };
    for facts in [
        Facts { hardness: true, ..on_path },
        Facts { friction: Some(Friction::Coulomb), ..on_path },
        Facts { law: LawKind::Exponential, ..on_path },
        Facts { wear: Some(WearBy::Distance), ..on_path },
        Facts { hardness: true, ..between },
        Facts { law: LawKind::Exponential, hardness: true, ..between },
        Facts { law: LawKind::Exponential, ..between },
        between,
    ] {
        let parts = Parts::of(facts);
        let given = parts.parts();
        let posed = parts.pose().unwrap();
        // With wear, each step is one solve, as below.
        let solves_per_step = if facts.wear.is_some() { 0 } else { Refinement::default().solves_per_step };
        let refinement = Refinement { solves_per_step, ..Refinement::default() };
        let mut path = Path::new(&posed, Budget::default(), refinement);
        let lost: Vec<_> = drives.iter().map(|drive| path.step(*drive, &mut ()).unwrap().dissipated).collect();
        let Parts { body, grid, heights, .. } = &parts;
        let direct: Vec<_> = match (facts.law, facts.wear.is_some()) {
            _ if facts.lower.is_some() => {
                let law = Some(Arc::clone(&parts.law));
                let hardness = facts.hardness.then(|| HARDNESS.into());
                let plain = gfmd_interface::Parts::new(body, grid, heights);
                let all = gfmd_interface::Parts { law, hardness, lower: parts.lower.as_ref().map(Into::into), ..plain };
                let contact = Squeezed::new(&all).unwrap();
                let mut direct = Path::new(&contact, Budget::default(), refinement);
                drives.iter().map(|drive| direct.step(*drive, &mut ()).unwrap().dissipated).collect()
            }
            (LawKind::Exponential, _) => {
                let contact = Interface::new(body, grid, heights, Arc::clone(&parts.law)).unwrap();
                let mut direct = Path::new(&contact, Budget::default(), Refinement::default());
                drives.iter().map(|drive| direct.step(*drive, &mut ()).unwrap().dissipated).collect()
            }
            (_, wears) => {
                let contact = QuasistaticContact::new(&gfmd_interface::Parts {
                    hardness: facts.hardness.then(|| HARDNESS.into()),
                    shear: given.shear,
                    wear: wears.then_some(Wear { by_distance: 0.5, by_slip: 0.0 }),
                    ..gfmd_interface::Parts::new(body, grid, heights)
                });
                let contact = contact.unwrap();
                if wears {
                    let mut states: Vec<QuasistaticState> = Vec::new();
                    for drive in drives {
                        states.push(contact.press(drive).starting_from(states.last()).solve().unwrap());
                    }
                    states.iter().map(|state| Some(state.losses.total())).collect()
                } else {
                    let mut direct = Path::new(&contact, Budget::default(), Refinement::default());
                    drives.iter().map(|drive| direct.step(*drive, &mut ()).unwrap().dissipated).collect()
                }
            }
        };
        assert_eq!(lost, direct, "{facts:?}");
        let mut checkpoint = MemoryCheckpoint::default();
        path.keep(&mut Writing(&mut checkpoint));
        let mut again = Path::new(&posed, Budget::default(), refinement);
        again.resume(drives[2], &mut Reading(&mut checkpoint)).unwrap();
        path.step(drive(0.03), &mut ()).unwrap();
        again.step(drive(0.03), &mut ()).unwrap();
        same(path.state().unwrap(), again.state().unwrap());
    }
}

/// Checks that a problem restores states from their fields and starts from them; another kind refuses them.
#[test]
fn states_come_back_from_their_fields_and_start_their_own_kind_only() {
    let load = Load::MeanPressure(0.01);
    let kinds = [
        Facts::default(),
        Facts { boundary: Boundary::Free, ..Facts::default() },
        Facts { finite_slope: true, ..Facts::default() },
        Facts { law: LawKind::Exponential, ..Facts::default() },
        Facts { lower: Some(Lower::Seed), support: Support::Slab(BaseKind::Bonded), ..Facts::default() },
        Facts {
            lower: Some(Lower::Seed),
            support: Support::Slab(BaseKind::Bonded),
            law: LawKind::Exponential,
            ..Facts::default()
        },
    ];
    let posed: Vec<_> = kinds.iter().map(|facts| Parts::of(*facts).pose().unwrap()).collect();
    let mut states: Vec<_> = posed.iter().map(|problem| problem.press(load).solve().unwrap()).collect();
    for (index, problem) in posed.iter().enumerate() {
        let state = &states[index];
        let pressure = state.pressure().into_owned();
        let lower = state
            .lower()
            .map(|lower| (lower.pressure().into_owned(), lower.displacement_z().to_owned(), lower.gap().to_owned()));
        let gap = state.gap().to_owned();
        let (displacement, approach) = (state.displacement_z().to_owned(), state.approach());
        let fields: Vec<_> = (problem.basis().iter())
            .map(|name| match *name {
                "pressure" => &*pressure,
                "gap" => &*gap,
                "lower_pressure" => &lower.as_ref().unwrap().0,
                "lower_gap" => &lower.as_ref().unwrap().2,
                other => panic!("{other}"),
            })
            .collect();
        let certified = problem.certify(&fields, load.into()).unwrap();
        assert!(certified.worst() <= 1e-8, "{:?}: {}", kinds[index], certified.worst());
        assert!(matches!(problem.certify(&[], load.into()), Err(Refusal::Basis { found: 0, .. })));
        let kept = StoredFields { pressure: &pressure, displacement_z: &displacement, gap: &gap, approach };
        let below = lower.as_ref().map(|(pressure, displacement_z, gap)| StoredFields {
            pressure,
            displacement_z,
            gap,
            approach: f64::NAN,
        });
        let recalled = problem.recall(kept, below).unwrap();
        let from = problem.press(load).starting_from(Some(&recalled)).solve().unwrap();
        assert!(from.worst() <= 1e-8, "{:?}: {}", kinds[index], from.worst());
        let mut checkpoint = MemoryCheckpoint::default();
        problem.keep(&mut states[index], &mut Writing(&mut checkpoint));
        let restored = problem.restore(load.into(), &mut Reading(&mut checkpoint)).unwrap();
        same(&restored, &states[index]);
    }
    let other = posed[0].press(load).starting_from(Some(&states[3])).solve();
    assert!(matches!(other, Err(SolveError::Refused(Refusal::OtherKind))));
    assert!(posed[0].stiffness(&states[3], 1e-9).is_err());
}

/// Returns true for a state whose wear by slip changes neither pressure nor gap of the next one: no pressed point
/// slips, or the pressure of each is the hardness, so that less plastic depth makes up for the depth worn off.
fn hides_wear(state: &AnyState) -> bool {
    let Some(sticking) = state.of_parts().and_then(QuasistaticState::stick_fraction) else { return false };
    let pressure = state.pressure();
    let pressed = || pressure.iter().filter(|pressure| **pressure > 0.0);
    sticking >= pressed().count() as f64 / pressure.len() as f64 || pressed().all(|pressure| *pressure == HARDNESS)
}

/// Checks that every combination is refused, or solved with all its parts. Equal states mean that a part is left out.
#[test]
fn every_combination_is_refused_by_the_table_or_solved() {
    let (mut solved, mut refused, mut surprises) = (0, 0, Vec::new());
    let mut states: HashMap<Vec<u64>, Facts> = HashMap::new();
    for facts in all_facts() {
        if facts.check().is_err() {
            refused += 1;
            continue;
        }
        let parts = Parts::of(facts);
        let far = facts.boundary == Boundary::Periodic || gfmd_green::has_level(&parts.body, &parts.grid);
        assert_eq!(facts.is_level_near(), !far, "{facts:?}");
        // Two faces share the approach, and have more contact; the pressure shall reach the hardness.
        let [approach, mean] = if facts.lower.is_some() { [0.022, 0.013] } else { [0.009, 0.01] };
        let load = if facts.approach { Load::Approach(approach) } else { Load::MeanPressure(mean) };
        let far = if facts.lateral { 1e-4 } else { 0.0 };
        let outcome = parts.pose().map_err(|error| format!("posed: {error}")).and_then(|problem| {
            let press = |time: f64, start: Option<&_>| {
                let moved = 1.0 + time;
                let drive = Drive { load, lateral: [far * moved, 0.0], time, distance: 0.005 * moved };
                let solved = problem.press(drive).starting_from(start).tolerance(1e-6).solve();
                solved.map_err(|error| format!("solved: {error}"))
            };
            // The memory of a path acts from the second step on.
            let start = press(0.0, None)?;
            let next = match facts.sequence {
                Sequence::Loads => None,
                Sequence::Path => Some(press(1.0, Some(&start))?),
            };
            let state = next.as_ref().unwrap_or(&start);
            let lateral = state.lateral().iter().flatten();
            let bits = state.pressure().iter().chain(state.gap()).chain(lateral).map(|value| value.to_bits()).collect();
            match states.insert(bits, facts) {
                // The first step of a path may be the state of a load.
                Some(other) if (Facts { sequence: facts.sequence, ..other }) != facts => {
                    let is_hidden = Facts { wear: facts.wear, ..other } == facts && hides_wear(&start);
                    if is_hidden { Ok(()) } else { Err(format!("the state of {other:?}")) }
                }
                _ if state.worst() <= 1e-6 => Ok(()),
                _ => Err(format!("residual {:e}", state.worst())),
            }
        });
        match outcome {
            Ok(()) => solved += 1,
            Err(why) => surprises.push(format!("{why}: {facts:?}")),
        }
    }
    assert!(surprises.is_empty(), "{} of {}: {:#?}", surprises.len(), solved, &surprises[..surprises.len().min(8)]);
    assert!(solved > 400 && refused > 4000, "{solved} {refused}");
}

/// Checks that each rule has a reason and allowed values and occurs once, and that each part occurs in a rule.
#[test]
fn rules_name_their_parts_and_reasons() {
    for rule in RULES {
        assert!(!rule.why.is_empty());
        assert!(!rule.allowed.is_empty());
        assert!(rule.part != rule.with);
        let twice = RULES.iter().filter(|other| (other.part, other.with) == (rule.part, rule.with)).count();
        let reversed = RULES.iter().filter(|other| (other.part, other.with) == (rule.with, rule.part)).count();
        assert_eq!((twice, reversed), (1, 0), "{:?} with {:?}", rule.part, rule.with);
    }
    // The leak is refused without the flow where its numbers are read.
    let mut parts = Part::ALL.iter().filter(|part| **part != Part::Leak);
    let names = |rule: &Rule, part: Part| {
        [rule.part, rule.with].into_iter().any(|named| named == part || named.members().contains(&part))
    };
    assert!(parts.all(|part| RULES.iter().any(|rule| names(rule, *part))));
    let facts = Facts { lower: Some(Lower::Seed), ..Facts::default() };
    let message = facts.check().unwrap_err().to_string();
    assert_eq!(message, "--height is inf; it must be finite with --lower-seed (a second surface needs a lower face)");
}

/// Checks that rules for some bases name them, and name all other bases as allowed.
#[test]
fn rules_of_bases_name_them() {
    let bases = |parts: &'static [Part], refused: bool| {
        let is_in = move |base: &BaseKind| {
            let facts = Facts { support: Support::Slab(*base), ..Facts::default() };
            parts.iter().any(|part| part.is_in(&facts)) == refused
        };
        BaseKind::ALL.into_iter().filter(is_in).map(BaseKind::name).collect::<BTreeSet<_>>()
    };
    let names = |list: &'static str| list.split(", ").flat_map(|part| part.split(" or ")).collect::<BTreeSet<_>>();
    for rule in RULES {
        match rule.part {
            Part::Plate => assert_eq!(names(rule.allowed), bases(&[Part::Plate], false)),
            Part::Sliding => assert_eq!(names(rule.allowed), bases(&[Part::Plate, Part::Sliding], false)),
            _ => {}
        }
    }
    let listed: BTreeSet<String> = (rules_of(Sequence::Path).into_iter().flat_map(|(_, parts)| parts))
        .filter_map(|part| part.strip_prefix("no --base ").map(str::to_owned))
        .filter(|part| !part.starts_with("or "))
        .collect();
    let named = listed.iter().flat_map(|part| part.split(" or ")).collect::<BTreeSet<_>>();
    assert_eq!(named, bases(&[Part::Plate, Part::Sliding], true));
}

/// Compares the page of the rules. `GFMD_DOCS=write cargo test -p gfmd-problem` writes it.
#[test]
fn the_page_has_the_rules() {
    let lines = |rules: Vec<(String, Vec<String>)>| {
        let line = |(with, others): (String, Vec<String>)| format!("- with {with}: {}\n", others.join(", "));
        rules.into_iter().map(line).collect::<String>()
    };
    let text = format!(
        "# Combinations of options\n\n\
         <!-- Made from crates/problem/src/rules.rs by `GFMD_DOCS=write cargo test -p gfmd-problem`. -->\n\n\
         A hard wall can be combined with every option. The program, the Python package (names without dashes), \
         `check` and the\n\
         tests use one table of refused combinations. All other combinations are solved, and a test tries each on a \
         small grid.\n\
         `gfmd contact --help`, `gfmd path --help` and `gfmd slide --help` print the same lists.\n\n\
         ## `contact`\n\n{}\n## `path`\n\n{}\n## `slide`\n\n{}\n\
         Steady sliding has neither laws, wear, free boundaries, nor lateral paths. Compressible slabs that\n\
         relax in shear alone, and pairs of bodies of which one relaxes, have no --friction there: the lift by the\n\
         shear is not known.\n\n\
         ## Reasons\n\n{}",
        lines(rules_of(Sequence::Loads)),
        lines(rules_of(Sequence::Path)),
        lines(rules_of_sliding()),
        table()
    );
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/together.md");
    if std::env::var_os("GFMD_DOCS").is_some_and(|what| what == "write") {
        std::fs::write(page, &text).unwrap();
    }
    assert_eq!(std::fs::read_to_string(page).unwrap(), text);
}
