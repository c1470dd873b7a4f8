//! Report of a contact as text.

use std::fmt;

use gfmd_measure::GridLimit;
use gfmd_record::{Table, lines, table_of, with_limit};

use super::Report;
use crate::measuring::legends;
use crate::session::{list_files, print_note, print_sheet};
use gfmd_input::hardness::GivenHardness;

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.head)?;
        if let Some(hardness) = &self.head.hardness {
            let shares = self.loads.iter().map(|load| format!("{:.6}", load.number("plastic_fraction")));
            let hardness = match hardness {
                GivenHardness::Number(number) => self.head.read(*number, "stress", ""),
                GivenHardness::Field(given) => given.to_string(),
            };
            writeln!(f, "hardness {hardness}, plastic fractions {}\n", shares.collect::<Vec<_>>().join(", "))?;
        }
        let units = self.head.units();
        let remark = |line: usize| match line == 0 || self.loads[line - 1].is("converged") {
            true => String::new(),
            false => "  NOT CONVERGED".into(),
        };
        let sheet = |width| table_of(&self.loads, &[Table::State], &units, width);
        print_sheet(f, sheet, self.loads.len(), |_| String::new(), remark)?;
        let upper = if self.head.lower.is_some() { "upper face\n" } else { "" };
        for (title, table) in [("lower face\n", Table::LowerFace), (upper, Table::Patches), (upper, Table::Flow)] {
            let sheet = table_of(&self.loads, &[table], &units, f.width());
            if !sheet.lines.is_empty() {
                write!(f, "\n{title}")?;
                print_sheet(f, |_| sheet, 0, |_| String::new(), |_| String::new())?;
                legends(table, &self.loads).into_iter().try_for_each(|legend| print_note(f, legend))?;
            }
        }
        self.threshold(f)?;
        lines(&self.loads, ["load", "loads"], |_| true).iter().try_for_each(|line| print_note(f, line))?;
        for used in self.accuracy.iter().flat_map(|accurate| &accurate.grids) {
            writeln!(f, "grid: {used}")?;
        }
        list_files(f, self.vtk.as_deref(), &[])?;
        list_files(f, self.export_law.as_deref(), &[])?;
        list_files(f, self.out.as_deref(), &self.plots)
    }
}

impl Report {
    /// Writes the lines of `--flow-threshold`.
    fn threshold(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (axis, found) in ["x", "y"].iter().zip(self.flow_threshold.iter().flatten()) {
            match found {
                Some(found) => {
                    let names = ["p_star", "area_fraction", "area_fraction_corrected"];
                    let [[p, q], [a, b], [c, d]] = names.map(|name| found.of(name));
                    writeln!(
                        f,
                        "\nthe flow along {axis} stops between p* = {p:.5e} and {q:.5e}, area {a:.4} and {b:.4} \
                         (corrected {c:.4} and {d:.4})"
                    )?;
                    if let Some(GridLimit { limit, half_width }) = found.limit_of("p_star") {
                        let limit = with_limit(limit, limit, half_width);
                        writeln!(f, "on an infinitely fine grid: p* = {limit}")?;
                    }
                }
                None => writeln!(f, "\nthe flow along {axis} does not stop between the lowest and the highest load")?,
            }
        }
        Ok(())
    }
}
