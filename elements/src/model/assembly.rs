//! Assembly: the model as a [`System`]. The pattern is found once, values go straight into place.

#![allow(non_snake_case)]

use super::slots::Complement;
use super::{Attached, Model, NONE, Node, Source};
use crate::element::{ElementError, Motion, Response};
use pullback_manifold::map::KinematicsMut;
use pullback_manifold::pullback::{self, Slot, Tangents};
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

/// Buffers of one element.
#[derive(Default)]
struct Local {
    x: Vec<f64>,
    previous: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    r: Vec<f64>,
    r_t: Vec<f64>,
    K: Vec<f64>,
    C: Vec<f64>,
    M: Vec<f64>,
    S: Vec<f64>,
    /// Second set, for a pull-back in two stages.
    K2: Vec<f64>,
    C2: Vec<f64>,
    M2: Vec<f64>,
    work: Vec<f64>,
    K_sigma: Vec<f64>,
    q: Vec<f64>,
    qv: Vec<f64>,
    qa: Vec<f64>,
    complements: Vec<Complement>,
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
            local: Local {
                x: zeros(n),
                previous: zeros(n),
                v: zeros(n),
                a: zeros(n),
                r: zeros(n),
                r_t: zeros(n),
                K: zeros(n * n),
                C: zeros(n * n),
                M: zeros(n * n),
                S: zeros(n * n),
                K2: zeros(n * n),
                C2: zeros(n * n),
                M2: zeros(n * n),
                work: zeros(n),
                K_sigma: zeros(masters * masters),
                q: zeros(masters),
                qv: zeros(masters),
                qa: zeros(masters),
                complements: vec![Complement::default(); MAX_NODES],
            },
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
                local.combine(e, &self.nodes, *weights, statics, [&w.B, &w.B_dot, &w.B_ddot]);
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
    }
}

impl Local {
    fn gather(&mut self, e: &Attached, nodes: &[Node], x: &[f64], v: &[f64], a: &[f64]) {
        let mut k = 0;
        for &node in &e.nodes {
            let range = nodes[node as usize].range();
            let end = k + range.len();
            self.x[k..end].copy_from_slice(&x[range.clone()]);
            self.v[k..end].copy_from_slice(&v[range.clone()]);
            self.a[k..end].copy_from_slice(&a[range]);
            k = end;
        }
    }

    /// The previous iterate in the element's chart.
    fn gather_previous(&mut self, e: &Attached, nodes: &[Node], x: &[f64]) {
        let mut k = 0;
        for (i, &node) in e.nodes.iter().enumerate() {
            let range = nodes[node as usize].range();
            let end = k + range.len();
            self.previous[k..end].copy_from_slice(&x[range]);
            if e.switched & (1 << i) != 0 {
                let (mut v, mut a) = ([0.0; 3], [0.0; 3]);
                self.complements[i].apply(&mut self.previous[k + 3..k + 6], &mut v, &mut a);
            }
            k = end;
        }
    }

    /// Takes the nodes that the element wants in the other chart through the complement map.
    fn switch(&mut self, e: &Attached, nodes: &[Node]) -> bool {
        if e.switched == 0 {
            return false;
        }
        let mut k = 0;
        for (i, &node) in e.nodes.iter().enumerate() {
            let dim = nodes[node as usize].dim;
            if e.switched & (1 << i) != 0 {
                let psi = k + 3..k + 6;
                self.complements[i].apply(
                    &mut self.x[psi.clone()],
                    &mut self.v[psi.clone()],
                    &mut self.a[psi],
                );
            }
            k += dim;
        }
        true
    }

    fn evaluate(
        &mut self,
        e: &Attached,
        t: f64,
        statics: bool,
        weights: Option<Weights>,
        rates: bool,
        previous: bool,
    ) -> Result<(), ElementError> {
        let n = e.element.dim();
        let tangent = weights.is_some() || rates;
        let moving = tangent && !statics;
        self.r[..n].fill(0.0);
        if tangent {
            self.K[..n * n].fill(0.0);
        }
        if moving {
            self.C[..n * n].fill(0.0);
            self.M[..n * n].fill(0.0);
        }
        if rates {
            self.r_t[..n].fill(0.0);
        }
        let end = if statics { 0 } else { n };
        let at = Motion {
            t,
            x: &self.x[..n],
            v: &self.v[..end],
            a: &self.a[..end],
        };
        let mut out = Response {
            r: &mut self.r[..n],
            K: tangent.then_some(&mut self.K[..n * n]),
            C: moving.then_some(&mut self.C[..n * n]),
            M: moving.then_some(&mut self.M[..n * n]),
            r_t: rates.then_some(&mut self.r_t[..n]),
        };
        if previous {
            e.element
                .evaluate_from(&self.previous[..n], &at, &mut out)
        } else {
            e.element.evaluate(&at, &mut out)
        }
    }

