//! Critical and optimal damping against the eigenvalues of the scheme.

use gfmd_relax::Damping;

use crate::check::Worst;
use crate::{Check, Reference, ValidationError};

pub(crate) fn checks(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    let [mut critical, mut off, mut optimal] = [Worst::new(); 3];
    for row in reference.table("critical_damping.json")? {
        let (k, dt) = (row.get("k"), row.get("dt"));
        let damping = Damping::critical(k, dt);
        critical.compare(damping.eta(), row.get("eta_cr"));
        critical.compare_to(damping.beta, row.get("beta_cr"), 1.0);
        // Double root of the characteristic polynomial: half the sum of the roots.
        critical.compare_to(0.5 * (1.0 + damping.beta - damping.tau * k), row.get("lam_cr"), 1.0);
        critical.compare(damping.stiffness_limit(), row.get("kmax_stable"));
        critical.compare(Damping::central_critical(k, dt), row.get("gamma_central"));
        for name in ["half", "1p3"] {
            let tau = dt * dt;
            let damping = Damping { beta: 1.0 - row.get(&format!("eta_{name}")) * tau, tau };
            off.compare(damping.spectral_radius(k), row.get(&format!("rho_{name}")));
        }
    }
    for row in reference.table("optimal_damping.json")? {
        let (soft, stiff) = (row.get("kmin"), row.get("kmax"));
        let (damping, descent) = (Damping::optimal(soft, stiff), Damping::plain_descent(soft, stiff));
        for (found, name) in [
            (damping.tau, "tau_opt"),
            (damping.tau.sqrt(), "dt_opt"),
            (damping.beta, "beta_opt"),
            (damping.eta(), "eta_opt"),
            (damping.spectral_radius(soft), "rho_opt"),
            (damping.spectral_radius(stiff), "rho_opt"),
            (damping.steps_per_decade(soft, stiff), "steps_per_decade"),
            (descent.tau, "tau_gd"),
            (descent.spectral_radius(soft), "rho_gd"),
        ] {
            optimal.compare(found, row.get(name));
        }
    }
    Ok(vec![
        critical.check("critical damping: eta, eigenvalue, limit of stability", "closed form, eigenvalues", 1e-12),
        off.check("half and 1.3 times the critical damping: spectral radius", "eigenvalues", 1e-12),
        optimal.check("best damping of a band: step, damping, rate", "closed form, eigenvalues", 1e-10),
    ])
}
