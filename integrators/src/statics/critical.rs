//! Critical points of an equilibrium path, found directly by an extended system.
//!
//! K is singular at a limit or bifurcation point. With one coordinate k held, e its unit vector, it is
//! regular there, and the bordered system
//!
//! ```text
//! ⎡K   e⎤ ⎡ψ⎤   ⎡0⎤
//! ⎣eᵀ  0⎦ ⎣g⎦ = ⎣1⎦
//! ```
//!
//! gives the shape ψ and −g, the stiffness against a force at k alone. K is singular where g = 0, and ψ is
//! its null vector then (Griewank & Reddien 1984; Govaerts 2000, Numerical Methods for Bifurcations of
//! Dynamical Equilibria, chapters 3 and 4). All other coordinates follow from q_k and t by equilibrium with k
//! held (Lyapunov and Schmidt), which leaves two unknowns:
//!
//! | point | equations |
//! |---|---|
//! | limit point | μ = 0, g = 0 |
//! | bifurcation | g = 0, h = 0, and μ = 0 is satisfied |
//!
//! with the reaction μ at k, g = −∂μ/∂q_k and h = −∂μ/∂t = φᵀ ∂r/∂t. Both are regular, and Newton's method converges
//! quadratically. The derivatives of g and h are second derivatives of φᵀr along ψ and w, where w is dq/dt with
//! k held. Those at a bifurcation give the directions of its paths.

mod derivatives;
mod held;

use super::newton::Newton;
use super::{Iteration, StaticNewtonOptions, StaticsError};
use crate::failure::Cause;
use crate::rounding::largest;
use crate::vectors::add;
use held::Held;
use pullback_manifold::system::{Point, System};

/// Limit or bifurcation point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CriticalKind {
    /// The load has a maximum or minimum on the path: ψᵀ ∂r/∂t ≠ 0.
    Limit,
    /// Paths cross.
    Bifurcation,
}

/// Direction of a path: (dq, dt).
#[derive(Clone, Debug, PartialEq)]
pub struct PathDirection {
    /// Change of the coordinates.
    pub dq: Vec<f64>,
    /// Change of the load parameter.
    pub dt: f64,
}

/// An equilibrium with a singular tangent.
#[derive(Clone, Debug, PartialEq)]
pub struct CriticalPoint {
    /// Limit or bifurcation point.
    pub kind: CriticalKind,
    /// Critical load parameter.
    pub t: f64,
    /// Coordinates.
    pub q: Vec<f64>,
    /// Null vector ψ of the tangent; its largest component is the scale of that coordinate.
    pub shape: Vec<f64>,
    /// Directions of the paths through the point, the one with the least part of ψ first, each with a largest
    /// component of one scale, or a change of the load alone: ψ itself at a limit point, two at a bifurcation, none if the
    /// point is isolated. The load does not change along a symmetric branch.
    pub paths: Vec<PathDirection>,
    /// The largest correction of each iteration, relative to the scales of coordinates or to the load.
    pub corrections: Vec<f64>,
}

/// The critical point near a state with charts as they are.
///
/// The coordinate that is held is the largest of `shape`, such as a [buckling
/// shape](crate::linearization::buckling), or of an estimate of the shape whose stiffness vanishes first along the path.
///
/// # Errors
/// [`StaticsError::NoCriticalPoint`] if Newton's method finds no simple critical point.
pub fn critical_point(
    system: &mut dyn System,
    at: Point<'_>,
    shape: Option<&[f64]>,
    options: &StaticNewtonOptions,
) -> Result<CriticalPoint, StaticsError> {
    super::options::check(&[], options)?;
    let mut newton = Newton::new(system, options, at.t)?;
    shape.map_or(Ok(()), |shape| newton.check("shape", shape))?;
    newton
        .critical_point(system, (at.q, at.t), shape)
        .map_err(|cause| {
            let reason = match cause {
                Cause::System(error) => error.to_string(),
                Cause::Linear { error, .. } => error.to_string(),
                Cause::TooManyIterations => "corrections do not become small".to_owned(),
                _ => "corrections grow".to_owned(),
            };
            StaticsError::NoCriticalPoint { t: at.t, reason }
        })
}

/// The equations of an equilibrium with k held: −μ = φᵀr, h, dq/dt = w, and second derivatives of φᵀr.
struct Equations {
    phi_r: f64,
    h: f64,
    w: PathDirection,
    psi_psi: f64,
    psi_w: f64,
    w_w: f64,
}

