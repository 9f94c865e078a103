//! Changes of chart and of segment at converged states.

pub(super) mod element_charts;
pub(super) mod nodes;
pub(super) mod segments;
