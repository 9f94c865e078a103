#![doc = include_str!("../README.md")]
//!
//! Four abstractions carry the idea:
//!
//! | | trait | what its author writes |
//! |---|---|---|
//! | chart | [`chart::RotationChart`] | coordinates ↔ quaternion, where it is valid |
//! | map | [`map::Map`], [`map::Parametrization`] | one generic function φ(t, q) |
//! | implicit constraint | [`implicit::Implicit`] | one generic function h(t, x), a map by [`implicit::ImplicitMap`] |
//! | system | [`system::System`] | residual and combined tangent of an equation of motion |
//!
//! The rest follows: [`map::derived`] gives B, Ḃ, B̈ and K_σ(f) by exact differentiation over the
//! number types of [`jet`], [`pullback`] transforms tangents by a map, and the crate
//! `pullback-conformance` verifies every implementation by convergence slopes.
//!
//! # Conventions
//! - Vectors are columns; matrices in slices are stored column by column.
//! - Rotation vectors Ψ and displacements d have components in the global frame e1, e2, e3; a
//!   frame's coordinates are (d, Ψ), in this order.
//! - The residual is r = f_ext − f_int − f_acc; K = −∂r/∂q, C = −∂r/∂q̇, M = −∂r/∂q̈.
//! - Names are the symbols of `docs/notation.md`; equation numbers are those of \[M04\], J. Mäkinen,
//!   *A Formulation for Flexible Multibody Mechanics*, Tampere University of Technology, Research
//!   Report 2004:3.

#![warn(clippy::unwrap_used)]

pub mod chart;
mod coordinate;
pub mod domain;
pub mod implicit;
pub mod jet;
pub mod map;
pub mod pullback;
pub mod quotients;
pub mod scalar;
pub mod so3;
pub mod sparse;
pub mod system;
