//! Kinds of contact.

use gfmd_contact::{
    Contact, Cotangents, Drive, Fields as _, FullContact, FullSolution, Gradient, Load, Refusal, RigidSurface,
    Solution, SqueezedContact, SqueezedSolution, SteepContact, SteepSolution, Stiffness,
};
use gfmd_interface::{
    FrictionState, FrictionalContact, Interface, Loss, PlasticContact, PlasticState, Quasistatic, Reading, State,
    StoredFields, Trapping,
};
use gfmd_viscoelastic::{ElasticContact, ViscoelasticContact};
use gfmd_wear::{WearContact, WearState};
use ndarray::ArrayRef2;

use crate::Unusable;
use crate::posed::{ContactKind, NoStiffness};

/// Returns the basis fields of a kind, which must be `N` fields.
fn all<'a, const N: usize>(fields: &[&'a ArrayRef2<f64>]) -> Result<[&'a ArrayRef2<f64>; N], Refusal> {
    fields.try_into().map_err(|_| Refusal::Basis { found: fields.len(), expected: N })
}

/// Returns the approach of stored fields. A file has no value for it if the displacement has no level; then it follows
/// from the fields, which have a level of their own.
fn approach(stored: &StoredFields<'_>, clearance: &[f64]) -> f64 {
    if !stored.approach.is_nan() {
        return stored.approach;
    }
    let fields = stored.gap.iter().zip(stored.displacement_z);
    let sum: f64 = clearance.iter().zip(fields).map(|(clearance, (gap, u))| clearance - gap - u).sum();
    sum / clearance.len() as f64
}

impl ContactKind for Contact {
    fn surface(&self) -> &RigidSurface {
        Contact::surface(self)
    }

    fn certify(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<Solution, Refusal> {
        let [pressure] = all(fields)?;
        Contact::certify(self, pressure, drive.load)
    }

    fn recall(&self, stored: StoredFields<'_>, _: Option<&ArrayRef2<f64>>) -> Result<Solution, Refusal> {
        let approach = approach(&stored, Contact::surface(self).clearance());
        Contact::certify(self, stored.pressure, Load::Approach(approach))
    }

    fn stiffness(&self, state: &Solution, tolerance: f64) -> Result<Stiffness, NoStiffness> {
        Contact::stiffness(self, state, tolerance).map_err(|(reached, why)| {
            let text = format!("the error of the stiffness {:e} is {:.1e} ({why})", reached.value, reached.error);
            NoStiffness::Inexact(reached, text)
        })
    }

    fn gradient(&self, state: &Solution, load: Load, of: &Cotangents) -> Result<Gradient, Unusable> {
        Contact::gradient(self, state, load, of).map_err(|error| Unusable::of(error.to_string()))
    }
}

impl ContactKind for FullContact {
    fn surface(&self) -> &RigidSurface {
        FullContact::surface(self)
    }

    fn certify(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<FullSolution, Refusal> {
        let [pressure] = all(fields)?;
        FullContact::certify(self, pressure, drive.load)
    }

    fn recall(&self, stored: StoredFields<'_>, _: Option<&ArrayRef2<f64>>) -> Result<FullSolution, Refusal> {
        let mean = stored.pressure.mean().unwrap_or(f64::NAN);
        FullContact::certify(self, stored.pressure, Load::MeanPressure(mean))
    }

    fn stiffness(&self, _: &FullSolution, _: f64) -> Result<Stiffness, NoStiffness> {
        Err(NoStiffness::Undefined(
            "not computed with all components: the Nyquist modes of an even grid have a stiffness of their own",
        ))
    }
}

impl ContactKind for SteepContact {
    fn surface(&self) -> &RigidSurface {
        SteepContact::surface(self)
    }

    fn certify(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<SteepSolution, Refusal> {
        let [pressure] = all(fields)?;
        SteepContact::certify(self, pressure, drive.load)
    }

    fn stiffness(&self, _: &SteepSolution, _: f64) -> Result<Stiffness, NoStiffness> {
        Err(NoStiffness::Undefined(
            "not computed with finite slopes: the points in contact move sideways with the load",
        ))
    }
}

impl ContactKind for SqueezedContact {
    fn surface(&self) -> &RigidSurface {
        self.surfaces()[0]
    }

    fn basis(&self) -> &'static [&'static str] {
        &["pressure", "lower_pressure"]
    }

    fn certify(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<SqueezedSolution, Refusal> {
        SqueezedContact::certify(self, all(fields)?, drive.load)
    }

    fn recall(&self, stored: StoredFields<'_>, lower: Option<&ArrayRef2<f64>>) -> Result<SqueezedSolution, Refusal> {
        let lower = lower.ok_or(Refusal::Basis { found: 1, expected: 2 })?;
        SqueezedContact::certify(self, [stored.pressure, lower], Load::Approach(stored.approach))
    }

    fn stiffness(&self, _: &SqueezedSolution, _: f64) -> Result<Stiffness, NoStiffness> {
        Err(NoStiffness::Undefined("not computed of a slab between two surfaces, which has two contacts"))
    }
}

impl ContactKind for Interface {
    fn surface(&self) -> &RigidSurface {
        Interface::surface(self)
    }

    fn basis(&self) -> &'static [&'static str] {
        if self.elastic().components() == 1 { &["gap", "pressure"] } else { &[] }
    }

