//! Derivations of all formulas, cited in the crates as (theory.md, section N).
//!
#![doc = include_str!("../docs/theory.md")]
