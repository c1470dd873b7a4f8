//! Law of the contact for finite elements, as a text file.

use std::path::{Path, PathBuf};

use clap::Args as ClapArgs;
use gfmd_contact::Boundary;
use gfmd_files::Output;
use gfmd_input::base::MovedBase;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_law::LawKind;
use gfmd_problem::options::Options;
use gfmd_problem::{key, setting, words};
use gfmd_report::contact_law::{ContactLaw, LawFormat, Realisation};
use gfmd_run::series::Prepared;
use gfmd_vector::contiguous;

use super::{Args, Report};

/// Flags of the law.
#[derive(ClapArgs, Options, Clone, Debug, PartialEq)]
pub(super) struct LawFileArgs {
    /// Write pressure against mean gap, area, stiffness, conductance and transmissivity of all loads, in SI units, for
    /// finite elements: .csv (table), .inp (Abaqus keywords) or .mac (ANSYS tables)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    export_law: Option<PathBuf>,
    /// Format of --export-law; overrides the file ending
    #[arg(long, value_parser = ["csv", "abaqus", "ansys"], requires = "export_law", help_heading = "Output")]
    export_law_format: Option<String>,
}

/// Law file to write.
pub(super) struct LawFile {
    /// File of the first process.
    output: Option<Output>,
    format: LawFormat,
}

const OPTION: &str = "export_law";

impl LawFile {
    /// Claims the path, if there is one, for this number of loads.
    ///
    /// # Errors
    /// Returns an error for a contact without a law, an unknown ending, or a path that cannot be written.
    pub(super) fn claim(
        args: &Args,
        prepared: &Prepared,
        loads: usize,
        session: &Session,
    ) -> Result<Option<Self>, Failure> {
        let Some(path) = &args.law_file.export_law else { return Ok(None) };
        let format = args.law_file.format(path)?;
        let surface = &prepared.surface;
        let refused = |allowed: gfmd_problem::Words| Err(Failure::value(key(OPTION), path.display(), allowed));
        if surface.grid.is_line() {
            return refused("left out of a profile: a law of an interface needs a surface".into());
        }
        if surface.boundary == Boundary::Free {
            return refused(words!["left out with ", setting("boundary", "free"), ": a law is of an endless surface"]);
        }
        if args.problem.law.law != LawKind::HardWall {
            return refused(words!["left out with an attraction (", key("law"), ")"]);
        }
        if prepared.lower.is_some() {
            return refused("left out between two surfaces, which have two interfaces".into());
        }
        if loads < 2 {
            return refused(format!("given with two or more loads (there is {loads})").into());
        }
        if surface.units().metres().zip(surface.units().pascals()).is_none() {
            let example = [setting("unit", "um"), setting("young", "70GPa")];
            let [unit, young] = example;
            return refused(words!["given with units, such as ", unit, " and ", young]);
        }
        let output = session.is_first().then(|| Output::claim(path)).transpose();
        Ok(Some(Self { output: output.map_err(|error| Failure::input(key(OPTION), error))?, format }))
    }

    /// Writes the law of the solved loads; the first of several processes does. Returns the file.
    ///
    /// # Errors
    /// Returns an error if the loads have no law, or if the file cannot be written.
    pub(super) fn write(&self, report: &Report, prepared: &Prepared) -> Result<Option<PathBuf>, Failure> {
        let (heights, share) =
            (MovedBase::under(prepared.base.as_ref(), &prepared.surface.heights), &prepared.surface.share);
        let first_gap = prepared.highest() - share.total_of(&contiguous(&heights)) / share.total() as f64;
        let Some(output) = &self.output else { return Ok(None) };
        let realisation = Realisation::of(&report.loads, first_gap);
        let law = ContactLaw::new(&[realisation], &prepared.surface.units());
        let law = law.map_err(|reason| Failure::input(key(OPTION), reason))?;
        let heading = format!("gfmd {}: {}", env!("CARGO_PKG_VERSION"), prepared.surface.description);
        let text = law.text(self.format, &heading);
        output.write(|file| std::io::Write::write_all(file, text.as_bytes()))?;
        Ok(Some(output.path().to_owned()))
    }
}

impl LawFileArgs {
    fn format(&self, path: &Path) -> Result<LawFormat, Failure> {
        if let Some(format) = self.export_law_format.as_deref().and_then(LawFormat::named) {
            return Ok(format);
        }
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        LawFormat::of_ending(ending).ok_or_else(|| {
            let allowed = words!["NAME.csv, NAME.inp or NAME.mac, or ", key("export_law_format"), " must be given"];
            Failure::value(key(OPTION), path.display(), allowed)
        })
    }
}
