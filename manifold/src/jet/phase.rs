//! Value, gradient and Hessian of an energy in coordinates and velocities.

use super::derivative;
use crate::scalar::{MAX_ORDER, Scalar};
use std::ops::{Add, Mul, Neg, Sub};

/// A value with its derivatives in `X` coordinates x and `V` velocities v, over the numbers `S`.
///
/// What an energy needs to become a force with its tangents:
///
/// - a potential energy has no velocities: V = 0, S = `f64`;
/// - a dissipation has both, S = `f64`;
/// - a kinetic energy moves along its own motion, S = [`Grad<f64, 1>`](super::Grad) with the
///   velocity of x and of v as derivatives. The Hessian in x alone is then not differentiated
///   along the motion, no equation of motion asks for it: `xx` are plain numbers.
///
/// `HX` and `HV` are `X` and `V` for the Hessian, or both 0 to leave it out. The gradient is the same
/// to the last bit with it and without.
///
/// Most values depend on a few variables only (the rotation of one frame), so variables are taken
/// in threes, and threes on which a value does not depend are left at zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase<S, const X: usize, const V: usize, const HX: usize, const HV: usize> {
    /// Value.
    pub value: S,
    /// Which threes of x and of v the value depends on, one bit each.
    seen: [u32; 2],
    /// Gradient in x.
    pub x: [S; X],
    /// Gradient in v.
    pub v: [S; V],
    /// Hessian in x; entries `xx[i][j]` of threes with j above i are not kept up to date.
    pub xx: [[f64; HX]; HX],
    /// Mixed Hessian ∂²/∂vᵢ∂xⱼ.
    pub vx: [[S; HX]; HV],
    /// Hessian in v; entries as in `xx`.
    pub vv: [[S; HV]; HV],
}

/// Variables that one bit stands for.
const GROUP: usize = 3;

/// Runs over the marked variables of `0..n`.
#[inline(always)]
fn each(n: usize, marks: u32, mut f: impl FnMut(usize)) {
    for b in 0..n / GROUP {
        if marks & (1 << b) != 0 {
            let i = GROUP * b;
            f(i);
            f(i + 1);
            f(i + 2);
        }
    }
    if !n.is_multiple_of(GROUP) && marks & (1 << (n / GROUP)) != 0 {
        for i in n - n % GROUP..n {
            f(i);
        }
    }
}

/// Runs over the marked pairs (i, j) with the three of j not above that of i.
#[inline(always)]
fn lower(n: usize, marks: u32, mut f: impl FnMut(usize, usize)) {
    each(n, marks, |i| {
        each((i / GROUP * GROUP + GROUP).min(n), marks, |j| f(i, j));
    });
}

impl<S: Scalar, const X: usize, const V: usize, const HX: usize, const HV: usize>
    Phase<S, X, V, HX, HV>
{
    /// A value that depends on no variable.
    #[inline]
    pub fn given(value: S) -> Self {
        const {
            assert!(HX == X && HV == V || HX == 0 && HV == 0, "all of the Hessian or none");
            assert!(X <= 96 && V <= 96, "one bit marks three variables");
        }
        Self {
            value,
            seen: [0; 2],
            x: [S::zero(); X],
            v: [S::zero(); V],
            xx: [[0.0; HX]; HX],
            vx: [[S::zero(); HX]; HV],
            vv: [[S::zero(); HV]; HV],
        }
    }

    /// Coordinate number `i`.
    #[inline]
    pub fn coordinate(value: S, i: usize) -> Self {
        let mut out = Self::given(value);
        out.x[i] = S::one();
        out.seen[0] = 1 << (i / GROUP);
        out
    }

    /// Velocity number `i`.
    #[inline]
    pub fn velocity(value: S, i: usize) -> Self {
        let mut out = Self::given(value);
        out.v[i] = S::one();
        out.seen[1] = 1 << (i / GROUP);
        out
    }

    /// Whether the value depends on no variable.
    #[inline]
    fn is_given(&self) -> bool {
        self.seen == [0; 2]
    }

    /// From rules for the entries, which are given the part of the Hessian as well.
    #[inline(always)]
    fn filled(
        value: S,
        seen: [u32; 2],
        x: impl Fn(usize) -> S,
        v: impl Fn(usize) -> S,
        xx: impl Fn(usize, usize) -> f64,
        vx: impl Fn(usize, usize) -> S,
        vv: impl Fn(usize, usize) -> S,
    ) -> Self {
        let mut out = Self::given(value);
        out.seen = seen;
        each(X, seen[0], |i| out.x[i] = x(i));
        each(V, seen[1], |i| out.v[i] = v(i));
        lower(HX, seen[0], |i, j| out.xx[i][j] = xx(i, j));
        each(HV, seen[1], |i| {
            each(HX, seen[0], |j| out.vx[i][j] = vx(i, j));
        });
        lower(HV, seen[1], |i, j| out.vv[i][j] = vv(i, j));
        out
    }

    /// All entries times a number without variables.
    #[inline(always)]
    fn scaled(&self, b: S) -> Self {
        let real = b.re();
        Self::filled(
            self.value * b,
            self.seen,
            |i| self.x[i] * b,
            |i| self.v[i] * b,
            |i, j| self.xx[i][j] * real,
            |i, j| self.vx[i][j] * b,
            |i, j| self.vv[i][j] * b,
        )
    }
}

