//! Charts of nodes and elements, changed at converged states only.

use crate::model::kinematics::complement::fold;
use crate::model::kinematics::node_entries::collect;
use crate::model::{Context, Model, Nodes, among};
use nalgebra::Vector3;
use pullback_manifold::chart::Complement;
use pullback_manifold::map::Map;
use pullback_manifold::system::{ChartChanges, Point};
use std::f64::consts::TAU;

/// Coordinates of a map that may reparametrize them.
#[derive(Clone)]
pub(in crate::model) struct MapCoordinates {
    /// The mapped node.
    node: u32,
    /// Whether the map has parents beside the first one.
    reads_others: bool,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<Vec<f64>>,
}

impl MapCoordinates {
    /// Those of all maps, in the order of their nodes.
    pub(in crate::model) fn all(nodes: &Nodes) -> Vec<Self> {
        let maps = nodes.mapped().filter(|(_, _, d)| d.reparametrizes);
        let buffers = maps.map(|(node, _, d)| Self {
            node,
            reads_others: d.initial_parents().len() > 1,
            q: vec![0.0; d.direct],
            v: vec![0.0; d.direct],
            a: Vec::new(),
        });
        buffers.collect()
    }
}

/// A free rotation vector whose chart may change: the unknowns of its components, `None` for held ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FreeRotation(pub [Option<usize>; 3]);

impl FreeRotation {
    /// Its components among values of all unknowns; zero without them, as velocities in statics.
    pub fn of(&self, x: &[f64]) -> Vector3<f64> {
        let entry = |u: usize| x.get(u).copied();
        self.0.map(|u| u.and_then(entry).unwrap_or(0.0)).into()
    }

    /// Writes its components to values of all unknowns.
    pub fn write(&self, x: &mut [f64], psi: &Vector3<f64>) {
        for (u, psi) in self.0.iter().zip(psi.iter()) {
            if let Some(x) = u.and_then(|u| x.get_mut(u)) {
                *x = *psi;
            }
        }
    }
}

impl Model {
    /// The unknowns of a node's rotation if its chart can change: the node is not mapped, part of
    /// the rotation is free, and the prescribed part is constant at zero. (A prescribed component
    /// would be another constraint in the other chart.)
    pub(in crate::model) fn free_rotation(&self, node: usize) -> Option<FreeRotation> {
        let node = &self.nodes[node];
        let first = node.rotation().filter(|_| node.is_own())?;
        let unknowns = std::array::from_fn(|i| self.unknown_of(first + i));
        if unknowns.iter().all(Option::is_none) {
            return None;
        }
        let held = among(&self.prescribed, first..first + 3);
        let still = held.iter().all(|p| p.function.constant() == Some(0.0));
        still.then_some(FreeRotation(unknowns))
    }

    /// Writes new coordinates of a node and their rates to those of the unknowns; a held one stays.
    fn write_back(
        &self,
        node: u32,
        (x, x_dot, x_ddot): (&[f64], &[f64], &[Vec<f64>]),
        q: &mut [f64],
        v: &mut [f64],
        accelerations: &mut [&mut [f64]],
    ) {
        for (i, c) in self.spans[node as usize].range().enumerate() {
            let Some(u) = self.unknown_of(c) else {
                continue;
            };
            q[u] = x[i];
            if !v.is_empty() {
                v[u] = x_dot[i];
            }
            for (a, x_ddot) in accelerations.iter_mut().zip(x_ddot) {
                a[u] = x_ddot[i];
            }
        }
    }
}

impl Context {
    /// Changes the charts of nodes where ψ > π, then those of the
    /// elements.
    pub(in crate::model) fn update_charts(
        &mut self,
        t: f64,
        q: &mut [f64],
        v: &mut [f64],
        accelerations: &mut [&mut [f64]],
    ) -> ChartChanges {
        // If a map cannot be evaluated, the next evaluation reports it.
        if !self.look_before(moving(t, q, v, accelerations)) {
            return ChartChanges::default();
        }
        let mut changed = self.fold_prescribed_rotations(t);
        changed += self.complement_rotations(q, v, accelerations);
        changed += self.reparametrize_coordinates(t, q, v, accelerations);
        self.work.segments_changed = false;
        if let (false, Some(a)) = (v.is_empty(), accelerations.first()) {
            self.keep_momentum(Point { t, q, v, a });
        }
        // If a map cannot be evaluated, the next evaluation reports it.
        let Ok(maps) = self.update_maps(moving(t, q, v, accelerations)) else {
            return ChartChanges::of(changed);
        };
        changed += usize::from(self.choose_equations(t, q));
        self.watch_left_out();
        ChartChanges {
            charts: changed + maps.charts,
            residual: self.follow_element_charts(t) || maps.residual,
        }
    }

    /// Replaces free rotation vectors with ψ > π by their complements; the number of them.
    fn complement_rotations(
        &self,
        q: &mut [f64],
        v: &mut [f64],
        accelerations: &mut [&mut [f64]],
    ) -> usize {
        let mut changed = 0;
        for node in 0..self.model.nodes.len() {
            let Some(rotation) = self.free_rotation(node) else {
                continue;
            };
            let psi = rotation.of(q);
            if !self.is_beyond(&psi) {
                continue;
            }
            changed += 1;
            let velocity = rotation.of(v);
            for a in accelerations.iter_mut() {
                let [_, _, second] = settled(&psi, &velocity, &rotation.of(a));
                rotation.write(a, &second);
            }
            let [x, first, _] = settled(&psi, &velocity, &Vector3::zeros());
            rotation.write(q, &x);
            rotation.write(v, &first);
        }
        changed
    }

