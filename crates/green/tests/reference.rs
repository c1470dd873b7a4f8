//! Every number of the reference files in data/reference that concerns this crate.

use std::f64::consts::TAU;

use gfmd_field::Grid;
use gfmd_green::{Base, Body, Layer, Material, normal_stiffness_range};
use num_complex::Complex64;

/// The rows of a reference file, with the names of their columns.
struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<Option<f64>>>,
}

impl Table {
    fn read(name: &str) -> Self {
        let json = read(name);
        let columns = json["columns"].as_array().unwrap().iter();
        let columns = columns.map(|c| c.as_str().unwrap_or_else(|| c["name"].as_str().unwrap()).to_owned());
        let rows = json["rows"].as_array().unwrap().iter();
        let rows = rows.map(|row| row.as_array().unwrap().iter().map(serde_json::Value::as_f64).collect());
        let table = Self { columns: columns.collect(), rows: rows.collect() };
        assert!(!table.rows.is_empty() && table.rows.iter().all(|row| row.len() == table.columns.len()));
        table
    }

    fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|values| Row { columns: &self.columns, values })
    }
}

struct Row<'a> {
    columns: &'a [String],
    values: &'a [Option<f64>],
}

impl Row<'_> {
    fn get(&self, column: &str) -> f64 {
        self.optional(column).unwrap_or_else(|| panic!("no number in column {column}"))
    }

    fn optional(&self, column: &str) -> Option<f64> {
        let index = self.columns.iter().position(|c| c == column);
        self.values[index.unwrap_or_else(|| panic!("no column {column}"))]
    }

    fn complex(&self, column: &str) -> Complex64 {
        Complex64::new(self.get(&format!("Re_{column}")), self.get(&format!("Im_{column}")))
    }

    fn material(&self) -> Material {
        Material::from_young(self.get("E"), self.get("nu")).unwrap()
    }
}

fn read(name: &str) -> serde_json::Value {
    let path = format!("{}/../../data/reference/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap()
}

/// The largest relative deviation met so far, and where.
#[derive(Default)]
struct Worst {
    error: f64,
    place: String,
    compared: usize,
}

impl Worst {
    /// Relative to the wanted number itself.
    fn compare(&mut self, what: &str, row: &Row, found: f64, wanted: f64) {
        self.compare_to(what, row, found, wanted, wanted.abs());
    }

    /// Relative to `scale`.
    fn compare_to(&mut self, what: &str, row: &Row, found: f64, wanted: f64, scale: f64) {
        self.compared += 1;
        let error = if found == wanted { 0.0 } else { (found - wanted).abs() / scale };
        if error.is_nan() || error > self.error {
            self.error = error;
            self.place = format!("{what}: found {found:e}, wanted {wanted:e} at {:?}", row.values);
        }
    }

    fn within(self, bound: f64) {
        assert!(self.compared > 0);
        assert!(self.error <= bound, "{:e} exceeds {bound:e} in {}", self.error, self.place);
    }
}

const KERNEL: f64 = 2e-14;

fn slab(row: &Row) -> Body {
    Body::slab(row.material(), row.get("zm")).unwrap()
}

#[test]
fn slab_kernels_in_two_dimensions() {
    let mut worst = Worst::default();
    for row in Table::read("slab_kernel_2d").rows() {
        let (body, q) = (slab(&row), row.get("q"));
        let (k, g) = (body.stiffness_blocks(q), body.compliance_blocks(q));
        for (name, found) in [
            ("KL", k.longitudinal),
            ("Kc", k.coupling[0]),
            ("KN", k.normal),
            ("KT", k.transverse),
            ("GL", g.longitudinal),
            ("Gc", g.coupling[1]),
            ("GN", g.normal),
            ("GN", body.normal_compliance(q)),
            ("rho", body.lateral_ratio(q)),
            ("invKN", 1.0 / body.restricted_normal_stiffness(q)),
        ] {
            worst.compare(name, &row, found, row.get(name));
        }
        let (right, left) = (body.plane_stiffness(q), body.plane_stiffness(-q));
        worst.compare("Kc", &row, right[0][1].im, row.get("Kc"));
        worst.compare("Kc", &row, left[1][0].im, row.get("Kc"));
        worst.compare("Gc", &row, body.plane_compliance(q)[1][0].im, row.get("Gc"));
    }
    worst.within(KERNEL);
}

#[test]
fn slab_kernels_in_three_dimensions() {
    let mut worst = Worst::default();
    for row in Table::read("slab_kernel_3d").rows() {
        let body = slab(&row);
        let q = [row.get("qx"), row.get("qy")];
        for (letter, m) in [("K", body.stiffness(q)), ("G", body.compliance(q))] {
            for (name, found) in [
                (format!("{letter}xx"), m[0][0].re),
                (format!("{letter}xy"), m[0][1].re),
                (format!("{letter}xy"), m[1][0].re),
                (format!("{letter}yy"), m[1][1].re),
                (format!("{letter}zz"), m[2][2].re),
                (format!("Im{letter}xz"), m[0][2].im),
                (format!("Im{letter}xz"), -m[2][0].im),
                (format!("Im{letter}yz"), m[1][2].im),
                (format!("Im{letter}yz"), -m[2][1].im),
            ] {
                // xy is the difference of two numbers that agree at ν = 0: it has the digits of its neighbours.
                let scale = if name.ends_with("xy") { m[0][0].re } else { row.get(&name).abs() };
                worst.compare_to(&name, &row, found, row.get(&name), scale);
            }
        }
    }
    worst.within(KERNEL);
}

#[test]
fn constants_and_limits() {
    let mut worst = Worst::default();
    for row in Table::read("slab_limits").rows() {
        let (material, q) = (row.material(), row.get("q"));
        let half_space = Body::half_space(material);
        let k = half_space.stiffness_blocks(q);
        let uniform = slab(&row).stiffness([0.0, 0.0]);
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
            ("G0_norm", slab(&row).normal_compliance(0.0)),
            ("G0_norm", slab(&row).compliance([0.0, 0.0])[2][2].re),
        ] {
            worst.compare(name, &row, found, row.get(name));
        }
        assert_eq!(material.p_wave_modulus().is_none(), row.optional("C11").is_none());
        match (material.p_wave_modulus(), row.optional("K0_norm")) {
            (Some(c11), Some(k0)) => {
                worst.compare("C11", &row, c11, row.get("C11"));
                worst.compare("K0_norm", &row, uniform[2][2].re, k0);
            }
            _ => assert_eq!(uniform[2][2].re, f64::INFINITY),
        }
    }
    worst.within(KERNEL);
}

