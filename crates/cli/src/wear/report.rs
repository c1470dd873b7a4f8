//! Printed report of wear.

use std::fmt;
use std::path::PathBuf;

use gfmd_record::{Record, lines};
use serde::Serialize;

use crate::course::{error_of_losses, print_flow, print_steps};
use crate::session::list_files;
use gfmd_input::memory::peak_bytes;
use gfmd_run::convergence::NotConverged;
use gfmd_run::series::Head;

/// Printed result.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    #[serde(flatten)]
    pub head: Head,
    /// Depth lost per distance divided by the pressure, 1/stress.
    pub coefficient: f64,
    pub steps: Vec<Record>,
    /// Work of the pressure on the depth lost along the path, per area.
    pub dissipated: Option<f64>,
    /// Sum of the errors of the steps; `None` if one is unknown.
    pub dissipated_error: Option<f64>,
    /// Sum of the imbalances of the steps.
    pub work_imbalance: Option<f64>,
    /// Mean depth lost at the end.
    pub wear_volume: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_converged: Option<NotConverged>,
    pub peak_bytes: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    pub plots: Vec<PathBuf>,
}

impl Report {
    /// Collects the results of the steps.
    pub(super) fn new(head: Head, coefficient: f64, steps: Vec<Record>) -> Self {
        let sum = |name: &str| steps.iter().filter_map(|step| step.value(name)).reduce(|a, b| a + b);
        Self {
            head,
            coefficient,
            dissipated: sum("dissipated"),
            dissipated_error: error_of_losses(&steps),
            work_imbalance: sum("work_imbalance"),
            wear_volume: steps.last().and_then(|step| step.value("wear_volume")),
            not_converged: None,
            peak_bytes: peak_bytes(),
            out: None,
            plots: Vec::new(),
            steps,
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.head)?;
        let read = |value: f64, kind: &str| self.head.read(value, kind, "");
        writeln!(f, "wear coefficient {}; wear: mean depth lost so far\n", read(self.coefficient, "1/stress"))?;
        print_steps(f, &self.steps, &self.head.units())?;
        print_flow(f, &self.steps, &self.head.units())?;
        if let (Some(lost), Some(imbalance), Some(volume)) = (self.dissipated, self.work_imbalance, self.wear_volume) {
            writeln!(
                f,
                "\nwear volume {} per area, dissipated {} per area (imbalance of work and energy {})",
                read(volume, "length"),
                read(lost, "stress*length"),
                read(imbalance, "stress*length")
            )?;
        }
        for line in lines(&self.steps, ["step", "steps"], |column| column == "dissipated_error") {
            writeln!(f, "{line}")?;
        }
        list_files(f, self.out.as_deref(), &self.plots)
    }
}
