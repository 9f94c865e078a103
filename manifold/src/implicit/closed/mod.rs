//! Implicit constraints of sizes known only at run time: loops of joints.
//!
//! Extends [`Solved`](super::Solved) in two respects. The equations h(t, p, x) = 0 have
//! **parameters** p beside the unknowns x: prescribed coordinates, the frame that carries the loop.
//! They follow q in the coordinates of the map (q, p) ↦ x, and
//!
//! ```text
//! ∂x/∂p = −P h_p       Z = [0 1; B_q B_p] = ∂(p, x)/∂(q, p)
//! Ḃ = −P ḣ_y Z         B̈ = −P (ḧ_y Z + 2 ḣ_y Ż)         K_σ(f) = −Zᵀ (Σ λ_i D²h_i) Z
//! ```
//!
//! with y = (p, x). The number of free x is found from the rank of h_x.

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
    /// Desired initial value.
    pub start: Option<f64>,
    /// Preference as an independent coordinate at the start, from 0 to 1, as far as the condition
    /// number allows.
    pub preference: f64,
}

/// One of the equations h = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Equation {
    /// Name, for messages.
    pub name: String,
    /// Size in its unit: 1 for an angle, a length of the mechanism for a gap.
    pub size: f64,
}

/// Names and sizes for a [`Closed`] constraint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Description {
    /// The unknowns x.
    pub unknowns: Vec<Unknown>,
    /// First of each three unknowns that are a rotation vector; its chart changes at ψ > π.
    pub rotations: Vec<usize>,
    /// The equations.
    pub equations: Vec<Equation>,
    /// Name of the owner of each parameter p, for messages.
    pub parameters: Vec<String>,
}

/// The map (q, p) ↦ x of equations h(t, p, x) = 0, solved for x in D = X − rank(h_x) of its own
/// coordinates and the parameters p.
///
/// q = 0 is the initial configuration. The split of x into q and dependent coordinates changes
/// during a run as for [`Solved`](super::Solved), but only when it becomes bad; if no split is
/// good, q are coordinates in the tangent space.
pub struct Closed(Mutex<core::Core>);

impl Closed {
    /// Assembles the equations at time `t` and parameters `p`: `h` takes (p, x) to the residuals.
    ///
    /// The unknowns start at zero, or at [`Unknown::start`]. If the loop is closed at zero, these
    /// values are approached in steps, so that the mechanism stays on its branch. If they are
    /// inconsistent, as many as possible are kept, in the order of the unknowns; the others are a
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

    /// The unknowns that cannot start at [`Unknown::start`], and their actual initial values.
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

    /// The unknowns selected as q; `None` in the tangent space.
    pub fn independent(&self) -> Option<Vec<usize>> {
        self.core().chart.independent.clone()
    }

    /// Condition number of A at (q, p); infinite if the equations cannot be solved.
    pub fn condition(&self, t: f64, q: &[f64]) -> f64 {
        let mut core = self.core();
        match core.solve(t, q) {
            Ok(()) => core.work.condition,
            Err(_) => f64::INFINITY,
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
            // There are no other coordinates to choose.
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
        // If there is no solution, all conformance checks report it.
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

/// The message with a remedy.
fn advised(error: DomainError) -> String {
    match error {
        DomainError::Singular { .. } | DomainError::Crossed => format!(
            "{error}; a map ends at a singular position: `closure = \"multipliers\"` goes through"
        ),
        other => other.to_string(),
    }
}
