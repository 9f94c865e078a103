//! The coordinates of a joint among the unknowns of its loop.

#![allow(non_snake_case)]

use pullback_manifold::map::{KinematicsMut, Parametrization};

/// Some consecutive unknowns of a loop, as the coordinates of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Part {
    /// Number of all unknowns, index of the first one, and their number.
    pub of: usize,
    pub first: usize,
    pub len: usize,
}

impl Parametrization for Part {
    fn kind(&self) -> &'static str {
        "in a loop"
    }

    fn dims(&self) -> (usize, usize) {
        (self.of, self.len)
    }

    fn tangent(&mut self, _t: f64, q: &[f64], x: &mut [f64], B: &mut [f64]) {
        x.copy_from_slice(&q[self.first..self.first + self.len]);
        B.fill(0.0);
        for i in 0..self.len {
            B[i + (self.first + i) * self.len] = 1.0;
        }
    }

    fn kinematics(&mut self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: KinematicsMut<'_>) {
        self.tangent(t, q, out.x, out.B);
        out.x_dot
            .copy_from_slice(&v[self.first..self.first + self.len]);
        out.x_ddot
            .copy_from_slice(&a[self.first..self.first + self.len]);
        out.B_dot.fill(0.0);
        out.B_ddot.fill(0.0);
    }

    fn geometric_stiffness(&mut self, _t: f64, _q: &[f64], _f: &[f64], K: &mut [f64]) {
        K.fill(0.0);
    }
}