    fn measure_load(&self, e: &Attached, nodes: &[Node], scales: &mut Scales) {
        let mut k = 0;
        for &node in &e.nodes {
            for kind in &nodes[node as usize].kinds {
                let force = &mut scales.force[kind.index()];
                *force = force.max(self.r[k].abs());
                k += 1;
            }
        }
    }

    /// First stage: from the element's chart to the charts of its nodes.
    fn pull_back_switch(
        &mut self,
        e: &Attached,
        nodes: &[Node],
        weights: Option<Weights>,
        statics: bool,
        rates: bool,
    ) {
        let n = e.element.dim();
        let mut k = 0;
        for (i, &node) in e.nodes.iter().enumerate() {
            if e.switched & (1 << i) != 0 {
                self.complements[i].load(&self.r[k + 3..k + 6]);
            }
            k += nodes[node as usize].dim;
        }
        let mut slots = [Slot::default(); 2 * MAX_NODES];
        let mut count = 0;
        for (i, &node) in e.nodes.iter().enumerate() {
            let dim = nodes[node as usize].dim;
            if e.switched & (1 << i) != 0 {
                // The translation is not touched: only the rotation has another chart.
                slots[count] = Slot {
                    n: 3,
                    d: 3,
                    ..Slot::default()
                };
                slots[count + 1] = self.complements[i].slot();
                count += 2;
            } else {
                slots[count] = Slot {
                    n: dim,
                    d: dim,
                    ..Slot::default()
                };
                count += 1;
            }
        }
        let slots = &slots[..count];
        if weights.is_some() || rates {
            let moving = (!statics).then_some(());
            let tangents = Tangents {
                K: Some(&self.K[..n * n]),
                C: moving.map(|()| &self.C[..n * n]),
                M: moving.map(|()| &self.M[..n * n]),
            };
            let one = |K, C, M| Weights { K, C, M };
            pullback::tangent(slots, tangents, one(1.0, 0.0, 0.0), &mut self.K2, &mut self.work);
            if !statics {
                pullback::tangent(slots, tangents, one(0.0, 1.0, 0.0), &mut self.C2, &mut self.work);
                pullback::tangent(slots, tangents, one(0.0, 0.0, 1.0), &mut self.M2, &mut self.work);
                std::mem::swap(&mut self.C, &mut self.C2);
                std::mem::swap(&mut self.M, &mut self.M2);
            }
            std::mem::swap(&mut self.K, &mut self.K2);
        }
        if rates {
            // d/dt (B_sᵀ r) at fixed unknowns = B_sᵀ ∂r/∂t + Ḃ_sᵀ r: before r is overwritten.
            pullback::residual(slots, &self.r_t, &mut self.work);
            self.r_t[..n].copy_from_slice(&self.work[..n]);
            let mut k = 0;
            for (i, &node) in e.nodes.iter().enumerate() {
                if e.switched & (1 << i) != 0 {
                    self.complements[i].add_rate(&self.r[k + 3..k + 6], &mut self.r_t[k + 3..k + 6]);
                }
                k += nodes[node as usize].dim;
            }
        }
        pullback::residual(slots, &self.r, &mut self.work);
        self.r[..n].copy_from_slice(&self.work[..n]);
    }

