//! Check of a file of fields below a surface.

use std::path::{Path, PathBuf};

use super::Args;
use super::quantity::{TENSOR, TENSOR_OF_A_LINE};
use crate::checking::{Checked, Checking};
use gfmd_check::result::{Comparison, printable};
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_input::source::file_of;

impl Checked for Args {
    /// Compares the mean of σ_xz, σ_yz, σ_zz on every plane of a file with the mean traction on the surface.
    fn check(Checking { reader, .. }: Checking, comparison: &mut Comparison) -> Result<(), Failure> {
        const MEAN: &str = "/fields/mean_traction";
        const STRESS: &str = "/fields/stress";
        // An older file has no mean traction; a row of points has another mean than its plane.
        if !reader.contains(MEAN) || !reader.contains(STRESS) || reader.text("/fields", "slice").is_ok() {
            return Ok(());
        }
        let wanted: Vec<f64> = reader.values(MEAN)?;
        let shape = reader.shape(STRESS)?;
        let (planes, components) = (shape.first().copied().unwrap_or(0), shape.last().copied().unwrap_or(0));
        let columns: Vec<&str> = match components {
            4 => TENSOR_OF_A_LINE.map(|component| TENSOR[component]).to_vec(),
            _ => TENSOR.to_vec(),
        };
        let names: &[&str] = if components == 4 { &["xz", "zz"] } else { &["xz", "yz", "zz"] };
        for plane in 0..planes {
            let stress: Vec<f64> = reader.slab(STRESS, plane)?;
            let scale = stress.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
            let mean = |name: &&str| {
                let column = columns.iter().position(|column| column == name).unwrap_or(0);
                let values = stress.iter().skip(column).step_by(components.max(1));
                values.sum::<f64>() / (stress.len() / components.max(1)) as f64
            };
            comparison.values("/fields/stress (mean)", &names.iter().map(mean).collect::<Vec<f64>>(), &wanted, scale);
        }
        Ok(())
    }

    /// Returns the problem of a file, if the displacement of the surface is available.
    fn repeated(Checking { reader, config, session, .. }: Checking) -> Result<Option<Self>, Failure> {
        let mut named = toml::Table::new();
        // Waves have no file.
        if let Some(surface) = config.file() {
            // Names used for an array or a contact in memory, which have no checksum.
            if matches!(surface, "array" | "contact") && reader.text("/input", "file").is_err() {
                let text = "the input was in memory, so that the fields cannot be computed again";
                session.warn("input-missing", text);
                return Ok(None);
            }
            let (file, input) = (file_of(surface), reader.text("/input", "file")?);
            // Only the input with a checksum is opened, and only as a regular file.
            if file != input {
                let text = format!("surface is {file:?}; it must be the input {input:?} of the file");
                return Err(Failure::input("config of the file", text));
            }
            if !Path::new(file).exists() {
                let text = format!(
                    "the input {} is not there, so that the fields cannot be computed again",
                    printable(&input)
                );
                session.warn("input-missing", text);
                return Ok(None);
            }
            named.insert("surface".into(), surface.into());
        }
        config.problem(&[], named).map(Some)
    }

    fn write(self, out: PathBuf, session: &Session) -> Result<(), Failure> {
        super::run(&Self { out: Some(out), ..self }, session).map(|_| ())
    }
}
