//! The map of an implicit constraint, of any sizes.

use super::core::{CONSISTENT, ImplicitMap};
use super::{
    Choice, Description, Equation, Equations, EvaluationError, Implicit, ImplicitError, Unknown,
};
use crate::map::{Map, Parametrization};

impl ImplicitMap {
    /// Assembles a constraint at time `t` as near as Newton's method gets to `guess`, with
    /// `freedoms` coordinates q.
    ///
    /// # Errors
    /// [`ImplicitError`] naming the equations and coordinates concerned.
    pub fn of<const X: usize, const M: usize>(
        constraint: impl Implicit<X, M> + Clone + 'static,
        freedoms: usize,
        t: f64,
        guess: [f64; X],
        choice: Choice,
    ) -> Result<Self, ImplicitError> {
        const { assert!(M > 0, "a constraint has equations") };
        let unknown = |k| Unknown {
            name: constraint.coordinate(k),
            size: constraint.size(k),
            start: None,
            preference: 0.0,
        };
        let equation = |i| Equation {
            name: constraint.equation(i),
            size: None,
        };
        let about = Description {
            unknowns: (0..X).map(unknown).collect(),
            equations: (0..M).map(equation).collect(),
            freedoms: Some(freedoms),
            choice,
            ..Description::default()
        };
        let h = Equations(constraint).boxed();
        ImplicitMap::assemble(h, about, t, &[], &guess)
    }

    /// Assembles equations at time `t` and parameters `p`: `h` takes (p, x) to the residuals.
    ///
    /// The unknowns start at zero, or at [`Unknown::start`]. If the equations hold at zero, these
    /// values are approached in steps, so that the mechanism stays on its branch. If they are
    /// inconsistent, as many as possible are kept, in the order of the unknowns; the others are a
    /// first guess ([`ImplicitMap::displaced`]).
    ///
    /// # Errors
    /// As [`ImplicitMap::of`].
    pub fn new(
        h: Box<dyn Parametrization>,
        about: Description,
        t: f64,
        p: &[f64],
    ) -> Result<Self, ImplicitError> {
        let zero = vec![0.0; about.unknowns.len()];
        ImplicitMap::assemble(h, about, t, p, &zero)
    }

    /// The same map with these unknowns as q, until others are better ([`Choice::Split`]) or for
    /// good ([`Choice::Fixed`]); `None` if they do not determine x. q = 0 stays the same
    /// configuration: to be called before anything moves.
    #[must_use]
    pub fn with_independent(mut self, independent: &[usize]) -> Option<Self> {
        let (t, mut q) = (self.anchor.t, self.anchor.q.clone());
        let mut v = vec![0.0; q.len()];
        let done = self.switch(t, Some(independent), &mut q, &mut v, &mut []);
        done.then_some(self)
    }

    /// Sizes of the unknowns ([`Unknown::size`]).
    pub fn unknown_sizes(&self) -> Vec<f64> {
        self.about.unknowns.iter().map(|u| u.size).collect()
    }

    /// The unknowns that cannot start at [`Unknown::start`], and their actual initial values.
    pub fn displaced(&self) -> Vec<(usize, f64)> {
        let off = |k: &usize| {
            let u = &self.about.unknowns[*k];
            let start = u.start.unwrap_or(self.reference[*k]);
            (self.reference[*k] - start).abs() > CONSISTENT * u.size
        };
        let all = (0..self.X).filter(off);
        all.map(|k| (k, self.reference[k])).collect()
    }

    /// Number D of free coordinates q.
    pub fn freedoms(&self) -> usize {
        self.D
    }

    /// The unknowns selected as q; `None` in the tangent space.
    pub fn independent(&self) -> Option<Vec<usize>> {
        self.chart.independent.clone()
    }

    /// Condition number of A at (q, p); infinite if the equations cannot be solved.
    pub fn condition(&mut self, t: f64, q: &[f64]) -> f64 {
        match self.solve(t, q) {
            Ok(()) => self.work.condition,
            Err(_) => f64::INFINITY,
        }
    }

    /// A warning about a nearby singular configuration, if any, to follow "joint at node a: ".
    pub fn singularity_warning(&mut self) -> Option<String> {
        let from = self.anchor.clone();
        self.close_to_singular(&from).map(advised)
    }
}

/// The message with a remedy.
pub(super) fn advised(error: EvaluationError) -> String {
    match error {
        EvaluationError::Singular { .. } | EvaluationError::Crossed => format!(
            "{error}; a map ends at a singular position: `closure = \"multipliers\"` goes through"
        ),
        other => other.to_string(),
    }
}
