//! Mapped nodes: kinematic operators along chains of maps, and the pull-back of forces and
//! geometric stiffness.

#![allow(non_snake_case)]

use crate::model::assembly::element_workspace::ElementWorkspace;
use crate::model::assembly::scatter::{Group, ScatterTarget};
use crate::model::assembly::workspace::Workspace;
use crate::model::build::dependency_graph::{Ancestors, Dependencies};
use crate::model::kinematics::node_entries::collect;
use crate::model::{Context, Node, Source, Span};
use pullback_manifold::map::{KinematicsMut, Parametrization};
use pullback_manifold::pullback::{self, Slot, Tangents};
use pullback_manifold::system::{ChartChanges, Point, SystemError, Weights};

/// The maps of a [`State`](crate::model::State), by [`MappedNode::index`].
pub(in crate::model) type Maps = [Box<dyn Parametrization>];

/// A map and its parents.
#[derive(Clone)]
pub(in crate::model) struct MappedNode {
    /// The map in its initial chart.
    pub map: Box<dyn Parametrization>,
    /// Parents for each segment of the map; most maps have one.
    pub segments: Vec<Vec<u32>>,
    /// Number of coordinates of the parents.
    pub direct: usize,
    /// Whether a parent is mapped itself, or occurs twice: the operators are then multiplied.
    pub chained: bool,
    /// Index among the mapped nodes, parents first.
    pub index: usize,
    /// Offsets of the operators with respect to the parents and to the ancestors.
    pub local: usize,
    pub total: usize,
}

/// B, Ḃ and B̈ of all mapped nodes, one after the other.
#[derive(Clone, Default)]
pub(in crate::model) struct Operators {
    pub B: Vec<f64>,
    pub B_dot: Vec<f64>,
    pub B_ddot: Vec<f64>,
}

impl Operators {
    pub(in crate::model) fn new(len: usize) -> Self {
        Self {
            B: vec![0.0; len],
            B_dot: vec![0.0; len],
            B_ddot: vec![0.0; len],
        }
    }

    /// The operators of a node of `n` coordinates at offset `from`.
    pub(in crate::model) fn slot(&self, n: usize, from: usize) -> Slot<'_> {
        Slot {
            n,
            B: Some(&self.B[from..]),
            B_dot: &self.B_dot[from..],
            B_ddot: &self.B_ddot[from..],
            ..Slot::default()
        }
    }
}

impl MappedNode {
    pub(in crate::model) fn new(
        map: Box<dyn Parametrization>,
        segments: Vec<Vec<u32>>,
        direct: usize,
    ) -> Self {
        Self {
            map,
            segments,
            direct,
            chained: false,
            index: 0,
            local: 0,
            total: 0,
        }
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
        let forces = pullback::transposed(&operators.B[self.local..], r);
        columns.zip(forces).map(|(c, force)| force * v[c]).sum()
    }

    /// Computes operators with respect to the ancestors from those with respect to the parents: B,
    /// and Ḃ and B̈ if `moving`.
    fn multiply(
        &self,
        n: usize,
        nodes: &[Node],
        parents: &[u32],
        dependencies: &Dependencies,
        operators: &mut Operators,
        moving: bool,
    ) {
        let Ancestors {
            columns,
            coordinates,
            ..
        } = &dependencies.0[self.index];
        let (len, total) = (n * self.direct, n * coordinates);
        // All values of the parents are stored before those of this node.
        let parts = [
            &mut operators.B,
            &mut operators.B_dot,
            &mut operators.B_ddot,
        ];
        let [
            (above, own, out),
            (above_dot, own_dot, out_dot),
            (above_ddot, own_ddot, out_ddot),
        ] = parts.map(|all| {
            let (above, rest) = all.split_at_mut(self.local);
            let (own, out) = rest.split_at_mut(len);
            (&*above, &*own, &mut out[..total])
        });
        out.fill(0.0);
        if moving {
            out_dot.fill(0.0);
            out_ddot.fill(0.0);
        }
        let (mut row, mut entry) = (0, 0);
        for m in parents {
            let parent = &nodes[*m as usize];
            let dim = parent.dim;
            let local = row * n..(row + dim) * n;
            row += dim;
            let Source::Mapped(from) = &parent.source else {
                let to = columns[entry] as usize * n;
                entry += 1;
                add(&mut out[to..], &own[local.clone()], 1.0);
                if moving {
                    add(&mut out_dot[to..], &own_dot[local.clone()], 1.0);
                    add(&mut out_ddot[to..], &own_ddot[local], 1.0);
                }
                continue;
            };
            let mut of = from.total;
            for &a in &dependencies.0[from.index].nodes {
                let first = columns[entry] as usize;
                entry += 1;
                for c in first..first + nodes[a as usize].dim {
                    let to = c * n..(c + 1) * n;
                    for (k, b) in local.clone().step_by(n).enumerate() {
                        let b = b..b + n;
                        let x = above[of + k];
                        let P = &own[b.clone()];
                        add(&mut out[to.clone()], P, x);
                        if !moving {
                            continue;
                        }
                        let (v, a) = (above_dot[of + k], above_ddot[of + k]);
                        let (P_dot, P_ddot) = (&own_dot[b.clone()], &own_ddot[b]);
                        add(&mut out_dot[to.clone()], P_dot, x);
                        add(&mut out_dot[to.clone()], P, v);
                        add(&mut out_ddot[to.clone()], P_ddot, x);
                        add(&mut out_ddot[to.clone()], P_dot, 2.0 * v);
                        add(&mut out_ddot[to.clone()], P, a);
                    }
                    of += dim;
                }
            }
        }
    }
}

