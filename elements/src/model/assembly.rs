//! Assembly: the model as a [`System`]. The pattern is found once, values go straight into place.

#![allow(non_snake_case)]

use super::local::Local;
use super::{Attached, Model, Node, Source};
use crate::element::ElementError;
use pullback_manifold::map::KinematicsMut;
use pullback_manifold::pullback::{self, Slot};
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::{
    ChartChanges, Evaluation, Kind, Point, Scales, System, SystemError, Weights,
};

/// Most nodes one element may have.
pub(super) const MAX_NODES: usize = 16;

/// Buffers of an evaluation, made once.
#[derive(Default)]
pub(super) struct Workspace {
    /// Coordinates, velocities, accelerations of all nodes.
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    /// Residual at all nodes: the reactions at prescribed coordinates, with the sign changed.
    pub r: Vec<f64>,
    pub r_t: Vec<f64>,
    /// Coordinates of all nodes at the previous iterate, while there is one.
    previous: Vec<f64>,
    has_previous: bool,
    /// Kinematic operators of mapped nodes, one after the other.
    pub B: Vec<f64>,
    pub B_dot: Vec<f64>,
    pub B_ddot: Vec<f64>,
    local: Local,
    scales: Scales,
}

impl Workspace {
    pub(super) fn new(nodes: &[Node], elements: &[Attached], length: f64) -> Self {
        let total = nodes.iter().map(|n| n.dim).sum::<usize>();
        let operators = nodes.iter().map(Node::operator_len).sum::<usize>();
        let masters = nodes.iter().map(Node::masters_dim).max().unwrap_or(0);
        let n = elements
            .iter()
            .map(|e| e.element.dim().max(e.pulled))
            .max()
            .unwrap_or(0);
        let zeros = |len: usize| vec![0.0; len];
        let mut scales = Scales::default();
        scales.coordinate[Kind::Length.index()] = length;
        Self {
            x: zeros(total),
            v: zeros(total),
            a: zeros(total),
            r: zeros(total),
            r_t: zeros(total),
            previous: zeros(total),
            has_previous: false,
            B: zeros(operators),
            B_dot: zeros(operators),
            B_ddot: zeros(operators),
            local: Local::new(n, masters),
            scales,
        }
    }
}

impl Model {
    /// Coordinates (and velocities, accelerations where given) of all nodes at a point, into the
    /// workspace: own nodes first, then the mapped ones.
    pub(super) fn expand(&mut self, at: Point<'_>) -> Result<(), SystemError> {
        let statics = at.v.is_empty();
        let w = &mut self.work;
        for (u, &c) in self.coordinates.iter().enumerate() {
            w.x[c] = at.q[u];
            (w.v[c], w.a[c]) = if statics {
                (0.0, 0.0)
            } else {
                (at.v[u], at.a[u])
            };
        }
        for p in &self.prescribed {
            // In statics the velocity of a prescribed coordinate is its rate with the load
            // parameter; that of free coordinates stays zero.
            [w.x[p.coordinate], w.v[p.coordinate], w.a[p.coordinate]] = p.function.at(at.t);
        }
        for (node, turns) in &self.driven_rotations {
            let first = self.nodes[*node].first + 3;
            super::slots::fold(
                *turns,
                &mut w.x[first..first + 3],
                &mut w.v[first..first + 3],
                &mut w.a[first..first + 3],
            );
        }
        let mut operator = 0;
        for node in &self.nodes {
            let Source::Mapped { map, masters } = &node.source else {
                continue;
            };
            let d = node.masters_dim();
            let (q, qv, qa) = (
                &mut w.local.q[..d],
                &mut w.local.qv[..d],
                &mut w.local.qa[..d],
            );
            let mut k = 0;
            for &m in masters {
                let master = &self.nodes[m as usize].range();
                q[k..k + master.len()].copy_from_slice(&w.x[master.clone()]);
                qv[k..k + master.len()].copy_from_slice(&w.v[master.clone()]);
                qa[k..k + master.len()].copy_from_slice(&w.a[master.clone()]);
                k += master.len();
            }
            let margin = map.margin(q);
            if margin.is_nan() || margin <= 0.0 {
                return Err(SystemError::OutsideChart {
                    what: format!("joint at node {}", node.name),
                    margin,
                });
            }
            let own = node.range();
            let len = node.operator_len();
            map.kinematics(
                at.t,
                q,
                qv,
                qa,
                KinematicsMut {
                    x: &mut w.x[own.clone()],
                    x_dot: &mut w.v[own.clone()],
                    x_ddot: &mut w.a[own],
                    B: &mut w.B[operator..operator + len],
                    B_dot: &mut w.B_dot[operator..operator + len],
                    B_ddot: &mut w.B_ddot[operator..operator + len],
                },
            );
            operator += len;
        }
        Ok(())
    }