#[test]
fn sliding_and_free_bases() {
    let mut worst = Worst::default();
    for row in Table::read("slab_other_bases").rows() {
        let q = row.get("q");
        for (suffix, base) in [("slide", Base::Sliding), ("free", Base::Free)] {
            let body = slab(&row).on(base).unwrap();
            let k = body.stiffness_blocks(q);
            for (name, found) in [
                (format!("KL_{suffix}"), k.longitudinal),
                (format!("Kc_{suffix}"), k.coupling[0]),
                (format!("KN_{suffix}"), k.normal),
                (format!("Gzz_{suffix}"), body.normal_compliance(q)),
                (format!("Gzz_{suffix}"), body.compliance_blocks(q).normal),
                ("KT_tanh".to_owned(), k.transverse),
            ] {
                worst.compare(&name, &row, found, row.get(&name));
            }
        }
    }
    worst.within(KERNEL);
}

#[test]
fn coated_half_space() {
    let mut worst = Worst::default();
    for row in Table::read("coated_halfspace").rows() {
        let substrate = Body::half_space(Material::from_young(row.get("E2"), row.get("nu2")).unwrap());
        let coating = Material::from_young(row.get("E1"), row.get("nu1")).unwrap();
        let body = Body::slab(coating, row.get("d")).unwrap().bonded_to(substrate).unwrap();
        let k = body.stiffness_blocks(row.get("q"));
        for (name, found) in [
            ("KL", k.longitudinal),
            ("Kc", k.coupling[0]),
            ("KN", k.normal),
            ("KT", k.transverse),
            ("Gzz", body.normal_compliance(row.get("q"))),
        ] {
            worst.compare(name, &row, found, row.get(name));
        }
    }
    worst.within(KERNEL);
}

#[test]
fn layer_matrix() {
    let mut worst = Worst::default();
    for row in Table::read("layer_matrix_4x4").rows() {
        let layer = Layer::new(row.material(), row.get("d")).unwrap();
        let q = row.get("q");
        let (l, reversed) = (layer.plane_matrix(q), layer.plane_matrix(-q));
        let cross = layer.cross_blocks(q);
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
            ("SB", cross.transverse),
        ] {
            worst.compare(name, &row, found, row.get(name));
        }
    }
    worst.within(KERNEL);
}

const BODY: f64 = 5e-14;

