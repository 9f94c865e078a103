//! The state of an implicit map besides its coordinates.

use super::Choice;
use super::core::ImplicitMap;
use crate::map::{MapState, Reparametrization};
use crate::system::ChartChanges;

impl ImplicitMap {
    /// Changes the charts of the equations at the present position.
    pub(super) fn change_equation_charts(&mut self, t: f64) {
        if let Some(state) = self.h.state() {
            self.work.piece_changed |= state.change_charts(t, &self.work.y).residual;
        }
    }
}

impl MapState for ImplicitMap {
    fn change_charts(&mut self, t: f64, q: &[f64]) -> ChartChanges {
        self.remember(t, q);
        if self.D == 0 {
            // There are no other coordinates to choose.
            self.reparametrize(t, &mut q.to_vec(), &mut vec![0.0; q.len()], &mut []);
        }
        ChartChanges {
            charts: 0,
            residual: std::mem::take(&mut self.work.piece_changed),
        }
    }

    fn freeze_piece(&mut self, at: Option<(f64, &[f64])>) {
        // If there is no solution, all conformance checks report it.
        if at.is_some_and(|(t, q)| self.solve(t, q).is_err()) {
            return;
        }
        if let Some(state) = self.h.state() {
            state.freeze_piece(at.map(|(t, _)| (t, &self.work.y[..])));
        }
    }

    /// Anchor, chart and sizes, and the state of the equations.
    fn save(&self) -> Vec<f64> {
        let mut out = vec![self.anchor.t];
        out.extend(&self.anchor.q);
        out.extend(&self.anchor.x);
        out.extend(&self.chart.L);
        out.extend(self.chart.used.iter().map(|&u| f64::from(u)));
        out.extend(&self.sizes);
        out.push(f64::from(self.chart.independent.is_some()));
        out.push(self.anchor.closing);
        out.extend(self.h.save());
        out
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        let (p, X, M, D) = (self.p, self.X, self.M, self.D);
        let before = self.save();
        if saved.len() != before.len() || !saved.iter().all(|x| x.is_finite()) {
            return false;
        }
        let mut rest = saved;
        let mut take = |n: usize| -> &[f64] {
            let (head, tail) = rest.split_at(n);
            rest = tail;
            head
        };
        let t = take(1)[0];
        let q = take(D + p).to_vec();
        let x = take(X).to_vec();
        self.chart.L.copy_from_slice(take(X * D));
        for (used, x) in self.chart.used.iter_mut().zip(take(M)) {
            *used = *x == 1.0;
        }
        self.sizes.copy_from_slice(take(M));
        let split = take(1)[0] == 1.0;
        self.anchor.closing = take(1)[0];
        let L = &self.chart.L;
        let picks = |j: usize| (0..X).find(|k| L[k + j * X] == 1.0);
        self.chart.independent = split.then(|| (0..D).filter_map(picks).collect());
        self.work.y[..p].copy_from_slice(&q[D..]);
        self.work.y[p..].copy_from_slice(&x);
        if !self.h.restore(rest) {
            return false;
        }
        self.change_equation_charts(t);
        self.work.piece_changed = false;
        let used = self.chart.used.iter().filter(|&&u| u).count();
        let complete = (self.chart.independent.as_ref()).is_none_or(|k| k.len() == D);
        used == X - D && complete && self.refresh(t, &q)
    }

    fn reparametrization(&mut self) -> Option<&mut dyn Reparametrization> {
        let changes = self.D > 0 && self.about.choice != Choice::Fixed;
        changes.then_some(self as _)
    }

    fn implicit(&mut self) -> Option<&mut ImplicitMap> {
        Some(self)
    }
}