    /// Second stage: from the nodes' coordinates to the unknowns' blocks, with the weights.
    fn combine(
        &mut self,
        e: &Attached,
        nodes: &[Node],
        weights: Weights,
        statics: bool,
        [B, B_dot, B_ddot]: [&[f64]; 3],
    ) {
        let n = e.element.dim();
        let moving = (!statics).then_some(());
        if !e.mapped {
            if statics {
                std::mem::swap(&mut self.K, &mut self.S);
                if weights.K != 1.0 {
                    self.S[..n * n].iter_mut().for_each(|s| *s *= weights.K);
                }
            } else {
                for (k, S) in self.S[..n * n].iter_mut().enumerate() {
                    *S = weights.K * self.K[k] + weights.C * self.C[k] + weights.M * self.M[k];
                }
            }
            return;
        }
        let mut slots = [Slot::default(); MAX_NODES];
        for (slot, &node) in slots.iter_mut().zip(&e.nodes) {
            let node = &nodes[node as usize];
            *slot = match &node.source {
                Source::Own => Slot {
                    n: node.dim,
                    d: node.dim,
                    ..Slot::default()
                },
                Source::Mapped { .. } => {
                    let range = node.operator..node.operator + node.operator_len();
                    Slot {
                        n: node.dim,
                        d: node.masters_dim(),
                        B: Some(&B[range.clone()]),
                        B_dot: moving.map_or(&[], |()| &B_dot[range.clone()]),
                        B_ddot: moving.map_or(&[], |()| &B_ddot[range]),
                        // The geometric stiffness is added once per node, for the sum of forces.
                        K_sigma: &[],
                    }
                }
            };
        }
        let tangents = Tangents {
            K: Some(&self.K[..n * n]),
            C: moving.map(|()| &self.C[..n * n]),
            M: moving.map(|()| &self.M[..n * n]),
        };
        pullback::tangent(
            &slots[..e.nodes.len()],
            tangents,
            weights,
            &mut self.S,
            &mut self.work,
        );
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
                return Err(SystemError::NotFinite {
                    what: self.name(u),
                });
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

/// Where local matrices go in the pattern: found once, looked up by position afterwards.
#[derive(Default)]
pub(super) struct Placement {
    /// Per own node: row of each coordinate inside its block, [`NONE`] when prescribed.
    pub rows: Vec<Vec<u32>>,
    /// Per own node: number of its block in the pattern, [`NONE`] when all is prescribed.
    pub blocks: Vec<u32>,
    /// Per element, consecutively: own node of each block.
    pub nodes: Vec<u32>,
    /// Per element, consecutively: first value of each pair of blocks, column by column.
    pub positions: Vec<u32>,
}

impl Placement {
    /// Adds an element's local matrix `S` (d×d).
    fn scatter(&self, e: &Attached, S: &[f64], values: &mut [f64]) {
        let nodes = &self.nodes[e.first_block..e.first_block + e.blocks];
        let positions = &self.positions[e.first_position..e.first_position + e.blocks * e.blocks];
        let d = e.pulled;
        let mut column = 0;
        for (j, &nj) in nodes.iter().enumerate() {
            let columns = &self.rows[nj as usize];
            let mut row = 0;
            for (i, &ni) in nodes.iter().enumerate() {
                let rows = &self.rows[ni as usize];
                let start = positions[j * nodes.len() + i];
                if start != NONE {
                    add_block(rows, columns, &S[row + column * d..], d, &mut values[start as usize..]);
                }
                row += rows.len();
            }
            column += columns.len();
        }
    }

    /// Adds a matrix (d×d) over the blocks of own nodes, found by search.
    fn scatter_nodes(
        &self,
        nodes: &[u32],
        S: &[f64],
        d: usize,
        pattern: &BlockPattern,
        values: &mut [f64],
    ) {
        let mut column = 0;
        for &nj in nodes {
            let columns = &self.rows[nj as usize];
            let mut row = 0;
            for &ni in nodes {
                let rows = &self.rows[ni as usize];
                let (bi, bj) = (self.blocks[ni as usize], self.blocks[nj as usize]);
                if bi != NONE
                    && bj != NONE
                    && let Some(start) = pattern.find(bi as usize, bj as usize)
                {
                    add_block(rows, columns, &S[row + column * d..], d, &mut values[start..]);
                }
                row += rows.len();
            }
            column += columns.len();
        }
    }
}

/// Adds one dense block, leaving out prescribed rows and columns; `S` has leading dimension d.
#[inline]
fn add_block(rows: &[u32], columns: &[u32], S: &[f64], d: usize, values: &mut [f64]) {
    let height = rows.iter().filter(|&&r| r != NONE).count();
    if height == 6 && rows.len() == 6 && columns.len() == 6 && columns.iter().all(|&c| c != NONE) {
        for (c, values) in values[..36].chunks_exact_mut(6).enumerate() {
            for (value, s) in values.iter_mut().zip(&S[c * d..c * d + 6]) {
                *value += s;
            }
        }
        return;
    }
    for (c, &column) in columns.iter().enumerate() {
        if column == NONE {
            continue;
        }
        for (r, &row) in rows.iter().enumerate() {
            if row != NONE {
                values[row as usize + column as usize * height] += S[r + c * d];
            }
        }
    }
}
