//! The model as a [`System`], for integrators.

use super::Context;
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::{
    ChartChanges, Charts, Energetics, Evaluation, Events, Point, Scales, System, SystemError,
};

impl System for Context {
    fn pattern(&self) -> &BlockPattern {
        &self.model.pattern
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        if let Some(previous) = out.previous {
            self.expand_own(Point::statics(previous.t, previous.q))?;
            self.work.previous.copy_from_slice(&self.work.x);
        }
        self.work.has_previous = out.previous.is_some();
        self.work.acceleration_step = out.accelerations;
        match out.S {
            Some(S) if self.has_spins() && !at.is_static() => {
                self.evaluate_spinning(at, out.r, S, out.r_t)
            }
            S => self.assemble(at, Evaluation { S, ..out }),
        }
    }

    fn is_symmetric(&self) -> bool {
        self.asymmetric().next().is_none()
    }

    fn scales(&self) -> Scales {
        self.work.scales
    }

    fn name(&self, i: usize) -> String {
        self.coordinate_name(self.model.coordinates[i])
    }

    fn charts(&mut self) -> Option<&mut dyn Charts> {
        Some(self)
    }

    fn events(&mut self) -> Option<&mut dyn Events> {
        Some(self)
    }

    fn energetics(&mut self) -> Option<&mut dyn Energetics> {
        Some(self)
    }
}

impl Charts for Context {
    fn change_charts(
        &mut self,
        t: f64,
        q: &mut [f64],
        v: &mut [f64],
        accelerations: &mut [&mut [f64]],
    ) -> ChartChanges {
        let changes = self.update_charts(t, q, v, accelerations);
        if let Some(a) = accelerations.first().filter(|_| !v.is_empty()) {
            // Restores the accepted state for observers. A joint outside its domain is reported by
            // the next evaluation.
            let _ = self.expand(Point { t, q, v, a });
        }
        changes
    }

    fn start(&mut self, t: f64, q: &[f64]) {
        self.start_element_charts(t, q);
    }

    fn singularity_warnings(&mut self) -> Vec<String> {
        let mut warnings = Vec::new();
        for ((_, node, _), map) in self.model.nodes.mapped().zip(&mut self.state.maps) {
            let why = map.implicit().and_then(|map| map.singularity_warning());
            warnings.extend(why.map(|why| format!("joint at node {}: {why}", node.name)));
        }
        warnings
    }
}
