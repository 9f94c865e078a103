//! Models of which every coordinate is prescribed: kinematics, and the forces of given motions.
//!
//! Solvers want something to solve for. They get a coordinate of its own that stays zero, a spring
//! and a mass that nothing else sees; states, reactions and energies are those of the drives.

#![allow(non_snake_case)]

use super::loops::Report;
use super::{ModelBuilder, ModelError, NodeForm};
use crate::element::{Element, ElementError, Motion, Response};
use pullback_manifold::system::Quantity;

/// A mass on a spring, both of size one; dim 1.
#[derive(Debug)]
struct DummyDof;

impl Element for DummyDof {
    fn dim(&self) -> usize {
        1
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), ElementError> {
        out.r[0] -= at.x[0] + at.a.first().copied().unwrap_or(0.0);
        for one in [&mut out.K, &mut out.M].into_iter().flatten() {
            one[0] += 1.0;
        }
        Ok(())
    }

    fn energy(&self, at: &Motion<'_>) -> f64 {
        0.5 * at.x[0] * at.x[0]
    }
}

impl ModelBuilder {
    /// Adds the coordinate that stays zero where nothing else is free once loops are closed.
    ///
    /// # Errors
    /// [`ModelError::LockedLoop`] where it is loops that leave nothing free, and no joint is driven.
    pub(super) fn keep_one_free(&mut self, loops: &[Report]) -> Result<(), ModelError> {
        let given: std::collections::HashSet<(usize, usize)> = (self.prescribed.iter())
            .map(|(n, k, _)| (n.0 as usize, *k))
            .collect();
        let free = self
            .nodes
            .iter()
            .enumerate()
            .filter(|(_, node)| node.is_own() && node.form != NodeForm::Multipliers)
            .any(|(n, node)| (0..node.dim).any(|k| !given.contains(&(n, k))));
        if free || self.nodes.is_empty() {
            return Ok(());
        }
        // Who drives a joint's coordinate wants it there, be it at zero; a support only holds.
        let mut prescribed = self.prescribed.iter();
        let still = prescribed.all(|(n, _, f)| {
            f.constant() == Some(0.0) && self.nodes[n.0 as usize].form != NodeForm::Coordinates
        });
        if let (true, Some(&(frame, _))) = (still, loops.iter().find_map(|r| r.closures.first())) {
            let joints = self.nodes[frame as usize].name.clone();
            return Err(ModelError::LockedLoop { joints });
        }
        let node = self.coordinates("nothing is free", &[Quantity::Other])?;
        self.nodes[node.0 as usize].form = NodeForm::Dummy;
        self.element("nothing is free", DummyDof, &[node])?;
        Ok(())
    }
}