/// out += factor x.
fn add(out: &mut [f64], x: &[f64], factor: f64) {
    if factor != 0.0 {
        for (o, x) in out.iter_mut().zip(x) {
            *o += factor * x;
        }
    }
}

impl Context {
    /// Evaluates coordinates, velocities, accelerations and operators of all mapped nodes.
    pub(in crate::model) fn expand_dependent(&mut self, t: f64) -> Result<(), SystemError> {
        (0..self.model.dependent.len())
            .try_for_each(|k| self.expand_node(t, self.model.dependent[k]))
    }

    /// The same for one node, if it is mapped.
    pub(in crate::model) fn expand_node(&mut self, t: f64, n: u32) -> Result<(), SystemError> {
        let (w, spans) = (&mut self.work, &self.model.spans);
        let node = &self.model.nodes[n as usize];
        let Source::Mapped(d) = &node.source else {
            return Ok(());
        };
        let (map, parents) = (&self.state.maps[d.index], d.parents(&self.state.maps));
        let local = &mut w.local;
        let k = collect(parents, spans, &w.x, &mut local.q);
        collect(parents, spans, &w.v, &mut local.qv);
        collect(parents, spans, &w.a, &mut local.qa);
        let margin = map.margin(t, &local.q[..k]);
        if margin.is_nan() || margin <= 0.0 {
            let what = format!("joint at node {}", node.name);
            let edge = map.edge();
            return Err(match map.domain_error(t, &local.q[..k]) {
                Some(why) => SystemError::Unsolved { what, why },
                None => SystemError::OutsideChart { edge, what, margin },
            });
        }
        let own = node.range();
        let range = d.local..d.local + node.dim * d.direct;
        let out = KinematicsMut {
            x: &mut w.x[own.clone()],
            x_dot: &mut w.v[own.clone()],
            x_ddot: &mut w.a[own],
            B: &mut w.operators.B[range.clone()],
            B_dot: &mut w.operators.B_dot[range.clone()],
            B_ddot: &mut w.operators.B_ddot[range],
        };
        let (q, v, a) = (&local.q[..k], &local.qv[..k], &local.qa[..k]);
        map.kinematics(t, q, v, a, out);
        Ok(())
    }

    /// Computes operators of all mapped nodes with respect to own nodes, for tangents.
    pub(in crate::model) fn chain_operators(&mut self, moving: bool) {
        for &n in &self.model.dependent {
            let node = &self.model.nodes[n as usize];
            if let Source::Mapped(d) = &node.source
                && d.chained
            {
                let Workspace {
                    operators,
                    scatter_map,
                    ..
                } = &mut self.work;
                let parents = d.parents(&self.state.maps);
                let nodes = &self.model.nodes;
                let dependencies = &scatter_map.dependencies;
                d.multiply(node.dim, nodes, parents, dependencies, operators, moving);
            }
        }
    }

