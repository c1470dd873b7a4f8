use gfmd_contact::{Drive, Load};
use gfmd_relax::{
    Budget, Descended, Ending, Minimum, ProjectedCg, RelaxError, SpectralProjectedGradient, Target, Watch,
};

use super::FrictionalContact;
use super::normal::NormalProblem;
use super::response::Transforms;
use super::state::FrictionState;
use super::tangential::{Limits, TangentialProblem};

/// Increment during its solution.
pub(super) struct Increment<'a> {
    pub(super) contact: &'a FrictionalContact,
    pub(super) drive: Drive,
    pub(super) transforms: Transforms,
    pub(super) normal: NormalProblem,
    /// Lateral displacement of the elastic surface without slip.
    pub(super) stuck: Vec<f64>,
    /// Limits of the shear at the start.
    pub(super) limits_before: Vec<f64>,
    pub(super) pressure: Vec<f64>,
    /// Length scale of the residuals: from the load, or from the displacement once it is known.
    pub(super) length_scale: f64,
    /// Traction on the elastic surface with all components; the z component is 0.
    pub(super) shear: Vec<f64>,
    /// Displacement G τ caused by the shear.
    sheared: Vec<f64>,
}

impl<'a> Increment<'a> {
    pub(super) fn new(contact: &'a FrictionalContact, drive: Drive, start: Option<&FrictionState>) -> Self {
        let points = contact.surface.clearance().len();
        let lateral = contact.lateral_components() * points;
        let mut pressure = vec![0.0; points];
        let mut shear = vec![0.0; lateral + points];
        let mut stuck: Vec<f64> = (0..lateral).map(|k| drive.lateral[k / points]).collect();
        if let Some(state) = start {
            let tractions = || state.traction.iter();
            pressure.iter_mut().zip(tractions().skip(lateral)).for_each(|(p, t)| *p = (-t).max(0.0));
            shear.iter_mut().zip(tractions().take(lateral)).for_each(|(shear, t)| *shear = *t);
            for (k, (stuck, u)) in stuck.iter_mut().zip(&state.displacement).enumerate() {
                *stuck += u - state.lateral[k / points];
            }
        }
        let rms_height = contact.surface.rms_height();
        let limits_before = Limits::new(contact.limit, &pressure, rms_height).values;
        if let (None, Load::MeanPressure(mean)) = (start, drive.load) {
            pressure.fill(mean);
        }
        let mut increment = Self {
            contact,
            drive,
            limits_before,
            transforms: contact.response.transforms(),
            normal: NormalProblem::new(&contact.response, contact.surface.clearance()),
            stuck,
            pressure,
            length_scale: contact.surface.length_scale(drive.load),
            sheared: vec![0.0; shear.len()],
            shear,
        };
        increment.lift(1.0);
        increment
    }

    /// Returns the number of lateral values, for x or for x and y.
    pub(super) fn lateral(&self) -> usize {
        self.stuck.len()
    }

    /// Returns the number of transform pairs so far.
    pub(super) fn pairs(&self) -> f64 {
        self.transforms.pairs() + self.normal.pairs as f64
    }

    /// Passes the fraction `share` of the change of u_z caused by the shear to the normal problem.
    pub(super) fn lift(&mut self, share: f64) {
        let lateral = self.lateral();
        let Self { contact, transforms, shear, sheared, normal, drive, .. } = self;
        transforms.compliance(shear, sheared);
        let approach = if let Load::Approach(approach) = drive.load { approach } else { 0.0 };
        for ((linear, clearance), u) in
            normal.linear.iter_mut().zip(contact.surface.clearance()).zip(&sheared[lateral..])
        {
            *linear += share * (clearance - u - approach - *linear);
        }
    }

    /// Finds the pressure for the present shear.
    pub(super) fn press(&mut self, budget: &Budget, watch: &mut dyn Watch) -> Result<Minimum, RelaxError> {
        let target = Target {
            mean: if let Load::MeanPressure(mean) = self.drive.load { Some(mean) } else { None },
            gradient_scale: self.length_scale,
            budget: *budget,
        };
        ProjectedCg.minimise(&mut self.normal, &mut self.pressure, &target, watch)
    }

    /// Returns the shear limits for the present pressure.
    pub(super) fn limits(&self) -> Limits {
        Limits::new(self.contact.limit, &self.pressure, self.length_scale)
    }

    /// Returns the traction on the elastic surface from the pressure and `shear`.
    pub(super) fn traction(&self, shear: &[f64]) -> Vec<f64> {
        shear.iter().copied().chain(self.pressure.iter().map(|p| -p)).collect()
    }

    /// Finds the shear for the present pressure.
    pub(super) fn shear(&mut self, budget: &Budget, watch: &mut dyn Watch) -> Descended {
        let lateral = self.lateral();
        let limits = self.limits();
        let mut traction = self.traction(&vec![0.0; lateral]);
        let Self { contact, transforms, stuck, shear, sheared, .. } = self;
        let mut slip = vec![0.0; traction.len()];
        transforms.compliance(&traction, &mut slip);
        limits.project(&mut shear[..lateral]);
        transforms.compliance(shear, sheared);
        slip.truncate(lateral);
        for ((slip, stuck), u) in slip.iter_mut().zip(stuck).zip(&*sheared) {
            *slip = *slip - *stuck + u;
        }
        if limits.strongest == 0.0 {
            return Descended { steps: 0, ending: Ending::Converged };
        }
        traction[lateral..].fill(0.0);
        // The first step is a stiffness: the stiffness of the shortest wave.
        let [_, stiffest] = contact.response.stiffness_range();
        let mut problem = TangentialProblem { transforms, limits: &limits, traction, displacement: sheared };
        let method = SpectralProjectedGradient { first_step: stiffest };
        method.minimise(&mut problem, &mut shear[..lateral], &mut slip, budget, watch)
    }
}
