//! Messages: which equations depend on which, and which coordinates they leave undetermined.

use super::super::DomainError;
use super::super::chart::RANK;
use super::super::names::list;
use super::core::Core;
use super::dense::Pivoted;
use super::start::{ASIDE, aside};

/// Coefficients and components below this are not named.
const SMALL: f64 = 1e-4;

impl Core {
    /// Names of the owners of the selected parameters, each once.
    pub(super) fn driven(&self, chosen: impl Fn(usize) -> bool) -> String {
        let mut names: Vec<String> = Vec::new();
        for (j, name) in self.about.parameters.iter().enumerate() {
            if chosen(j) && !names.contains(name) {
                names.push(name.clone());
            }
        }
        list(&names)
    }

    /// Why an equation that was redundant does not follow any more, at the present h_y: the
    /// parameters, if it changes with them while the others hold.
    pub(super) fn contradicted(&mut self, equation: String, residual: f64) -> DomainError {
        self.operators();
        let (p, X, M, D) = (self.p, self.X, self.M, self.D);
        let found = self.about.equations.iter().position(|e| e.name == equation);
        let w = &self.work;
        let slope = |i: usize, j: usize| {
            let along = (0..X).map(|k| w.J[i + (p + k) * M] * w.Y[k + (D + j) * X]);
            (w.J[i + j * M] + along.sum::<f64>()).abs() / self.sizes[i]
        };
        match found.filter(|&i| (0..p).any(|j| slope(i, j) > SMALL)) {
            Some(i) => DomainError::Overdriven {
                driven: self.driven(|j| slope(i, j) > SMALL),
                equation,
                residual,
            },
            None => DomainError::Inconsistent { equation, residual },
        }
    }

    /// Names of the equations on which equation `i` depends, at the present h_y.
    pub(super) fn others(&mut self, i: usize) -> String {
        let X = self.X;
        self.rank_equations();
        let rows = &self.work.scaled;
        let mut rest = rows.clone();
        rest[i * X..(i + 1) * X].fill(0.0);
        let mut found = Pivoted::default();
        found.run(X, &rest);
        let mut left = rows[i * X..(i + 1) * X].to_vec();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut named = Vec::new();
        for k in (0..found.rank(RANK)).rev() {
            let equation = found.order[k];
            let row = &rows[equation * X..(equation + 1) * X];
            let direction = found.direction(k);
            let factor = dot(&left, direction) / dot(row, direction);
            left.iter_mut().zip(row).for_each(|(l, r)| *l -= factor * r);
            if factor.abs() > SMALL {
                named.push(equation);
            }
        }
        named.sort_unstable();
        let names: Vec<String> = (named.iter())
            .map(|&i| self.about.equations[i].name.clone())
            .collect();
        if names.is_empty() {
            "no other equation".to_owned()
        } else {
            list(&names)
        }
    }

    /// Equations beyond the rank (the weakest if all `expected` are independent), each with those
    /// on which it depends, and the unknowns that can move while the equations hold.
    pub(super) fn dependences(&mut self, expected: usize) -> (String, String) {
        self.rank_equations();
        let rank = self.work.equations.rank(RANK);
        self.dependences_beyond(rank, expected)
    }

    /// Which equations are nontrivial near x, even if they are trivial at x: those of a planar
    /// mechanism out of its plane are not.
    fn speak_aside(&mut self) -> Vec<bool> {
        let (p, X, M, t) = (self.p, self.X, self.M, self.anchor.t);
        let y = self.work.y.clone();
        for k in 0..X {
            self.work.y[p + k] += ASIDE * aside(k) * self.size(k);
        }
        self.linearise(t);
        let speaks = |i: usize| {
            let least = SMALL * ASIDE * self.about.equations[i].size;
            (0..X).any(|k| (self.work.J[i + (p + k) * M] * self.size(k)).abs() > least)
        };
        let speak = (0..M).map(speaks).collect();
        self.work.y = y;
        self.linearise(t);
        speak
    }

    /// As [`Core::dependences`] for equations beyond a given rank: the weakest of the independent
    /// ones near a singular configuration.
    pub(super) fn dependences_beyond(&mut self, rank: usize, expected: usize) -> (String, String) {
        let X = self.X;
        let speak = self.speak_aside();
        self.rank_equations();
        let equations = self.work.equations.clone();
        // Trivial equations of this mechanism (out of its plane) are not named.
        let mut weak: Vec<usize> = (equations.order.iter().skip(rank.min(self.M - 1)).copied())
            .filter(|&i| {
                self.work.scaled[i * X..(i + 1) * X]
                    .iter()
                    .any(|x| x.abs() > SMALL)
            })
            .collect();
        weak.sort_unstable();
        let dependent: Vec<String> = weak
            .into_iter()
            .map(|i| {
                let others = self.others(i);
                format!("{} depends on {others}", self.about.equations[i].name)
            })
            .collect();
        let moves = |k: usize| {
            let along = (0..rank.min(expected)).map(|j| equations.direction(j)[k].powi(2));
            1.0 - along.sum::<f64>() > SMALL
        };
        let moving: Vec<String> = (0..X)
            .filter(|&k| moves(k))
            .map(|k| self.about.unknowns[k].name.clone())
            .collect();
        let dependent = if dependent.is_empty() {
            // Its gradient has vanished.
            let beyond = &equations.order[rank.min(self.M - 1)..];
            let weakest = beyond.iter().find(|&&i| speak[i]).unwrap_or(&beyond[0]);
            let name = &self.about.equations[*weakest].name;
            format!("{name} says nothing to first order")
        } else {
            list(&dependent)
        };
        (dependent, list(&moving))
    }
}
