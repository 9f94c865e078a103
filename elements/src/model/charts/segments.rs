//! Maps with several segments: changes of segment, and the momentum to conserve.

use crate::model::assembly::workspace::Workspace;
use crate::model::kinematics::mapped_node::{MappedNode, pull_back_forces};
use crate::model::kinematics::node_entries::collect;
use crate::model::{Context, Nodes};
use pullback_manifold::system::{Events, Point, SystemError};

/// Buffers for maps with several segments.
#[derive(Clone, Default)]
pub(in crate::model) struct SegmentChanges {
    /// Coordinates and velocities of their parents at the beginning of a step, map by map.
    from: [Vec<f64>; 2],
    /// Changes ahead: node, overshoot, next segment.
    overshoots: Vec<(u32, f64, usize)>,
    /// Before a change: momenta at all nodes, operators and segments of the mapped ones.
    momenta: Vec<f64>,
    B: Vec<f64>,
    segments: Vec<usize>,
}

impl Events for Context {
    fn kinks(&self) -> Vec<f64> {
        let prescribed = self.model.prescribed.iter();
        let prescribed = prescribed.flat_map(|p| p.function.kinks());
        let loads = self.model.elements.iter().flat_map(|e| e.element.kinks());
        prescribed.chain(loads).collect()
    }

    fn inputs(&mut self) -> &mut [f64] {
        &mut self.state.inputs
    }

    fn value(&mut self, from: Point<'_>, to: Point<'_>) -> f64 {
        self.collect_overshoots(from, to);
        let ahead = self.work.segment_changes.overshoots.iter();
        ahead.fold(f64::NEG_INFINITY, |most, (_, by, _)| most.max(*by))
    }

    fn apply(&mut self, from: Point<'_>, to: Point<'_>, since: f64) {
        self.collect_overshoots(from, to);
        for (n, by, segment) in &self.work.segment_changes.overshoots {
            let mapped = self.model.nodes[*n as usize].mapped();
            if let Some(d) = mapped.filter(|_| *by >= since)
                && let Some(state) = self.state.maps[d.index].state()
            {
                state.enter(*segment);
            }
        }
    }

    fn kept_momentum(&mut self, at: Option<Point<'_>>, p: &mut [f64]) -> Result<bool, SystemError> {
        if !self.work.segments_changed {
            return Ok(false);
        }
        let mut momenta = std::mem::take(&mut self.work.segment_changes.momenta);
        let known = at.map_or(Ok(()), |at| self.node_momenta(at));
        if at.is_none() {
            self.work.r.clone_from(&momenta);
        }
        momenta.clone_from(&self.work.r);
        p.fill(0.0);
        for before in [false, true] {
            self.work.r.copy_from_slice(&momenta);
            self.pull_back_momenta(before);
            for (p, &c) in p.iter_mut().zip(&self.model.coordinates) {
                *p += 0.5 * self.work.r[c];
            }
        }
        self.work.segment_changes.momenta = momenta;
        known.map(|()| true)
    }
}

impl Context {
    fn collect_overshoots(&mut self, from: Point<'_>, to: Point<'_>) {
        let is_static = to.is_static();
        let h = if is_static { 1.0 } else { to.t - from.t };
        self.work.segment_changes.overshoots.clear();
        if self.model.nodes.segmented().next().is_none() || self.expand(from).is_err() {
            return;
        }
        let mut changes = std::mem::take(&mut self.work.segment_changes);
        changes.from.iter_mut().for_each(Vec::clear);
        let Workspace { local, x, v, .. } = &mut self.work;
        for (_, d) in self.model.nodes.segmented() {
            for (all, x) in changes.from.iter_mut().zip([&*x, &*v]) {
                let parents = d.parents(&self.state.maps);
                let k = collect(parents, &self.model.spans, x, &mut local.q);
                all.extend_from_slice(&local.q[..k]);
            }
        }
        if is_static {
            // Rates are those by the load parameter.
            changes.from[1].fill(0.0);
        }
        if self.expand(to).is_ok() {
            let Workspace { local, x, v, .. } = &mut self.work;
            let mut first = 0;
            for (n, d) in self.model.nodes.segmented() {
                let parents = d.parents(&self.state.maps);
                let k = collect(parents, &self.model.spans, x, &mut local.q);
                collect(parents, &self.model.spans, v, &mut local.qv);
                if is_static {
                    local.qv[..k].fill(0.0);
                }
                let from = changes.from.each_ref().map(|all| &all[first..first + k]);
                let to = [&local.q[..k], &local.qv[..k]];
                let map = self.state.maps[d.index].segments();
                let overshoot = map.and_then(|map| map.overshoot(h, from, to));
                changes
                    .overshoots
                    .extend(overshoot.map(|(by, segment)| (n, by, segment)));
                first += k;
            }
        }
        self.work.segment_changes = changes;
    }

    /// Records the momenta at the nodes, and the operators to the parents, before a possible change.
    pub(in crate::model) fn keep_momentum(&mut self, at: Point<'_>) {
        if self.model.nodes.segmented().next().is_none() {
            return;
        }
        // The forces of the accepted state are used later.
        let mut forces = std::mem::take(&mut self.work.segment_changes.momenta);
        forces.clone_from(&self.work.r);
        let known = self.node_momenta(at);
        let changes = &mut self.work.segment_changes;
        changes.momenta = std::mem::replace(&mut self.work.r, forces);
        // If a map cannot be evaluated, the next evaluation reports it.
        if known.is_err() {
            return;
        }
        changes.B.clone_from(&self.work.operators[0]);
        changes.segments.clear();
        let segments = self.state.maps.iter().map(|map| map.segment());
        changes.segments.extend(segments);
    }

    /// Pulls back from the nodes to the unknowns, by the present maps or by those before the change.
    fn pull_back_momenta(&mut self, before: bool) {
        let w = &mut self.work;
        if before {
            std::mem::swap(&mut w.operators[0], &mut w.segment_changes.B);
        }
        for (_, node, d) in self.model.nodes.mapped().rev() {
            let parents = match before {
                true => &d.segments[w.segment_changes.segments[d.index]],
                false => d.parents(&self.state.maps),
            };
            pull_back_forces(d, parents, node, &self.model.spans, w, false);
        }
        let w = &mut self.work;
        if before {
            std::mem::swap(&mut w.operators[0], &mut w.segment_changes.B);
        }
    }
}

impl Nodes {
    /// Those with several segments, and their maps.
    fn segmented(&self) -> impl Iterator<Item = (u32, &MappedNode)> {
        let mapped = self.mapped().map(|(n, _, d)| (n, d));
        mapped.filter(|(_, d)| d.segments.len() > 1)
    }
}
