//! The element of energies at points, in variables interpolated from the nodes.

use super::EnergyElement;
use super::local::{self, Local};
use crate::element::{
    Abilities, Combined, CombinedTangents, Element, ElementEnergies, Motion, Properties, Response,
};
use nalgebra::{SMatrix, SVector};
use pullback_manifold::domain::DomainError;

/// An element by its energies, the weighted sum of those at some points: of all its coordinates at once
/// ([`EnergyElement::into_element`]), or at the integration points of a finite element.
///
/// ```text
/// E(x) = Σ w e(y),  y = y₀ + A x        r = Σ w Aᵀ r_y,   K, C, M = Σ w Aᵀ (K, C, M)_y A
/// ```
pub struct ByEnergy<const N: usize> {
    points: Vec<EnergySample<N>>,
}

/// Energies at one point of an element with N coordinates, in their own variables.
///
/// Jets run over the variables of a point: strains at a point depend on fewer variables than all nodes
/// have, and the cost of jets is quadratic in them.
pub struct EnergySample<const N: usize>(Box<dyn Sample<N>>);

impl<const N: usize> EnergySample<N> {
    /// A point with the given weight in the sum: `energies` in D variables y = y₀ + A x with rates ẏ = A ẋ, A
    /// is D×N.
    pub fn new<E: EnergyElement<D> + 'static, const D: usize>(
        energies: E,
        weight: f64,
        y0: SVector<f64, D>,
        A: &SMatrix<f64, D, N>,
    ) -> Self {
        let all = (0..D).flat_map(|i| (0..N).map(move |j| (i, j)));
        Self(Box::new(Interpolated {
            energies,
            weight,
            y0,
            entries: all
                .map(|(i, j)| (i, j, A[(i, j)]))
                .filter(|e| e.2 != 0.0)
                .collect(),
        }))
    }
}

/// Energies in D variables y = y₀ + A x.
struct Interpolated<E, const D: usize, const N: usize> {
    energies: E,
    weight: f64,
    y0: SVector<f64, D>,
    /// The nonzero entries of A: row, column, value.
    entries: Vec<(usize, usize, f64)>,
}

/// The same with any number of variables.
trait Sample<const N: usize>: Combined + ElementEnergies + Send + Sync {
    fn properties(&self) -> Properties;

    /// Adds ∂r/∂t.
    fn add_load_rate(&self, at: &Motion<'_>, r_t: &mut [f64]);
}

impl<E, const D: usize, const N: usize> Interpolated<E, D, N> {
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

impl<E: EnergyElement<D>, const D: usize, const N: usize> Sample<N> for Interpolated<E, D, N> {
    fn properties(&self) -> Properties {
        self.energies.properties()
    }

    fn add_load_rate(&self, at: &Motion<'_>, r_t: &mut [f64]) {
        let rate = local::load_rate(&self.energies, at.t, &self.position(at.x));
        self.spread(&rate, r_t);
    }
}

impl<E: EnergyElement<D>, const D: usize, const N: usize> Combined for Interpolated<E, D, N> {
    fn add(
        &self,
        at: &Motion<'_>,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    ) -> Result<(), DomainError> {
        let y = self.position(at.x);
        self.energies.domain(&y)?;
        let rates = || (self.interpolated(at.v), self.interpolated(at.a));
        let moving = (!at.v.is_empty()).then(rates);
        let wanted = tangents.iter().any(Option::is_some);
        let local = Local::new(&self.energies, at.t, &y, moving.as_ref(), wanted);
        self.spread(&local.r, r);
        for (weights, out) in tangents.iter_mut().flatten() {
            self.spread_tangent(&local.tangent(*weights), out);
        }
        Ok(())
    }
}

impl<E: EnergyElement<D>, const D: usize, const N: usize> ElementEnergies
    for Interpolated<E, D, N>
{
    fn energy(&self, at: &Motion<'_>) -> f64 {
        self.weight * self.energies.potential(at.t, &self.position(at.x))
    }

    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        if at.v.is_empty() || !E::DISSIPATION {
            return 0.0;
        }
        let (y, y_dot) = (self.position(at.x), self.interpolated(at.v));
        self.weight * local::power(&self.energies, &y, &y_dot)
    }
}

impl<const N: usize> ByEnergy<N> {
    /// The sum over the given points.
    pub fn new(points: impl IntoIterator<Item = EnergySample<N>>) -> Self {
        let points = points.into_iter().collect();
        Self { points }
    }

    fn points(&self) -> impl Iterator<Item = &dyn Sample<N>> {
        self.points.iter().map(|p| &*p.0)
    }
}

impl<const N: usize> Element for ByEnergy<N> {
    fn dim(&self) -> usize {
        N
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let (r, mut tangents) = out.parts();
        self.add(at, r, &mut tangents)?;
        if let Some(r_t) = out.r_t.as_deref_mut() {
            self.points().for_each(|p| p.add_load_rate(at, r_t));
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
        let points = self.points().map(Sample::properties);
        points
            .reduce(Properties::sum)
            .unwrap_or(Properties::INTERNAL)
    }
}

impl<const N: usize> ElementEnergies for ByEnergy<N> {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        self.points().map(|p| p.energy(at)).sum()
    }

    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        self.points().map(|p| p.dissipation(at)).sum()
    }
}

impl<const N: usize> Combined for ByEnergy<N> {
    fn add(
        &self,
        at: &Motion<'_>,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    ) -> Result<(), DomainError> {
        self.points().try_for_each(|p| p.add(at, r, tangents))
    }
}