    fn certify(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<State, Refusal> {
        let [gap, pressure] = all(fields)?;
        Interface::certify(self, gap, pressure, drive)
    }

    fn recall(&self, stored: StoredFields<'_>, _: Option<&ArrayRef2<f64>>) -> Result<State, Refusal> {
        let approach = approach(&stored, Interface::surface(self).clearance());
        Interface::recall(self, StoredFields { approach, ..stored })
    }

    fn stiffness(&self, _: &State, _: f64) -> Result<Stiffness, NoStiffness> {
        Err(NoStiffness::Undefined(
            "not computed with a law across the gap: it acts on all points, not on those in contact alone",
        ))
    }

    fn reading(&self, state: &State) -> Reading {
        Quasistatic::reading(self, state)
    }

    fn trapping(&self) -> Option<Trapping> {
        Interface::trapping(self)
    }

    fn gradient(&self, state: &State, load: Load, of: &Cotangents) -> Result<Gradient, Unusable> {
        Interface::gradient(self, state, load, of).map_err(|error| Unusable::of(error.to_string()))
    }
}

/// Reason why states of a path have no stiffness.
const ON_A_PATH: NoStiffness = NoStiffness::Undefined("not computed along a path");

impl ContactKind for FrictionalContact {
    fn surface(&self) -> &RigidSurface {
        FrictionalContact::surface(self)
    }

    fn basis(&self) -> &'static [&'static str] {
        &[]
    }

    fn certify(&self, fields: &[&ArrayRef2<f64>], _: Drive) -> Result<FrictionState, Refusal> {
        Err(Refusal::Basis { found: fields.len(), expected: 0 })
    }

    fn stiffness(&self, _: &FrictionState, _: f64) -> Result<Stiffness, NoStiffness> {
        Err(ON_A_PATH)
    }

    fn reading(&self, state: &FrictionState) -> Reading {
        Quasistatic::reading(self, state)
    }

    fn depends_on_division(&self, start: Option<&FrictionState>, end: &FrictionState, tolerance: f64) -> bool {
        Quasistatic::depends_on_division(self, start, end, tolerance)
    }

    fn change(&self, start: Option<&FrictionState>, from: &FrictionState, to: &FrictionState) -> f64 {
        Quasistatic::change(self, start, from, to)
    }

    fn change_of_stick(&self, from: &FrictionState, to: &FrictionState) -> f64 {
        Quasistatic::change_of_stick(self, from, to)
    }
}

impl ContactKind for PlasticContact {
    fn surface(&self) -> &RigidSurface {
        self.contact().surface()
    }

    fn basis(&self) -> &'static [&'static str] {
        &["pressure", "plastic_depth"]
    }

    fn certify(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<PlasticState, Refusal> {
        let [pressure, depth] = all(fields)?;
        PlasticContact::certify(self, pressure, depth, drive.load)
    }

    fn stiffness(&self, _: &PlasticState, _: f64) -> Result<Stiffness, NoStiffness> {
        Err(ON_A_PATH)
    }

    fn reading(&self, state: &PlasticState) -> Reading {
        Quasistatic::reading(self, state)
    }
}

impl<C> ContactKind for ViscoelasticContact<C>
where
    C: ElasticContact<State: Send + Sync + 'static> + Send + Sync + 'static,
{
    fn surface(&self) -> &RigidSurface {
        self.contact().surface()
    }

    fn basis(&self) -> &'static [&'static str] {
        &[]
    }

    fn certify(&self, fields: &[&ArrayRef2<f64>], _: Drive) -> Result<Self::State, Refusal> {
        Err(Refusal::Basis { found: fields.len(), expected: 0 })
    }

    fn stiffness(&self, _: &Self::State, _: f64) -> Result<Stiffness, NoStiffness> {
        Err(ON_A_PATH)
    }

    fn reading(&self, state: &Self::State) -> Reading {
        Reading {
            mean_pressure: state.mean_pressure(),
            approach: state.approach(),
            mean_shear: [0.0; 2],
            lateral: [0.0; 2],
            time: state.time,
            distance: 0.0,
            loss: Loss::Certified {
                lost: state.dissipated,
                imbalance: state.work_imbalance,
                stored: (!C::RESTS_AT_FIRST_TOUCH).then(|| state.elastic_energy + C::interface_energy(&state.solution)),
            },
        }
    }
}

impl ContactKind for WearContact {
    fn surface(&self) -> &RigidSurface {
        self.contact().surface()
    }

    fn basis(&self) -> &'static [&'static str] {
        &["pressure", "wear_depth"]
    }

    fn certify(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<WearState, Refusal> {
        let [pressure, depth] = all(fields)?;
        WearContact::certify(self, pressure, depth, drive)
    }

    fn stiffness(&self, _: &WearState, _: f64) -> Result<Stiffness, NoStiffness> {
        Err(ON_A_PATH)
    }

    fn reading(&self, state: &WearState) -> Reading {
        Reading {
            mean_pressure: state.solution.mean_pressure,
            approach: state.solution.approach,
            mean_shear: [0.0; 2],
            lateral: [0.0; 2],
            time: 0.0,
            distance: state.distance,
            loss: Loss::Certified { lost: state.dissipated, imbalance: state.work_imbalance, stored: None },
        }
    }
}
