#![doc = include_str!("../README.md")]
//!
//! | verb | for | laws |
//! |---|---|---|
//! | [`map`] | a [`Map`](pullback_manifold::map::Map) | B, ẋ, ẍ, Ḃ, B̈, K_σ follow from φ; closed forms agree with exact derivatives |
//! | [`implicit`] | an [`Implicit`](pullback_manifold::implicit::Implicit) constraint that is solved | h = 0; the laws of a map; a change of the coordinates q can be undone |
//! | [`rewriting`] | a map that reparametrizes | x, ẋ, ẍ and forces stay; the change back |
//! | [`chart`] | a [`RotationChart`](pullback_manifold::chart::RotationChart) | coordinates and quaternions determine each other; a change of chart keeps the motion |
//! | [`forces`] | any residual with tangents | K = −∂r/∂x, C = −∂r/∂ẋ, M = −∂r/∂ẍ, r_t, r = −∂E/∂x |
//! | [`system`] | a [`System`](pullback_manifold::system::System) | the same for the tangent in its pattern; equations of multipliers for accelerations |
//! | [`parametrization`] | a map behind slices | those of [`map`] without closed forms |
//! | [`kinematics`] | the same, at one state | those of [`map`] without closed forms |
//! | [`pieces`] | the same, if it consists of several pieces | x, ẋ, ẍ, B, Ḃ are continuous between pieces |
//! | [`element`] | an [`Element`](pullback_elements::element::Element) | its tangents, energies, powers, requests |
//! | [`same`] | two implementations of an element | all their results agree |
//! | [`joint`] | a [`Joint`](pullback_elements::joint::Joint) | those of its map; its coordinates and its rotation |
//! | [`model`] | a [`Context`](pullback_elements::model::Context) | those of every element and joint at states of the model, with objectivity and changes of chart; those of the assembled system, with transport and the balance of power |
//! | [`scheme`] | a [`Scheme`](pullback_integrators::dynamics::Scheme) | orders, stability, exactness, time reversal |
//!
//! Derivatives are checked by **slopes**, not by tolerances: if B is the derivative of φ, the defect
//! ‖φ(q+εd) − φ(q) − εBd‖ decreases like ε²; with an error δ in B it decreases like ε as soon as ε is below δ. The slope
//! of log defect over log ε, measured at the smallest ε at which the defect is well above round-off, reveals relative
//! errors down to about 1e-6 without any tuned number. If the defect is at round-off for all but the largest ε, as for
//! a linear map, the law holds.
//!
//! Coordinates are in groups ([`Layout`]) with a unit each, and slopes are measured group by group: errors of small
//! numbers are compared with their own magnitude, also beside larger ones. A failure names the wrong block of a matrix,
//! its error and its factor ([`Block`]); the correct block is found by extrapolated central differences.
//!
//! The random generator is seeded: two runs give the same report. Positions are the origin, 1e-8 from it, random ones,
//! both sides of π, and 0.3 from the boundary 2π of a rotation chart; every three consecutive coordinates have that norm
//! and a random direction. Rotation vectors are thus checked at all of them, in any layout in which they begin at a
//! multiple of three.

mod block;
mod elements;
mod forces;
mod layout;
mod maps;
mod models;
mod report;
mod sample;
mod schemes;
mod vectors;

pub use block::Block;
pub use elements::{InCharts, element, joint, same};
pub use forces::{Forces, TestState, forces, forces_at, states, system};
pub use layout::{CoordinateGroup, Layout};
pub use maps::{
    Mapped, chart, implicit, kinematics, map, motion, parametrization, pieces, rewriting,
};
pub use models::{ModelOptions, model};
pub use report::{LawRow, Measure, Report};
pub use sample::Random;
pub use schemes::scheme;