impl<S: Scalar, const X: usize, const V: usize, const HX: usize, const HV: usize> Scalar
    for Phase<S, X, V, HX, HV>
{
    const ORDER: usize = {
        let own = if HX + HV > 0 { 2 } else { 1 };
        assert!(S::ORDER + own <= MAX_ORDER, "jets nest to total order three");
        S::ORDER + own
    };

    #[inline]
    fn constant(value: f64) -> Self {
        Self::given(S::constant(value))
    }

    #[inline]
    fn re(&self) -> f64 {
        self.value.re()
    }

    #[inline]
    fn compose(self, f: [f64; MAX_ORDER + 1]) -> Self {
        const { assert!(Self::ORDER <= MAX_ORDER) };
        let f1 = derivative(f);
        let slope = self.value.compose(f1);
        // Without a Hessian f″ is not read; with one it is differentiated as often as S asks.
        let bend = if HX + HV > 0 {
            self.value.compose(derivative(f1))
        } else {
            S::zero()
        };
        let (slope_re, bend_re) = (slope.re(), bend.re());
        let (x, v) = (&self.x, &self.v);
        Self::filled(
            self.value.compose(f),
            self.seen,
            |i| slope * x[i],
            |i| slope * v[i],
            |i, j| slope_re * self.xx[i][j] + bend_re * x[i].re() * x[j].re(),
            |i, j| slope * self.vx[i][j] + bend * (v[i] * x[j]),
            |i, j| slope * self.vv[i][j] + bend * (v[i] * v[j]),
        )
    }
}

impl<S: Scalar, const X: usize, const V: usize, const HX: usize, const HV: usize> Mul
    for Phase<S, X, V, HX, HV>
{
    type Output = Self;
    #[inline]
    fn mul(self, b: Self) -> Self {
        if b.is_given() {
            return self.scaled(b.value);
        }
        if self.is_given() {
            return b.scaled(self.value);
        }
        let (p, q) = (self.value, b.value);
        let (p_re, q_re) = (p.re(), q.re());
        let seen = [self.seen[0] | b.seen[0], self.seen[1] | b.seen[1]];
        Self::filled(
            p * q,
            seen,
            |i| self.x[i] * q + p * b.x[i],
            |i| self.v[i] * q + p * b.v[i],
            |i, j| {
                (self.xx[i][j] * q_re + p_re * b.xx[i][j])
                    + (self.x[i].re() * b.x[j].re() + b.x[i].re() * self.x[j].re())
            },
            |i, j| {
                (self.vx[i][j] * q + p * b.vx[i][j]) + (self.v[i] * b.x[j] + b.v[i] * self.x[j])
            },
            |i, j| {
                (self.vv[i][j] * q + p * b.vv[i][j]) + (self.v[i] * b.v[j] + b.v[i] * self.v[j])
            },
        )
    }
}

impl<S: Scalar, const X: usize, const V: usize, const HX: usize, const HV: usize>
    Phase<S, X, V, HX, HV>
{
    /// Changes every entry on which `b` depends.
    #[inline(always)]
    fn changed(mut self, b: &Self, f: impl Fn(&mut S, S), real: impl Fn(&mut f64, f64)) -> Self {
        f(&mut self.value, b.value);
        each(X, b.seen[0], |i| f(&mut self.x[i], b.x[i]));
        each(V, b.seen[1], |i| f(&mut self.v[i], b.v[i]));
        lower(HX, b.seen[0], |i, j| real(&mut self.xx[i][j], b.xx[i][j]));
        each(HV, b.seen[1], |i| {
            each(HX, b.seen[0], |j| f(&mut self.vx[i][j], b.vx[i][j]));
        });
        lower(HV, b.seen[1], |i, j| f(&mut self.vv[i][j], b.vv[i][j]));
        self.seen = [self.seen[0] | b.seen[0], self.seen[1] | b.seen[1]];
        self
    }
}

impl<S: Scalar, const X: usize, const V: usize, const HX: usize, const HV: usize> Add
    for Phase<S, X, V, HX, HV>
{
    type Output = Self;
    #[inline]
    fn add(self, b: Self) -> Self {
        self.changed(&b, |x, y| *x += y, |x, y| *x += y)
    }
}

impl<S: Scalar, const X: usize, const V: usize, const HX: usize, const HV: usize> Sub
    for Phase<S, X, V, HX, HV>
{
    type Output = Self;
    #[inline]
    fn sub(self, b: Self) -> Self {
        self.changed(&b, |x, y| *x -= y, |x, y| *x -= y)
    }
}

impl<S: Scalar, const X: usize, const V: usize, const HX: usize, const HV: usize> Mul<f64>
    for Phase<S, X, V, HX, HV>
{
    type Output = Self;
    #[inline]
    fn mul(self, b: f64) -> Self {
        Self::filled(
            self.value * b,
            self.seen,
            |i| self.x[i] * b,
            |i| self.v[i] * b,
            |i, j| self.xx[i][j] * b,
            |i, j| self.vx[i][j] * b,
            |i, j| self.vv[i][j] * b,
        )
    }
}

impl<S: Scalar, const X: usize, const V: usize, const HX: usize, const HV: usize> Neg
    for Phase<S, X, V, HX, HV>
{
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<S: Scalar, const X: usize, const V: usize, const HX: usize, const HV: usize> Add<f64>
    for Phase<S, X, V, HX, HV>
{
    type Output = Self;
    #[inline]
    fn add(mut self, b: f64) -> Self {
        self.value = self.value + b;
        self
    }
}

derived_operators!(
    [S: Scalar, const X: usize, const V: usize, const HX: usize, const HV: usize]
    Phase<S, X, V, HX, HV>
);
quotient_by_reciprocal!(
    [S: Scalar, const X: usize, const V: usize, const HX: usize, const HV: usize]
    Phase<S, X, V, HX, HV>
);
