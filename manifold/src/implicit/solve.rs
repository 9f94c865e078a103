//! Newton's method on h(t, x) = 0, and the choice of the coordinates q.

use super::assemble::{assemble, touching};
use super::chart::{Chart, Inverse, RANK, best, invert, singular, sizes, split};
use super::{Choice, DomainError, Equations, GAIN, Implicit, ImplicitError, names};
use crate::map::{Map, Reparametrized, derived};
use nalgebra::{SMatrix, SVector};

/// Largest residual of a redundant equation, as a relative change of coordinates, that counts as zero.
pub(super) const CONSISTENT: f64 = 1e-9;
/// Correction relative to the sizes of the coordinates that ends Newton's method; the next one
/// would be its square.
pub(super) const CONVERGED: f64 = 1e-13;
/// Correction that may be rounding if the condition number is large.
pub(super) const ROUNDING: f64 = 1e-10;
/// Largest number of iterations from the last converged state.
const ITERATIONS: usize = 30;

/// A solution of h(t, x) = 0 at given q.
pub(super) struct Solution<const D: usize, const X: usize, const M: usize> {
    pub x: SVector<f64, X>,
    pub inverse: Inverse<D, X, M>,
}

/// An implicit constraint solved for X coordinates x = φ(t, q) in D = X − rank(h_x) of its own.
///
/// q = 0 is the initial configuration. D + M exceeds X by the number of redundant equations, which
/// are found, dropped and named ([`Solved::redundant`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solved<H, const D: usize, const X: usize, const M: usize> {
    pub(super) constraint: H,
    choice: Choice,
    /// Configuration at q = 0.
    reference: SVector<f64, X>,
    /// The last converged x and B there: Newton's method starts from it.
    anchor: SVector<f64, X>,
    anchor_B: SMatrix<f64, X, D>,
    /// Largest length of each row of h_x so far.
    pub(super) sizes: [f64; M],
    pub(super) chart: Chart<D, X, M>,
}

