//! Curves, surfaces and chains of beams, for joints along them.

mod between;
mod chain;
mod quadric;
mod spline;

pub(super) use between::Between;
pub use chain::Chain;
pub use quadric::Quadric;
pub use spline::{Spline, SplineError};
