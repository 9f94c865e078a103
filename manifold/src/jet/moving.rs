//! Value, velocity and acceleration with their gradients: the kinematics of a map in one run.

use crate::scalar::{MAX_ORDER, Scalar};

/// A value x that moves: x, ẋ, ẍ along one motion, and the gradients of all three in `D` variables.
/// `Moving<0>` is x, ẋ, ẍ alone.
///
/// The chain, product and quotient rules are multiplied out, and two structures exploited:
///
/// - most values depend on a few variables only (the rotations of one frame): variables are taken
///   two by two, and pairs on which neither factor depends are left at zero;
/// - the gradient of a value that is affine in the variables is constant.
///
/// The layout matters for speed: with the marks between them, the compiler cannot join x and the
/// gradients to one run of numbers, whose stores would straddle the pairs that the next operation
/// loads.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(16))]
pub struct Moving<const D: usize> {
    /// x, ẋ, ẍ.
    pub x: [f64; 3],
    /// Bit b: depends on variable 2b or 2b + 1.
    pairs: u32,
    /// Whether it is not affine, so that `g[1]` and `g[2]` may differ from zero.
    nonlinear: bool,
    /// Gradients of x, ẋ, ẍ.
    pub g: [[f64; D]; 3],
}

impl<const D: usize> Moving<D> {
    /// The independent variable number `i` with its velocity and acceleration.
    #[inline]
    pub fn variable(x: [f64; 3], i: usize) -> Self {
        let mut out = Self::given(x);
        out.g[0][i] = 1.0;
        out.pairs = 1 << (i / 2);
        out
    }

    /// A given motion that depends on no variable, such as time: (t, 1, 0).
    #[inline]
    pub fn given(x: [f64; 3]) -> Self {
        Self {
            x,
            pairs: 0,
            nonlinear: false,
            g: [[0.0; D]; 3],
        }
    }
}

/// Gradients by a rule for one variable, evaluated for the marked pairs of them.
#[inline(always)]
fn gradients<const D: usize>(pairs: u32, rule: impl Fn(usize) -> [f64; 3]) -> [[f64; D]; 3] {
    let mut g = [[0.0; D]; 3];
    let mut put = |i: usize, x: [f64; 3]| {
        g[0][i] = x[0];
        g[1][i] = x[1];
        g[2][i] = x[2];
    };
    for b in 0..D / 2 {
        if pairs & (1 << b) != 0 {
            let i = 2 * b;
            let (x, y) = (rule(i), rule(i + 1));
            put(i, x);
            put(i + 1, y);
        }
    }
    if D % 2 == 1 && pairs & (1 << (D / 2)) != 0 {
        put(D - 1, rule(D - 1));
    }
    g
}

impl<const D: usize> Scalar for Moving<D> {
    const ORDER: usize = {
        assert!(D <= 64, "one bit marks two variables");
        3
    };

    #[inline]
    fn constant(value: f64) -> Self {
        const { assert!(Self::ORDER <= MAX_ORDER) };
        Self::given([value, 0.0, 0.0])
    }

    #[inline]
    fn re(&self) -> f64 {
        self.x[0]
    }

    #[inline]
    fn compose(self, f: [f64; MAX_ORDER + 1]) -> Self {
        // y = f(x): f′ moves as s = (f′, f″ẋ, f″ẍ + f‴ẋ²).
        let [_, x1, x2] = self.x;
        let s = [f[1], f[2] * x1, f[2] * x2 + f[3] * x1 * x1];
        let twice = 2.0 * s[1];
        let [g0, g1, g2] = &self.g;
        Self {
            x: [f[0], s[0] * x1, s[0] * x2 + s[1] * x1],
            pairs: self.pairs,
            nonlinear: true,
            g: gradients(self.pairs, |i| {
                [
                    s[0] * g0[i],
                    s[0] * g1[i] + s[1] * g0[i],
                    s[0] * g2[i] + twice * g1[i] + s[2] * g0[i],
                ]
            }),
        }
    }
}

impl<const D: usize> Moving<D> {
    /// Entry by entry combination; rows are whole, since a sum costs less than asking for pairs.
    #[inline(always)]
    fn combined(mut self, b: &Self, f: impl Fn(&mut f64, f64)) -> Self {
        for k in 0..3 {
            f(&mut self.x[k], b.x[k]);
            for i in 0..D {
                f(&mut self.g[k][i], b.g[k][i]);
            }
        }
        self.pairs |= b.pairs;
        self.nonlinear |= b.nonlinear;
        self
    }

    #[inline]
    fn plus(self, b: Self) -> Self {
        self.combined(&b, |x, y| *x += y)
    }

    #[inline]
    fn minus(self, b: Self) -> Self {
        self.combined(&b, |x, y| *x -= y)
    }

    #[inline]
    fn times(self, b: Self) -> Self {
        let ([a0, a1, a2], [b0, b1, b2]) = (self.x, b.x);
        let (twice_a1, twice_b1) = (2.0 * a1, 2.0 * b1);
        let ([p0, p1, p2], [q0, q1, q2]) = (&self.g, &b.g);
        let pairs = self.pairs | b.pairs;
        let g = if self.nonlinear || b.nonlinear {
            gradients(pairs, |i| {
                [
                    p0[i] * b0 + a0 * q0[i],
                    (p1[i] * b0 + p0[i] * b1) + (a0 * q1[i] + a1 * q0[i]),
                    (p2[i] * b0 + p1[i] * twice_b1 + p0[i] * b2)
                        + (a0 * q2[i] + twice_a1 * q1[i] + a2 * q0[i]),
                ]
            })
        } else {
            gradients(pairs, |i| {
                [
                    p0[i] * b0 + a0 * q0[i],
                    p0[i] * b1 + a1 * q0[i],
                    p0[i] * b2 + a2 * q0[i],
                ]
            })
        };
        Self {
            x: [
                a0 * b0,
                a0 * b1 + a1 * b0,
                a0 * b2 + twice_a1 * b1 + a2 * b0,
            ],
            pairs,
            nonlinear: true,
            g,
        }
    }

    #[inline]
    fn quotient(self, b: Self) -> Self {
        // c = a/b from the product rule of c b = a, order by order.
        let ([a0, a1, a2], [b0, b1, b2]) = (self.x, b.x);
        let (r, twice_b1) = (1.0 / b0, 2.0 * b1);
        let c0 = a0 * r;
        let c1 = (a1 - c0 * b1) * r;
        let c2 = (a2 - c1 * twice_b1 - c0 * b2) * r;
        let twice_c1 = 2.0 * c1;
        let ([p0, p1, p2], [q0, q1, q2]) = (&self.g, &b.g);
        let pairs = self.pairs | b.pairs;
        Self {
            x: [c0, c1, c2],
            pairs,
            nonlinear: true,
            g: gradients(pairs, |i| {
                let d0 = (p0[i] - c0 * q0[i]) * r;
                let d1 = ((p1[i] - c0 * q1[i] - c1 * q0[i]) - d0 * b1) * r;
                let own = p2[i] - c0 * q2[i] - twice_c1 * q1[i] - c2 * q0[i];
                [d0, d1, (own - d0 * b2 - d1 * twice_b1) * r]
            }),
        }
    }

    #[inline]
    fn scaled(mut self, b: f64) -> Self {
        for k in 0..3 {
            self.x[k] *= b;
            for i in 0..D {
                self.g[k][i] *= b;
            }
        }
        self
    }

    #[inline]
    fn shifted(mut self, b: f64) -> Self {
        self.x[0] += b;
        self
    }
}

operators!([const D: usize] Moving<D>, |a: Self, b| a.quotient(b));
