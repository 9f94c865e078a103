//! Redundant equations of multipliers: which ones are omitted.

use crate::model::constraints::enforced::EnforcedEquations;
use crate::model::constraints::start::start;
use crate::model::{Context, Model, ModelError, NodeId};
use nalgebra::{DMatrix, DVector};
use pullback_manifold::system::{Point, System};

/// Remainder of a gradient, relative to the largest gradient, that counts as rounding.
const RANK: f64 = 1e-8;
/// Relative gradient by prescribed coordinates above which an equation depends on them.
const PRESCRIBES: f64 = 1e-4;
/// Change of a coordinate, relative to its size, after which the choice of equations is revised.
const MOVED: f64 = 0.1;
/// Gain of the least independent equation that changes the choice.
const GAIN: f64 = 1.5;

impl Model {
    /// The equations enforced by multipliers.
    fn counting(&self, all: &EnforcedEquations) -> Vec<usize> {
        let counts = |&i: &usize| self.elements[all.of[i].0].multiplied().is_some();
        (0..all.of.len()).filter(counts).collect()
    }

    /// The multiplier of an equation of an element.
    fn multiplier(&self, (element, equation): (usize, usize)) -> Option<usize> {
        let e = &self.elements[element];
        let &node = e.nodes.last()?;
        self.unknown_at(NodeId(node), equation)
    }
}

impl Context {
    /// Selects independent equations, those with the largest gradients first, and omits the others.
    pub(in crate::model) fn leave_out_redundant(&mut self, q: &[f64]) -> Result<(), ModelError> {
        let all = self.equations(0.0, q, &[]).map_err(start)?;
        let counting = self.counting(&all);
        let choice = Chosen::of(&all, &counting);
        self.leave_out(&all, &choice);
        if self.state.elements.iter().any(|e| e.left_out != 0) {
            self.state.chosen_at = q.to_vec();
        }
        Ok(())
    }

    /// Omits the equations that are not selected.
    fn leave_out(&mut self, all: &EnforcedEquations, choice: &Chosen) {
        let (of, waiting) = (&all.of, &choice.waiting);
        // Equations that follow from others at given prescribed positions, but not at all
        // positions.
        self.state.overprescribed.clear();
        for &i in waiting {
            let off = choice.by_prescribed.row(i);
            let names: Vec<String> = (self.prescribed().zip(off.iter()))
                .filter(|(_, slope)| slope.abs() > PRESCRIBES * choice.limit / RANK)
                .map(|(c, _)| self.coordinate_name(c))
                .collect();
            if !names.is_empty() {
                self.state.overprescribed.push((of[i], names.join(", ")));
            }
        }
        for &k in &self.model.enforced {
            let mine = waiting.iter().map(|&i| of[i]).filter(|&(e, _)| e == k);
            self.state.elements[k].left_out = mine.fold(0, |bits, (_, i)| bits | 1 << i);
        }
    }

    /// Revises the choice at a converged state away from the last one: replaces equations that have
    /// become much less independent than the best ones, and gives the forces of the old multipliers
    /// to the new ones. Returns whether it did.
    ///
    /// The independent gaps of a planar loop depend on the orientation of its frames.
    pub(in crate::model) fn choose_equations(&mut self, t: f64, q: &mut [f64]) -> bool {
        let moved = |u: usize| {
            let change = (q[u] - self.state.chosen_at[u]).abs();
            change > MOVED * self.unit(u) && !self.pattern().coordinates()[u].is_multiplier
        };
        if self.state.unwatched || self.state.chosen_at.is_empty() || !(0..q.len()).any(moved) {
            return false;
        }
        self.state.chosen_at.copy_from_slice(q);
        // The forces of the accepted state are used later.
        let forces = self.work.r.clone();
        let all = self.equations(t, q, &[]);
        self.work.r = forces;
        let Ok(all) = all else {
            return false;
        };
        let counting = self.counting(&all);
        let taken = |&i: &usize| {
            let (k, number) = all.of[i];
            self.state.elements[k].left_out & (1 << number) == 0
        };
        let used: Vec<usize> = counting.iter().copied().filter(taken).collect();
        let (now, best) = (Chosen::of(&all, &used), Chosen::of(&all, &counting));
        // A singular configuration is not suitable for a choice.
        if best.taken.len() != used.len() || now.least * GAIN > best.least {
            return false;
        }
        let multiplier = |i: usize| self.multiplier(all.of[i]);
        let mut force = DVector::zeros(q.len());
        for &i in &used {
            if let Some(u) = multiplier(i) {
                force += all.J.row(i).transpose() * q[u];
            }
        }
        let gradients = all.J.select_rows(&best.taken);
        let Some(factors) = (&gradients * gradients.transpose()).cholesky() else {
            return false;
        };
        let lambda = factors.solve(&(&gradients * force));
        for &i in &used {
            if let Some(u) = multiplier(i) {
                q[u] = 0.0;
            }
        }
        for (&i, lambda) in best.taken.iter().zip(lambda.iter()) {
            if let Some(u) = multiplier(i) {
                q[u] = *lambda;
            }
        }
        self.leave_out(&all, &best);
        // Forces at this state are evaluated with these multipliers.
        self.expand(Point::statics(t, q)).is_ok()
    }

