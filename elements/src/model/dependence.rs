//! Nodes that follow from other nodes: kinematic operators along chains of maps, forces and
//! geometric stiffness handed back from the last link to the first.

#![allow(non_snake_case)]

use super::ancestry::find_ancestors;
use super::assembly::Workspace;
use super::gather::collect;
use super::{Model, Node, Source, Span};
use pullback_manifold::map::{KinematicsMut, Parametrization};
use pullback_manifold::pullback::{self, Slot, Tangents};
use pullback_manifold::system::{ChartChanges, Point, SystemError, Weights};

/// How a node follows: its map, the nodes that the map reads, and the own nodes behind those.
pub(super) struct Dependence {
    pub map: Box<dyn Parametrization>,
    /// Masters for each segment that the map can be on; a single set for most maps.
    pub segments: Vec<Vec<u32>>,
    /// Own nodes behind the masters in use, in their order; a node may stand there twice.
    pub ancestors: Vec<u32>,
    /// Coordinates of the masters.
    pub direct: usize,
    /// Coordinates of the ancestors in use, and the most of any segment.
    pub pulled: usize,
    pub most: usize,
    /// Whether a master follows other nodes itself: the operators are then multiplied.
    pub chained: bool,
    /// First values of the operators with respect to the masters and to the ancestors.
    pub local: usize,
    pub total: usize,
}

/// B, Ḃ and B̈ of all dependent nodes, one after the other.
#[derive(Default)]
pub(super) struct Operators {
    pub B: Vec<f64>,
    pub B_dot: Vec<f64>,
    pub B_ddot: Vec<f64>,
}

impl Operators {
    pub(super) fn new(len: usize) -> Self {
        Self {
            B: vec![0.0; len],
            B_dot: vec![0.0; len],
            B_ddot: vec![0.0; len],
        }
    }
}

impl Dependence {
    pub(super) fn new(
        map: Box<dyn Parametrization>,
        segments: Vec<Vec<u32>>,
        direct: usize,
    ) -> Self {
        Self {
            map,
            segments,
            ancestors: Vec::new(),
            direct,
            pulled: 0,
            most: 0,
            chained: false,
            local: 0,
            total: 0,
        }
    }

    /// The nodes that the map reads at present.
    pub(super) fn masters(&self) -> &[u32] {
        &self.segments[self.map.segment()]
    }

    /// Kinematic operators as a slot of an element at a node of `n` coordinates. The geometric
    /// stiffness is added once per node, for the sum of its forces.
    pub(super) fn slot<'a>(&self, n: usize, operators: &'a Operators, moving: bool) -> Slot<'a> {
        let range = self.total..self.total + n * self.pulled;
        Slot {
            n,
            d: self.pulled,
            B: Some(&operators.B[range.clone()]),
            B_dot: if moving {
                &operators.B_dot[range.clone()]
            } else {
                &[]
            },
            B_ddot: if moving {
                &operators.B_ddot[range]
            } else {
                &[]
            },
            K_sigma: &[],
        }
    }

    /// r·B v of the masters: the part of the power of a force `r` at a dependent node that comes
    /// through its masters (the rest, r·∂φ/∂t, is the map's own).
    pub(super) fn carried_power(
        &self,
        r: &[f64],
        spans: &[Span],
        v: &[f64],
        operators: &Operators,
    ) -> f64 {
        let masters = self.masters().iter();
        let columns = masters.flat_map(|&m| spans[m as usize].range());
        let B = operators.B[self.local..].chunks_exact(r.len());
        let power = |(c, B): (usize, &[f64])| {
            let force: f64 = B.iter().zip(r).map(|(B, r)| B * r).sum();
            force * v[c]
        };
        columns.zip(B).map(power).sum()
    }

    /// Operators with respect to the ancestors from those with respect to the masters.
    fn multiply(&self, n: usize, nodes: &[Node], operators: &mut Operators) {
        // Everything that the masters need lies before this node's own values.
        let (B_of, B) = operators.B.split_at_mut(self.local);
        let (B_dot_of, B_dot) = operators.B_dot.split_at_mut(self.local);
        let (B_ddot_of, B_ddot) = operators.B_ddot.split_at_mut(self.local);
        let len = n * self.direct;
        let (b, B) = B.split_at_mut(len);
        let (b_dot, B_dot) = B_dot.split_at_mut(len);
        let (b_ddot, B_ddot) = B_ddot.split_at_mut(len);
        let (mut row, mut column) = (0, 0);
        for &master in self.masters() {
            let master = &nodes[master as usize];
            match &master.source {
                Source::Own => {
                    let (from, len) = (row * n, master.dim * n);
                    let to = column * n;
                    B[to..to + len].copy_from_slice(&b[from..from + len]);
                    B_dot[to..to + len].copy_from_slice(&b_dot[from..from + len]);
                    B_ddot[to..to + len].copy_from_slice(&b_ddot[from..from + len]);
                    column += master.dim;
                }
                Source::Mapped(above) => {
                    for c in 0..above.pulled {
                        let of = above.total + c * master.dim;
                        for i in 0..n {
                            let (mut x, mut v, mut a) = (0.0, 0.0, 0.0);
                            for k in 0..master.dim {
                                let at = i + (row + k) * n;
                                let (P, P_dot) = (B_of[of + k], B_dot_of[of + k]);
                                x += b[at] * P;
                                v += b_dot[at] * P + b[at] * P_dot;
                                a += b_ddot[at] * P
                                    + 2.0 * b_dot[at] * P_dot
                                    + b[at] * B_ddot_of[of + k];
                            }
                            let to = i + (column + c) * n;
                            (B[to], B_dot[to], B_ddot[to]) = (x, v, a);
                        }
                    }
                    column += above.pulled;
                }
            }
            row += master.dim;
        }
    }
}

