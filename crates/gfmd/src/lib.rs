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
//! ```
//! use gfmd::contact::{Contact, Equilibrium, Load};
//! use gfmd::green::{Body, Material};
//! use gfmd::measure::{contact_area, kappa};
//! use gfmd::{field::Grid, surface::{Discretisation, SelfAffine}};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let discretisation = Discretisation { eps_t_inv: 2.0, eps_f_inv: 8.0, eps_c_inv: 8.0 };
//! let grid = Grid::square(discretisation.points()?, 1.0)?;
//! let (rms_gradient, p_star) = (0.1, 0.02);
//! let rough = SelfAffine { hurst: 0.8, ..SelfAffine::with_rms_gradient(rms_gradient) };
//! let heights = discretisation.self_affine(1.0, rough).heights(&grid, 1)?;
//!
//! let body = Body::half_space(Material::from_young(1.0, 0.3)?);
//! let contact = Contact::new(&body, &grid, &heights)?;
//! let solution = contact.press(Load::MeanPressure(p_star * contact.reduced_pressure_unit())).solve()?;
//!
//! let kappa = kappa(contact_area(solution.pressure.view()).fraction, p_star);
//! assert!((1.6..3.5).contains(&kappa), "{kappa}");
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
