//! Implicit constraints whose sizes are known at run time only: loops of joints.
//!
//! The same mathematics as [`Solved`](super::Solved), with two more things. The equations
//! h(t, p, x) = 0 have **parameters** p beside the unknowns x: driven coordinates, the frame that
//! carries the loop. They stand behind q among the coordinates of the map (q, p) ↦ x, and
//!
//! ```text
//! ∂x/∂p = −P h_p       Z = [0 1; B_q B_p] = ∂(p, x)/∂(q, p)
//! Ḃ = −P ḣ_y Z         B̈ = −P (ḧ_y Z + 2 ḣ_y Ż)         K_σ(f) = −Zᵀ (Σ λ_i D²h_i) Z
//! ```
//!
//! with y = (p, x). And how many of the x are free is found by the rank of h_x, not given.

#![allow(non_snake_case)]
#![allow(
    clippy::needless_range_loop,
    reason = "matrices in slices are read by their indices"
)]

mod charts;
mod core;
mod dense;
mod names;
mod start;
mod walk;

use super::{DomainError, ImplicitError};
use crate::map::{KinematicsMut, Parametrization};
use crate::system::ChartChanges;
pub(super) use start::aside;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// One of the unknowns x.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    /// Name, for messages.
    pub name: String,
    /// Typical size in its unit: 1 for an angle, a length of the mechanism for a length.
    pub size: f64,
    /// A value that it should start with.
    pub start: Option<f64>,
    /// Between 0 and 1: how gladly it is taken for one of the q at the start, where the condition
    /// number allows that.
    pub preference: f64,
}

/// One of the equations h = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Equation {
    /// Name, for messages.
    pub name: String,
    /// What counts as one in its unit: 1 for an angle, a length of the mechanism for a gap.
    pub size: f64,
}

/// Names and sizes of what a [`Closed`] constraint is made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Description {
    /// The unknowns x.
    pub unknowns: Vec<Unknown>,
    /// First of each three unknowns that are a rotation vector: they change their chart at ψ > π.
    pub rotations: Vec<usize>,
    /// The equations.
    pub equations: Vec<Equation>,
    /// What each of the parameters p belongs to, for messages.
    pub parameters: Vec<String>,
}

/// The map (q, p) ↦ x of equations h(t, p, x) = 0, solved for x in D = X − rank(h_x) of its own
/// coordinates and the parameters p.
///
/// q = 0 is the configuration at which it was made. The split of x into q and dependent coordinates
/// is changed in the run as for [`Solved`](super::Solved), but only where it has become bad; where no split is good q are coordinates
/// in the tangent space.
pub struct Closed(Mutex<core::Core>);

impl Closed {
    /// Assembles the equations at time `t` and parameters `p`: `h` takes (p, x) to the residuals.
    ///
    /// The unknowns start at zero, or where [`Unknown::start`] says. If they are closed at zero,
    /// those values are approached in steps, so that the mechanism stays on its branch. Of values that
    /// do not fit together as many are kept as do, in the order of the unknowns; the others are a
    /// first guess ([`Closed::displaced`]).
    ///
    /// # Errors
    /// [`ImplicitError`] naming the equations and coordinates concerned.
    pub fn new(
        h: Box<dyn Parametrization>,
        about: Description,
        t: f64,
        p: &[f64],
    ) -> Result<Self, ImplicitError> {
        core::Core::assemble(h, about, t, p).map(|core| Self(Mutex::new(core)))
    }

    fn core(&self) -> MutexGuard<'_, core::Core> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn core_mut(&mut self) -> &mut core::Core {
        self.0.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    /// The configuration at q = 0.
    pub fn reference(&self) -> Vec<f64> {
        self.core().reference.clone()
    }

    /// The unknowns that do not start where [`Unknown::start`] says, as it does not fit, and where
    /// they start instead.
    pub fn displaced(&self) -> Vec<(usize, f64)> {
        let core = self.core();
        let off = |k: &usize| {
            let u = &core.about.unknowns[*k];
            let start = u.start.unwrap_or(core.reference[*k]);
            (core.reference[*k] - start).abs() > super::solve::CONSISTENT * u.size
        };
        let all = (0..core.X).filter(off);
        all.map(|k| (k, core.reference[k])).collect()
    }

    /// Number D of free coordinates q.
    pub fn freedoms(&self) -> usize {
        self.core().D
    }