#[test]
fn transfer_into_the_body() {
    let mut worst = Worst::default();
    for row in Table::read("body_transfer").rows() {
        let body = Body::slab(Material::from_young(1.0, row.get("nu")).unwrap(), row.get("zm")).unwrap();
        let (z, q) = (row.get("z"), row.get("q"));
        let by_height = body.at_height(z).unwrap();
        let by_depth = body.at_depth(row.get("zm") - z).unwrap();
        for section in [by_height, by_depth] {
            let t = section.displacement_transfer([0.0, q]);
            for (name, found) in [
                ("Txx", t[1][1].re),
                ("ImTxz", t[1][2].im),
                ("ImTzx", t[2][1].im),
                ("Tzz", t[2][2].re),
                ("Ttt", t[0][0].re),
            ] {
                worst.compare(name, &row, found, row.get(name));
            }
        }
    }
    worst.within(BODY);
}

#[test]
fn fields_in_the_body() {
    let mut worst = Worst::default();
    for row in Table::read("body_fields").rows() {
        let body = slab(&row);
        let section = body.at_height(row.get("z")).unwrap();
        let [qx, qy] = [row.get("qx"), row.get("qy")];
        let surface = ["us_x", "us_y", "us_z"].map(|name| row.complex(name));
        let of_surface = |entries: &[Complex64; 3]| entries.iter().zip(surface).map(|(e, u)| e * u).sum::<Complex64>();
        let u = section.displacement_transfer([qx, qy]).each_ref().map(of_surface);
        let stress = section.stress_transfer([qx, qy]).each_ref().map(of_surface);
        let (material, i) = (row.material(), Complex64::I);
        let shear = material.shear_modulus();
        let (exx, eyy) = (i * qx * u[0], i * qy * u[1]);
        let ezz = stress[2] * material.p_wave_compliance() - (1.0 - 2.0 * material.s()) * (exx + eyy);
        let fields = [
            ("ux", u[0]),
            ("uy", u[1]),
            ("uz", u[2]),
            ("exx", exx),
            ("eyy", eyy),
            ("ezz", ezz),
            ("gyz", stress[3] / shear),
            ("gxz", stress[4] / shear),
            ("gxy", stress[5] / shear),
            ("sxx", stress[0]),
            ("syy", stress[1]),
            ("szz", stress[2]),
            ("syz", stress[3]),
            ("sxz", stress[4]),
            ("sxy", stress[5]),
        ];
        for (name, found) in fields {
            let wanted = row.complex(name);
            worst.compare_to(name, &row, (found - wanted).norm(), 0.0, wanted.norm().max(f64::MIN_POSITIVE));
        }
    }
    worst.within(BODY);
}

#[test]
fn softest_mode() {
    let mut worst = Worst::default();
    for row in Table::read("softest_mode").rows() {
        let material = Material::from_young(1.0, row.get("nu")).unwrap();
        let body = Body::slab(material, 1.0).unwrap();
        let at_minimum = row.get("h_at_minimum (0 = uniform mode)");
        // The mode (0, 1) of this cell is the softest there is.
        let length = if at_minimum > 0.0 { TAU / at_minimum } else { 3.0 };
        let softest = normal_stiffness_range(&body, &Grid::square(16, length).unwrap()).unwrap();
        let ratio = softest.softest * material.p_wave_compliance();
        worst.compare("minimum", &row, ratio, row.get("min (1/Gzz)/(C11/zm)"));
        if at_minimum > 0.0 {
            assert_eq!(softest.softest_mode.wavenumber(), TAU / length);
            for nearby in [0.999, 1.001] {
                assert!(body.normal_stiffness(at_minimum * nearby) > softest.softest);
            }
        } else {
            assert!(softest.softest_mode.is_uniform());
        }
    }
    worst.within(KERNEL);
}

/// Made numerically: the file is as good as the largest change of its last refinement.
#[test]
fn stiffness_by_finite_elements() {
    let table = read("stiffness_table");
    let rows = table["rows"].as_array().unwrap();
    let changes = rows.iter().map(|row| row["rel_change_p10_p12"].as_f64().unwrap());
    let bound = changes.fold(0.0, f64::max);
    assert!(rows.len() > 10 && bound < 1e-11);
    for row in rows {
        let get = |name: &str| row[name].as_f64().unwrap();
        let young = 2.0 * (1.0 + get("nu"));
        let body = Body::slab(Material::from_young(young, get("nu")).unwrap(), 1.0).unwrap();
        let k = body.stiffness_blocks(get("q_zm"));
        for (name, found) in [
            ("kLL", k.longitudinal),
            ("kLz", k.coupling[0]),
            ("kzz", k.normal),
            ("kTT", k.transverse),
            ("compliance_zz_shear_free", body.normal_compliance(get("q_zm"))),
        ] {
            // The coupling passes through zero, where its error is that of the matrix.
            let scale = if name == "kLz" { k.longitudinal } else { found };
            let error = ((found - get(name)) / scale).abs();
            assert!(error <= bound, "{name}: {error:e} exceeds {bound:e} at {row}");
        }
    }
}