impl Model {
    /// Coordinates, velocities, accelerations and operators of all nodes that follow others.
    pub(super) fn expand_dependent(&mut self, t: f64) -> Result<(), SystemError> {
        let w = &mut self.work;
        for &n in &self.dependent {
            let node = &self.nodes[n as usize];
            let Source::Mapped(d) = &node.source else {
                continue;
            };
            let local = &mut w.local;
            let k = collect(d.masters(), &self.spans, &w.x, &mut local.q);
            collect(d.masters(), &self.spans, &w.v, &mut local.qv);
            collect(d.masters(), &self.spans, &w.a, &mut local.qa);
            let margin = d.map.margin(t, &local.q[..k]);
            if margin.is_nan() || margin <= 0.0 {
                let what = format!("joint at node {}", node.name);
                return Err(SystemError::OutsideChart {
                    edge: d.map.edge(),
                    what: match d.map.trouble(t, &local.q[..k]) {
                        Some(trouble) => format!("{what} ({trouble})"),
                        None => what,
                    },
                    margin,
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
            d.map.kinematics(t, q, v, a, out);
            if d.chained {
                d.multiply(node.dim, &self.nodes, &mut w.operators);
            }
        }
        Ok(())
    }

    /// Hands the forces at dependent nodes to their masters, the last link of a chain first, and
    /// adds the geometric stiffness of each map.
    pub(super) fn pull_back_nodes(
        &mut self,
        t: f64,
        mut S: Option<(Weights, &mut [f64])>,
        rates: bool,
    ) {
        let w = &mut self.work;
        for &n in self.dependent.iter().rev() {
            let node = &self.nodes[n as usize];
            let Source::Mapped(d) = &node.source else {
                continue;
            };
            hand_back(d, node, &self.spans, w, rates);
            let Some((weights, values)) = &mut S else {
                continue;
            };
            let k = collect(d.masters(), &self.spans, &w.x, &mut w.local.q);
            let local = &mut w.local;
            let K_sigma = &mut local.K_sigma[..k * k];
            d.map
                .geometric_stiffness(t, &local.q[..k], &w.r[node.range()], K_sigma);
            if K_sigma.iter().all(|k| *k == 0.0) {
                continue;
            }
            // K_mr has −K_σ; the pull-back to the ancestors is that of any stiffness.
            let minus = Weights {
                K: -weights.K,
                C: 0.0,
                M: 0.0,
            };
            let pulled = if d.chained {
                let mut slots = [Slot::default(); super::assembly::MAX_NODES];
                for (slot, &m) in slots.iter_mut().zip(d.masters()) {
                    *slot = self.nodes[m as usize].slot(&w.operators, false);
                }
                let stiffness = Tangents {
                    K: Some(K_sigma),
                    ..Tangents::default()
                };
                let slots = &slots[..d.masters().len()];
                pullback::tangent(slots, stiffness, minus, &mut local.S, &mut local.work);
                &local.S[..d.pulled * d.pulled]
            } else {
                K_sigma.iter_mut().for_each(|k| *k *= minus.K);
                &*K_sigma
            };
            let (own, pulled) = (&d.ancestors, (pulled, d.pulled));
            self.placement
                .scatter_nodes(own, &self.spans, pulled, &self.pattern, values);
        }
    }

    /// Lets the maps change their charts, masters first: a node sees those of its masters changed
    /// already. Where one has moved on to another segment, the places of all tangents are found anew.
    pub(super) fn update_maps(&mut self, t: f64, q: &[f64]) -> Result<ChartChanges, SystemError> {
        let at = Point {
            t,
            q,
            v: &[],
            a: &[],
        };
        self.expand(at)?;
        let mut all = ChartChanges::default();
        let (mut changed, mut moved) = (false, false);
        for &n in &self.dependent {
            let node = &mut self.nodes[n as usize];
            let own = node.range();
            let Source::Mapped(d) = &mut node.source else {
                continue;
            };
            let w = &mut self.work;
            let before = d.map.segment();
            // On a new segment the map reads other masters, and may want other charts for them.
            for _ in 0..3 {
                let len = collect(d.masters(), &self.spans, &w.x, &mut w.local.q);
                let changes = d.map.change_charts(t, &w.local.q[..len]);
                if changes == ChartChanges::default() {
                    break;
                }
                changed = true;
                all.charts += changes.charts;
                all.residual |= changes.residual;
            }
            if changed {
                let len = collect(d.masters(), &self.spans, &w.x, &mut w.local.q);
                let B = &mut w.operators.B[d.local..d.local + own.len() * d.direct];
                d.map.tangent(t, &w.local.q[..len], &mut w.x[own], B);
            }
            moved |= d.map.segment() != before;
        }
        if moved {
            self.work.handed_over = true;
            for &n in &self.dependent {
                find_ancestors(&mut self.nodes, n as usize);
            }
            self.placement
                .locate(&self.nodes, &mut self.elements, &self.pattern);
        }
        if changed {
            self.expand(at)?;
        }
        Ok(all)
    }
}

/// Adds Bᵀ r (and its rate) to the masters' residuals.
fn hand_back(d: &Dependence, node: &Node, spans: &[Span], w: &mut Workspace, rates: bool) {
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
    for &m in d.masters() {
        for c in spans[m as usize].range() {
            w.r[c] += f[k];
            if rates {
                w.r_t[c] += f_t[k] + df[k];
            }
            k += 1;
        }
    }
}
