//! Green's function molecular dynamics of rough contact: one dependency for all the physics crates.
