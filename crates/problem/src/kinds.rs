//! Kinds of contact.

use gfmd_contact::{
    Cotangents, Drive, Gradient, Load, Refusal, RigidSurface, SqueezedContact, SqueezedSolution, SteepContact,
    SteepSolution, Stiffness,
};
use gfmd_interface::{
    Increment, PathGradient, QuasistaticContact, QuasistaticState, Squeezed, SqueezedState, StiffnessError,
    StoredFields, Trapping, stiffness_between_walls,
};
use gfmd_plasticity::{PlasticState, YieldingContact};
use gfmd_relax::Why;
use ndarray::ArrayRef2;

use crate::Unusable;
use crate::posed::{ContactKind, NoStiffness, OfState, other_fields};

/// Returns the basis fields of a kind, which must be `N` fields.
fn all<'a, const N: usize>(fields: &[&'a ArrayRef2<f64>]) -> Result<[&'a ArrayRef2<f64>; N], Refusal> {
    fields.try_into().map_err(|_| Refusal::Basis { found: fields.len(), expected: N })
}

/// Describes a stiffness that is less exact than requested.
fn inexact((reached, why): (Stiffness, Why)) -> NoStiffness {
    let text = format!("the error of the stiffness {:e} is {:.1e} ({why})", reached.value, reached.error);
    NoStiffness::Inexact(reached, text)
}

impl ContactKind for SteepContact {
    fn surface(&self) -> &RigidSurface {
        SteepContact::surface(self)
    }

    fn certify(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<SteepSolution, Refusal> {
        let [pressure] = all(fields)?;
        SteepContact::certify(self, pressure, drive.load)
    }

    fn stiffness(&self, state: &SteepSolution, tolerance: f64) -> Result<Stiffness, NoStiffness> {
        SteepContact::stiffness(self, state, tolerance).map_err(inexact)
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

    fn recall(&self, stored: StoredFields<'_>, lower: Option<StoredFields<'_>>) -> Result<SqueezedSolution, Refusal> {
        let lower = lower.ok_or(Refusal::Basis { found: 1, expected: 2 })?;
        SqueezedContact::certify(self, [stored.pressure, lower.pressure], Load::Approach(stored.approach))
    }

    fn stiffness(&self, state: &SqueezedSolution, tolerance: f64) -> Result<Stiffness, NoStiffness> {
        stiffness_between_walls(self, state, tolerance).map_err(no_stiffness)
    }
}

impl ContactKind for Squeezed {
    fn surface(&self) -> &RigidSurface {
        self.surfaces()[0]
    }

    fn basis(&self) -> &'static [&'static str] {
        Squeezed::basis(self)
    }

    fn certify(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<SqueezedState, Refusal> {
        Squeezed::certify(self, fields, drive)
    }

    fn recall(&self, stored: StoredFields<'_>, lower: Option<StoredFields<'_>>) -> Result<SqueezedState, Refusal> {
        Squeezed::recall(self, stored, lower.ok_or(Refusal::Basis { found: 1, expected: 2 })?)
    }

    fn stiffness(&self, state: &SqueezedState, tolerance: f64) -> Result<Stiffness, NoStiffness> {
        Squeezed::stiffness(self, state, tolerance).map_err(no_stiffness)
    }

    fn stiffness_of_fields(&self, faces: &[[&ArrayRef2<f64>; 2]], tolerance: f64) -> Result<Stiffness, NoStiffness> {
        let faces = faces.try_into().map_err(|_| other_fields())?;
        Squeezed::stiffness_of_fields(self, faces, tolerance).map_err(no_stiffness)
    }

    fn trapping(&self) -> Option<Trapping> {
        Squeezed::trapping(self)
    }
}

fn no_stiffness(error: StiffnessError) -> NoStiffness {
    match error {
        StiffnessError::Inexact { reached, .. } => NoStiffness::Inexact(reached, error.to_string()),
        error => NoStiffness::Undefined(error.to_string().into()),
    }
}

impl ContactKind for QuasistaticContact {
    fn surface(&self) -> &RigidSurface {
        QuasistaticContact::surface(self)
    }

    fn basis(&self) -> &'static [&'static str] {
        QuasistaticContact::basis(self)
    }

    fn certify(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<QuasistaticState, Refusal> {
        QuasistaticContact::certify(self, fields, drive)
    }

    fn recall(&self, stored: StoredFields<'_>, _: Option<StoredFields<'_>>) -> Result<QuasistaticState, Refusal> {
        QuasistaticContact::recall(self, stored)
    }

    fn stiffness(&self, state: &QuasistaticState, tolerance: f64) -> Result<Stiffness, NoStiffness> {
        QuasistaticContact::stiffness(self, state, tolerance).map_err(no_stiffness)
    }

    fn stiffness_of_fields(&self, faces: &[[&ArrayRef2<f64>; 2]], tolerance: f64) -> Result<Stiffness, NoStiffness> {
        let [[pressure, gap]] = faces.try_into().map_err(|_| other_fields())?;
        QuasistaticContact::stiffness_of_fields(self, pressure, gap, tolerance).map_err(no_stiffness)
    }

    fn gradient(&self, state: &QuasistaticState, load: Load, of: &Cotangents) -> Result<Gradient, Unusable> {
        QuasistaticContact::gradient(self, state, load, of).map_err(|error| Unusable::of(error.to_string()))
    }

    fn gradient_along(&self, increments: &[OfState<QuasistaticState>]) -> Result<PathGradient, Unusable> {
        let increments: Vec<Increment> =
            increments.iter().map(|(load, state, of)| Increment { load: *load, state, of: *of }).collect();
        QuasistaticContact::gradient_along(self, &increments).map_err(|error| Unusable::of(error.to_string()))
    }

    fn trapping(&self) -> Option<Trapping> {
        QuasistaticContact::trapping(self)
    }
}

impl ContactKind for YieldingContact {
    fn surface(&self) -> &RigidSurface {
        YieldingContact::surface(self)
    }

    /// Returns no names: the strain below the surface does not follow from fields on it.
    fn basis(&self) -> &'static [&'static str] {
        &[]
    }

    fn certify(&self, fields: &[&ArrayRef2<f64>], _: Drive) -> Result<PlasticState, Refusal> {
        Err(Refusal::Basis { found: fields.len(), expected: 0 })
    }

    fn stiffness(&self, state: &PlasticState, tolerance: f64) -> Result<Stiffness, NoStiffness> {
        YieldingContact::stiffness(self, state, tolerance).map_err(inexact)
    }

    fn stiffness_of_fields(&self, faces: &[[&ArrayRef2<f64>; 2]], tolerance: f64) -> Result<Stiffness, NoStiffness> {
        let [[pressure, _]] = faces.try_into().map_err(|_| other_fields())?;
        // It is the stiffness of the elastic contact with these points in contact.
        let elastic = self.contact().certify(pressure, Load::Approach(0.0));
        let elastic = elastic.map_err(|refusal| NoStiffness::Undefined(refusal.to_string().into()))?;
        self.contact().stiffness(&elastic, tolerance).map_err(inexact)
    }
}
