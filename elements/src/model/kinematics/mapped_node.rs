//! Mapped nodes: kinematic operators along chains of maps, and the pull-back of forces and
//! geometric stiffness.

use crate::model::assembly::element_workspace::ElementWorkspace;
use crate::model::assembly::pull_back::Operator;
use crate::model::assembly::scatter::ScatterTarget;
use crate::model::assembly::workspace::Workspace;
use crate::model::kinematics::node_entries::{collect, distribute};
use crate::model::{Context, Node, NodeForm, Span};
use pullback_manifold::map::Parametrization;
use pullback_manifold::pullback;
use pullback_manifold::system::{ChartChanges, Point, SystemError, Weights};
use std::ops::Range;
use std::sync::Arc;

/// The maps of a [`ModelState`](crate::model::ModelState), by [`MappedNode::index`].
pub(in crate::model) type Maps = [Box<dyn Parametrization>];

/// A map and its parents.
#[derive(Clone)]
pub(in crate::model) struct MappedNode {
    /// The map in its initial chart.
    pub map: Box<dyn Parametrization>,
    /// Whether the map may change its coordinates, those of its first parent.
    pub reparametrizes: bool,
    /// Parents for each segment of the map; most maps have one.
    pub segments: Vec<Vec<u32>>,
    /// Number of coordinates of the parents.
    pub direct: usize,
    /// Index among the mapped nodes, parents first.
    pub index: usize,
    /// Whether an element or a map reads its values: it is not evaluated otherwise.
    pub read: bool,
    /// Where its operators are among those of all mapped nodes.
    pub operators: Range<usize>,
}

/// B, Ḃ and B̈ of all mapped nodes, one after the other.
pub(in crate::model) type Operators = [Vec<f64>; 3];

impl MappedNode {
    /// A map of some parents.
    pub(in crate::model) fn of(map: Box<dyn Parametrization>, parents: Vec<u32>) -> Box<Self> {
        Self::along(map, vec![parents])
    }

    /// A map with different parents in its segments.
    pub(in crate::model) fn along(
        mut map: Box<dyn Parametrization>,
        segments: Vec<Vec<u32>>,
    ) -> Box<Self> {
        Box::new(Self {
            reparametrizes: map.reparametrization().is_some(),
            direct: map.dims().0,
            map,
            segments,
            index: 0,
            read: true,
            operators: 0..0,
        })
    }

    /// The parents in the initial segment.
    pub(in crate::model) fn initial_parents(&self) -> &[u32] {
        &self.segments[self.map.segment()]
    }

    /// The present parents.
    pub(in crate::model) fn parents(&self, maps: &Maps) -> &[u32] {
        &self.segments[maps[self.index].segment()]
    }

    /// r·B v of the parents: the part of the power of a force `r` at a mapped node that belongs to
    /// its parents (the rest, r·∂φ/∂t, belongs to the map).
    pub(in crate::model) fn carried_power(
        &self,
        parents: &[u32],
        r: &[f64],
        spans: &[Span],
        v: &[f64],
        operators: &Operators,
    ) -> f64 {
        let parents = parents.iter();
        let columns = parents.flat_map(|&m| spans[m as usize].range());
        let forces = pullback::transposed(&operators[0][self.operators.clone()], r);
        columns.zip(forces).map(|(c, force)| force * v[c]).sum()
    }
}

impl Context {
    /// Evaluates coordinates, velocities, accelerations and operators of all mapped nodes.
    pub(in crate::model) fn expand_dependent(&mut self, t: f64) -> Result<(), SystemError> {
        (0..self.model.nodes.mapped.len())
            .try_for_each(|k| self.expand_node(t, self.model.nodes.mapped[k]))
    }

    /// The same for one node, if it is mapped.
    pub(in crate::model) fn expand_node(&mut self, t: f64, n: u32) -> Result<(), SystemError> {
        let (w, spans) = (&mut self.work, &self.model.spans);
        let node = &self.model.nodes[n as usize];
        let Some(d) = node.mapped().filter(|d| d.read) else {
            return Ok(());
        };
        let parents = d.parents(&self.state.maps);
        let (map, k) = (&mut self.state.maps[d.index], d.direct);
        let ElementWorkspace { q, qv, qa, .. } = &mut w.local;
        for (all, own) in [(&w.x, &mut *q), (&w.v, qv), (&w.a, qa)] {
            collect(parents, spans, all, own);
        }
        let [q, v, a] = [q, qv, qa].map(|x| &x[..k]);
        let what = || match d.initial_parents() == [node.partner] {
            true => format!("rotation of node {}", node.name),
            false => format!("joint at node {}", node.name),
        };
        map.domain(t, q)
            .map_err(|why| SystemError::Domain { what: what(), why })?;
        let own = node.range();
        let [x, v_own, a_own] = [&mut w.x, &mut w.v, &mut w.a].map(|x| &mut x[own.clone()]);
        let B = w.operators.each_mut();
        let [B, B_dot, B_ddot] = B.map(|B| &mut B[d.operators.clone()]);
        map.evaluate(t, [q, v, a], &mut [[x, B], [v_own, B_dot], [a_own, B_ddot]]);
        match w.x[own].iter().all(|x| x.is_finite()) {
            true => Ok(()),
            false => Err(SystemError::NotFinite { what: what() }),
        }
    }

