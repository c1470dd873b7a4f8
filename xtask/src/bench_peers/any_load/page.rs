//! Tables and page of `--any-load`.

use std::fmt::{self, Write as _};

use super::{AnyLoad, Block, Cell, Row, Table};

/// Relative pressure difference (rms) above which it is reported in per cent.
const OFF: f64 = 1e-3;

impl fmt::Display for Cell {
    /// Writes effort and certified residual, or the problem.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Some(verdict) = &self.verdict else {
            let said = self.said.as_deref().unwrap_or("no pressure");
            return f.write_str(if said.contains("longer than") { "✗ too long" } else { "✗ fails" });
        };
        if self.certified {
            match (self.transform_pairs, self.iterations) {
                (Some(pairs), _) => write!(f, "{pairs:.0}")?,
                (None, Some(iterations)) => write!(f, "{iterations} it.")?,
                (None, None) => f.write_str("?")?,
            }
            return write!(f, ", {:.0e}", verdict.worst());
        }
        write!(f, "✗ {:.0e}", verdict.worst())?;
        if verdict.differs.pressure > OFF { write!(f, ", {} off", per_cent(verdict.differs.pressure)) } else { Ok(()) }
    }
}

/// Formats a fraction in per cent with two digits.
fn per_cent(fraction: f64) -> String {
    let number = 100.0 * fraction;
    match number {
        ..0.1 => format!("{number:.1e} %"),
        ..10.0 => format!("{number:.1} %"),
        ..1000.0 => format!("{number:.0} %"),
        _ => format!("{number:.0e} %"),
    }
}

impl Block {
    fn words(&self) -> String {
        let hardness = self.kind.hardness.map_or_else(String::new, |hardness| format!(", hardness {hardness} E\\*"));
        format!("{} boundaries{hardness}, H = {}", self.kind.boundary, self.hurst)
    }

    fn table(&self, title: &str, cell: impl Fn(&Cell) -> String) -> Table {
        let head = ["p*", "contact"].map(str::to_owned).into_iter().chain(self.contestants.iter().cloned());
        let row = |row: &Row| {
            let contact = row.contact.map_or_else(|| "?".into(), per_cent);
            [row.p_star.to_string(), contact].into_iter().chain(row.cells.iter().map(&cell)).collect()
        };
        Table {
            title: format!("{title}: {}", self.words()),
            head: head.collect(),
            rows: self.rows.iter().map(row).collect(),
        }
    }
}

impl AnyLoad {
    /// Returns the number of loads with a certified result of each contestant, for each kind of contact.
    fn summary(&self) -> Table {
        let mut names: Vec<&String> = Vec::new();
        for name in self.blocks.iter().flat_map(|block| &block.contestants) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let head = self.blocks.iter().map(Block::words);
        let count = |name: &String, block: &Block| {
            let Some(place) = block.contestants.iter().position(|other| other == name) else { return "-".into() };
            let certified = block.rows.iter().filter(|row| row.cells[place].certified).count();
            format!("{certified}/{}", block.rows.len())
        };
        let row = |name: &&String| {
            std::iter::once((*name).clone()).chain(self.blocks.iter().map(|block| count(name, block))).collect()
        };
        Table {
            title: "Loads with a certified result".into(),
            head: std::iter::once(String::new()).chain(head).collect(),
            rows: names.iter().map(row).collect(),
        }
    }

    pub(super) fn tables(&self) -> Vec<Table> {
        let (title, timed) =
            if self.timed { ("Effort, certificate, seconds", true) } else { ("Effort and certificate", false) };
        let cell = |cell: &Cell| match cell.seconds {
            Some(seconds) if timed && cell.certified => format!("{cell}, {seconds:.3}"),
            _ => cell.to_string(),
        };
        let blocks = self.blocks.iter().map(|block| block.table(title, cell));
        std::iter::once(self.summary()).chain(blocks).collect()
    }

    /// Returns the results that are not certified, one line per contestant and surface.
    pub(super) fn failures(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for block in &self.blocks {
            for (place, name) in block.contestants.iter().enumerate() {
                let cells: Vec<(f64, &Cell)> = block.rows.iter().map(|row| (row.p_star, &row.cells[place])).collect();
                let failed: Vec<String> = cells.iter().filter(|(_, cell)| !cell.certified).map(reported).collect();
                if !failed.is_empty() {
                    lines.push(format!("{name}, {}: {}", block.words(), failed.join("; ")));
                }
            }
        }
        lines
    }

    pub(in crate::bench_peers) fn page(&self) -> String {
        let Self { date, machine, commit, points, seed, tolerance, patience, .. } = self;
        let versions: Vec<String> = self.versions.iter().map(|(name, version)| format!("{name} {version}")).collect();
        let (versions, short) = (versions.join(", "), commit.get(..12).unwrap_or(commit));
        let flag = if self.timed { "" } else { " --without-times" };
        let seconds = if self.timed { ", and the seconds of the solution" } else { "" };
        let busy = if self.timed {
            ""
        } else {
            "The machine was busy with other work, so that times are left out, and the effective \
             time limit is shorter than stated.\n\n"
        };
        let mut page = format!(
            "<!-- Written by `cargo xtask bench-peers --any-load{flag} --write-docs`; change \
             xtask/src/bench_peers/any_load instead. -->\n\
             # Any load: what each program reaches\n\n\
             Loads from first touch to full contact that each program solves with a certified result, with periodic \
             and free\n\
             boundaries and with a hardness. [Benchmarks](benchmarks.md) has times on larger grids.\n\n\
             {date}. {machine}. Commit {short}. {versions}.\n\n\
             {points} x {points} points, E\\* = 1, self-affine surfaces with rms gradient 0.1, 1/ε_t = 2, 1/ε_c = 4 \
             ([glossary](glossary.md)), seed {seed}. A cell has the transform pairs (iterations, it., if a program \
             counts only them), the residual of the pressure by the certificate below, at most \
             {tolerance:e}{seconds}; every second load of the first H is shown. ✗: not certified, with the residual \
             reached and the deviation of the pressure (rms, relative to gfmd, if above 0.1 %), or no result within \
             {patience} s.\n\n{busy}"
        );
        for note in &self.notes {
            let _ = writeln!(page, "> {note}\n");
        }
        // The first table counts all loads; each other one is of a block.
        for (number, mut table) in self.tables().into_iter().enumerate() {
            if number > 0 {
                if self.blocks[number - 1].hurst != self.blocks[0].hurst {
                    continue;
                }
                table.rows = table.rows.into_iter().step_by(2).collect();
            }
            let _ = writeln!(page, "{}", table.markdown());
        }
        page += include_str!("method.md");
        page
    }
}

/// Describes a load that is not certified in words.
fn reported((p_star, cell): &(f64, &Cell)) -> String {
    let said = cell.said.as_ref().map(|said| format!(" ({said})")).unwrap_or_default();
    match &cell.verdict {
        None => format!("p\\* = {p_star}: no result{said}"),
        Some(verdict) => format!(
            "p\\* = {p_star}: residual {:.0e}, pressure {} off{said}",
            verdict.worst(),
            per_cent(verdict.differs.pressure)
        ),
    }
}
