//! The conformance kit: every law that a map, chart, element, joint, model or scheme must obey, checked in
//! one line.
//!
//! ```
//! # use pullback_conformance as check;
//! # use pullback_elements::load::{LoadKind, NodalLoad};
//! # use pullback_elements::time::Constant;
//! # use pullback_integrators::dynamics::Scheme;
//! # use pullback_manifold::chart::Complement;
//! check::map(&Complement).assert();
//! check::element(&NodalLoad::new(LoadKind::FollowerForce, [1.0, 2.0, 3.0], Constant(2.0))).assert();
//! check::scheme(&Scheme::chung_hulbert(0.8)?).assert();
//! # Ok::<(), pullback_integrators::dynamics::DynamicsError>(())
//! ```
//!
//! | verb | for | laws |
//! |---|---|---|
//! | [`map`] | a [`Map`](pullback_manifold::map::Map) | B, ẋ, ẍ, Ḃ, B̈, K_σ follow from φ; closed forms agree with exact derivatives |
//! | [`implicit`] | an [`Implicit`](pullback_manifold::implicit::Implicit) constraint that is solved | h = 0; the laws of a map; a change of the coordinates q and back loses nothing |
//! | [`rewriting`] | a map that changes the meaning of its q | x, ẋ, ẍ and forces stay; the change back |
//! | [`chart`] | a [`Chart`](pullback_manifold::chart::Chart) | coordinates and points determine each other; a change of chart loses nothing |
//! | [`forces`] | any residual with tangents | K = −∂r/∂x, C = −∂r/∂ẋ, M = −∂r/∂ẍ, r_t, r = −∂E/∂x |
//! | [`system`] | a [`System`](pullback_manifold::system::System) | the same, with the tangent taken out of its pattern |
//! | [`parametrization`] | a map behind slices | those of [`map`] that need no closed form to compare with |
//! | [`kinematics`] | the same, at one state | those of [`map`] that need no closed form to compare with |
//! | [`pieces`] | the same, where it is pieced together | x, ẋ, ẍ, B, Ḃ are the same where one formula takes over from another |
//! | [`element`] | an [`Element`](pullback_elements::element::Element) | its tangents, energies, powers, requests |
//! | [`same`] | two elements that should be one | all that they answer |
//! | [`joint`] | a [`Joint`](pullback_elements::joint::Joint) | those of its map; its coordinates and its rotation |
//! | [`model`] | a [`Context`](pullback_elements::model::Context) | those of every element and joint where the model uses them, with objectivity and changes of chart; those of the assembled system, with transport and the balance of power |
//! | [`scheme`] | a [`Scheme`](pullback_integrators::dynamics::Scheme) | orders, stability, exactness, time reversal |
//!
//! Derivatives are checked by **slope**, not by tolerance: if B is the derivative of φ, the defect
//! ‖φ(q+εd) − φ(q) − εBd‖ falls like ε²; with an error δ in B it falls like ε as soon as ε is below
//! δ. The slope of log defect over log ε, measured at the smallest ε at which the defect still
//! stands well above round-off, therefore tells right from wrong down to relative errors of about
//! 1e-6 and needs no tuned number. Where the defect is at round-off for all but the largest ε (a
//! linear map, say) this is itself the proof.
//!
//! Coordinates come in groups ([`Layout`]) with a unit each, and slopes are measured group by group:
//! what is soft or small beside something stiff or large is held to its own size. A failure says
//! which block of which matrix is wrong, by how much, and by which factor ([`Block`]); what is right
//! there comes from extrapolated central differences.
//!
//! Everything is drawn from a seeded generator: two runs give the same report. Positions: the origin,
//! 1e-8 from it, random ones, both sides of π, and 0.3 from the edge 2π of a rotation chart; every
//! three consecutive coordinates have that norm and a random direction, so rotation vectors in any
//! layout that starts at a multiple of three are exercised at all of them.

#![allow(non_snake_case)]

mod block;
mod elements;
mod forces;
mod layout;
mod maps;
mod models;
mod report;
mod sample;
mod schemes;

pub use block::{Block, Compared, difference};
pub use elements::{InCharts, element, element_at, joint, same};
pub use forces::{
    CONFIRMED, Forces, State, dense, forces, forces_at, sizes, states, system, system_at,
    system_sizes,
};
pub use layout::{CoordinateGroup, Layout};
pub use maps::{
    Mapped, chart, implicit, kinematics, map, parametrization, pieces, plain, rewriting, shortened,
};
pub use models::{Options, model};
pub use report::{LawRow, Measure, Report};
pub use sample::Random;
pub use schemes::{Known, scheme};
