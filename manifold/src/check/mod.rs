//! The conformance kit: every law a leaf of this framework must obey, checked in one line.
//!
//! ```
//! # use pullback_manifold::{check, chart::Complement};
//! check::map(&Complement).assert();
//! ```
//!
//! | verb | for | laws |
//! |---|---|---|
//! | [`map`] | a [`Map`](crate::map::Map) | B, ẋ, ẍ, Ḃ, B̈, K_σ follow from φ; closed forms agree with exact derivatives |
//! | [`implicit`] | an [`Implicit`](crate::implicit::Implicit) constraint that is solved | h = 0; the laws of a map; a change of the coordinates q and back loses nothing |
//! | [`rewriting`] | a map that changes the meaning of its q | x, ẋ, ẍ and forces stay; the way back |
//! | [`chart`] | a [`Chart`](crate::chart::Chart) | coordinates and points determine each other; a change of chart loses nothing |
//! | [`forces`] | any residual with tangents | K = −∂r/∂x, C = −∂r/∂ẋ, M = −∂r/∂ẍ, r_t, r = −∂E/∂x |
//! | [`system`] | a [`System`](crate::system::System) | the same, with the tangent taken out of its pattern |
//! | [`kinematics`] | a map behind slices, at one state | those of [`map`] that need no closed form to compare with |
//! | [`pieces`] | the same, where it is pieced together | x, ẋ, ẍ, B, Ḃ are the same where one formula takes over from another |
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
mod chart;
mod finite;
mod forces;
mod implicit;
mod kinematics;
mod layout;
mod map;
mod pieces;
mod report;
mod sample;
mod system;
mod tangents;

pub use block::{Block, Compared, difference};
pub use chart::chart;
pub use forces::{Forces, State, forces, forces_at, sizes, states};
pub use implicit::{implicit, rewriting};
pub use kinematics::{Mapped, kinematics};
pub use layout::{Group, Layout};
pub use map::{map, plain, shortened};
pub use pieces::pieces;
pub use report::{Measure, Report, Row};
pub use sample::Random;
pub use system::{dense, system, system_at, system_sizes};
pub use tangents::CONFIRMED;
