//! The compared methods: schemes of the library, each in a formulation, and general solvers.

use super::Values;
use crate::method::Method;
use crate::studies::general::{self, General};
use pullback_elements::model::Formulation;
use pullback_integrators::dynamics::DynamicsError;
use std::fmt;
use std::str::FromStr;

/// A scheme in a formulation of rotations, or a general solver of ordinary differential equations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "a comparison has a few of them, and copies them"
)]
#[non_exhaustive]
pub enum Candidate {
    /// A scheme of the library.
    Method(Method),
    /// A general solver: a step size stands for a tolerance ([`General::at`]).
    General(General),
}

impl Candidate {
    /// The formulation of rotations.
    pub fn formulation(&self) -> Formulation {
        match self {
            Self::Method(method) => method.formulation(),
            Self::General(_) => Formulation::Total,
        }
    }

    /// Description with reference.
    pub fn about(&self) -> &'static str {
        match self {
            Self::Method(method) => method.about(),
            Self::General(general) => general.about(),
        }
    }

    /// Its order in theory, if its step size is prescribed.
    pub fn order(&self) -> Option<usize> {
        match self {
            Self::Method(method) => Some(method.order()),
            Self::General(_) => None,
        }
    }

    /// The order of each quantity, on a model with multipliers or without.
    pub fn orders(&self, multipliers: bool) -> Option<Values<usize>> {
        match (self, multipliers) {
            (Self::Method(method), true) => {
                let [position, velocity] = method.orders_with_multipliers();
                Some(Values::of_levels([position, velocity, velocity]))
            }
            _ => Some(Values::of_levels([self.order()?; 3])),
        }
    }
}

impl From<Method> for Candidate {
    fn from(method: Method) -> Self {
        Self::Method(method)
    }
}

impl FromStr for Candidate {
    type Err = DynamicsError;

    /// The name of a [`General`] solver or a [`Method`].
    fn from_str(text: &str) -> Result<Self, DynamicsError> {
        let text = text.trim();
        match text.starts_with(general::PREFIX) {
            true => text.parse().map(Self::General),
            false => text.parse().map(Self::Method),
        }
    }
}

impl fmt::Display for Candidate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Method(method) => method.fmt(f),
            Self::General(general) => general.fmt(f),
        }
    }
}
