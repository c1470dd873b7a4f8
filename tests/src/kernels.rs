//! Stiffness and compliance of one wave vector against boundary-value problems solved by other methods.

use std::f64::consts::TAU;

use gfmd_field::Grid;
use gfmd_green::{Base, Body, Layer, Material, normal_stiffness_range};

use crate::check::Worst;
use crate::reference::Row;
use crate::{Check, Reference, ValidationError};

const DIGITS: &str = "boundary-value problems in 60-digit arithmetic";

/// Relative error of a matrix entry.
const KERNEL: f64 = 2e-14;

pub(crate) fn checks(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    Ok(vec![
        two_dimensions(reference)?.check("bonded slab, plane strain: K, G, rho", DIGITS, KERNEL),
        three_dimensions(reference)?.check("bonded slab, any wave vector: K, G", DIGITS, KERNEL),
        limits(reference)?.check("half-space, uniform mode, elastic constants", DIGITS, KERNEL),
        other_bases(reference)?.check("slab on a sliding base, plate: K, G_zz", DIGITS, KERNEL),
        layer(reference)?.check("layer with two faces: L", DIGITS, KERNEL),
        coating(reference)?.check("layer on a half-space: K, G_zz", DIGITS, KERNEL),
        softest_mode(reference)?.check("softest frictionless mode of a slab", DIGITS, KERNEL),
        finite_elements(reference)?,
    ])
}

fn slab(row: &Row) -> Result<Body, ValidationError> {
    Ok(Body::slab(row.material()?, row.get("zm"))?)
}

fn two_dimensions(reference: &Reference) -> Result<Worst, ValidationError> {
    let mut worst = Worst::new();
    for row in reference.table("slab_kernel_2d.json")? {
        let (body, q) = (slab(&row)?, row.get("q"));
        let (k, g) = (body.stiffness_blocks(q), body.compliance_blocks(q));
        let (right, left) = (body.plane_stiffness(q), body.plane_stiffness(-q));
        for (name, found) in [
            ("KL", k.longitudinal),
            ("Kc", k.coupling[0]),
            ("Kc", right[0][1].im),
            ("Kc", left[1][0].im),
            ("KN", k.normal),
            ("KT", k.transverse),
            ("GL", g.longitudinal),
            ("Gc", g.coupling[1]),
            ("Gc", body.plane_compliance(q)[1][0].im),
            ("GN", g.normal),
            ("GN", body.normal_compliance(q)),
            ("rho", body.lateral_ratio(q)),
            ("invKN", 1.0 / body.restricted_normal_stiffness(q)),
        ] {
            worst.compare(found, row.get(name));
        }
    }
    Ok(worst)
}

fn three_dimensions(reference: &Reference) -> Result<Worst, ValidationError> {
    let mut worst = Worst::new();
    for row in reference.table("slab_kernel_3d.json")? {
        let (body, q) = (slab(&row)?, [row.get("qx"), row.get("qy")]);
        for (letter, m) in [("K", body.stiffness(q)), ("G", body.compliance(q))] {
            for (name, found) in
                [("xx", m[0][0].re), ("xy", m[0][1].re), ("xy", m[1][0].re), ("yy", m[1][1].re), ("zz", m[2][2].re)]
            {
                let wanted = row.get(&format!("{letter}{name}"));
                // Entry xy is the difference of two values that are equal at ν = 0, so its error is relative to entry
                // xx.
                worst.compare_to(found, wanted, if name == "xy" { m[0][0].re } else { wanted.abs() });
            }
            for (name, found) in [("xz", m[0][2]), ("xz", m[2][0].conj()), ("yz", m[1][2]), ("yz", m[2][1].conj())] {
                worst.compare(found.im, row.get(&format!("Im{letter}{name}")));
            }
        }
    }
    Ok(worst)
}

fn limits(reference: &Reference) -> Result<Worst, ValidationError> {
    let mut worst = Worst::new();
    for row in reference.table("slab_limits.json")? {
        let (material, body, q) = (row.material()?, slab(&row)?, row.get("q"));
        let half_space = Body::half_space(material);
        let k = half_space.stiffness_blocks(q);
        let uniform = body.stiffness([0.0, 0.0]);
        for (name, found) in [
            ("C44", material.shear_modulus()),
            ("s", material.s()),
            ("r", material.r()),
            ("Estar", material.contact_modulus()),
            ("KL_inf", k.longitudinal),
            ("Kc_inf", k.coupling[0]),
            ("KN_inf", k.normal),
            ("KT_inf", k.transverse),
            ("Gzz_inf", half_space.normal_compliance(q)),
            ("K0_lat", uniform[0][0].re),
            ("K0_lat", uniform[1][1].re),
            ("G0_norm", body.normal_compliance(0.0)),
            ("G0_norm", body.compliance([0.0, 0.0])[2][2].re),
        ] {
            worst.compare(found, row.get(name));
        }
        // The file has no entry where a value is infinite.
        let infinite = |wanted: f64| if wanted.is_nan() { f64::INFINITY } else { wanted };
        worst.compare(material.p_wave_modulus().unwrap_or(f64::INFINITY), infinite(row.get("C11")));
        worst.compare(uniform[2][2].re, infinite(row.get("K0_norm")));
    }
    Ok(worst)
}

