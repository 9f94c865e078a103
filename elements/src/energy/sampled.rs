//! Energies at integration points, in variables interpolated from the nodes.

#![allow(non_snake_case)]

use super::EnergyElement;
use super::local::{self, Local};
use crate::element::{
    Abilities, Combined, CombinedTangents, Element, ElementEnergies, Motion, Properties, Response,
};
use nalgebra::{SMatrix, SVector};
use pullback_manifold::domain::DomainError;

/// One integration point: energies in D variables y = y₀ + A x of an element of N coordinates x,
/// with rates ẏ = A ẋ.
#[derive(Clone, Debug)]
pub struct EnergySample<E, const D: usize, const N: usize> {
    energies: E,
    weight: f64,
    y0: SVector<f64, D>,
    /// The nonzero entries of A: row, column, value.
    entries: Vec<(usize, usize, f64)>,
}

impl<E, const D: usize, const N: usize> EnergySample<E, D, N> {
    /// A point with the given weight in the sum: `energies` in y = y₀ + A x, A is D×N.
    pub fn new(energies: E, weight: f64, y0: SVector<f64, D>, A: &SMatrix<f64, D, N>) -> Self {
        let all = (0..D).flat_map(|i| (0..N).map(move |j| (i, j)));
        Self {
            energies,
            weight,
            y0,
            entries: all
                .map(|(i, j)| (i, j, A[(i, j)]))
                .filter(|e| e.2 != 0.0)
                .collect(),
        }
    }

    /// A x.
    #[inline]
    fn interpolated(&self, x: &[f64]) -> SVector<f64, D> {
        let mut y = SVector::zeros();
        if x.len() >= N {
            for &(i, j, a) in &self.entries {
                y[i] += a * x[j];
            }
        }
        y
    }

    fn position(&self, x: &[f64]) -> SVector<f64, D> {
        self.y0 + self.interpolated(x)
    }

    /// Adds weight · Aᵀ f.
    #[inline]
    fn spread(&self, f: &SVector<f64, D>, r: &mut [f64]) {
        for &(i, j, a) in &self.entries {
            r[j] += self.weight * a * f[i];
        }
    }

    /// Adds weight · Aᵀ H A.
    #[inline]
    fn spread_tangent(&self, H: &SMatrix<f64, D, D>, out: &mut [f64]) {
        let mut HA = SMatrix::<f64, D, N>::zeros();
        for &(i, j, a) in &self.entries {
            let a = self.weight * a;
            for k in 0..D {
                HA[(k, j)] += a * H[(k, i)];
            }
        }
        for (HA, out) in HA.as_slice().chunks_exact(D).zip(out.chunks_exact_mut(N)) {
            for &(i, j, a) in &self.entries {
                out[j] += a * HA[i];
            }
        }
    }
}

/// An element that is the weighted sum of energies at its integration points.
///
/// ```text
/// E(x) = Σ w e(y),  y = y₀ + A x        r = Σ w Aᵀ r_y,   K, C, M = Σ w Aᵀ (K, C, M)_y A
/// ```
///
/// The jets run over the D variables of a point: strains at a point depend on fewer variables than
/// all nodes have, and the cost of jets is quadratic in them.
#[derive(Clone, Debug)]
pub struct Sampled<E, const D: usize, const N: usize> {
    points: Vec<EnergySample<E, D, N>>,
}

impl<E: EnergyElement<D>, const D: usize, const N: usize> Sampled<E, D, N> {
    /// The sum over the given points.
    pub fn new(points: impl IntoIterator<Item = EnergySample<E, D, N>>) -> Self {
        Self {
            points: points.into_iter().collect(),
        }
    }
}

impl<E: EnergyElement<D>, const D: usize, const N: usize> Element for Sampled<E, D, N> {
    fn dim(&self) -> usize {
        N
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let (r, mut tangents) = out.parts();
        self.add(at, r, &mut tangents)?;
        if let Some(r_t) = out.r_t.as_deref_mut() {
            for p in &self.points {
                p.spread(&local::load_rate(&p.energies, at.t, &p.position(at.x)), r_t);
            }
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            combined: Some(self),
            energies: Some(self),
            enforced: None,
            sections: None,
        }
    }

    fn properties(&self) -> Properties {
        let points = self.points.iter().map(|p| p.energies.properties());
        points
            .reduce(Properties::sum)
            .unwrap_or(Properties::INTERNAL)
    }
}

impl<E: EnergyElement<D>, const D: usize, const N: usize> ElementEnergies for Sampled<E, D, N> {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        let of =
            |p: &EnergySample<E, D, N>| p.weight * p.energies.potential(at.t, &p.position(at.x));
        self.points.iter().map(of).sum()
    }

    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        if at.v.is_empty() || !E::DISSIPATION {
            return 0.0;
        }
        let of = |p: &EnergySample<E, D, N>| {
            p.weight * local::power(&p.energies, &p.position(at.x), &p.interpolated(at.v))
        };
        self.points.iter().map(of).sum()
    }
}

impl<E: EnergyElement<D>, const D: usize, const N: usize> Combined for Sampled<E, D, N> {
    fn add(
        &self,
        at: &Motion<'_>,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    ) -> Result<(), DomainError> {
        let wanted = tangents.iter().any(Option::is_some);
        for p in &self.points {
            let y = p.position(at.x);
            p.energies.domain(&y)?;
            let moving = (!at.v.is_empty()).then(|| (p.interpolated(at.v), p.interpolated(at.a)));
            let local = Local::new(&p.energies, at.t, &y, moving.as_ref(), wanted);
            p.spread(&local.r, r);
            for (weights, out) in tangents.iter_mut().flatten() {
                p.spread_tangent(&local.tangent(*weights), out);
            }
        }
        Ok(())
    }
}
