//! Value, gradient and Hessian of an energy in coordinates and velocities.

use super::{derivative, nested_order};
use crate::scalar::{MAX_ORDER, Scalar};

/// A value with its derivatives in `X` coordinates x and `V` velocities v, over the numbers `S`.
///
/// Derivatives of an energy for its force and tangents:
///
/// - a potential energy has no velocities: V = 0, S = `f64`;
/// - a dissipation has both, S = `f64`;
/// - a kinetic energy moves along its own motion, S = [`Grad<f64, 1>`](super::Grad) with the
///   velocity of x and of v as derivatives. The Hessian in x alone needs no derivative along the
///   motion, as no equation of motion contains it: `xx` are plain numbers.
///
/// `HX` and `HV` are `X` and `V` for the Hessian, or both 0 to omit it. The gradient is the same to
/// the last bit with and without it.
///
/// Most values depend on a few variables only (the rotation of one frame), so variables are grouped
/// in twos or threes, and groups on which a value does not depend are left at zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase<S, const X: usize, const V: usize, const HX: usize, const HV: usize> {
    /// Value.
    pub value: S,
    /// Which groups of x and of v the value depends on, one bit each.
    depends: [u32; 2],
    /// Whether it is not affine, so that `xx`, `vx`, `vv` may differ from zero.
    nonlinear: bool,
    /// Gradient in x.
    pub x: [S; X],
    /// Gradient in v.
    pub v: [S; V],
    /// Hessian in x; entries `xx[i][j]` of groups with j above i are not kept up to date.
    pub xx: [[f64; HX]; HX],
    /// Mixed Hessian ∂²/∂vᵢ∂xⱼ.
    pub vx: [[S; HX]; HV],
    /// Hessian in v; entries as in `xx`.
    pub vv: [[S; HV]; HV],
}

/// Number of variables, of n, that one bit stands for: vectors of space have three.
const fn group(n: usize) -> usize {
    if n.is_multiple_of(3) { 3 } else { 2 }
}

/// Number of groups of n variables, the last of which may be smaller.
const fn groups(n: usize) -> usize {
    n.div_ceil(group(n))
}

/// Whether a group is marked.
#[inline(always)]
fn has(marks: u32, group: usize) -> bool {
    marks & (1 << group) != 0
}

/// Runs over the variables of a group.
#[inline(always)]
fn members<const N: usize>(k: usize, mut f: impl FnMut(usize)) {
    let (size, i) = (group(N), group(N) * k);
    if i + size <= N {
        f(i);
        f(i + 1);
        if size == 3 {
            f(i + 2);
        }
    } else {
        (i..N).for_each(f);
    }
}

/// Runs over the marked variables.
#[inline(always)]
fn each<const N: usize>(marks: u32, mut f: impl FnMut(usize)) {
    for a in 0..groups(N) {
        if has(marks, a) {
            members::<N>(a, &mut f);
        }
    }
}

/// Runs over all pairs of variables of two groups.
#[inline(always)]
fn block<const N: usize, const M: usize>(a: usize, b: usize, mut f: impl FnMut(usize, usize)) {
    members::<N>(a, |i| members::<M>(b, |j| f(i, j)));
}

/// Runs over the marked pairs (i, j).
#[inline(always)]
fn pairs<const N: usize, const M: usize>(marks: [u32; 2], mut f: impl FnMut(usize, usize)) {
    for a in 0..groups(N) {
        for b in 0..groups(M) {
            if has(marks[0], a) && has(marks[1], b) {
                block::<N, M>(a, b, &mut f);
            }
        }
    }
}

/// Runs over the marked pairs (i, j) with the group of j not above that of i.
#[inline(always)]
fn lower<const N: usize>(marks: u32, f: impl FnMut(usize, usize)) {
    lower_across::<N>(marks, marks, f);
}

/// Runs over the pairs as [`lower`], i in the first marks and j in the second.
#[inline(always)]
fn lower_across<const N: usize>(rows: u32, columns: u32, mut f: impl FnMut(usize, usize)) {
    for a in 0..groups(N) {
        if has(rows, a) {
            for b in 0..=a {
                if has(columns, b) {
                    block::<N, N>(a, b, &mut f);
                }
            }
        }
    }
}