    /// Pulls the forces at mapped nodes back to their parents, the last link of a chain first, and
    /// the rows of the tangent at these nodes, with the geometric stiffness of each map.
    pub(in crate::model) fn pull_back_nodes(
        &mut self,
        t: f64,
        mut S: Option<(Weights, &mut [f64])>,
        rates: bool,
    ) {
        let w = &mut self.work;
        for &n in self.model.dependent.iter().rev() {
            let node = &self.model.nodes[n as usize];
            let Source::Mapped(d) = &node.source else {
                continue;
            };
            let (map, parents) = (&self.state.maps[d.index], d.parents(&self.state.maps));
            pull_back_forces(d, parents, node, &self.model.spans, w, rates);
            let Some((weights, values)) = &mut S else {
                continue;
            };
            let ElementWorkspace {
                q, K_sigma, work, ..
            } = &mut w.local;
            let mut into = ScatterTarget {
                values,
                panels: &mut w.panels,
                work,
            };
            let scatter_map = &w.scatter_map;
            if let Some(first_position) = scatter_map
                .geometric_stiffness(n)
                .filter(|_| !map.is_linear())
            {
                let k = collect(parents, &self.model.spans, &w.x, q);
                let K_sigma = &mut K_sigma[..k * k];
                map.geometric_stiffness(t, &q[..k], &w.r[node.range()], K_sigma);
                if K_sigma.iter().any(|k| *k != 0.0) {
                    // K_mr contains −K_σ; its pull-back to the ancestors is that of any stiffness.
                    let group = Group {
                        nodes: parents,
                        first_position,
                        tangents: Tangents {
                            K: Some(K_sigma),
                            ..Tangents::default()
                        },
                        weights: Weights {
                            K: -weights.K,
                            C: 0.0,
                            M: 0.0,
                        },
                    };
                    scatter_map.scatter_group(&self.model.nodes, &w.operators, &group, &mut into);
                }
            }
            scatter_map.pull_back_rows(
                n,
                &self.model.nodes,
                &self.state.maps,
                &w.operators,
                &mut into,
            );
        }
    }

    /// Lets the maps change their charts, parents first, so that a node sees the new charts of its
    /// parents. After a change of segment the positions of all tangents are updated.
    pub(in crate::model) fn update_maps(
        &mut self,
        t: f64,
        q: &[f64],
    ) -> Result<ChartChanges, SystemError> {
        let at = Point {
            t,
            q,
            v: &[],
            a: &[],
        };
        self.expand(at)?;
        let mut all = ChartChanges::default();
        let (mut changed, mut moved) = (false, false);
        for &n in &self.model.dependent {
            let node = &self.model.nodes[n as usize];
            let own = node.range();
            let Source::Mapped(d) = &node.source else {
                continue;
            };
            let (w, maps) = (&mut self.work, &mut self.state.maps);
            let before = maps[d.index].segment();
            // On a new segment the map has other parents, and may need other charts.
            for _ in 0..3 {
                let len = collect(d.parents(maps), &self.model.spans, &w.x, &mut w.local.q);
                let changes = maps[d.index].change_charts(t, &w.local.q[..len]);
                if changes == ChartChanges::default() {
                    break;
                }
                changed = true;
                all.charts += changes.charts;
                all.residual |= changes.residual;
            }
            if changed {
                let len = collect(d.parents(maps), &self.model.spans, &w.x, &mut w.local.q);
                let B = &mut w.operators.B[d.local..d.local + own.len() * d.direct];
                maps[d.index].tangent(t, &w.local.q[..len], &mut w.x[own], B);
            }
            moved |= maps[d.index].segment() != before;
        }
        if moved {
            self.work.segments_changed = true;
            self.locate_tangents();
        }
        if changed {
            self.expand(at)?;
        }
        Ok(all)
    }

    /// Finds the positions of all tangents for the present segments.
    pub(in crate::model) fn locate_tangents(&mut self) {
        self.work.scatter_map.locate(
            &self.model.nodes,
            &self.model.dependent,
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
    let range = d.local..d.local + node.dim * d.direct;
    let slot = [Slot {
        n: node.dim,
        d: d.direct,
        B: Some(&w.operators.B[range.clone()]),
        ..Slot::default()
    }];
    let slot_dot = [Slot {
        B: Some(&w.operators.B_dot[range]),
        ..slot[0]
    }];
    let (f, f_t, df) = (&mut w.local.q, &mut w.local.qv, &mut w.local.qa);
    pullback::residual(&slot, &w.r[node.range()], f);
    if rates {
        // d/dt (Bᵀ r) at fixed unknowns.
        pullback::residual(&slot, &w.r_t[node.range()], f_t);
        pullback::residual(&slot_dot, &w.r[node.range()], df);
    }
    let mut k = 0;
    for &m in parents {
        for c in spans[m as usize].range() {
            w.r[c] += f[k];
            if rates {
                w.r_t[c] += f_t[k] + df[k];
            }
            k += 1;
        }
    }
}
