//! Double-double arithmetic and Taylor series: the high-precision oracle of the quotients.

use std::ops::{Add, Div, Mul, Neg};

/// Unevaluated sum of two doubles, about 31 digits.
#[derive(Clone, Copy)]
pub struct Dd(pub f64, pub f64);

fn two_sum(a: f64, b: f64) -> Dd {
    let s = a + b;
    let t = s - a;
    Dd(s, (a - (s - t)) + (b - t))
}

impl Add for Dd {
    type Output = Dd;
    fn add(self, b: Dd) -> Dd {
        let Dd(s, e) = two_sum(self.0, b.0);
        let Dd(t, f) = two_sum(self.1, b.1);
        let Dd(s, e) = two_sum(s, e + t);
        two_sum(s, e + f)
    }
}
impl Neg for Dd {
    type Output = Dd;
    fn neg(self) -> Dd {
        Dd(-self.0, -self.1)
    }
}
impl Mul for Dd {
    type Output = Dd;
    fn mul(self, b: Dd) -> Dd {
        let p = self.0 * b.0;
        let e = self.0.mul_add(b.0, -p);
        two_sum(p, e + (self.0 * b.1 + self.1 * b.0))
    }
}
impl Div for Dd {
    type Output = Dd;
    fn div(self, b: Dd) -> Dd {
        let q = Dd(self.0 / b.0, 0.0);
        let r = self + -(q * b);
        let q = q + Dd(r.0 / b.0, 0.0);
        let r = self + -(q * b);
        q + Dd(r.0 / b.0, 0.0)
    }
}

/// (−1)^n D^n Σ (−z)^j/(2j+m)! by its Taylor series, D = 2 d/dz.
pub fn series(n: usize, m: usize, z: Dd) -> Dd {
    let mut sum = Dd(0.0, 0.0);
    // The leading term: 2·4·…·2n/(m+2n)!.
    let mut term = Dd(1.0, 0.0);
    for i in 1..=n {
        term = term * Dd((2 * i) as f64, 0.0);
    }
    for i in 1..=m + 2 * n {
        term = term / Dd(i as f64, 0.0);
    }
    for j in 0..60 {
        sum = sum + term;
        let top = 2 * j + m + 2 * n;
        let ratio = Dd((2 * (j + n) + 2) as f64, 0.0)
            / Dd(((2 * j + 2) * (top + 1) * (top + 2)) as f64, 0.0);
        term = -(term * ratio * z);
    }
    sum
}