impl<H, const D: usize, const X: usize, const M: usize> Solved<H, D, X, M>
where
    H: Implicit<X, M>,
{
    /// Assembles the constraint at time `t` as near as Newton's method gets to `guess`, with the
    /// best split of its coordinates.
    ///
    /// # Errors
    /// [`ImplicitError`] naming the equations and coordinates concerned.
    pub fn new(constraint: H, t: f64, guess: [f64; X]) -> Result<Self, ImplicitError> {
        Self::with(constraint, t, guess, Choice::default())
    }

    /// As [`Solved::new`], with another choice of the coordinates q.
    ///
    /// # Errors
    /// As [`Solved::new`].
    pub fn with(
        constraint: H,
        t: f64,
        guess: [f64; X],
        choice: Choice,
    ) -> Result<Self, ImplicitError> {
        const {
            assert!(
                D <= X && X <= D + M,
                "X coordinates have D freedoms and M equations or fewer"
            );
        }
        let x = assemble::<H, D, X, M>(&constraint, t, guess.into())?;
        let J = derived::tangent(&Equations(&constraint), t, &x).B;
        let sizes = sizes(&constraint, &J, &[0.0; M]);
        let found = best(&constraint, &J, &sizes, choice);
        // An equation with a vanishing gradient is redundant, or the configuration is singular.
        let flat = touching(&constraint, t, &x, &J);
        let used = match &found {
            Some((chart, _)) => chart.used,
            None => [flat.iter().all(|flat| *flat); M],
        };
        if let Some(i) = (0..M).find(|&i| used[i] && flat[i]) {
            let equation = constraint.equation(i);
            return Err(ImplicitError::Touching { equation });
        }
        let (chart, inverse) =
            found.ok_or_else(|| singular::<H, D, X, M>(&constraint, &J, &sizes))?;
        Ok(Self {
            constraint,
            choice,
            reference: x,
            anchor: x,
            anchor_B: inverse.B,
            sizes,
            chart,
        })
    }

    /// The same constraint with these coordinates as q, until a better choice is found
    /// ([`Choice::Split`]) or for good ([`Choice::Fixed`]); `None` if they do not determine the
    /// others. q = 0 stays the same configuration: to be called before anything moves.
    #[must_use]
    pub fn with_independent(mut self, t: f64, independent: [usize; D]) -> Option<Self> {
        let zero = SVector::zeros();
        self.switch(t, &zero, &zero, Some(independent))
            .map(|_| self)
    }

    /// The configuration at q = 0.
    pub fn reference(&self) -> SVector<f64, X> {
        self.reference
    }

    /// q of a configuration x.
    pub fn coordinates(&self, x: &SVector<f64, X>) -> SVector<f64, D> {
        self.chart.L.tr_mul(&(x - self.reference))
    }

    /// q̇ of a velocity ẋ that the constraint allows, or q̈ of an acceleration.
    pub fn rates(&self, x_dot: &SVector<f64, X>) -> SVector<f64, D> {
        self.chart.L.tr_mul(x_dot)
    }

    /// The coordinates selected as q; `None` in the tangent space.
    pub fn independent(&self) -> Option<[usize; D]> {
        self.chart.independent
    }

    /// The equations behind it.
    pub fn constraint(&self) -> &H {
        &self.constraint
    }

    /// The choice of q.
    pub fn choice(&self) -> Choice {
        self.choice
    }

    /// Names of the redundant equations.
    pub fn redundant(&self) -> Vec<String> {
        let unused = (0..M).filter(|&i| !self.chart.used[i]);
        unused.map(|i| self.constraint.equation(i)).collect()
    }

    /// Condition number of A at q; infinite if the equations cannot be solved.
    pub fn condition(&self, t: f64, q: &SVector<f64, D>) -> f64 {
        self.solve(t, q)
            .map_or(f64::INFINITY, |s| s.inverse.condition)
    }

    /// x at q, and A⁻¹ there.
    pub(super) fn solve(
        &self,
        t: f64,
        q: &SVector<f64, D>,
    ) -> Result<Solution<D, X, M>, DomainError> {
        let residual = Equations(&self.constraint);
        let mut x = self.anchor + self.anchor_B * (q - self.coordinates(&self.anchor));
        let mut before = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let at = derived::tangent(&residual, t, &x);
            let inverse = invert(&self.constraint, &self.chart, &at.B, &self.sizes);
            let Some(inverse) = inverse.filter(|i| i.condition * RANK < 1.0) else {
                return Err(self.singular(&at.B));
            };
            let dx = inverse.B * (q - self.coordinates(&x)) - inverse.P * at.x;
            x += dx;
            let size = self.largest(&dx);
            // Newton's method contracts near the branch of solutions on which it started; otherwise
            // it may end on another one.
            let rounding = ROUNDING.max(f64::EPSILON * 10.0 * inverse.condition);
            let stalled = size <= rounding && size > 0.5 * before;
            if size <= CONVERGED || stalled {
                self.check_unused(&at.x)?;
                return Ok(Solution { x, inverse });
            }
            if size.is_nan() || size > 0.5 * before || size > 1.0 {
                return Err(self.too_far(&at.x));
            }
            before = size;
        }
        Err(self.too_far(&self.constraint.h(t, &x)))
    }

    /// Largest entry of a change of x, relative to the sizes of the coordinates.
    fn largest(&self, dx: &SVector<f64, X>) -> f64 {
        let relative = |(k, dx): (usize, &f64)| (dx / self.constraint.size(k)).abs();
        // A sum keeps NaN.
        dx.iter()
            .enumerate()
            .map(relative)
            .fold(0.0, |a, b| if a > b { a } else { b + 0.0 * a })
    }

    fn check_unused(&self, h: &SVector<f64, M>) -> Result<(), DomainError> {
        for i in (0..M).filter(|&i| !self.chart.used[i]) {
            let allowed = CONSISTENT * self.sizes[i];
            if h[i].is_nan() || h[i].abs() > allowed {
                return Err(DomainError::Inconsistent {
                    equation: self.constraint.equation(i),
                    residual: h[i],
                });
            }
        }
        Ok(())
    }

    fn too_far(&self, h: &SVector<f64, M>) -> DomainError {
        let i = h.iamax();
        DomainError::TooFar {
            equation: self.constraint.equation(i),
            residual: h[i],
        }
    }

    fn singular(&self, J: &SMatrix<f64, M, X>) -> DomainError {
        let condition = invert(&self.constraint, &self.chart, J, &self.sizes)
            .map_or(f64::INFINITY, |i| i.condition);
        let (equations, coordinates) = names::dependences(&self.constraint, J, &self.sizes, X - D);
        DomainError::Singular {
            condition,
            equations,
            coordinates,
        }
    }

    /// Makes a converged state the start of Newton's method.
    pub(super) fn remember(&mut self, t: f64, q: &SVector<f64, D>) -> Option<Solution<D, X, M>> {
        let now = self.solve(t, q).ok()?;
        (self.anchor, self.anchor_B) = (now.x, now.inverse.B);
        let J = derived::tangent(&Equations(&self.constraint), t, &now.x).B;
        self.sizes = sizes(&self.constraint, &J, &self.sizes);
        Some(now)
    }

    /// Changes the chart at a converged state if needed, and makes the state the new start.
    pub(super) fn settle(
        &mut self,
        t: f64,
        q: &SVector<f64, D>,
        v: &SVector<f64, D>,
    ) -> Option<Reparametrized<D>> {
        let now = self.remember(t, q)?;
        if self.choice == Choice::Fixed {
            return None;
        }
        let J = derived::tangent(&Equations(&self.constraint), t, &now.x).B;
        let (chart, inverse) = best::<H, D, X, M>(&self.constraint, &J, &self.sizes, self.choice)?;
        if now.inverse.condition <= GAIN * inverse.condition {
            return None;
        }
        Some(self.reparametrize(t, q, v, chart, inverse.B))
    }

    /// Changes the chart at (q, q̇) in any case: to the coordinates `independent`, or to the tangent
    /// space there. `None`, without a change, if they do not determine x.
    pub fn switch(
        &mut self,
        t: f64,
        q: &SVector<f64, D>,
        v: &SVector<f64, D>,
        independent: Option<[usize; D]>,
    ) -> Option<Reparametrized<D>> {
        let now = self.remember(t, q)?;
        let J = derived::tangent(&Equations(&self.constraint), t, &now.x).B;
        let used = self.chart.used;
        let chart = match independent {
            Some(independent) => split(independent, used)?,
            None => Chart {
                used,
                ..best(&self.constraint, &J, &self.sizes, Choice::Tangent)?.0
            },
        };
        let inverse = invert(&self.constraint, &chart, &J, &self.sizes)?;
        (inverse.condition * RANK < 1.0).then(|| self.reparametrize(t, q, v, chart, inverse.B))
    }

    /// q′ = L′ᵀ(x − x_ref) is linear in x: x, ẋ and ẍ do not change.
    fn reparametrize(
        &mut self,
        t: f64,
        q: &SVector<f64, D>,
        v: &SVector<f64, D>,
        chart: Chart<D, X, M>,
        B: SMatrix<f64, X, D>,
    ) -> Reparametrized<D> {
        let k = self.kinematics(t, q, v, &SVector::zeros());
        self.chart = chart;
        self.anchor_B = B;
        Reparametrized {
            q: self.coordinates(&k.x),
            v: self.rates(&k.x_dot),
            B: chart.L.tr_mul(&k.B),
            c: self.rates(&k.x_ddot),
        }
    }
}