    /// The unknowns that q are; `None` in the tangent space.
    pub fn independent(&self) -> Option<Vec<usize>> {
        self.core().chart.independent.clone()
    }

    /// Condition number of A at (q, p); infinite where the equations cannot be solved.
    pub fn condition(&self, t: f64, q: &[f64]) -> f64 {
        let mut core = self.core();
        match core.solve(t, q) {
            Ok(()) => core.work.condition,
            Err(_) => f64::INFINITY,
        }
    }

    /// Changes the chart at (q, p) whether that is due or not: to the unknowns `independent` as q,
    /// or to the tangent space there. False, and no change, where they do not determine x.
    ///
    /// `q`, its velocity `v` and accelerations `a` hold those of the parameters behind those of q.
    pub fn switch(
        &mut self,
        t: f64,
        independent: Option<&[usize]>,
        q: &mut [f64],
        v: &mut [f64],
        a: &mut [Vec<f64>],
    ) -> bool {
        self.core_mut().switch(t, independent, q, v, a)
    }
}

impl Parametrization for Closed {
    fn kind(&self) -> &'static str {
        "closed loop"
    }

    fn dims(&self) -> (usize, usize) {
        let core = self.core();
        (core.D + core.p, core.X)
    }

    fn duplicate(&self) -> Box<dyn Parametrization> {
        Box::new(Self(Mutex::new(self.core().clone())))
    }

    fn margin(&self, t: f64, q: &[f64]) -> f64 {
        let mut core = self.core();
        match core.solve(t, q) {
            Ok(()) => 1.0 / core.work.condition - super::chart::RANK,
            Err(_) => -1.0,
        }
    }

    fn change_charts(&mut self, t: f64, q: &[f64]) -> ChartChanges {
        let core = self.core_mut();
        core.remember(t, q);
        if core.D == 0 {
            // Nobody asks for other coordinates where there are none.
            core.settle(t, &mut q.to_vec(), &mut vec![0.0; q.len()], &mut []);
        }
        ChartChanges::default()
    }

    fn reparametrize(&mut self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]) -> bool {
        self.core_mut().settle(t, q, v, a)
    }

    fn reparametrizes(&self) -> bool {
        self.core().D > 0
    }

    fn edge(&self) -> &'static str {
        "the positions that its equations allow"
    }

    fn domain_error(&self, t: f64, q: &[f64]) -> Option<String> {
        self.core().solve(t, q).err().map(advised)
    }

    fn singularity_warning(&self) -> Option<String> {
        let mut core = self.core();
        let from = core.anchor.clone();
        core.close_to_singular(&from).map(advised)
    }

    fn describe(&self) -> Option<String> {
        Some(self.core().describe())
    }

    fn save(&self) -> Vec<f64> {
        self.core().save()
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        self.core_mut().restore(saved)
    }

    fn freeze_piece(&mut self, at: Option<(f64, &[f64])>) {
        let core = self.core_mut();
        let Some((t, q)) = at else {
            return core.h.freeze_piece(None);
        };
        // Where nothing can be found, every law that is asked there says so.
        if core.solve(t, q).is_ok() {
            core.h.freeze_piece(Some((t, &core.work.y)));
        }
    }

    fn tangent(&self, t: f64, q: &[f64], x: &mut [f64], B: &mut [f64]) {
        let mut core = self.core();
        if core.solve(t, q).is_ok() {
            x.copy_from_slice(core.x());
            B.copy_from_slice(&core.work.Y);
        } else {
            x.fill(f64::NAN);
            B.fill(f64::NAN);
        }
    }

    fn kinematics(&self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: KinematicsMut<'_>) {
        self.core().kinematics(t, q, v, a, out);
    }

    fn geometric_stiffness(&self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        self.core().geometric_stiffness(t, q, f, K);
    }

    fn violation(&self, t: f64, q: &[f64]) -> Option<f64> {
        Some(self.core().violation(t, q))
    }

    fn multipliers(&self, t: f64, q: &[f64], f: &[f64], lambda: &mut [f64]) {
        let mut core = self.core();
        match core.solve(t, q) {
            Ok(()) => core.multipliers(f, lambda),
            Err(_) => lambda.fill(f64::NAN),
        }
    }
}

/// What there is to say, and to do.
fn advised(error: DomainError) -> String {
    match error {
        DomainError::Singular { .. } | DomainError::Crossed => format!(
            "{error}; a map ends at a singular position: `closure = \"multipliers\"` goes through"
        ),
        other => other.to_string(),
    }
}
