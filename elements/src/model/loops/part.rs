//! The coordinates of a joint among the unknowns of its loop.

use pullback_manifold::map::{Order, Parametrization};

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

    fn evaluate(&mut self, _t: f64, motion: [&[f64]; 3], out: &mut [Order<'_>]) {
        for (k, [x, B]) in out.iter_mut().enumerate() {
            x.copy_from_slice(&motion[k][self.first..self.first + self.len]);
            B.fill(0.0);
            if k == 0 {
                let own = &mut B[self.first * self.len..];
                let diagonal = own.iter_mut().step_by(self.len + 1);
                diagonal.take(self.len).for_each(|b| *b = 1.0);
            }
        }
    }

    fn geometric_stiffness(&mut self, _t: f64, _q: &[f64], _f: &[f64], K: &mut [f64]) {
        K.fill(0.0);
    }
}
