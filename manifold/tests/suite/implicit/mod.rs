//! Maps defined by equations.

mod charts;
mod flat;
mod linear;
mod map;
mod rank;
mod steep;

use crate::support::*;

/// A solved constraint with factors at Ḃ and K_σ.
#[derive(Clone)]
struct Planted {
    map: ImplicitMap,
    B_dot: f64,
    K: f64,
}

impl Parametrization for Planted {
    fn dims(&self) -> (usize, usize) {
        self.map.dims()
    }

    fn domain(&mut self, t: f64, q: &[f64]) -> Result<f64, DomainError> {
        self.map.domain(t, q)
    }

    fn state(&mut self) -> Option<&mut dyn MapState> {
        Some(&mut self.map)
    }

    fn evaluate(&mut self, t: f64, motion: [&[f64]; 3], out: &mut [Order<'_>]) {
        self.map.evaluate(t, motion, out);
        if let [_, [_, B_dot], _] = out {
            B_dot.iter_mut().for_each(|b| *b *= self.B_dot);
        }
    }

    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        self.map.geometric_stiffness(t, q, f, K);
        K.iter_mut().for_each(|k| *k *= self.K);
    }
}
