//! The model as a [`System`], for integrators.

use super::{Context, Source};
use crate::time::Input;
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::{
    ChartChanges, Energies, Evaluation, Point, Quantity, RigidRates, Scales, Symmetry, System,
    SystemError,
};

impl System for Context {
    fn pattern(&self) -> &BlockPattern {
        &self.model.pattern
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        if self.has_spins() && !at.is_static() && out.S.is_some() {
            self.evaluate_spinning(at, out)
        } else {
            self.assemble(at, out)
        }
    }

    fn evaluate_from(
        &mut self,
        previous: Point<'_>,
        at: Point<'_>,
        out: Evaluation<'_>,
    ) -> Result<(), SystemError> {
        self.expand_positions(previous.t, previous.q)?;
        std::mem::swap(&mut self.work.x, &mut self.work.previous);
        self.work.has_previous = true;
        let outcome = self.evaluate(at, out);
        self.work.has_previous = false;
        outcome
    }

    fn evaluate_accelerations(
        &mut self,
        at: Point<'_>,
        h: f64,
        out: Evaluation<'_>,
    ) -> Result<(), SystemError> {
        self.work.acceleration_step = Some(h);
        let outcome = self.evaluate(at, out);
        self.work.acceleration_step = None;
        outcome
    }

    fn is_multiplier(&self, i: usize) -> bool {
        self.model.multipliers[self.model.coordinates[i]]
    }

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

    fn overshoot(&mut self, from: Point<'_>, to: Point<'_>) -> Option<f64> {
        self.find_overshoot(from, to)
    }

    fn change_segments(&mut self, from: Point<'_>, to: Point<'_>, since: f64) {
        self.enter_segments(from, to, since);
    }

    fn start(&mut self, t: f64, q: &[f64]) {
        self.start_element_charts(t, q);
    }

    fn singularity_warnings(&self) -> Vec<String> {
        let warning = |&n: &u32| {
            let node = &self.model.nodes[n as usize];
            match &node.source {
                Source::Mapped(d) => (self.state.maps[d.index].singularity_warning())
                    .map(|why| format!("joint at node {}: {why}", node.name)),
                Source::Own => None,
            }
        };
        self.model.dependent.iter().filter_map(warning).collect()
    }

    fn kinks(&self) -> Vec<f64> {
        let driven = self
            .model
            .prescribed
            .iter()
            .flat_map(|p| p.function.kinks());
        let loads = self.model.elements.iter().flat_map(|e| e.element.kinks());
        driven.chain(loads).collect()
    }

    fn inputs(&self) -> Vec<f64> {
        self.model.inputs.iter().map(Input::get).collect()
    }

    fn energies(&mut self, at: Point<'_>) -> Result<Option<Energies>, SystemError> {
        self.enter_element_charts();
        self.evaluate_energies(at, false)
            .map(|out| Some(out.energies))
    }

    fn momentum(&mut self, at: Point<'_>, p: &mut [f64]) -> Result<bool, SystemError> {
        self.generalised_momentum(at, p)
    }

    fn symmetries(&mut self, span: [f64; 2], q: &[f64], v: &[f64]) -> Vec<Symmetry> {
        self.find_symmetries(span, q, v)
    }

    fn rigid_rates(&self, q: &[f64], motion: &RigidRates, rates: &mut [f64]) {
        self.write_rigid_rates(q, motion, rates);
    }

    fn kept_momentum(&mut self, at: Option<Point<'_>>, p: &mut [f64]) -> Result<bool, SystemError> {
        self.mean_momentum(at, p)
    }

    fn is_symmetric(&self) -> bool {
        self.model.elements.iter().all(|e| e.element.is_symmetric())
    }

    fn quantity(&self, i: usize) -> Quantity {
        self.model.quantities[self.model.coordinates[i]]
    }

    fn name(&self, i: usize) -> String {
        self.coordinate_name(self.model.coordinates[i])
    }

    fn magnitude(&self, i: usize) -> f64 {
        self.model.magnitudes[i]
    }

    fn scales(&self) -> Scales {
        self.work.scales
    }
}