    /// Pulls the forces at mapped nodes back to their parents, the last link of a chain first, and
    /// the rows of the tangent at these nodes, with the geometric stiffness of each map.
    pub(in crate::model) fn pull_back_nodes(
        &mut self,
        t: f64,
        mut S: Option<(Weights, &mut [f64])>,
        [statics, rates]: [bool; 2],
    ) {
        let w = &mut self.work;
        let all = self.model.nodes.mapped().rev();
        for (n, node, d) in all.filter(|(_, _, d)| d.read) {
            let parents = d.parents(&self.state.maps);
            let map = &mut self.state.maps[d.index];
            pull_back_forces(d, parents, node, &self.model.spans, w, rates);
            let Some((weights, values)) = &mut S else {
                continue;
            };
            if d.direct == 0 || !w.scatter_map.couplings.0[d.index].loaded {
                continue;
            }
            let mut into = ScatterTarget::new(values, &mut w.coupled, weights, statics);
            let ElementWorkspace { q, K_sigma, .. } = &mut w.local;
            let K_sigma = &mut K_sigma[..d.direct * d.direct];
            match into.needed.start {
                0 => {
                    let k = collect(parents, &self.model.spans, &w.x, q);
                    map.geometric_stiffness(t, &q[..k], &w.r[node.range()], K_sigma);
                }
                _ => K_sigma.fill(0.0),
            }
            let B = w.operators.each_ref().map(|B| &B[d.operators.clone()]);
            let nodes = &self.model.nodes;
            let of_poses = [n, parents[0]].map(|n| nodes[n as usize].form == NodeForm::Pose);
            let operator = Operator::new(node.dim, B, of_poses == [true; 2]);
            let (map, work) = (&w.scatter_map, &mut w.scratch);
            map.pull_back(d.index, operator, K_sigma, &mut into, work);
        }
    }

    /// Lets the maps change their charts, parents first, so that a node sees the new charts of its
    /// parents, and is not evaluated in a chart that it leaves. After a change of segment the positions of all tangents are
    /// updated.
    pub(in crate::model) fn update_maps(
        &mut self,
        at: Point<'_>,
    ) -> Result<ChartChanges, SystemError> {
        let t = at.t;
        self.take_inputs();
        let mut stale = !self.work.known.is(at);
        if stale {
            self.expand_own(at)?;
        }
        let mut all = ChartChanges::default();
        let mut moved = false;
        let model = Arc::clone(&self.model);
        for (n, _, d) in model.nodes.mapped().filter(|(_, _, d)| d.read) {
            let (w, maps) = (&mut self.work, &mut self.state.maps);
            let before = maps[d.index].segment();
            // On a new segment the map has other parents, and may need other charts.
            for _ in 0..3 {
                let len = collect(d.parents(maps), &model.spans, &w.x, &mut w.local.q);
                let Some(state) = maps[d.index].state() else {
                    break;
                };
                let changes = state.change_charts(t, &w.local.q[..len]);
                if changes == ChartChanges::default() {
                    break;
                }
                stale = true;
                w.known.forget();
                all.charts += changes.charts;
                all.residual |= changes.residual;
            }
            moved |= maps[d.index].segment() != before;
            if stale {
                self.expand_node(t, n)?;
            }
        }
        if moved {
            self.work.segments_changed = true;
            self.locate_tangents();
        }
        self.work.known.set(at);
        Ok(all)
    }

    /// Finds the positions of all tangents for the present segments.
    pub(in crate::model) fn locate_tangents(&mut self) {
        self.work.scatter_map.locate(
            &self.model.nodes,
            &self.state.maps,
            &self.model.elements,
            &self.model.pattern,
        );
    }
}

/// Adds Bᵀ r (and its rate) to the parents' residuals.
pub(in crate::model) fn pull_back_forces(
    d: &MappedNode,
    parents: &[u32],
    node: &Node,
    spans: &[Span],
    w: &mut Workspace,
    rates: bool,
) {
    let [B, B_dot, _] = w.operators.each_ref().map(|B| &B[d.operators.clone()]);
    let (f, f_t) = (&mut w.local.q, &mut w.local.qv);
    let pull_back = |B: &[f64], r: &[f64], out: &mut [f64]| {
        out.iter_mut()
            .zip(pullback::transposed(B, r))
            .for_each(|(o, f)| *o += f);
    };
    f[..d.direct].fill(0.0);
    pull_back(B, &w.r[node.range()], f);
    distribute(parents, spans, &f[..d.direct], &mut w.r);
    if rates {
        // d/dt (Bᵀ r) at fixed unknowns.
        f_t[..d.direct].fill(0.0);
        pull_back(B, &w.r_t[node.range()], f_t);
        pull_back(B_dot, &w.r[node.range()], f_t);
        distribute(parents, spans, &f_t[..d.direct], &mut w.r_t);
    }
}
