//! States in the middle of domains, for the conformance kit.

use super::gather::collect;
use super::{Form, Model, NONE, Source};
use pullback_manifold::system::Point;

/// A joint with less room than this is at the edge of its domain, and how far from there it is taken,
/// in units of its coordinates.
const NARROW: f64 = 1e-3;
const STEP: f64 = 0.1;

impl Model {
    /// Takes coordinates of joints that are at the edges of their domains, a slide at the end of its
    /// chain, a little inside: nothing can be said about derivatives where a step leads outside.
    pub(crate) fn step_inside(&mut self, t: f64, q: &mut [f64], units: &[f64]) {
        for k in 0..self.dependent.len() {
            let n = self.dependent[k];
            let Some(room) = self.room(n, t, q).filter(|&room| room < NARROW) else {
                continue;
            };
            let Source::Mapped(d) = &self.nodes[n as usize].source else {
                continue;
            };
            let steps: Vec<(usize, f64)> = (d.parents().iter())
                .filter(|&&m| self.nodes[m as usize].form == Form::Coordinates)
                .flat_map(|&m| {
                    let all = self.nodes[m as usize].range();
                    let free = all.filter(|&c| self.unknowns[c] != NONE);
                    free.map(move |c| (c, STEP * units[m as usize]))
                })
                .map(|(c, step)| (self.unknowns[c] as usize, step))
                .collect();
            let mut best = (10.0 * room, None);
            for (u, step) in steps.into_iter().flat_map(|(u, s)| [(u, s), (u, -s)]) {
                q[u] += step;
                let there = self.room(n, t, q).unwrap_or(0.0);
                q[u] -= step;
                if there > best.0 {
                    best = (there, Some((u, step)));
                }
            }
            if let Some((u, step)) = best.1 {
                q[u] += step;
            }
        }
    }

    /// Lets every map keep to the formula that holds at a state at rest, or to none again: see
    /// [`keep_piece`](pullback_manifold::map::Map::keep_piece).
    pub(crate) fn keep_pieces(&mut self, at: Option<(f64, &[f64])>) {
        let (v, a) = (&[][..], &[][..]);
        let known = at.is_none_or(|(t, q)| self.expand(Point { t, q, v, a }).is_ok());
        for &n in self.dependent.iter().filter(|_| known) {
            if let Source::Mapped(d) = &mut self.nodes[n as usize].source {
                let w = &mut self.work;
                let len = collect(d.parents(), &self.spans, &w.x, &mut w.local.q);
                d.map.keep_piece(at.map(|(t, _)| (t, &w.local.q[..len])));
            }
        }
    }

    /// The margin of a map at a state at rest; none outside of its domain.
    fn room(&mut self, n: u32, t: f64, q: &[f64]) -> Option<f64> {
        let (v, a) = (&[][..], &[][..]);
        self.expand(Point { t, q, v, a }).ok()?;
        let Source::Mapped(d) = &self.nodes[n as usize].source else {
            return None;
        };
        let w = &mut self.work;
        let len = collect(d.parents(), &self.spans, &w.x, &mut w.local.q);
        Some(d.map.margin(t, &w.local.q[..len]))
    }
}
