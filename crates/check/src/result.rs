//! Result files as the commands read them: kind, configuration, and comparison with recomputed values.

mod comparison;
mod configuration;
mod folder;
mod pair;
mod surface;
pub mod trust;

use gfmd_files::Reader;
use serde::Serialize;

pub use comparison::Difference;
pub use comparison::{Comparison, printable};
pub use configuration::{Configuration, FILES};
pub use folder::Folder;
pub use pair::{Against, Pair, layout};
pub use surface::{compare_heights, regenerated, repeated_problem, stored_problem};

/// Largest residual of a law on a patch, as computed from the fields of a file, divided by the solve tolerance. A file
/// lacks the displacement outside the patch, which follows from its pressure only to within the residual.
pub(crate) const RESIDUAL_OF_A_PATCH: f64 = 10.0;

/// Kinds of result files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[expect(missing_docs, reason = "the names of the commands")]
pub enum ResultKind {
    Contact,
    Path,
    Slide,
    Punch,
    Body,
    KappaSweep,
    Study,
}

impl ResultKind {
    /// Returns the kind of a file, from its groups; `None` if it is not a result.
    pub fn of(reader: &Reader) -> Option<Self> {
        let has = |group: &str| !reader.names(group).is_empty();
        let groups = [
            ("/loads", Self::Contact),
            ("/path", Self::Path),
            ("/states", Self::Slide),
            ("/punch", Self::Punch),
            ("/runs", Self::KappaSweep),
            ("/study", Self::Study),
        ];
        (groups.into_iter())
            .find_map(|(group, kind)| has(group).then_some(kind))
            .or_else(|| reader.contains("/fields/depth").then_some(Self::Body))
    }

    /// Returns the name of its command.
    pub fn name(self) -> &'static str {
        match self {
            Self::Contact => "contact",
            Self::Path => "path",
            Self::Slide => "slide",
            Self::Punch => "punch",
            Self::Body => "body",
            Self::KappaSweep => "kappa-sweep",
            Self::Study => "study",
        }
    }
}
