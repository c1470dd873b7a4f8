//! Native part of the Python package `gfmd`: arrays in, arrays out, checked by the libraries. Names, defaults, results
//! and the user documentation are in `python/gfmd`.

use pyo3::prelude::*;

mod command;
mod contact;
mod failure;
mod files;
mod law;
mod surface;
mod unit;
mod worker;

/// Native module.
#[pymodule]
mod _gfmd {
    #[pymodule_export]
    use crate::command::{FileDraft, figures, path_vjp, program, solve, write_file, write_page};
    #[pymodule_export]
    use crate::contact::{
        Problem, State, adhesion, check_compliance, check_law, conductance, gas_conductance, gas_in_gap, law_traction,
        options,
    };
    #[pymodule_export]
    use crate::files::{StoredFile, save};
    #[pymodule_export]
    use crate::law::law_text;
    #[pymodule_export]
    use crate::surface::{
        composite, detrend, even, fill, finer, periodise, prepared, psd, read, self_affine, statistics, surface_report,
        texture,
    };
    #[pymodule_export]
    use crate::unit::{
        canonical, converted, fluids, in_units, kinds, law_kinds, materials, option_kinds, readable, unit_name,
        with_limit,
    };

    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
    #[pymodule_export]
    const GIT_COMMIT: &str = gfmd_input::session::GIT_COMMIT;
}
