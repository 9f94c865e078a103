//! States of a model in other charts, for the conformance kit.

use super::Model;
use super::inspect::Rotation;
use super::slots::Complement;
use nalgebra::{DVector, Vector3};
use pullback_manifold::check::State;
use pullback_manifold::system::{System, SystemError};
use std::f64::consts::{PI, TAU};

impl Model {
    /// Rotations that are free and whose chart may be changed.
    pub(crate) fn free_rotations(&self) -> Vec<Rotation> {
        (0..self.nodes.len())
            .filter_map(|n| self.free_rotation(n))
            .collect()
    }

    /// Writes rotations of a state in their other charts, with everything that follows from that, as
    /// at the end of a step; how many. Those near 0 or 2π, where the other chart ends, stay.
    pub(crate) fn switch(
        &mut self,
        rotations: &[Rotation],
        s: &mut State,
    ) -> Result<usize, SystemError> {
        self.look_before(s.t, s.x.as_slice());
        // From the nearer of 0 and 2π.
        let away = |unknowns: &Rotation| {
            let parts = unknowns.iter().flatten().map(|&u| s.x[u] * s.x[u]);
            let psi = parts.sum::<f64>().sqrt();
            psi.min(TAU - psi)
        };
        let most = rotations.iter().map(away).fold(0.0, f64::max);
        let least = (LARGER * most).clamp(TURNED[0], TURNED[1]);
        let clear = least..TAU - least;
        let count = rotations.iter().filter(|r| complement(r, s, &clear));
        let count = count.count();
        self.update_maps(s.t, s.x.as_slice())?;
        self.follow_element_charts(s.t);
        Ok(count)
    }

    /// Charts as a run that starts here has them, but for maps that would give coordinates another
    /// meaning.
    pub(crate) fn settle(&mut self, s: &mut State) -> Result<(), SystemError> {
        self.fold_driven_rotations(s.t);
        for unknowns in self.free_rotations() {
            let parts = unknowns.iter().flatten().map(|&u| s.x[u] * s.x[u]);
            if parts.sum::<f64>().sqrt() > PI {
                complement(&unknowns, s, &(PI..TAU));
            }
        }
        // A slide enters the line that it was told to recall first, and then the one that it is on.
        self.update_maps(s.t, s.x.as_slice())?;
        self.update_maps(s.t, s.x.as_slice())?;
        self.start(s.t, s.x.as_slice());
        Ok(())
    }
}

/// Writes a rotation of a state, in motion or at rest, in its other chart, where its angle is among
/// those given; whether it is.
fn complement(unknowns: &Rotation, s: &mut State, angles: &std::ops::Range<f64>) -> bool {
    let take = |from: &DVector<f64>| {
        let entry = |u: usize| from.get(u).copied().unwrap_or(0.0);
        Vector3::from_fn(|i, _| unknowns[i].map_or(0.0, entry))
    };
    let mut all = [take(&s.x), take(&s.v), take(&s.a)];
    if !angles.contains(&all[0].norm()) {
        return false;
    }
    let [x, v, a] = &mut all;
    Complement::default().apply(x.as_mut_slice(), v.as_mut_slice(), a.as_mut_slice());
    for (to, from) in [&mut s.x, &mut s.v, &mut s.a].into_iter().zip(all) {
        for (u, x) in unknowns.iter().zip(from.iter()) {
            if let Some(to) = u.and_then(|u| to.get_mut(u)) {
                *to = *x;
            }
        }
    }
    true
}

/// Rotation vectors close to 0 or 2π keep their chart: there the change of charts enlarges round-off by
/// 2π/ψ, and the smallest ψ would decide what is allowed for all. Charts change at this distance or
/// more, and where all rotations are smaller than the second one, at those near the largest.
const TURNED: [f64; 2] = [0.2, 1.0];
const LARGER: f64 = 0.7;