    /// State of the choice: the unknowns there, and the omitted equations.
    pub(in crate::model) fn save_choice(&self) -> Vec<f64> {
        let mut saved = self.state.chosen_at.clone();
        let left_out = |&k: &usize| f64::from(self.state.elements[k].left_out);
        saved.extend(self.model.enforced.iter().map(left_out));
        saved
    }

    /// Restores the state from [`Context::save_choice`]; false for anything else.
    pub(in crate::model) fn restore_choice(&mut self, saved: &[f64]) -> bool {
        let n = self.state.chosen_at.len();
        if saved.len() != n + self.model.enforced.len() || saved.iter().any(|x| !x.is_finite()) {
            return false;
        }
        let equations = |&k: &usize| {
            let enforced = self.model.elements[k].element.abilities().enforced;
            enforced.map_or(0, |enforced| enforced.dims().1)
        };
        let counts = self.model.enforced.iter().map(equations);
        if counts
            .zip(&saved[n..])
            .any(|(M, left_out)| *left_out as u64 >> M != 0)
        {
            return false;
        }
        self.state.chosen_at.copy_from_slice(&saved[..n]);
        for (&k, left_out) in self.model.enforced.iter().zip(&saved[n..]) {
            self.state.elements[k].left_out = *left_out as u32;
        }
        true
    }
}

/// Equations selected one after the other, by the largest remainder of their gradients.
struct Chosen {
    taken: Vec<usize>,
    /// Redundant equations, and the remainders of their gradients by prescribed coordinates.
    waiting: Vec<usize>,
    by_prescribed: DMatrix<f64>,
    /// Remainder of the last selected gradient; below it an equation is redundant.
    least: f64,
    limit: f64,
}

impl Chosen {
    fn of(all: &EnforcedEquations, candidates: &[usize]) -> Self {
        let (mut rest, mut by_prescribed) = (all.J.clone(), all.prescribed.clone());
        let (mut waiting, mut taken) = (candidates.to_vec(), Vec::new());
        let (mut limit, mut least) = (0.0, f64::INFINITY);
        let mut norms: Vec<f64> = rest.row_iter().map(|row| row.norm()).collect();
        while let Some(best) =
            (waiting.iter().copied()).max_by(|&i, &j| norms[i].total_cmp(&norms[j]))
        {
            let size = norms[best];
            limit = f64::max(limit, RANK * size);
            if size <= limit || size == 0.0 {
                break;
            }
            least = size;
            taken.push(best);
            waiting.retain(|&i| i != best);
            let direction = rest.row(best) / size;
            let along_prescribed = by_prescribed.row(best) / size;
            // A loop has few of many unknowns.
            let own: Vec<usize> = (0..direction.len())
                .filter(|&u| direction[u] != 0.0)
                .collect();
            for &i in &waiting {
                let along: f64 = own.iter().map(|&u| rest[(i, u)] * direction[u]).sum();
                if along == 0.0 {
                    continue;
                }
                own.iter()
                    .for_each(|&u| rest[(i, u)] -= direction[u] * along);
                norms[i] = rest.row(i).norm();
                let reduced = by_prescribed.row(i) - &along_prescribed * along;
                by_prescribed.set_row(i, &reduced);
            }
        }
        Self {
            taken,
            waiting,
            by_prescribed,
            least,
            limit,
        }
    }
}
