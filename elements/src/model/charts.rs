//! Which chart each node and each element uses, decided at converged states only.

use super::slots::Complement;
use super::{Model, Node, Source};
use nalgebra::Vector3;
use pullback_manifold::system::{ChartChanges, Point};
use std::f64::consts::{PI, TAU};

impl Model {
    /// Changes the charts of nodes with ψ > π, then lets the elements choose theirs.
    pub(super) fn update_charts(
        &mut self,
        t: f64,
        q: &mut [f64],
        v: &mut [f64],
        accelerations: &mut [&mut [f64]],
    ) -> ChartChanges {
        // Where a map cannot be evaluated, the next evaluation says so.
        if !self.look_before(t, q) {
            return ChartChanges::default();
        }
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
            residual: self.follow_element_charts(t) || maps.residual,
        }
    }

    /// Lets maps choose other coordinates of their own for the same x, ẋ, ẍ. These are free
    /// coordinates of one own node, which nobody else uses: seen to when the model is built.
    fn rewrite_coordinates(
        &mut self,
        t: f64,
        q: &mut [f64],
        v: &mut [f64],
        accelerations: &mut [&mut [f64]],
    ) -> usize {
        let mut changed = 0;
        for &n in &self.dependent {
            if let Source::Mapped(d) = &mut self.nodes[n as usize].source
                && d.map.rewrites()
            {
                let coordinate = self.spans[d.masters()[0] as usize].first as usize;
                let first = self.unknowns[coordinate] as usize;
                changed += usize::from(d.map.rewrite(t, first, q, v, accelerations));
            }
        }
        changed
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
    pub(super) fn free_rotation(&self, node: usize) -> Option<[Option<usize>; 3]> {
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

    /// Whole turns off the rotations that are driven, by the time alone; how many have changed.
    pub(super) fn fold_driven_rotations(&mut self, t: f64) -> usize {
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
}
