//! The laws of elements and joints.

mod element;
mod in_charts;
mod inertia;
pub(crate) mod invariance;
mod joint;
mod rigid;
mod same;

pub use element::element;
pub(crate) use element::{Request, element_at, evaluate};
pub use in_charts::InCharts;
pub(crate) use invariance::{Component, EXACT, FIRST};
pub use joint::joint;
pub(crate) use rigid::{Carrier, FrameAt, carry};
pub use same::same;
