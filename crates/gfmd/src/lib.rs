//! Green's function molecular dynamics of rough contact: the physics crates of the workspace under one name.
//!
//! | module       | what                                                        |
//! |--------------|-------------------------------------------------------------|
//! | [`field`]    | periodic grids, half spectra, transforms                    |
//! | [`green`]    | elastic half-spaces, slabs and stacks, per wave vector      |
//! | [`surface`]  | self-affine surfaces and their statistics                   |
//! | [`relax`]    | minimisers without physics                                  |
//! | [`response`] | stiffness and compliance of a body, applied to whole fields |
//! | [`body`]     | displacement, strain and stress below the surface           |
//! | [`contact`]  | hard-wall contact: problem, solvers, certified solution     |
//! | [`mixed`]    | displacement prescribed here, traction there                |
//! | [`law`]      | cohesive zones, adhesion, friction, point by point          |
//! | [`interface`] | adhesive, cohesive and frictional contact                  |
//! | [`measure`]  | area, kappa, pressure statistics, comparison theories       |
//! | [`theory`]   | derivations of the formulas, cited as (theory.md, section N) |
//!
//! Contact area against load, each load started from the one before:
//!
//! ```
//! use gfmd::prelude::*;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let grid = Grid::square(128, 1.0)?; // 128² points, cell of length 1
//! let rough = SelfAffine {
//!     hurst: 0.8,
//!     longest_wavelength: 0.5,
//!     shortest_wavelength: 1.0 / 16.0,
//!     ..SelfAffine::with_rms_gradient(0.1)
//! };
//! let heights = rough.heights(&grid, 1)?; // Array2<f64>, seed 1
//! let body = Body::slab(Material::from_young(70e9, 0.33)?, 0.5)?;
//! let contact = Contact::new(&body, &grid, &heights)?;
//! let unit = contact.reduced_pressure_unit(); // E* times the rms gradient
//! let mut last = None;
//! for p_star in [0.005, 0.01, 0.02, 0.05] {
//!     let load = Load::MeanPressure(p_star * unit);
//!     let solution = contact.press(load).tolerance(1e-8).starting_from(last.as_ref()).solve()?;
//!     let summary = solution.summary();
//!     println!("{p_star:6.3}  a = {:.5}  kappa = {:.4}  {}", summary.area_fraction, summary.kappa, solution.effort);
//!     # assert!((1.3..3.5).contains(&summary.kappa) && (summary.p_star / p_star - 1.0).abs() < 1e-9, "{summary:?}");
//!     last = Some(solution);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! With adhesion it is the same program with another contact:
//!
//! ```
//! # use gfmd::prelude::*;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let grid = Grid::line(128, 1.0)?;
//! # let heights = Array2::from_shape_fn((128, 1), |(i, _)| 0.01 * (std::f64::consts::TAU * i as f64 / 128.0).cos());
//! # let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0)?);
//! let contact = Interface::new(&body, &grid, &heights, Exponential::new(5e-5, 5e-3)?)?;
//! let solution = contact.press(Load::MeanPressure(-1e-4)).solve()?;
//! assert!(solution.contact_fraction > 0.0);
//! # Ok(())
//! # }
//! ```

pub use gfmd_body as body;
pub use gfmd_contact as contact;
pub use gfmd_field as field;
pub use gfmd_green as green;
pub use gfmd_interface as interface;
pub use gfmd_law as law;
pub use gfmd_measure as measure;
pub use gfmd_mixed as mixed;
pub use gfmd_relax as relax;
pub use gfmd_response as response;
pub use gfmd_surface as surface;

pub mod theory;

/// Arrays of the version that the fields are made of.
pub use ndarray;

/// All that a program about a contact usually needs: `use gfmd::prelude::*;`.
pub mod prelude {
    pub use gfmd_contact::{
        Budget, Contact, Drive, Effort, Equilibrium, Fields, Load, Progress, Refusal, SolveError, Solver, Watch,
    };
    pub use gfmd_field::Grid;
    pub use gfmd_green::{Body, Material};
    pub use gfmd_interface::{FrictionalContact, Interface};
    pub use gfmd_law::{Exponential, Law, Limit};
    pub use gfmd_measure::Summary;
    pub use gfmd_surface::{Discretisation, SelfAffine};
    pub use ndarray::{Array2, ArrayView2};
}