    /// Lets maps reparametrize their coordinates at the same x, ẋ, ẍ. These are free coordinates of one
    /// own node, the first parent, and have no other user, which is checked when the model is built.
    fn reparametrize_coordinates(
        &mut self,
        t: f64,
        q: &mut [f64],
        v: &mut [f64],
        accelerations: &mut [&mut [f64]],
    ) -> usize {
        let mut all = std::mem::take(&mut self.work.reparametrizations);
        let (mut changed, mut stale) = (0, true);
        for k in 0..all.len() {
            // The other parents may depend on coordinates that have just changed.
            if stale && (k == 0 || all[k].reads_others) {
                if !self.collect_reparametrizations(t, q, v, accelerations, &mut all) {
                    break;
                }
                stale = false;
            }
            let c = &mut all[k];
            let Some(d) = self.model.nodes[c.node as usize].mapped() else {
                continue;
            };
            let a = &mut c.a[..accelerations.len()];
            let map = self.state.maps[d.index].reparametrization();
            if map.is_some_and(|map| map.reparametrize(t, &mut c.q, &mut c.v, a)) {
                self.work.known.forget();
                let parent = d.parents(&self.state.maps)[0];
                let new = (&c.q[..], &c.v[..], &c.a[..]);
                self.model.write_back(parent, new, q, v, accelerations);
                changed += 1;
                stale = true;
            }
        }
        self.work.reparametrizations = all;
        changed
    }

    /// Collects coordinates, velocities and all accelerations of the parents of all maps that may
    /// reparametrize them; false if the point is outside a chart, which the next evaluation reports.
    fn collect_reparametrizations(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        accelerations: &[&mut [f64]],
        all: &mut [MapCoordinates],
    ) -> bool {
        let rest = match accelerations.is_empty() {
            true => vec![0.0; v.len()],
            false => Vec::new(),
        };
        let expands = all.iter().any(|c| c.reads_others);
        for k in 0..accelerations.len().max(1) {
            let a = accelerations.get(k).map_or(&rest[..], |a| a);
            if expands && self.expand(Point { t, q, v, a }).is_err() {
                return false;
            }
            let (w, spans) = (&self.work, &self.model.spans);
            for c in &mut *all {
                let Some(d) = self.model.nodes[c.node as usize].mapped() else {
                    continue;
                };
                if c.a.len() <= k {
                    c.a.push(vec![0.0; d.direct]);
                }
                let parents = d.parents(&self.state.maps);
                let own = spans[parents[0] as usize].range();
                let parts = [
                    (&w.x, q, &mut c.q),
                    (&w.v, v, &mut c.v),
                    (&w.a, a, &mut c.a[k]),
                ];
                for (nodes, free, to) in parts {
                    collect(parents, spans, nodes, to);
                    // Rates of the unknowns as they are: they may be angular velocities.
                    for (to, coordinate) in to.iter_mut().zip(own.clone()) {
                        let u = self.model.unknown_of(coordinate);
                        if let Some(x) = u.and_then(|u| free.get(u)) {
                            *to = *x;
                        }
                    }
                }
            }
        }
        true
    }

    /// Subtracts whole turns from prescribed rotations, as a function of time alone; returns the
    /// number of changes.
    pub(in crate::model) fn fold_prescribed_rotations(&mut self, t: f64) -> usize {
        let mut changed = 0;
        for (&node, turns) in (self.model.prescribed_rotations.iter()).zip(&mut self.state.turns) {
            let first = self.model.nodes[node].first + 3;
            let mut psi = Vector3::zeros();
            for p in among(&self.model.prescribed, first..first + 3) {
                psi[p.coordinate - first] = p.function.at(t, &self.state.inputs)[0];
            }
            // Nearest whole number of turns, with the same switch at ψ > π as for free nodes.
            let wanted = (psi.norm() / TAU - 1e-12).round() as i32;
            if wanted != *turns {
                *turns = wanted;
                changed += 1;
            }
        }
        if changed > 0 {
            self.work.known.forget();
        }
        changed
    }
}

/// A point with these rates, or at rest without them.
fn moving<'a>(t: f64, q: &'a [f64], v: &'a [f64], accelerations: &'a [&mut [f64]]) -> Point<'a> {
    match accelerations.first() {
        Some(a) if !v.is_empty() => Point { t, q, v, a },
        _ => Point::statics(t, q),
    }
}

/// A rotation vector and its rates after a change of chart; a step may have rotated it by more than
/// one turn, so whole turns are subtracted.
fn settled(psi: &Vector3<f64>, rate: &Vector3<f64>, second: &Vector3<f64>) -> [Vector3<f64>; 3] {
    let mut k = Complement.kinematics(0.0, psi, rate, second);
    let turns = (k.x.norm() / TAU - 1e-12).round() as i32;
    fold(
        turns,
        k.x.as_mut_slice(),
        k.x_dot.as_mut_slice(),
        k.x_ddot.as_mut_slice(),
    );
    [k.x, k.x_dot, k.x_ddot]
}