    /// Adds all elements: residuals to the nodes, tangents into `S`.
    fn add_elements(
        &mut self,
        t: f64,
        statics: bool,
        mut S: Option<(Weights, &mut [f64])>,
        rates: bool,
    ) -> Result<(), SystemError> {
        let w = &mut self.work;
        let local = &mut w.local;
        for e in &self.elements {
            let n = e.element.dim();
            local.gather(e, &self.nodes, &w.x, &w.v, &w.a);
            if w.has_previous {
                local.gather_previous(e, &self.nodes, &w.previous);
            }
            let switched = local.switch(e, &self.nodes);
            let weights = S.as_ref().map(|(weights, _)| *weights);
            local
                .evaluate(e, t, statics, weights, rates, w.has_previous)
                .map_err(|error| named(error, &e.name))?;
            if e.element.is_load() {
                local.measure_load(e, &self.nodes, &mut w.scales);
            }
            if rates {
                // ∂r/∂t through the nodes' motion at fixed unknowns: −K ẋ.
                for (k, &v) in local.v[..n].iter().enumerate() {
                    if v != 0.0 {
                        for (r, K) in local.r_t[..n].iter_mut().zip(&local.K[k * n..(k + 1) * n]) {
                            *r -= K * v;
                        }
                    }
                }
            }
            if switched {
                local.pull_back_switch(e, &self.nodes, weights, statics, rates);
            }
            let mut k = 0;
            for &node in &e.nodes {
                let range = self.nodes[node as usize].range();
                for c in range {
                    w.r[c] += local.r[k];
                    if rates {
                        w.r_t[c] += local.r_t[k];
                    }
                    k += 1;
                }
            }
            if let Some((weights, values)) = &mut S {
                local.combine(
                    e,
                    &self.nodes,
                    *weights,
                    statics,
                    [&w.B, &w.B_dot, &w.B_ddot],
                );
                self.placement.scatter(e, &local.S, values);
            }
        }
        Ok(())
    }

    /// Hands the forces at mapped nodes to their masters, with the geometric stiffness of the map.
    fn pull_back_nodes(&mut self, t: f64, mut S: Option<(Weights, &mut [f64])>, rates: bool) {
        let w = &mut self.work;
        let mut operator = 0;
        for node in &self.nodes {
            let Source::Mapped { map, masters } = &node.source else {
                continue;
            };
            let d = node.masters_dim();
            let len = node.operator_len();
            let own = node.range();
            let slot = [Slot {
                n: node.dim,
                d,
                B: Some(&w.B[operator..operator + len]),
                ..Slot::default()
            }];
            let slot_dot = [Slot {
                B: Some(&w.B_dot[operator..operator + len]),
                ..slot[0]
            }];
            let (f, f_t, df) = (
                &mut w.local.q[..d],
                &mut w.local.qv[..d],
                &mut w.local.qa[..d],
            );
            pullback::residual(&slot, &w.r[own.clone()], f);
            if rates {
                pullback::residual(&slot, &w.r_t[own.clone()], f_t);
                pullback::residual(&slot_dot, &w.r[own.clone()], df);
            }
            let mut k = 0;
            for &m in masters {
                for c in self.nodes[m as usize].range() {
                    w.r[c] += f[k];
                    if rates {
                        w.r_t[c] += f_t[k] + df[k];
                    }
                    k += 1;
                }
            }
            if let Some((weights, values)) = &mut S {
                let mut k = 0;
                for &m in masters {
                    for c in self.nodes[m as usize].range() {
                        f[k] = w.x[c];
                        k += 1;
                    }
                }
                let K_sigma = &mut w.local.K_sigma[..d * d];
                map.geometric_stiffness(t, f, &w.r[own], K_sigma);
                for k in K_sigma.iter_mut() {
                    *k *= -weights.K;
                }
                self.placement
                    .scatter_nodes(masters, K_sigma, d, &self.pattern, values);
            }
            operator += len;
        }
    }