fn other_bases(reference: &Reference) -> Result<Worst, ValidationError> {
    let mut worst = Worst::new();
    for row in reference.table("slab_other_bases.json")? {
        let q = row.get("q");
        for (suffix, base) in [("slide", Base::SLIDING), ("free", Base::FREE)] {
            let body = slab(&row)?.on(base)?;
            let k = body.stiffness_blocks(q);
            for (name, found) in [
                ("KL", k.longitudinal),
                ("Kc", k.coupling[0]),
                ("KN", k.normal),
                ("Gzz", body.normal_compliance(q)),
                ("Gzz", body.compliance_blocks(q).normal),
            ] {
                worst.compare(found, row.get(&format!("{name}_{suffix}")));
            }
            worst.compare(k.transverse, row.get("KT_tanh"));
        }
    }
    Ok(worst)
}

fn layer(reference: &Reference) -> Result<Worst, ValidationError> {
    let mut worst = Worst::new();
    for row in reference.table("layer_matrix_4x4.json")? {
        let (layer, q) = (Layer::new(row.material()?, row.get("d"))?, row.get("q"));
        let (l, reversed) = (layer.plane_matrix(q), layer.plane_matrix(-q));
        for (name, found) in [
            ("L11", l[0][0].re),
            ("L11", l[2][2].re),
            ("ImL12", l[0][1].im),
            ("ImL12", -l[1][0].im),
            ("ImL12", -l[2][3].im),
            ("ImL12", -reversed[0][1].im),
            ("L22", l[1][1].re),
            ("L22", l[3][3].re),
            ("L13", l[0][2].re),
            ("L13", l[2][0].re),
            ("ImL14", l[0][3].im),
            ("ImL14", -l[3][0].im),
            ("ImL23", l[1][2].im),
            ("ImL23", -l[2][1].im),
            ("ImL23", -reversed[1][2].im),
            ("L24", l[1][3].re),
            ("L24", l[3][1].re),
            ("ImL34", l[2][3].im),
            ("ST", layer.top_blocks(q).transverse),
            ("ST", layer.bottom_blocks(q).transverse),
            ("SB", layer.cross_blocks(q).transverse),
        ] {
            worst.compare(found, row.get(name));
        }
    }
    Ok(worst)
}

fn coating(reference: &Reference) -> Result<Worst, ValidationError> {
    let mut worst = Worst::new();
    for row in reference.table("coated_halfspace.json")? {
        let substrate = Body::half_space(Material::from_young(row.get("E2"), row.get("nu2"))?);
        let coating = Material::from_young(row.get("E1"), row.get("nu1"))?;
        let body = Body::slab(coating, row.get("d"))?.bonded_to(substrate)?;
        let k = body.stiffness_blocks(row.get("q"));
        for (name, found) in [
            ("KL", k.longitudinal),
            ("Kc", k.coupling[0]),
            ("KN", k.normal),
            ("KT", k.transverse),
            ("Gzz", body.normal_compliance(row.get("q"))),
        ] {
            worst.compare(found, row.get(name));
        }
    }
    Ok(worst)
}

fn softest_mode(reference: &Reference) -> Result<Worst, ValidationError> {
    let mut worst = Worst::new();
    for row in reference.table("softest_mode.json")? {
        let material = Material::from_young(1.0, row.get("nu"))?;
        let body = Body::slab(material, 1.0)?;
        let at_minimum = row.get("h_at_minimum (0 = uniform mode)");
        // The mode (0, 1) of this cell is the softest one.
        let length = if at_minimum > 0.0 { TAU / at_minimum } else { 3.0 };
        let softest = normal_stiffness_range(&body, &Grid::square(16, length)?);
        let (stiffness, wavenumber) =
            softest.map_or([f64::NAN; 2].into(), |range| (range.softest, range.softest_mode.wavenumber()));
        worst.compare(stiffness * material.p_wave_compliance(), row.get("min (1/Gzz)/(C11/zm)"));
        worst.compare(wavenumber, at_minimum);
        // It is a minimum: modes nearby are not softer.
        for nearby in [0.999, 1.001] {
            let softer = stiffness - body.normal_stiffness((at_minimum + 1e-3) * nearby);
            worst.compare_to(softer.max(0.0), 0.0, stiffness);
        }
    }
    Ok(worst)
}

/// Compares with a table of finite elements.
fn finite_elements(reference: &Reference) -> Result<Check, ValidationError> {
    /// Largest change in the last refinement of the finite elements, a measure of their accuracy.
    const CHANGE: f64 = 7e-12;
    let file = reference.json("stiffness_table.json")?;
    let mut worst = Worst::new();
    for row in file["rows"].as_array().into_iter().flatten() {
        let get = |name: &str| row[name].as_f64().unwrap_or(f64::NAN);
        let body = Body::slab(Material::from_young(2.0 * (1.0 + get("nu")), get("nu"))?, 1.0)?;
        let k = body.stiffness_blocks(get("q_zm"));
        for (name, found) in [
            ("kLL", k.longitudinal),
            ("kLz", k.coupling[0]),
            ("kzz", k.normal),
            ("kTT", k.transverse),
            ("compliance_zz_shear_free", body.normal_compliance(get("q_zm"))),
        ] {
            // The coupling passes through zero; its error is relative to the longitudinal entry.
            worst.compare_to(found, get(name), if name == "kLz" { k.longitudinal } else { found });
        }
    }
    Ok(worst.check("bonded slab, any wavenumber: K, G_zz", "finite elements of high order", CHANGE))
}
