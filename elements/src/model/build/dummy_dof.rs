//! Models with all coordinates prescribed: kinematics, and the forces of prescribed motions.
//!
//! Solvers need at least one unknown. They get a separate coordinate that stays zero, with a spring
//! and a mass; states, reactions and energies are those of the prescribed motions.

use crate::element::{Abilities, Element, ElementEnergies, Motion, Response};
use crate::model::loops::LoopReport;
use crate::model::{ModelBuilder, ModelError, NodeForm, Subject};
use pullback_manifold::domain::DomainError;
use pullback_manifold::system::Quantity;

/// A unit mass on a unit spring; dim 1.
#[derive(Debug)]
struct DummyDof;

impl Element for DummyDof {
    fn dim(&self) -> usize {
        1
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        out.r[0] -= at.x[0] + at.a.first().copied().unwrap_or(0.0);
        for one in [&mut out.K, &mut out.M].into_iter().flatten() {
            one[0] += 1.0;
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities::of_energies(self)
    }
}

impl ElementEnergies for DummyDof {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        0.5 * at.x[0] * at.x[0]
    }
}

impl ModelBuilder {
    /// Adds the dummy coordinate if nothing else is free after loops are closed.
    ///
    /// # Errors
    /// [`ModelError::LockedLoop`] if loops leave nothing free, and no joint is prescribed.
    pub(in crate::model) fn add_dummy_dof(
        &mut self,
        loops: &[LoopReport],
    ) -> Result<(), ModelError> {
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
        // A prescribed joint coordinate is intended, even at zero; a support only fixes.
        let mut prescribed = self.prescribed.iter();
        let still = prescribed
            .all(|(n, _, f)| f.constant() == Some(0.0) && !self.nodes[n.0 as usize].is_released());
        if let (true, Some(closed)) = (still, loops.iter().find_map(|r| r.loops.first())) {
            let joints = Subject::node(&self.nodes, closed.frame);
            return Err(ModelError::LockedLoop { joints });
        }
        let node =
            self.add_coordinates_of("nothing is free", NodeForm::Dummy, &[Quantity::Other])?;
        self.element("nothing is free", DummyDof, &[node])?;
        Ok(())
    }
}
