//! Elements, loads and models of flexible multibody systems on top of `pullback-manifold`.
//!
//! - [`element::Element`] is the one trait for whatever contributes to the residual: beams, loads,
//!   and what users write. One evaluation fills residual and tangents in place.
//! - [`beam`] is Reissner's geometrically exact beam with total rotation vectors, two to four
//!   nodes; [`body`] has rigid bodies and point masses, [`inertia`] the kernel they share with it;
//!   [`spring`] has springs, dampers and bushings.
//! - [`constraint`] enforces equations by multipliers or by a penalty, where no map is wanted.
//! - [`energy`] has elements of which only the energies are written, one generic function each.
//! - [`load`] has nodal and distributed loads with exact tangents; [`time`] their functions.
//! - [`model`] collects nodes, elements, loads and supports, checks them, numbers the unknowns and
//!   assembles them into a [`System`](pullback_manifold::system::System).
//!
//! # Conventions
//! A frame node has the coordinates (d, Ψ): displacement from its reference position and rotation
//! vector from its reference orientation, in global components e1, e2, e3. The residual is
//! r = f_ext − f_int − f_acc, tangents are its negative derivatives, matrices stand column by
//! column. Cross-sections have axes E₁ (along the beam), E₂, E₃; stress resultants N, M and strains
//! Γ, K are given in these. Units are the user's, but consistent.

#![warn(clippy::unwrap_used)]

pub mod beam;
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
