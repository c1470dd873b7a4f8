//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! The elastic response of a body is condensed onto its surface, one matrix for each wave vector. The surface is
//! pressed against a rigid rough one and brought to rest, by damped dynamics or by faster solvers of the same problem.
//! Every result is certified: its residuals are recomputed from the final fields, and a state that does not meet the
//! tolerance is an error that carries the state.
//!
//! With adhesion one line of the example differs, and loads may pull:
//!
//! ```
//! # use gfmd::prelude::*;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let grid = Grid::square(32, 1.0)?;
//! # let rough = SelfAffine {
//! #     hurst: 0.8, longest_wavelength: 0.5, shortest_wavelength: 0.25, ..SelfAffine::with_rms_gradient(0.05)
//! # };
//! # let heights = rough.heights(&grid, 1)?;
//! # let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0)?);
//! let contact = Interface::new(&body, &grid, &heights, Exponential::new(4e-6, 1e-3)?)?;
//! let pressed = contact.press(Load::Approach(0.004)).solve()?;
//! let pulled = contact.press(Load::Approach(-0.001)).starting_from(Some(&pressed)).solve()?;
//! println!("{:.1e} after {:.1e}", pulled.mean_pressure, pressed.mean_pressure);
//! # let [pull, push] = [pulled.mean_pressure, pressed.mean_pressure];
//! # assert!(pull < 0.0 && push > 0.0, "{pull} {push}");
//! # Ok(())
//! # }
//! ```
//!
//! # Conventions
//!
//! - Any consistent units. Moduli and pressures share one unit of stress, heights and displacements one unit of length.
//! - Arrays are `[x, y]`. A line contact in plane strain has one point along y ([`Grid::line`](field::Grid::line)).
//! - Heights `h` belong to the rigid surface. Its peaks point at the body, and the highest touches first.
//! - Pressure is positive in compression. `u_z < 0` presses the body down. The cell is periodic.
//! - E* = E/(1 − ν²), ḡ is the root mean square of |∇h| over the whole surface, and p* = p̄/(E* ḡ).
//!
//! # When a solve fails
//!
//! [`SolveError`](contact::SolveError) separates unusable input ([`Refusal`](contact::Refusal), with the value found
//! and the allowed values) from a search that did not converge, was interrupted, or detached. The last three carry the
//! state reached ([`into_state`](contact::SolveError::into_state)).
//!
//! # The crates
//!
//! Each crate can be used alone; this one re-exports them all.
//!
//! | to ... | module | start at |
//! |---|---|---|
//! | make a rough surface, or prepare a measured one | [`surface`] | [`SelfAffine`], [`Statistics`] |
//! | describe an elastic body | [`green`] | [`Body`], [`Material`] |
//! | press the surface on the body | [`contact`] | [`Contact`], [`Equilibrium`] |
//! | add a law across the gap | [`interface`] | [`Interface`] |
//! | add friction, hardness, wear, relaxation; follow a path | [`interface`] | [`QuasistaticContact`], [`Path`] |
//! | choose or evaluate the law of an interface | [`law`] | [`Law`], [`LawKind`] |
//! | describe how a viscoelastic body relaxes, or slide over it | [`medium`] | [`Prony`], [`SlidingContact`] |
//! | prescribe displacements on some points, tractions on others | [`mixed`] | [`MixedProblem`] |
//! | measure area, kappa and pressures; compare with theories | [`measure`] | [`Summary`], [`measure::theory`] |
//! | find the temperature of a surface under friction | [`heat`] | [`Flash`], [`Thermal`] |
//! | let a fluid flow through the gap | [`flow`] | [`flow::flow`], [`Flow`] |
//! | see displacement, strain and stress below the surface | [`body`] | [`Interior`] |
//! | move dislocations below a punch | [`dislocation`] | [`Domain`], [`Crystal`] |
//! | apply stiffness and compliance of a body to whole fields | [`response`] | [`NormalResponse`] |
//! | minimise something else | [`relax`] | [`Landscape`], [`Quadratic`] |
//! | transform periodic fields | [`field`] | [`Grid`], [`Transform`] |
//! | look a formula up | [`theory`] | |
//!
//! Studies of many contacts (`gfmd-sweep`), extrapolation (`gfmd-fit`), pictures (`gfmd-plot`) and files (`gfmd-files`)
//! are crates beside this one, and `gfmd-cli` is the program.
//!
//! [`SelfAffine`]: surface::SelfAffine
//! [`Statistics`]: surface::Statistics
//! [`Body`]: green::Body
//! [`Material`]: green::Material
//! [`Contact`]: contact::Contact
//! [`Equilibrium`]: contact::Equilibrium
//! [`Interface`]: interface::Interface
//! [`QuasistaticContact`]: interface::QuasistaticContact
//! [`Path`]: interface::Path
//! [`Law`]: law::Law
//! [`LawKind`]: law::LawKind
//! [`Prony`]: medium::Prony
//! [`SlidingContact`]: medium::SlidingContact
//! [`MixedProblem`]: mixed::MixedProblem
//! [`Summary`]: measure::Summary
//! [`Flash`]: heat::Flash
//! [`Thermal`]: heat::Thermal
//! [`Flow`]: flow::Flow
//! [`Interior`]: body::Interior
//! [`Domain`]: dislocation::Domain
//! [`Crystal`]: dislocation::Crystal
//! [`NormalResponse`]: response::NormalResponse
//! [`Landscape`]: relax::Landscape
//! [`Quadratic`]: relax::Quadratic
//! [`Grid`]: field::Grid
//! [`Transform`]: field::Transform

#[doc(inline)]
pub use gfmd_body as body;
#[doc(inline)]
pub use gfmd_contact as contact;
#[doc(inline)]
pub use gfmd_dislocation as dislocation;
#[doc(inline)]
pub use gfmd_field as field;
#[doc(inline)]
pub use gfmd_flow as flow;
#[doc(inline)]
pub use gfmd_green as green;
pub use gfmd_heat as heat;
#[doc(inline)]
pub use gfmd_interface as interface;
#[doc(inline)]
pub use gfmd_law as law;
#[doc(inline)]
pub use gfmd_measure as measure;
#[doc(inline)]
pub use gfmd_medium as medium;
#[doc(inline)]
pub use gfmd_mixed as mixed;
#[doc(inline)]
pub use gfmd_relax as relax;
#[doc(inline)]
pub use gfmd_response as response;
#[doc(inline)]
pub use gfmd_surface as surface;
/// Arrays of all fields, in the version that this crate takes and returns.
#[doc(no_inline)]
pub use ndarray;

pub mod prelude;
pub mod theory;
