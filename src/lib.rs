//! Flexible multibody dynamics on manifolds: geometrically exact beams, and constraints as maps.
//!
//! # Conventions
//!
//! These hold everywhere; nothing converts silently.
//!
//! - **Frames.** All vectors are in components of one fixed frame (e1, e2, e3), also the rotation
//!   vector Ψ at every node. The section axes (E₁, E₂, E₃), E₁ along the beam, serve only for
//!   section laws, strains Γ, K and resultants N, M.
//! - **Coordinates.** A frame node has six, in this order: displacement d from its reference position
//!   (x, y, z), then rotation vector Ψ from its reference orientation (rx, ry, rz) in radians. Ψ
//!   lives in a chart and is replaced by its complement when it has grown beyond π.
//! - **Residual.** r = f_ext − f_int − f_acc, and K = −∂r/∂q, C = −∂r/∂q̇, M = −∂r/∂q̈. Newton's
//!   correction solves K δq = r. The residual is a covector: its rotational part is paired with
//!   δΨ, and is Tᵀ times the material moment, not the moment itself.
//! - **Reactions** act on the structure.
//! - **Units** are consistent ones of the user's choice; angles are radians.
//!
//! # A cantilever
//!
//! ```
//! use pullback::prelude::*;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let (length, EI, moment) = (1.0, 2.0, std::f64::consts::PI);
//! let mut builder = ModelBuilder::new();
//! let root = builder.node("root", [0.0; 3])?;
//! let tip = builder.node("tip", [length, 0.0, 0.0])?;
//! let axis = StraightLine::new(builder.position(root), builder.position(tip));
//! let section = Section::diagonal(1e4, [1e4, 1e4], 2.0, [EI, EI])?;
//! builder.line("beam", &axis, [root, tip], &BeamLine::new(10, section))?;
//! builder.support(root, &Dof::ALL);
//! let load = NodalLoad::new(LoadKind::SpatialMoment, [0.0, 0.0, moment], Proportional(1.0));
//! builder.element("tip moment", load, &[tip])?;
//! let mut context = Context::new(builder.build()?);
//!
//! LoadSteps::new(&mut context, Vec::new(), &StaticOptions::default())?.finish()?;
//!
//! // A pure moment bends a straight beam into an arc of angle M L / EI.
//! let angle = context.node_state(tip).psi.z;
//! assert!((angle - moment * length / EI).abs() < 1e-9);
//! # Ok(())
//! # }
//! ```
//!
//! # A pendulum
//!
//! ```
//! use pullback::elements::joint::Revolute;
//! use pullback::prelude::*;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let (length, g) = (1.0, 9.81);
//! let mut builder = ModelBuilder::new();
//! let ground = builder.node("ground", [0.0; 3])?;
//! builder.support(ground, &Dof::ALL);
//! let pivot = builder.attach("pivot", ground, Revolute::new([0.0, 1.0, 0.0])?)?;
//! let end = builder.offset("end", pivot.frame, [0.0, 0.0, -length])?;
//! let bob = PointMass::new(2.0)?;
//! builder.element("bob", bob, &[end])?;
//! builder.element("weight", bob.weight([0.0, 0.0, -g], Constant(1.0)), &[end])?;
//! let mut context = Context::new(builder.build()?);
//!
//! // A small swing returns after 2π √(l/g).
//! let period = std::f64::consts::TAU * (length / g).sqrt();
//! let state = start(&context, 0.0, &[0.01], &[0.0])?;
//! let mut run = Simulation::new(&mut context, state, &DynamicOptions::new(period, period / 500.0))?;
//! while let Some(step) = run.step()? {
//!     assert!(step.progress.state.q[0].abs() < 0.0101);
//! }
//! assert!((run.state().q[0] - 0.01).abs() < 1e-6);
//! # Ok(())
//! # }
//! ```
//!
//! The same from a model file: [`run::run`], or `pullback run model.toml`.
//!
//! # Features
//!
//! - `cli` (default): model files, results, figures, [`studies`] and the program. Without it the library
//!   is [`elements`], [`integrators`], [`manifold`], the [`prelude`] and [`conformance`], which has the functions of
//!   [`check`], on nalgebra and faer.
//! - `diffsol`: general solvers of ordinary differential equations in comparisons.

// Both panic on closed pipes: `terminal::tell` and `cli::print` do not.
#![deny(clippy::print_stdout, clippy::print_stderr)]

#[cfg(feature = "cli")]
pub mod check;
#[cfg(feature = "cli")]
pub mod cli;
mod failure;
#[cfg(feature = "cli")]
pub mod input;
#[cfg(feature = "cli")]
pub mod linear;
#[cfg(feature = "cli")]
pub mod method;
#[cfg(feature = "cli")]
pub mod modes;
#[cfg(feature = "cli")]
pub mod motion;
#[cfg(feature = "cli")]
pub mod output;
#[cfg(feature = "cli")]
pub mod probe;
#[cfg(feature = "cli")]
pub mod run;
#[cfg(feature = "cli")]
pub mod solve;
#[cfg(feature = "cli")]
pub mod studies;
#[cfg(feature = "cli")]
mod terminal;
#[cfg(feature = "cli")]
mod warnings;

pub use failure::Failure;
pub use pullback_conformance as conformance;
pub use pullback_elements as elements;
pub use pullback_integrators as integrators;
pub use pullback_manifold as manifold;

/// What most programs need.
pub mod prelude {
    pub use nalgebra::{SVector, Vector3};
    pub use pullback_elements::beam::Section;
    pub use pullback_elements::body::{PointMass, RigidBody};
    pub use pullback_elements::joint::{Joint, JointCoordinate, Pose};
    pub use pullback_elements::load::{LoadKind, NodalLoad};
    pub use pullback_elements::model::{
        BeamLine, Context, Dof, Model, ModelBuilder, NodeId, StraightLine,
    };
    pub use pullback_elements::time::{Constant, Proportional};
    pub use pullback_integrators::dynamics::{DynamicOptions, Scheme, Simulation, start};
    pub use pullback_integrators::statics::{LoadSteps, StaticOptions, equilibrium};
    pub use pullback_manifold::domain::DomainError;
    pub use pullback_manifold::scalar::Scalar;
    pub use pullback_manifold::so3::Quaternion;
    pub use pullback_manifold::system::Quantity;
}
