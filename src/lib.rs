//! Flexible multibody dynamics on manifolds: geometrically exact beams, and constraints as maps.
//!
//! # Conventions
//!
//! These hold everywhere; nothing converts silently.
//!
//! - **Frames.** All vectors are in components of one fixed frame (e1, e2, e3), also the rotation
//!   vector Ψ at every node. The section axes (E₁, E₂, E₃), E₁ along the beam, serve only for
//!   section laws, strains Γ, K and resultants N, M.
//! - **Coordinates.** A frame node has six, in this order: displacement d from its reference place
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
//! let axis = Straight {
//!     from: builder.place(root),
//!     to: builder.place(tip),
//!     second: None,
//!     twist: 0.0,
//! };
//! let section = Section::diagonal(1e4, [1e4, 1e4], 2.0, [EI, EI])?;
//! let line = Line { elements: 10, order: 1, section };
//! builder.line("beam", &axis, [root, tip], &line)?;
//! builder.support(root, &Dof::ALL);
//! let load = NodalLoad::new(Which::SpatialMoment, [0.0, 0.0, moment], Proportional(1.0));
//! builder.element("tip moment", load, &[tip])?;
//! let mut model = builder.build()?;
//!
//! let mut q = Vec::new();
//! let options = StaticOptions::default();
//! solve_statics(&mut model, &mut q, &options, &mut |_, _| ControlFlow::Continue(()))?;
//!
//! // A pure moment bends a straight beam into an arc of angle M L / EI.
//! let angle = model.node_state(tip).psi.z;
//! assert!((angle - moment * length / EI).abs() < 1e-9);
//! # Ok(())
//! # }
//! ```
//!
//! The same from a model file: [`run::run`], or `pullback run model.toml`.

pub mod gallery;
pub mod input;
pub mod output;
pub mod probe;
pub mod run;
pub mod solve;

pub use pullback_elements as elements;
pub use pullback_integrators as integrators;
pub use pullback_manifold as manifold;

/// What most programs need.
pub mod prelude {
    pub use nalgebra::{Unit, Vector3};
    pub use pullback_elements::beam::{Material, Section};
    pub use pullback_elements::load::{LineLoad, NodalLoad, Which};
    pub use pullback_elements::model::{
        Arc, Axis, Dof, Line, Model, ModelBuilder, ModelError, NodeId, NodeState, Straight,
    };
    pub use pullback_elements::time::{Constant, Proportional, Sine, Table, TimeFunction};
    pub use pullback_integrators::statics::{
        ArcLengthOptions, Event, StaticOptions, StaticsError, Step, solve_statics, trace_path,
    };
    pub use pullback_manifold::system::System;
    pub use std::ops::ControlFlow;
}
