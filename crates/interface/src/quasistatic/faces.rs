//! Contacts of both faces of a plate.

use std::sync::Arc;

use gfmd_contact::{Boundary, Refusal, RigidSurface, Units};
use gfmd_green::Plate;
use gfmd_law::{HardWall, InUnits, Law};
use gfmd_medium::Relaxes;

use super::normal::{Normal, NormalState};
use super::{Parts, QuasistaticContact, QuasistaticState, Sequence, Wear};
use crate::Interface;

impl QuasistaticContact {
    /// Creates the contact of both faces of a plate as one ([`Squeezed`](crate::Squeezed)); a hardness has the points
    /// of both faces, and the heights of the parts are not used.
    pub(crate) fn squeezed(parts: &Parts, surfaces: &[Arc<RigidSurface>; 2]) -> Result<Self, Refusal> {
        let Parts { body, boundary, law, all_components, held, hardness, shear, relaxation, wear, .. } = parts;
        for (is_given, with) in [
            (*boundary == Boundary::Free, "free boundaries"),
            (*all_components, "all components of the displacement"),
            (shear.is_some(), "a limit of the shear"),
        ] {
            if is_given {
                return Err(Refusal::NoWall { part: "a lower surface is", with });
            }
        }
        let given = Arc::new(RigidSurface::stacked(&surfaces[0], &surfaces[1])?);
        let units = match parts.sequence {
            // The interface has units of its own.
            Sequence::Loads => Units::ONE,
            Sequence::Path => Units::of(body, &given)?,
        };
        let (stress, length) = (units.stress(), units.length());
        let law = law.clone().unwrap_or_else(|| HardWall.into_shared());
        let law = if units.are_one() { law } else { InUnits::new(law, stress, length).into_shared() };
        let wear = wear.map(Wear::check).transpose()?;
        if wear.is_some_and(|wear| wear.by_slip > 0.0) {
            return Err(Refusal::WearBySlip);
        }
        if relaxation.is_some_and(|(_, relaxes)| relaxes == Relaxes::Shear) {
            return Err(Refusal::ShearAlone { with: "a second surface" });
        }
        let medium = parts.medium(given.grid(), given.share(), 1)?;
        let (scaled, hardness) = (units.surface(&given), hardness.as_ref().map(|h| h.times(1.0 / stress)));
        let plate = if *held { Plate::held_sideways } else { Plate::of };
        let interface = Interface::of_plate(plate, &units.body(body), &scaled, law)?;
        let interface = match &hardness {
            Some(hardness) => interface.with_hardness(hardness.clone())?,
            None => interface,
        };
        if parts.sequence == Sequence::Loads {
            parts.check_of_loads()?;
            return Ok(Self::of_normal(Normal::Law(interface), body.contact_modulus()));
        }
        Ok(Self {
            sequence: Sequence::Path,
            normal: Normal::Law(interface),
            medium,
            hardness,
            shear: None,
            response: None,
            wear: wear.map(|wear| Wear { by_distance: wear.by_distance * stress, ..wear }),
            all_components: false,
            sideways: Vec::new(),
            scaled,
            given,
            contact_modulus: body.contact_modulus(),
            units,
        })
    }

    /// Returns a face, 0 for the upper one, of the state of both faces of a plate.
    pub(crate) fn face(&self, both: &QuasistaticState, face: usize, surface: &Arc<RigidSurface>) -> QuasistaticState {
        let normal = match (&both.normal, &self.normal) {
            (NormalState::Law(state), Normal::Law(interface)) => NormalState::Law(interface.face_of(
                state,
                face,
                surface,
                self.units.length() * interface.units.length(),
            )),
            (state, _) => state.clone(),
        };
        let part = |field: &ndarray::Array2<f64>| {
            let rows = field.nrows() / 2;
            field.slice(ndarray::s![face * rows..(face + 1) * rows, ..]).to_owned()
        };
        // The hardness of both faces is the same, point by point.
        let hardness = self.hardness.as_ref().map(|hardness| hardness.times(self.units.stress()));
        let displacement = normal.fields().displacement_z();
        let (points, indentation) = (displacement.len(), displacement.iter().map(|u| -u).collect());
        let memory =
            both.memory.as_ref().and_then(|memory| memory.part(face * points..(face + 1) * points, indentation));
        QuasistaticState {
            memory,
            plastic_fraction: match hardness {
                Some(hardness) => self.saturated(&normal, &hardness),
                None => normal.plastic_fraction(),
            },
            normal,
            worn: both.worn.as_ref().map(part),
            pressed_in: both.pressed_in.as_ref().map(part),
            stored: both.stored.map(|energy| 2.0 * energy),
            losses: both.losses.times(2.0),
            work_imbalance: 2.0 * both.work_imbalance,
            ..both.clone()
        }
    }
}
