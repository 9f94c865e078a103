//! The map of an implicit constraint, of any sizes.

use super::core::{CONSISTENT, Core, RANK};
use super::{
    Choice, Description, DomainError, Equation, Equations, Implicit, ImplicitError, Unknown,
};
use crate::map::{KinematicsMut, Map, OutsideDomain, Parametrization};
use crate::system::ChartChanges;

/// The map (q, p) ↦ x of equations h(t, p, x) = 0, solved for x in D = X − rank(h_x) of its own
/// coordinates and the parameters p.
///
/// q = 0 is the initial configuration. Redundant equations are found, dropped and named.
#[derive(Clone)]
pub struct ImplicitMap(Core);

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
        Core::assemble(h, about, t, &[], &guess).map(Self)
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
        Core::assemble(h, about, t, p, &zero).map(Self)
    }

    /// The same map with these unknowns as q, until others are better ([`Choice::Split`]) or for
    /// good ([`Choice::Fixed`]); `None` if they do not determine x. q = 0 stays the same
    /// configuration: to be called before anything moves.
    #[must_use]
    pub fn with_independent(mut self, independent: &[usize]) -> Option<Self> {
        let core = &mut self.0;
        let (t, mut q) = (core.anchor.t, core.anchor.q.clone());
        let mut v = vec![0.0; q.len()];
        let done = core.switch(t, Some(independent), &mut q, &mut v, &mut []);
        done.then_some(self)
    }

    /// The configuration at q = 0.
    pub fn reference(&self) -> Vec<f64> {
        self.0.reference.clone()
    }

    /// q̇ of a velocity ẋ that the constraint allows.
    pub fn rates(&self, x_dot: &[f64]) -> Vec<f64> {
        let core = &self.0;
        let columns = core.chart.L.chunks_exact(core.X);
        columns
            .map(|L| L.iter().zip(x_dot).map(|(l, x)| l * x).sum())
            .collect()
    }

    /// The unknowns that cannot start at [`Unknown::start`], and their actual initial values.
    pub fn displaced(&self) -> Vec<(usize, f64)> {
        let core = &self.0;
        let off = |k: &usize| {
            let u = &core.about.unknowns[*k];
            let start = u.start.unwrap_or(core.reference[*k]);
            (core.reference[*k] - start).abs() > CONSISTENT * u.size
        };
        let all = (0..core.X).filter(off);
        all.map(|k| (k, core.reference[k])).collect()
    }

    /// Number D of free coordinates q.
    pub fn freedoms(&self) -> usize {
        self.0.D
    }

    /// The unknowns selected as q; `None` in the tangent space.
    pub fn independent(&self) -> Option<Vec<usize>> {
        self.0.chart.independent.clone()
    }

    /// Names of the redundant equations.
    pub fn redundant(&self) -> Vec<String> {
        self.0.redundant()
    }

    /// Condition number of A at (q, p); infinite if the equations cannot be solved.
    pub fn condition(&mut self, t: f64, q: &[f64]) -> f64 {
        let core = &mut self.0;
        match core.solve(t, q) {
            Ok(()) => core.work.condition,
            Err(_) => f64::INFINITY,
        }
    }

    /// A warning about a nearby singular configuration, if any, to follow "joint at node a: ".
    pub fn singularity_warning(&mut self) -> Option<String> {
        let core = &mut self.0;
        let from = core.anchor.clone();
        core.close_to_singular(&from).map(advised)
    }

    /// Describes the independent coordinates and the redundant equations at present.
    pub fn describe(&self) -> String {
        self.0.describe()
    }

    /// Largest residual at φ(t, q) of the equations, each relative to its size.
    pub fn violation(&mut self, t: f64, q: &[f64]) -> f64 {
        self.0.violation(t, q)
    }

    /// Lagrange multipliers of the equations under the covector `f` (X), one per equation; not numbers
    /// where the equations have no solution.
    pub fn multipliers(&mut self, t: f64, q: &[f64], f: &[f64], lambda: &mut [f64]) {
        let core = &mut self.0;
        match core.solve(t, q) {
            Ok(()) => core.multipliers(f, lambda),
            Err(_) => lambda.fill(f64::NAN),
        }
    }

    /// Changes the chart at (q, p) in any case: to the unknowns `independent` as q, or to the
    /// tangent space there. False, without a change, if they do not determine x.
    ///
    /// The parameters follow q in `q`, in its velocity `v` and in the accelerations `a`.
    pub fn switch(
        &mut self,
        t: f64,
        independent: Option<&[usize]>,
        q: &mut [f64],
        v: &mut [f64],
        a: &mut [Vec<f64>],
    ) -> bool {
        self.0.switch(t, independent, q, v, a)
    }
}

impl Parametrization for ImplicitMap {
    fn kind(&self) -> &'static str {
        self.0.h.kind()
    }

    fn dims(&self) -> (usize, usize) {
        let core = &self.0;
        (core.D + core.p, core.X)
    }

    fn duplicate(&self) -> Box<dyn Parametrization> {
        Box::new(self.clone())
    }

    fn margin(&mut self, t: f64, q: &[f64]) -> f64 {
        let core = &mut self.0;
        match core.solve(t, q) {
            Ok(()) => 1.0 / core.work.condition - RANK,
            Err(_) => -1.0,
        }
    }

    fn change_charts(&mut self, t: f64, q: &[f64]) -> ChartChanges {
        let core = &mut self.0;
        core.remember(t, q);
        if core.D == 0 {
            // There are no other coordinates to choose.
            core.settle(t, &mut q.to_vec(), &mut vec![0.0; q.len()], &mut []);
        }
        ChartChanges::default()
    }

    fn reparametrize(&mut self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]) -> bool {
        self.0.settle(t, q, v, a)
    }

    fn reparametrizes(&self) -> bool {
        let core = &self.0;
        core.D > 0 && core.about.choice != Choice::Fixed
    }

    fn domain_error(&mut self, t: f64, q: &[f64]) -> OutsideDomain {
        match self.0.solve(t, q) {
            Ok(()) => OutsideDomain::Beyond("the positions that its equations allow"),
            Err(error) => OutsideDomain::Undefined(advised(error)),
        }
    }

    fn save(&self) -> Vec<f64> {
        self.0.save()
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        self.0.restore(saved)
    }

    fn freeze_piece(&mut self, at: Option<(f64, &[f64])>) {
        let core = &mut self.0;
        let Some((t, q)) = at else {
            return core.h.freeze_piece(None);
        };
        // If there is no solution, all conformance checks report it.
        if core.solve(t, q).is_ok() {
            core.h.freeze_piece(Some((t, &core.work.y)));
        }
    }

    fn tangent(&mut self, t: f64, q: &[f64], x: &mut [f64], B: &mut [f64]) {
        let core = &mut self.0;
        if core.solve(t, q).is_ok() {
            x.copy_from_slice(core.x());
            B.copy_from_slice(&core.work.Y);
        } else {
            x.fill(f64::NAN);
            B.fill(f64::NAN);
        }
    }

    fn kinematics(&mut self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: KinematicsMut<'_>) {
        self.0.kinematics(t, q, v, a, out);
    }

    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        self.0.geometric_stiffness(t, q, f, K);
    }

    fn implicit(&mut self) -> Option<&mut ImplicitMap> {
        Some(self)
    }
}

/// The message with a remedy.
fn advised(error: DomainError) -> String {
    match error {
        DomainError::Singular { .. } | DomainError::Crossed => format!(
            "{error}; a map ends at a singular position: `closure = \"multipliers\"` goes through"
        ),
        other => other.to_string(),
    }
}