/// Largest slope of the load along a path, relative to the load, that counts as rounding of these differences.
const SYMMETRIC: f64 = 1e-4;
/// Distance of a limit point from a bifurcation, in corrections, from which on it is told apart.
const APART: f64 = 10.0;
/// Correction, relative to the scales of coordinates or to the load, at which an iteration ends.
const EXACT: f64 = 1e-9;
/// The same for equilibrium with k held, which is found before each correction.
const BALANCED: f64 = f64::EPSILON;
/// Factor below which corrections still decrease.
const DECREASE: f64 = 0.5;

/// Whether the corrections have come down to [`EXACT`] or to rounding errors: small ones that do not decrease any more, or
/// that no longer converge quadratically after they did.
fn is_exact(corrections: &[f64]) -> bool {
    let quadratic = |from: f64, to: f64| to < from.powf(1.5);
    let (before, last, now) = match *corrections {
        [.., before, last, now] => (before, last, now),
        [last, now] => (0.0, last, now),
        _ => return false,
    };
    let stagnates = now > DECREASE * last || (quadratic(before, last) && !quadratic(last, now));
    now <= EXACT || (last < EXACT.sqrt() && now <= last && stagnates)
}

/// Size of changes of a load parameter.
fn load(t: f64) -> f64 {
    if t == 0.0 { 1.0 } else { t.abs() }
}

impl Newton {
    /// See [`critical_point`].
    pub(super) fn critical_point(
        &mut self,
        system: &mut dyn System,
        guess: (&[f64], f64),
        shape: Option<&[f64]>,
    ) -> Result<CriticalPoint, Cause> {
        self.history.clear();
        self.test.first = [0.0; 3];
        self.evaluate(system, None, guess.0, guess.1)
            .map_err(Cause::System)?;
        let estimate = match shape {
            Some(shape) => shape.to_vec(),
            None => self.estimate(system, guess)?,
        };
        let relative = |i: &usize| (estimate[*i] * self.inverse_scale[*i]).abs();
        let largest = (0..estimate.len()).max_by(|i, j| relative(i).total_cmp(&relative(j)));
        let k = largest.ok_or(Cause::Diverged)?;
        let mut held = Held::at(k, self, system).ok_or(Cause::Diverged)?;
        held.update(self)?;
        let (w, h) = held.solve(&mut self.solver, &self.r_t, 1.0)?;
        // The tangent of the path is w − (h/g) ψ.
        let steep = (h / held.g).abs() * self.size(&held.psi.dq) > self.size(&w.dq);
        let [likely, other] = match steep {
            true => [CriticalKind::Limit, CriticalKind::Bifurcation],
            false => [CriticalKind::Bifurcation, CriticalKind::Limit],
        };
        let found = self.extended(system, guess, &mut held, likely);
        found.or_else(|cause| {
            let found = self.extended(system, guess, &mut held, other);
            found.map_err(|_| cause)
        })
    }

    /// Newton's method for one kind of point.
    fn extended(
        &mut self,
        system: &mut dyn System,
        guess: (&[f64], f64),
        held: &mut Held,
        kind: CriticalKind,
    ) -> Result<CriticalPoint, Cause> {
        let (mut q, mut t) = (guess.0.to_vec(), guess.1);
        let mut corrections: Vec<f64> = Vec::new();
        let mut load = t.abs();
        loop {
            let eq = self.equations(system, &mut q, t, held, kind)?;
            let on_path = [eq.h, held.g, -eq.phi_r];
            let singular = [eq.psi_w, eq.psi_psi, -held.g];
            let crossing = [eq.w_w, eq.psi_w, -eq.h];
            let [first, second] = match kind {
                CriticalKind::Limit => [on_path, singular],
                CriticalKind::Bifurcation => [singular, crossing],
            };
            let determinant = first[0] * second[1] - first[1] * second[0];
            let dt = (first[2] * second[1] - first[1] * second[2]) / determinant;
            let along = (first[0] * second[2] - first[2] * second[0]) / determinant;
            for ((dq, w), psi) in self.dq.iter_mut().zip(&eq.w.dq).zip(&held.psi.dq) {
                *dq = dt * w + along * psi;
            }
            load = load.max(dt.abs());
            let relative = if dt == 0.0 { 0.0 } else { (dt / load).abs() };
            let correction = self.size(&self.dq).max(relative);
            if !correction.is_finite() {
                return Err(Cause::Diverged);
            }
            corrections.push(correction);
            add(&mut q, 1.0, &self.dq);
            t += dt;
            if is_exact(&corrections) {
                // ∂r/∂t has a part of its own there.
                let apart = eq.h.abs() * self.size(&held.psi.dq);
                if kind == CriticalKind::Limit && apart <= APART * correction * eq.psi_w.abs() {
                    return Err(Cause::Diverged);
                }
                self.hold(system, &mut q, t, held)?;
                if !self.is_balanced(system, &q) {
                    return Err(Cause::Diverged);
                }
                let scale = self.size(&held.psi.dq);
                return Ok(CriticalPoint {
                    kind,
                    t,
                    q,
                    shape: held.psi.dq.iter().map(|x| x / scale).collect(),
                    paths: self.paths(&eq, held, kind, t),
                    corrections,
                });
            }
            if corrections.len() > self.options.max_iterations {
                return Err(Cause::TooManyIterations);
            }
        }
    }

