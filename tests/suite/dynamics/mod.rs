//! Motions: orders, energies, charts, allocation.

mod allocation;
mod contexts;
mod energy_momentum;
mod energy_momentum_limits;
mod kinks;
mod newton;
mod order;
mod tsitouras;
mod twist;
mod waves;

use crate::support::prelude::*;

/// A unit mass that moves along e1, and its node.
fn mass_on_rail() -> (ModelBuilder, NodeId) {
    let mut b = ModelBuilder::new();
    let node = b.node("mass", [0.0; 3]).unwrap();
    b.support(node, &Dof::ALL[1..]);
    let mass = PointMass::new(1.0).unwrap();
    b.element("mass", mass, &[node]).unwrap();
    (b, node)
}
