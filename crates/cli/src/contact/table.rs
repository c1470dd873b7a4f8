//! The report of a contact in words and numbers.

use std::fmt;

use gfmd_record::{Record, lines};

use super::Report;
use crate::session::list_files;
use gfmd_report::digits::uncertain;

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.head)?;
        if let Some(hardness) = &self.head.hardness {
            let shares = self.loads.iter().map(|load| format!("{:.6}", load.number("plastic_fraction")));
            writeln!(f, "hardness {hardness}, plastic fractions {}\n", shares.collect::<Vec<_>>().join(", "))?;
        }
        writeln!(
            f,
            "{:>11} {:>11} {:>11} {:>9} {:>9} {:>7} {:>11} {:>11} {:>11} {:>7} {:>8} {:>9}",
            "pressure",
            "p*",
            "approach",
            "area",
            "corrected",
            "kappa",
            "mean gap",
            "peak p",
            "stiffness",
            "steps",
            "pairs",
            "residual"
        )?;
        for load in &self.loads {
            writeln!(
                f,
                "{:>11.4e} {:>11.4e} {:>11.4e} {:>9.6} {:>9.6} {:>7.4} {:>11.4e} {:>11.4e} {:>11.4e} {:>7} {:>8.1} {:>9.1e}{}",
                load.number("mean_pressure"),
                load.number("p_star"),
                load.number("displacement"),
                load.number("area_fraction"),
                load.number("area_fraction_corrected"),
                load.number("kappa"),
                load.number("mean_gap"),
                load.number("max_pressure"),
                load.number("stiffness"),
                load.number("iterations"),
                load.number("transform_pairs"),
                load.worst(),
                if load.is("converged") { "" } else { "  NOT CONVERGED" }
            )?;
        }
        self.lower_face(f)?;
        self.statistics(f)?;
        for line in lines(&self.loads, ["load", "loads"], |_| true) {
            writeln!(f, "{line}")?;
        }
        list_files(f, self.vtk.as_deref(), &[])?;
        list_files(f, self.out.as_deref(), &self.plots)
    }
}

impl Report {
    /// The lines of the lower face.
    fn lower_face(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.head.lower.is_some() {
            let head = ["p*", "approach", "area", "corrected", "mean gap", "peak p", "residual"];
            let [p, approach, area, corrected, gap, peak, residual] = head;
            writeln!(
                f,
                "\nlower face\n{p:>11} {approach:>11} {area:>9} {corrected:>9} {gap:>11} {peak:>11} {residual:>9}"
            )?;
        }
        for load in &self.loads {
            if !load.has("lower_mean_gap") {
                continue;
            }
            writeln!(
                f,
                "{:>11.4e} {:>11.4e} {:>9.6} {:>9.6} {:>11.4e} {:>11.4e} {:>9.1e}",
                load.number("p_star"),
                load.number("lower_displacement"),
                load.number("lower_area_fraction"),
                load.number("lower_area_fraction_corrected"),
                load.number("lower_mean_gap"),
                load.number("lower_max_pressure"),
                load.worst_of("lower_residual")
            )?;
        }
        Ok(())
    }

    /// The lines of `--statistics` and `--flow`.
    fn statistics(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let yes = |load: &Record, name: &str| match ["x", "y"].map(|axis| load.is(&format!("{name}_{axis}"))) {
            [true, true] => "x, y",
            [true, false] => "x",
            [false, true] => "y",
            _ => "-",
        };
        if self.loads.iter().any(|load| load.has("patches")) {
            writeln!(f, "\n{:>11} {:>9} {:>11} {:>10} {:>11}", "p*", "patches", "largest", "percolate", "conductance")?;
        }
        for load in &self.loads {
            if !load.has("patches") {
                continue;
            }
            writeln!(
                f,
                "{:>11.4e} {:>9} {:>11.6} {:>10} {:>11.4e}",
                load.number("p_star"),
                load.number("patches"),
                load.number("largest_patch_fraction"),
                yes(load, "percolates"),
                load.number("conductance")
            )?;
        }
        if self.loads.iter().any(|load| load.has("flow_xx")) {
            let [xx, yy, xy] = ["flow xx", "flow yy", "flow xy"];
            let limit = "fine grid";
            writeln!(f, "\n{:>11} {xx:>8} {limit:>12} {yy:>8} {limit:>12} {xy:>8} {:>10}", "p*", "percolate")?;
        }
        for load in &self.loads {
            if !load.has("flow_xx") {
                continue;
            }
            let [xx, xy, yy] = ["xx", "xy", "yy"].map(|of| load.number(&format!("flow_{of}")));
            let limit =
                |of: &str| uncertain(load.number(&format!("{of}_limit")), load.number(&format!("{of}_limit_error")));
            let ([along_x, along_y], through) = (["flow_xx", "flow_yy"].map(limit), yes(load, "flow_percolates"));
            writeln!(
                f,
                "{:>11.4e} {xx:>8.1e} {along_x:>12} {yy:>8.1e} {along_y:>12} {xy:>8.1e} {through:>10}",
                load.number("p_star")
            )?;
        }
        for (axis, found) in ["x", "y"].iter().zip(self.flow_threshold.iter().flatten()) {
            match found {
                Some(found) => writeln!(
                    f,
                    "\nthe flow along {axis} stops between p* = {:.5e} and {:.5e}, area {:.4} and {:.4} (corrected {:.4} and {:.4})",
                    found.p_star[0],
                    found.p_star[1],
                    found.area_fraction[0],
                    found.area_fraction[1],
                    found.area_fraction_corrected[0],
                    found.area_fraction_corrected[1]
                )?,
                None => writeln!(f, "\nthe flow along {axis} does not stop between the lowest and the highest load")?,
            }
        }
        Ok(())
    }
}