impl<S: Scalar, const X: usize, const V: usize, const HX: usize, const HV: usize>
    Phase<S, X, V, HX, HV>
{
    /// A value that depends on no variable.
    #[inline]
    pub fn given(value: S) -> Self {
        const {
            assert!(
                HX == X && HV == V || HX == 0 && HV == 0,
                "all of the Hessian or none"
            );
            assert!(groups(X) <= 32 && groups(V) <= 32, "one bit marks a group");
        }
        Self {
            value,
            depends: [0; 2],
            nonlinear: false,
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
        out.depends[0] = 1 << (i / group(X));
        out
    }

    /// Velocity number `i`.
    #[inline]
    pub fn velocity(value: S, i: usize) -> Self {
        let mut out = Self::given(value);
        out.v[i] = S::one();
        out.depends[1] = 1 << (i / group(V));
        out
    }

    /// Whether the value depends on no variable.
    #[inline]
    fn is_given(&self) -> bool {
        self.depends == [0; 2]
    }

    /// Adds the second derivatives of another value times a factor.
    #[inline(always)]
    fn add_second_derivatives(&mut self, b: &Self, factor: S) {
        if !b.nonlinear {
            return;
        }
        let real = factor.re();
        let [x, v] = b.depends;
        lower::<HX>(x, |i, j| self.xx[i][j] += b.xx[i][j] * real);
        pairs::<HV, HX>([v, x], |i, j| self.vx[i][j] += b.vx[i][j] * factor);
        lower::<HV>(v, |i, j| self.vv[i][j] += b.vv[i][j] * factor);
    }

    /// All entries times a number without variables.
    #[inline(always)]
    fn times_given(&self, b: S) -> Self {
        let mut out = Self::given(self.value * b);
        (out.depends, out.nonlinear) = (self.depends, self.nonlinear);
        each::<X>(self.depends[0], |i| out.x[i] = self.x[i] * b);
        each::<V>(self.depends[1], |i| out.v[i] = self.v[i] * b);
        out.add_second_derivatives(self, b);
        out
    }
}

impl<S: Scalar, const X: usize, const V: usize, const HX: usize, const HV: usize> Scalar
    for Phase<S, X, V, HX, HV>
{
    const ORDER: usize = nested_order(S::ORDER, if HX + HV > 0 { 2 } else { 1 });

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
        // Without a Hessian f″ is not read; with one it has all derivatives that S carries.
        let bend = if HX + HV > 0 {
            self.value.compose(derivative(f1))
        } else {
            S::zero()
        };
        let (x, v) = (&self.x, &self.v);
        let [x_depends, v_depends] = self.depends;
        let mut out = Self::given(self.value.compose(f));
        (out.depends, out.nonlinear) = (self.depends, true);
        each::<X>(x_depends, |i| out.x[i] = slope * x[i]);
        each::<V>(v_depends, |i| out.v[i] = slope * v[i]);
        let bend_re = bend.re();
        lower::<HX>(x_depends, |i, j| {
            out.xx[i][j] = bend_re * x[i].re() * x[j].re();
        });
        pairs::<HV, HX>([v_depends, x_depends], |i, j| {
            out.vx[i][j] = bend * (v[i] * x[j]);
        });
        lower::<HV>(v_depends, |i, j| out.vv[i][j] = bend * (v[i] * v[j]));
        out.add_second_derivatives(&self, slope);
        out
    }
}

impl<S: Scalar, const X: usize, const V: usize, const HX: usize, const HV: usize>
    Phase<S, X, V, HX, HV>
{
    /// Changes every entry on which `b` depends.
    #[inline(always)]
    fn changed(mut self, b: &Self, f: impl Fn(&mut S, S), real: impl Fn(&mut f64, f64)) -> Self {
        f(&mut self.value, b.value);
        let [x, v] = b.depends;
        each::<X>(x, |i| f(&mut self.x[i], b.x[i]));
        each::<V>(v, |i| f(&mut self.v[i], b.v[i]));
        if b.nonlinear {
            lower::<HX>(x, |i, j| real(&mut self.xx[i][j], b.xx[i][j]));
            pairs::<HV, HX>([v, x], |i, j| f(&mut self.vx[i][j], b.vx[i][j]));
            lower::<HV>(v, |i, j| f(&mut self.vv[i][j], b.vv[i][j]));
            self.nonlinear = true;
        }
        self.depends = [
            self.depends[0] | b.depends[0],
            self.depends[1] | b.depends[1],
        ];
        self
    }

    #[inline]
    fn plus(self, b: Self) -> Self {
        self.changed(&b, |x, y| *x += y, |x, y| *x += y)
    }

    #[inline]
    fn minus(self, b: Self) -> Self {
        self.changed(&b, |x, y| *x -= y, |x, y| *x -= y)
    }

    #[inline]
    fn times(self, b: Self) -> Self {
        if b.is_given() {
            return self.times_given(b.value);
        }
        if self.is_given() {
            return b.times_given(self.value);
        }
        let (p, q) = (self.value, b.value);
        let ([ax, av], [bx, bv]) = (self.depends, b.depends);
        let mut out = Self::given(p * q);
        (out.depends, out.nonlinear) = ([ax | bx, av | bv], true);
        each::<X>(ax | bx, |i| out.x[i] = self.x[i] * q + p * b.x[i]);
        each::<V>(av | bv, |i| out.v[i] = self.v[i] * q + p * b.v[i]);
        // The gradient of each with the other.
        for (f, g) in [(&self, &b), (&b, &self)] {
            let ([fx, fv], [gx, gv]) = (f.depends, g.depends);
            lower_across::<HX>(fx, gx, |i, j| {
                out.xx[i][j] += f.x[i].re() * g.x[j].re();
            });
            pairs::<HV, HX>([fv, gx], |i, j| out.vx[i][j] += f.v[i] * g.x[j]);
            lower_across::<HV>(fv, gv, |i, j| out.vv[i][j] += f.v[i] * g.v[j]);
        }
        out.add_second_derivatives(&self, q);
        out.add_second_derivatives(&b, p);
        out
    }

    #[inline]
    fn scaled(self, b: f64) -> Self {
        self.times_given(S::constant(b))
    }

    #[inline]
    fn shifted(mut self, b: f64) -> Self {
        self.value = self.value + b;
        self
    }
}

operators!([S: Scalar, const X: usize, const V: usize, const HX: usize, const HV: usize] Phase<S, X, V, HX, HV>);
