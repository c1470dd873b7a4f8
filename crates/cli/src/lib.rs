//! Commands of the program `gfmd`, as a library. Each command is a module with a function `run` that takes the flags
//! and returns a report, to be printed as a table or as JSON (docs/interface.md).
//!
//! ```
//! use clap::Parser;
//! use gfmd_cli::green;
//!
//! #[derive(Parser)]
//! struct Line {
//!     #[command(flatten)]
//!     args: green::Args,
//! }
//!
//! let line = Line::parse_from("green --qx 3 --qy 4 --height inf --young 1 --poisson 0".split(' '));
//! let report = green::run(&line.args)?;
//! assert!(report.to_string().contains("stiffness"));
//! # Ok::<(), gfmd_input::failure::Failure>(())
//! ```

pub mod body;
pub mod check;
mod checking;
pub mod completions;
pub mod contact;
pub mod estimate;
pub mod green;
mod guess;
pub mod inputs;
pub mod kappa_sweep;
pub mod kinds;
pub mod law;
mod line;
mod loads;
pub mod materials;
mod measuring;
pub mod path;
mod processes;
pub mod program;
pub mod progress;
pub mod prony;
pub mod punch;
pub mod report;
pub mod serve;
pub mod session;
pub mod slide;
pub mod study;
pub mod surface;
pub mod theory;
mod whole;
