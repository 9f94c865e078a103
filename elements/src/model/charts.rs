//! Which chart each node and each element uses, decided at converged states only.

use super::dependence::collect;
use super::slots::Complement;
use super::{Form, Model, Node, Source};
use nalgebra::Vector3;
use pullback_manifold::so3;
use pullback_manifold::system::{ChartChanges, Point};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Gain in angle (rad) that makes an element move to the other chart: hysteresis, so that an
/// element on the border does not change to and fro.
const HYSTERESIS: f64 = 1e-6;

impl Model {
    /// Which of its nodes each element takes through the complement map (bit k for node k): what
    /// a model remembers of its way besides the coordinates.
    pub fn element_charts(&self) -> Vec<u32> {
        self.elements.iter().map(|e| e.switched).collect()
    }

    /// Goes on from what [`Model::element_charts`] gave for the same model; entries beyond its
    /// elements are ignored.
    pub fn set_element_charts(&mut self, charts: &[u32]) {
        for (e, &switched) in self.elements.iter_mut().zip(charts) {
            e.switched = switched;
        }
    }

    /// What the maps that nodes follow through remember of their way, map by map: the coordinates
    /// that a closed loop has chosen, and from where it is solved.
    pub fn map_memories(&self) -> Vec<Vec<f64>> {
        let memory = |&n: &u32| match &self.nodes[n as usize].source {
            Source::Mapped(d) => d.map.memory(),
            Source::Own => Vec::new(),
        };
        self.dependent.iter().map(memory).collect()
    }

    /// Goes on from what [`Model::map_memories`] gave for the same model; false where it is not of
    /// this model.
    #[must_use]
    pub fn recall_maps(&mut self, memories: &[Vec<f64>]) -> bool {
        let same = memories.len() == self.dependent.len();
        same && (self.dependent.iter().zip(memories)).all(|(&n, memory)| {
            match &mut self.nodes[n as usize].source {
                Source::Mapped(d) => d.map.recall(memory),
                Source::Own => false,
            }
        })
    }

    /// Changes the charts of nodes with ψ > π, then lets the elements choose theirs.
    pub(super) fn update_charts(
        &mut self,
        t: f64,
        q: &mut [f64],
        v: &mut [f64],
        accelerations: &mut [&mut [f64]],
    ) -> ChartChanges {
        let mut changed = self.fold_driven_rotations(t);
        for node in 0..self.nodes.len() {
            let Some(unknowns) = self.free_rotation(node) else {
                continue;
            };
            let take = |from: &[f64]| Vector3::from_fn(|i, _| unknowns[i].map_or(0.0, |u| from[u]));
            let psi = take(q);
            if psi.norm() <= PI {
                continue;
            }
            changed += 1;
            let put = |to: &mut [f64], from: &Vector3<f64>| {
                for (u, x) in unknowns.iter().zip(from.iter()) {
                    if let Some(u) = *u {
                        to[u] = *x;
                    }
                }
            };
            let velocity = if v.is_empty() {
                Vector3::zeros()
            } else {
                take(v)
            };
            let mut x = psi;
            let mut first = velocity;
            for a in accelerations.iter_mut() {
                x = psi;
                first = velocity;
                let mut second = take(a);
                Complement::default().apply(
                    x.as_mut_slice(),
                    first.as_mut_slice(),
                    second.as_mut_slice(),
                );
                put(a, &second);
            }
            if accelerations.is_empty() {
                let mut second = Vector3::zeros();
                Complement::default().apply(
                    x.as_mut_slice(),
                    first.as_mut_slice(),
                    second.as_mut_slice(),
                );
            }
            put(q, &x);
            if !v.is_empty() {
                put(v, &first);
            }
        }
        changed += self.rewrite_coordinates(t, q, v, accelerations);
        self.work.handed_over = false;
        if let (false, Some(a)) = (v.is_empty(), accelerations.first()) {
            self.keep_momentum(Point { t, q, v, a });
        }
        // Where a map cannot be evaluated, the next evaluation says so.
        let Ok(maps) = self.update_maps(t, q) else {
            return ChartChanges {
                charts: changed,
                residual: false,
            };
        };
        ChartChanges {
            charts: changed + maps.charts,
            residual: self.choose_element_charts() || maps.residual,
        }
    }

