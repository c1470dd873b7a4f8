//! Tests of `gfmd-contact` as one program. One file runs with `cargo test -p gfmd-contact --test suite FILE::`.

mod certificate;
mod checkpoint;
mod conductance;
mod cost;
mod dilute;
mod dynamics;
mod extreme;
mod flat_tops;
mod free;
mod full;
mod hardness;
mod ranks;
mod springs;
mod squeezed;
mod squeezed_hardness;
mod steady;
mod steep;
mod stiffness;

/// Returns true for the long tests (`.ci/long`).
fn long() -> bool {
    std::env::var_os("GFMD_LONG").is_some()
}
mod gradient;