    fn measure_reactions(&mut self) {
        let w = &mut self.work;
        let force = &mut w.scales.force;
        for p in &self.prescribed {
            let kind = self.kinds[p.coordinate].index();
            force[kind] = force[kind].max(w.r[p.coordinate].abs());
        }
        // Forces and moments measure each other over the size of the model: a pure moment has no
        // force to be relative to, and round-off in one shows up in the other.
        let length = w.scales.coordinate[Kind::Length.index()];
        let (f, m) = (force[0], force[1]);
        force[0] = f.max(m / length);
        force[1] = m.max(f * length);
    }
}

fn named(error: ElementError, name: &str) -> SystemError {
    match error {
        ElementError::OutsideChart { psi } => SystemError::OutsideChart {
            what: name.to_owned(),
            margin: std::f64::consts::TAU - psi,
        },
        ElementError::ZeroLength { .. } => SystemError::OutsideChart {
            what: format!("{name}, whose ends coincide,"),
            margin: 0.0,
        },
    }
}

impl System for Model {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        let statics = at.v.is_empty();
        let rates = out.r_t.is_some();
        let Evaluation { r, mut S, r_t } = out;
        self.expand(at)?;
        self.work.r.fill(0.0);
        self.work.r_t.fill(0.0);
        self.work.scales.force = [0.0; 3];
        if let Some((_, values)) = &mut S {
            values.fill(0.0);
        }
        let mut again = |S: &mut Option<(Weights, &mut [f64])>| -> Result<(), SystemError> {
            let borrow = S.as_mut().map(|(w, values)| (*w, &mut **values));
            self.add_elements(at.t, statics, borrow, rates)?;
            let borrow = S.as_mut().map(|(w, values)| (*w, &mut **values));
            self.pull_back_nodes(at.t, borrow, rates);
            Ok(())
        };
        again(&mut S)?;
        self.measure_reactions();
        for (u, &c) in self.coordinates.iter().enumerate() {
            r[u] = self.work.r[c];
            if !r[u].is_finite() {
                return Err(SystemError::NotFinite { what: self.name(u) });
            }
        }
        if let Some(r_t) = r_t {
            for (u, &c) in self.coordinates.iter().enumerate() {
                r_t[u] = self.work.r_t[c];
            }
        }
        Ok(())
    }

    fn evaluate_from(
        &mut self,
        previous: Point<'_>,
        at: Point<'_>,
        out: Evaluation<'_>,
    ) -> Result<(), SystemError> {
        self.expand(previous)?;
        std::mem::swap(&mut self.work.x, &mut self.work.previous);
        self.work.has_previous = true;
        let outcome = self.evaluate(at, out);
        self.work.has_previous = false;
        outcome
    }

    fn change_charts(
        &mut self,
        t: f64,
        q: &mut [f64],
        v: &mut [f64],
        accelerations: &mut [&mut [f64]],
    ) -> ChartChanges {
        self.update_charts(t, q, v, accelerations)
    }

    fn is_symmetric(&self) -> bool {
        self.elements.iter().all(|e| e.element.is_symmetric())
    }

    fn kind(&self, i: usize) -> Kind {
        self.kinds[self.coordinates[i]]
    }

    fn name(&self, i: usize) -> String {
        self.coordinate_name(self.coordinates[i])
    }

    fn scales(&self) -> Scales {
        self.work.scales
    }
}