    /// Lets maps choose other coordinates of their own for the same x, ẋ, ẍ. These are free
    /// coordinates of one own node, the first master, which nobody else uses: seen to when the
    /// model is built.
    fn rewrite_coordinates(
        &mut self,
        t: f64,
        q: &mut [f64],
        v: &mut [f64],
        accelerations: &mut [&mut [f64]],
    ) -> usize {
        let mut changed = 0;
        for k in 0..self.dependent.len() {
            let n = self.dependent[k] as usize;
            let rewrites = match &self.nodes[n].source {
                Source::Mapped(d) => d.map.rewrites(),
                Source::Own => false,
            };
            if !rewrites || !self.collect_masters(n, t, q, v, accelerations) {
                continue;
            }
            let Source::Mapped(d) = &mut self.nodes[n].source else {
                continue;
            };
            let (own, buffers) = (&mut self.work.local, &mut self.work.accelerations);
            let (x, x_dot) = (&mut own.q[..d.direct], &mut own.qv[..d.direct]);
            let x_ddot = &mut buffers[..accelerations.len()];
            if !d.map.rewrite(t, x, x_dot, x_ddot) {
                continue;
            }
            changed += 1;
            let range = self.spans[d.masters()[0] as usize].range();
            for (i, c) in range.enumerate() {
                let u = self.unknowns[c] as usize;
                q[u] = x[i];
                if !v.is_empty() {
                    v[u] = x_dot[i];
                }
                for (a, x_ddot) in accelerations.iter_mut().zip(&*x_ddot) {
                    a[u] = x_ddot[i];
                }
            }
        }
        changed
    }

    /// Coordinates, velocities and all accelerations of the masters of node n, into the workspace;
    /// false where the point is outside a chart, which the next evaluation says.
    fn collect_masters(
        &mut self,
        n: usize,
        t: f64,
        q: &[f64],
        v: &[f64],
        accelerations: &[&mut [f64]],
    ) -> bool {
        let rest: Vec<f64> = match (accelerations.is_empty(), v.is_empty()) {
            (true, false) => vec![0.0; v.len()],
            _ => Vec::new(),
        };
        for k in 0..accelerations.len().max(1) {
            let a = accelerations.get(k).map_or(&rest[..], |a| a);
            if self.expand(Point { t, q, v, a }).is_err() {
                return false;
            }
            let Source::Mapped(d) = &self.nodes[n].source else {
                return false;
            };
            let w = &mut self.work;
            collect(d.masters(), &self.spans, &w.x, &mut w.local.q);
            collect(d.masters(), &self.spans, &w.v, &mut w.local.qv);
            if w.accelerations.len() <= k {
                w.accelerations.push(Vec::new());
            }
            w.accelerations[k].resize(d.direct, 0.0);
            collect(d.masters(), &self.spans, &w.a, &mut w.accelerations[k]);
        }
        true
    }

    /// Keeps the momentum where a map may be handed over.
    fn keep_momentum(&mut self, at: Point<'_>) {
        let travels = |n: &Node| match &n.source {
            Source::Mapped(d) => d.segments.len() > 1,
            Source::Own => false,
        };
        if self.nodes.iter().any(travels) {
            let mut kept = std::mem::take(&mut self.work.kept);
            kept.resize(at.q.len(), 0.0);
            // Where a map cannot be evaluated, the next evaluation says so.
            self.generalised_momentum(at, &mut kept).ok();
            self.work.kept = kept;
        }
    }

    /// The unknowns of a node's rotation if its chart can be changed: the node is no joint's
    /// slave, something of the rotation is free, and what is prescribed is and stays zero. (A
    /// component that is driven means another constraint in the other chart.)
    fn free_rotation(&self, node: usize) -> Option<[Option<usize>; 3]> {
        let node = &self.nodes[node];
        let first = node.rotation().filter(|_| node.is_own())?;
        let unknowns = std::array::from_fn(|i| {
            let u = self.unknowns[first + i];
            (u != super::NONE).then_some(u as usize)
        });
        if unknowns.iter().all(Option::is_none) {
            return None;
        }
        let held = |p: &&super::Prescribed| (first..first + 3).contains(&p.coordinate);
        self.prescribed
            .iter()
            .filter(held)
            .all(|p| p.function.is_zero())
            .then_some(unknowns)
    }

