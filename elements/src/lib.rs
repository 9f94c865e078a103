#![doc = include_str!("../README.md")]
//!
//! # Contents
//!
//! - [`element::Element`] is the one trait of everything that contributes to the residual: beams,
//!   loads, and user elements. One evaluation gives residual and tangents.
//! - [`beam`] is Reissner's geometrically exact beam with total rotation vectors, two to four
//!   nodes; [`body`] has rigid bodies and point masses, [`inertia`] the kernel they share with it;
//!   [`spring`] has springs, dampers and bushings.
//! - [`constraint`] enforces equations by multipliers or by a penalty instead of a map.
//! - [`energy`] has elements defined by their energies, one generic function each.
//! - [`load`] has nodal and distributed loads with exact tangents; [`time`] their functions.
//! - [`model`] collects nodes, elements, loads and supports, checks them, numbers the unknowns and
//!   assembles them into a [`System`](pullback_manifold::system::System).
//!
//! # Conventions
//! A frame node has the coordinates (d, Ψ): displacement from its reference position and rotation
//! vector from its reference orientation, in global components e1, e2, e3. The residual is r =
//! f_ext − f_int − f_acc, tangents are its negative derivatives, matrices are stored column by
//! column. Cross-sections have axes E₁ (along the beam), E₂, E₃, used for stress resultants N, M
//! and strains Γ, K. Units are free, but must be consistent.

#![warn(clippy::unwrap_used)]

mod asymmetry;
pub mod beam;
mod blocks;
pub mod body;
pub mod constraint;
pub mod element;
pub mod energy;
pub mod inertia;
pub mod joint;
pub mod load;
mod memory;
pub mod model;
pub mod spring;
pub mod time;

pub use asymmetry::Asymmetry;
