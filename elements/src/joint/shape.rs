//! Curves and surfaces by data, for joints along them.

mod quadric;
mod spline;

pub use quadric::Quadric;
pub use spline::{Spline, SplineError};
