//! The conformance kit for elements and whole models.
//!
//! ```
//! # use pullback_elements::{check, load::{NodalLoad, LoadKind}, time::Constant};
//! check::element(&NodalLoad::new(LoadKind::FollowerForce, [1.0, 2.0, 3.0], Constant(2.0))).assert();
//! ```
//!
//! | verb | for | laws |
//! |---|---|---|
//! | [`element`] | an [`Element`](crate::element::Element) | its tangents, energies, powers, requests |
//! | [`same`] | two elements that should be one | all that they answer |
//! | [`model`] | a [`Model`](crate::model::Model) | those of every element and joint where the model uses them, with objectivity and changes of chart; those of the assembled system, with transport and the balance of power |
//!
//! Positions, slopes and reports are those of [`pullback_manifold::check`].

mod element;
mod hand_over;
mod hung;
mod inertia;
mod invariance;
mod joint;
mod model;
mod rigid;
mod same;
mod states;
mod transport;

pub use element::{element, element_at};
pub(crate) use hung::hung;
pub use model::{Options, model};
pub(crate) use rigid::Frame;
pub use same::same;
