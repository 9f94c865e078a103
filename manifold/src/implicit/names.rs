//! Messages: which equations depend on which, and which coordinates they leave undetermined.

use super::core::{Anchor, ImplicitMap, RANK};
use super::dense::Pivoted;
use super::start::ASIDE;
use super::{Choice, EvaluationError};

/// Coefficients and components below this are not named.
const SMALL: f64 = 1e-4;
/// Condition number per unknown, of the best chart, beyond which a singular configuration is near.
const CLOSE: f64 = 20.0;

/// Names joined as in a sentence.
fn list(names: &[String]) -> String {
    match names {
        [] => "none".to_owned(),
        [one] => one.clone(),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    }
}

impl ImplicitMap {
    /// Names of the redundant equations.
    pub fn redundant(&self) -> Vec<String> {
        let unused = (0..self.M).filter(|&i| !self.chart.used[i]);
        unused
            .map(|i| self.about.equations[i].name.clone())
            .collect()
    }

    /// Describes the independent coordinates and the redundant equations at present.
    pub fn describe(&self) -> String {
        let chart = match &self.chart.independent {
            Some(k) if k.is_empty() => "nothing is free".to_owned(),
            Some(k) => {
                let names = k.iter().map(|&k| self.about.unknowns[k].name.as_str());
                format!("independent: {}", names.collect::<Vec<_>>().join(", "))
            }
            None => "coordinates in the tangent space".to_owned(),
        };
        let redundant = self.redundant();
        if redundant.is_empty() {
            chart
        } else {
            format!("{chart}; redundant: {}", redundant.join(", "))
        }
    }

    /// Names of the owners of the selected parameters, each once.
    pub(super) fn prescribed(&self, chosen: impl Fn(usize) -> bool) -> String {
        let mut names: Vec<String> = Vec::new();
        for (j, name) in self.about.parameters.iter().enumerate() {
            if chosen(j) && !names.contains(name) {
                names.push(name.clone());
            }
        }
        list(&names)
    }

    /// The singular configuration near a state, if any: no chart has a fair condition number there.
    pub(super) fn close_to_singular(&mut self, at: &Anchor) -> Option<EvaluationError> {
        let rank = self.X - self.D;
        if rank == 0 {
            return None;
        }
        let w = &mut self.work;
        w.y[..self.p].copy_from_slice(&at.q[self.D..]);
        w.y[self.p..].copy_from_slice(&at.x);
        self.linearise(at.t);
        let condition = self.best(Choice::Tangent);
        if condition <= CLOSE * self.X as f64 {
            return None;
        }
        let (equations, coordinates) = self.dependences_beyond(rank - 1, rank);
        Some(EvaluationError::Singular {
            condition,
            equations,
            coordinates,
        })
    }

    pub(super) fn singular(&mut self) -> EvaluationError {
        let condition = self.work.condition;
        let (equations, coordinates) = self.dependences(self.X - self.D);
        EvaluationError::Singular {
            condition,
            equations,
            coordinates,
        }
    }

    /// Why an equation that was redundant does not follow any more, at the present h_y: the
    /// parameters, if it changes with them while the others hold.
    pub(super) fn contradicted(&mut self, equation: String, residual: f64) -> EvaluationError {
        self.operators();
        let (p, X, M, D) = (self.p, self.X, self.M, self.D);
        let found = self.about.equations.iter().position(|e| e.name == equation);
        let w = &self.work;
        let slope = |i: usize, j: usize| {
            let along = (0..X).map(|k| w.J[i + (p + k) * M] * w.Y[k + (D + j) * X]);
            (w.J[i + j * M] + along.sum::<f64>()).abs() / self.sizes[i]
        };
        match found.filter(|&i| (0..p).any(|j| slope(i, j) > SMALL)) {
            Some(i) => EvaluationError::Overprescribed {
                prescribed: self.prescribed(|j| slope(i, j) > SMALL),
                equation,
                residual,
            },
            None => EvaluationError::Inconsistent { equation, residual },
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

    /// As [`ImplicitMap::dependences`] for equations beyond a given rank: the weakest of the independent
    /// ones near a singular configuration.
    pub(super) fn dependences_beyond(&mut self, rank: usize, expected: usize) -> (String, String) {
        let X = self.X;
        let beside = self.rows_beside(self.anchor.t);
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
            // Its gradient has vanished, and has not beside x: those of a planar mechanism out of
            // its plane have everywhere.
            let beyond = &equations.order[rank.min(self.M - 1)..];
            let speaks = |i: &&usize| beside[**i] > SMALL * ASIDE * self.scale(**i);
            let weakest = beyond.iter().find(speaks).unwrap_or(&beyond[0]);
            let name = &self.about.equations[*weakest].name;
            format!("{name} says nothing to first order")
        } else {
            list(&dependent)
        };
        (dependent, list(&moving))
    }
}