    /// Equilibrium with k held, from `q`; its tangent is evaluated and factorised.
    fn hold(
        &mut self,
        system: &mut dyn System,
        q: &mut [f64],
        t: f64,
        held: &mut Held,
    ) -> Result<(), Cause> {
        let (mut last, mut previous) = (f64::INFINITY, q.to_vec());
        for iteration in 0..=self.options.max_iterations {
            let from = (iteration > 0).then_some((t, &previous[..]));
            self.evaluate(system, from, q, t).map_err(Cause::System)?;
            held.update(self)?;
            let (x, _) = held.solve(&mut self.solver, &self.r, 0.0)?;
            let correction = self.size(&x.dq);
            let found = correction <= BALANCED
                || (correction < EXACT.sqrt() && correction > DECREASE * last);
            let residual = largest(system.pattern(), &self.r, [0.0; 3]);
            let measures = system.scales().measures();
            self.history.push(Iteration {
                residual,
                ratio: self.test.ratio(residual, measures),
                correction,
                damping: if found { 0.0 } else { 1.0 },
            });
            if found {
                return Ok(());
            }
            if !correction.is_finite() {
                return Err(Cause::Diverged);
            }
            last = correction;
            previous.copy_from_slice(q);
            add(q, 1.0, &x.dq);
        }
        Err(Cause::TooManyIterations)
    }

    /// Finds the equilibrium with k held, and evaluates everything there.
    fn equations(
        &mut self,
        system: &mut dyn System,
        q: &mut [f64],
        t: f64,
        held: &mut Held,
        kind: CriticalKind,
    ) -> Result<Equations, Cause> {
        self.hold(system, q, t, held)?;
        let (_, phi_r) = held.solve(&mut self.solver, &self.r, 0.0)?;
        let (w, h) = held.solve(&mut self.solver, &self.r_t, 1.0)?;
        let mut second = |along: &PathDirection, with: &[&PathDirection]| {
            let mut out = [0.0; 2];
            let changes = self.second(system, (q, t), along, with)?;
            for (out, change) in out.iter_mut().zip(changes) {
                *out = held.solve(&mut self.solver, &change, 0.0)?.1;
            }
            Ok(out)
        };
        let [psi_psi, psi_w] = second(&held.psi, &[&held.psi, &w])?;
        let [w_w, _] = match kind {
            CriticalKind::Limit => [0.0; 2],
            CriticalKind::Bifurcation => second(&w, &[&w])?,
        };
        Ok(Equations {
            phi_r,
            h,
            w,
            psi_psi,
            psi_w,
            w_w,
        })
    }

    /// Directions of the paths through a point: s ψ + τ w, where
    /// s² φᵀr″ψψ + 2 s τ φᵀr″ψw + τ² φᵀr″ww = 0 at a bifurcation.
    fn paths(&self, eq: &Equations, held: &Held, kind: CriticalKind, t: f64) -> Vec<PathDirection> {
        let load = load(t);
        let direction = |s: f64, tau: f64| {
            let parts = held.psi.dq.iter().zip(&eq.w.dq);
            let dq: Vec<f64> = parts.map(|(psi, w)| s * psi + tau * w).collect();
            // A path may change the load alone.
            let length = match self.size(&dq) {
                0.0 => tau.abs() / load,
                size => size,
            };
            let dt = tau / length;
            PathDirection {
                dq: dq.iter().map(|x| x / length).collect(),
                dt: if dt.abs() <= SYMMETRIC * load {
                    0.0
                } else {
                    dt
                },
            }
        };
        if kind == CriticalKind::Limit {
            return vec![direction(1.0, 0.0)];
        }
        // ψ as large as w, so that the coefficients are comparable.
        let unit = self.size(&eq.w.dq).max(EXACT / load) / self.size(&held.psi.dq);
        let (a, b, c) = (unit * unit * eq.psi_psi, unit * eq.psi_w, eq.w_w);
        let discriminant = b * b - a * c;
        if discriminant.is_nan() || discriminant < 0.0 {
            return Vec::new();
        }
        let sum = -(b + discriminant.sqrt().copysign(b));
        let mut roots = [(sum, a), (c, sum)];
        roots.sort_by(|x, y| (x.0 * y.1).abs().total_cmp(&(y.0 * x.1).abs()));
        roots.map(|(s, tau)| direction(unit * s, tau)).to_vec()
    }
}
