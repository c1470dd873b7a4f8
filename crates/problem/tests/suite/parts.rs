//! Small problems of all kinds, for the tests of `gfmd-problem` and `gfmd-record`.

use std::sync::Arc;

use gfmd_contact::{Boundary, Refusal};
use gfmd_field::Grid;
use gfmd_green::{BaseKind, Body, Material};
use gfmd_interface::Wear;
use gfmd_law::{HardWall, Law, LawKind, Limit};
use gfmd_medium::{Prony, Relaxes};
use gfmd_plasticity::{Cells, Hardening};
use gfmd_problem::options::Plasticity;
use gfmd_problem::{Facts, Friction, GridError, KeptStrain, Lower, Posed, Sequence, Support, Unknown, WearBy, pose};
use ndarray::Array2;

const N: usize = 16;

fn heights(grid: &Grid) -> Array2<f64> {
    let [nx, ny] = grid.points();
    Array2::from_shape_fn((nx, ny), |(i, j)| {
        let [x, y] = [(i, nx), (j, ny)].map(|(index, count)| std::f64::consts::TAU * index as f64 / count as f64);
        0.01 * (x.cos() * y.cos() + 0.4 * (3.0 * x + 2.0 * y).sin() + 0.2 * (5.0 * x - 3.0 * y).cos())
    })
}

/// Hardness, stress; E is 1.
pub(crate) const HARDNESS: f64 = 0.04;

/// Owner of the parts that a problem borrows.
pub(crate) struct Parts {
    pub(crate) facts: Facts,
    pub(crate) grid: Grid,
    pub(crate) body: Body,
    pub(crate) heights: Array2<f64>,
    pub(crate) lower: Option<Array2<f64>>,
    pub(crate) law: Arc<dyn Law>,
    prony: Option<Prony>,
    plasticity: Option<Plasticity>,
}

fn body_on(support: Support, young: f64) -> Body {
    let material = Material::from_young(young, 0.3).unwrap();
    let slab = || Body::slab(material, 0.3).unwrap();
    match support {
        Support::HalfSpace => Body::half_space(material),
        Support::Table => {
            // The slab, tabulated beyond the wavenumbers of the grid.
            let rows: Vec<[f64; 2]> =
                (0..60).map(|k| 1.2_f64.powi(k)).map(|q| [q, slab().normal_compliance(q)]).collect();
            Body::tabulated(material.contact_modulus(), &rows, slab().normal_compliance(0.0)).unwrap()
        }
        Support::Slab(base) => {
            let below = base.ground().is_none().then(|| Material::from_young(3.0, 0.2).unwrap());
            slab().on(base.with(below).unwrap()).unwrap()
        }
    }
}

impl Parts {
    pub(crate) fn of(facts: Facts) -> Self {
        let grid = if facts.line { Grid::line(N, 1.0) } else { Grid::square(N, 1.0) }.unwrap();
        let body = body_on(facts.support, 1.0);
        let body = match facts.second {
            Some(second) => body.against(body_on(second, 2.0)),
            None => body,
        };
        let law = match facts.law {
            LawKind::HardWall => HardWall.into_shared(),
            law => law.with(&[("gamma", 2e-4), ("range", 4e-3)]).unwrap().into_shared(),
        };
        let lower = facts.lower.map(|_| -heights(&grid));
        let prony = facts.relaxes.map(|_| Prony::from_fractions(&[(0.5, 0.3), (20.0, 0.4)]).unwrap());
        let steel = Hardening::new(0.02).unwrap().isotropic(0.02).unwrap();
        let has_half_space = facts.support == Support::Slab(BaseKind::HalfSpace);
        let hardening = [Some(steel)].into_iter().chain(has_half_space.then_some(None)).collect();
        let plasticity =
            facts.yields.then(|| Plasticity { hardening, cells: Cells::default(), kept_strain: KeptStrain::Last });
        Self { facts, grid, body, heights: heights(&grid), lower, law, prony, plasticity }
    }

    pub(crate) fn parts(&self) -> gfmd_interface::Parts<'_> {
        let shear = self.facts.friction.map(|friction| match friction {
            Friction::Coulomb => Limit::Coulomb(0.3),
            Friction::Tresca => Limit::Tresca(0.02),
            Friction::Orowan => Limit::Orowan { coefficient: 0.3, strength: 0.02 },
        });
        let wear = self.facts.wear.map(|by| match by {
            WearBy::Distance => Wear { by_distance: 0.5, by_slip: 0.0 },
            WearBy::Slip => Wear { by_distance: 0.0, by_slip: 0.5 },
        });
        gfmd_interface::Parts {
            lower: self.lower.as_ref().map(Into::into),
            law: Some(Arc::clone(&self.law)),
            hardness: self.facts.hardness.then_some(HARDNESS.into()),
            shear: shear.map(Into::into),
            relaxation: self.prony.as_ref().zip(self.facts.relaxes),
            wear,
            ..gfmd_interface::Parts::new(&self.body, &self.grid, &self.heights)
        }
    }

    pub(crate) fn pose(&self) -> Result<Posed, Refusal> {
        pose(&self.facts, &self.parts(), self.plasticity.as_ref())
    }
}

/// Returns all facts that differ in their physics.
pub(crate) fn all_facts() -> impl Iterator<Item = Facts> {
    let supports: Vec<Support> =
        [Support::HalfSpace, Support::Table].into_iter().chain(BaseKind::ALL.map(Support::Slab)).collect();
    let seconds = [None, Some(Support::HalfSpace), Some(Support::Slab(BaseKind::Bonded))];
    let wears = [None, Some(WearBy::Distance), Some(WearBy::Slip)];
    let relaxing = [None, Some(Relaxes::Both), Some(Relaxes::Shear)];
    let flags = 2_usize.pow(11);
    let count = flags * relaxing.len() * wears.len() * Unknown::ALL.len() * supports.len() * seconds.len();
    let facts = (0..count).map(move |mut index| {
        let mut digit = |base: usize| {
            let digit = index % base;
            index /= base;
            digit
        };
        Facts {
            hardness: digit(2) == 1,
            yields: digit(2) == 1,
            friction: [None, Some(Friction::Coulomb)][digit(2)],
            sequence: [Sequence::Loads, Sequence::Path][digit(2)],
            law: [LawKind::HardWall, LawKind::Exponential][digit(2)],
            boundary: Boundary::ALL[digit(2)],
            unknown: Unknown::ALL[digit(Unknown::ALL.len())],
            finite_slope: digit(2) == 1,
            lower: [None, Some(Lower::Surface)][digit(2)],
            support: supports[digit(supports.len())],
            second: seconds[digit(seconds.len())],
            line: digit(2) == 1,
            approach: digit(2) == 1,
            lateral: digit(2) == 1,
            relaxes: relaxing[digit(relaxing.len())],
            wear: wears[digit(wears.len())],
            // All fields, so that a new fact must be varied here. The following ones do not change the contact.
            layers: false,
            moved_base: None,
            statistics: false,
            flow: false,
            leak: false,
            gas: false,
            conducts: false,
            flow_threshold: false,
            grid_error: GridError::Estimate,
            history: false,
            resume: false,
            processes: 1,
        }
    });
    // Loads have no flags for lateral motion, friction, time or distance.
    let is_of_loads = |facts: &Facts| {
        let no_part = facts.friction.is_none() && facts.relaxes.is_none() && facts.wear.is_none() && !facts.yields;
        no_part && !facts.lateral
    };
    facts.filter(move |facts| facts.sequence == Sequence::Path || is_of_loads(facts))
}
