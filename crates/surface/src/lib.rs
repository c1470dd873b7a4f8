//! Self-affine rough surfaces and profiles: synthesis from a spectrum and a seed, and measured statistics.