    fn fold_driven_rotations(&mut self, t: f64) -> usize {
        let mut changed = 0;
        for (node, turns) in &mut self.driven_rotations {
            let first = self.nodes[*node].first + 3;
            let mut psi = Vector3::zeros();
            for p in &self.prescribed {
                if (first..first + 3).contains(&p.coordinate) {
                    psi[p.coordinate - first] = p.function.at(t)[0];
                }
            }
            // Nearest whole number of turns, with the same switch at ψ > π as for free nodes.
            let wanted = (psi.norm() / TAU - 1e-12).round() as i32;
            if wanted != *turns {
                *turns = wanted;
                changed += 1;
            }
        }
        changed
    }

    /// Each element evaluates its nodes in one common chart: the one in which the largest
    /// rotation angle is smallest. Nodes that are stored in the other chart go through the
    /// complement map. The choice does not depend on how the nodes are stored. Returns whether
    /// any element changed.
    ///
    /// The configuration is the one last expanded.
    pub(super) fn choose_element_charts(&mut self) -> bool {
        let w = &mut self.work;
        w.sheets.clear();
        w.sheets.extend(self.nodes.iter().map(|n| match n.form {
            Form::Frame => Sheet::new(&w.x[n.first + 3..n.first + 6]),
            _ => Sheet::default(),
        }));
        let mut changed = false;
        for e in &mut self.elements {
            let sheets = e.nodes.iter().map(|n| &w.sheets[*n as usize]);
            // Below a right angle all quaternions are within 45° of (1, 0): they agree.
            let plain = e.switched == 0 && sheets.clone().all(|s| s.angle < FRAC_PI_2);
            if plain {
                continue;
            }
            let switched = choose(e.switched, sheets);
            changed |= switched != e.switched;
            e.switched = switched;
        }
        changed
    }
}

/// A node's rotation angle, and its quaternion where charts may be in question.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheet {
    frame: bool,
    angle: f64,
    quaternion: so3::Quaternion<f64>,
}

impl Default for Sheet {
    fn default() -> Self {
        Self {
            frame: false,
            angle: 0.0,
            quaternion: so3::quaternion(&Vector3::zeros()),
        }
    }
}

impl Sheet {
    fn new(psi: &[f64]) -> Self {
        let psi = Vector3::new(psi[0], psi[1], psi[2]);
        Self {
            frame: true,
            angle: psi.norm(),
            quaternion: so3::quaternion(&psi),
        }
    }
}

/// Which nodes of an element go through the complement map (bit k for node k).
fn choose<'a>(before: u32, sheets: impl Iterator<Item = &'a Sheet>) -> u32 {
    // Two candidates: all quaternions on the side of the first one, or all opposite.
    let mut reference: Option<so3::Quaternion<f64>> = None;
    let (mut count, mut opposite, mut all) = (0, 0_u32, 0_u32);
    let (mut as_first, mut as_other) = (0.0_f64, 0.0_f64);
    for (k, sheet) in sheets.enumerate().filter(|(_, s)| s.frame) {
        let first = *reference.get_or_insert(sheet.quaternion);
        let angle = sheet.angle;
        all |= 1 << k;
        count += 1;
        if first.dot(&sheet.quaternion) < 0.0 {
            opposite |= 1 << k;
            as_first = as_first.max(TAU - angle);
            as_other = as_other.max(angle);
        } else {
            as_first = as_first.max(angle);
            as_other = as_other.max(TAU - angle);
        }
    }
    let other = all & !opposite;
    let better = if before == other {
        as_other <= as_first + HYSTERESIS
    } else {
        as_other < as_first - HYSTERESIS
    };
    // A single node has no neighbour to agree with.
    match (count >= 2, better) {
        (false, _) => 0,
        (true, true) => other,
        (true, false) => opposite,
    }
}
