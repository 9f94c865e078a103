//! The beam element with two, three or four nodes, by the same code.

use super::interpolation::{Rotations, Total};
use super::mass::MassPoint;
use super::orientation::oriented;
use super::point::{GaussPoint, mirror};
use super::section::{Damping, Section};
use super::shape::{gauss, lagrange};
use super::strain::{Gradients, Law, Strained, extrapolated, strain_energy};
use super::viscous::Viscous;
use crate::blocks::three;
use crate::element::{
    Abilities, Combined, CombinedTangents, CrossSections, Element, ElementEnergies, Motion,
    Response, SectionState,
};
use nalgebra::{Matrix3, Vector3};
use pullback_manifold::domain::{CHART_EDGE, DomainError, LARGEST_ANGLE};
use pullback_manifold::so3;

/// Error of a beam element.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum BeamError {
    #[error("its length is zero: nodes at {at:?} coincide")]
    ZeroLength { at: [f64; 3] },
    #[error("a beam element has two, three or four nodes, not {0}")]
    Nodes(usize),
    #[error(
        "the section's orientation is not usable: it must be a rotation whose E1 is within 60 \
         degrees of the tangent {tangent:?}, got E1 = {first:?}"
    )]
    Orientation { tangent: [f64; 3], first: [f64; 3] },
}

/// Reissner's beam with NN nodes: d and Ψ are interpolated with the same shape functions, NN − 1
/// Gauss points for the internal force and its tangent (no shear or membrane locking).
///
/// Coordinates are (d₁, Ψ₁, …) in global components; I is the interpolation of rotations, [`Total`]
/// or [`Geodesic`](super::Geodesic).
#[derive(Clone, Debug)]
pub struct Beam<const NN: usize, I = Total<NN>> {
    /// The first integration point, the only one of two nodes, stored inline to avoid cache misses.
    first: GaussPoint<NN>,
    others: Vec<GaussPoint<NN>>,
    pub(super) rotations: I,
    damping: Damping,
}

impl<const NN: usize, I: Rotations<NN>> Beam<NN, I> {
    /// See [`Interpolation::beam`](super::Interpolation::beam).
    ///
    /// # Errors
    /// [`BeamError`] for coinciding nodes and an invalid orientation.
    pub fn new(
        positions: &[Vector3<f64>; NN],
        frame: &dyn Fn(f64) -> Matrix3<f64>,
        section: &Section,
    ) -> Result<Self, BeamError> {
        let size = positions.iter().fold(0.0_f64, |s, p| s.max(p.amax()));
        // The length at an integration point does not show whether nodes coincide.
        for (i, a) in positions.iter().enumerate() {
            let gap = |b: &Vector3<f64>| (a - b).norm();
            if let Some(b) = positions[..i].iter().find(|b| gap(b) <= 1e-12 * size) {
                return Err(BeamError::ZeroLength { at: (*b).into() });
            }
        }
        let point = |(xi, weight): (f64, f64)| {
            let (N, dN) = lagrange::<NN>(xi);
            let sum = |c: &[f64; NN]| -> Vector3<f64> {
                positions.iter().zip(c).map(|(p, c)| p * *c).sum()
            };
            let (X, slope) = (sum(&N), sum(&dN));
            let jacobian = slope.norm();
            if jacobian.is_nan() || jacobian <= 1e-12 * size || jacobian == 0.0 {
                return Err(BeamError::ZeroLength { at: X.into() });
            }
            let X_prime = slope / jacobian;
            let given = frame(xi);
            let R0 = oriented(&given, &X_prime)?;
            Ok(GaussPoint {
                N,
                dN: dN.map(|d| d / jacobian),
                weight: weight * jacobian,
                X,
                X_prime,
                R0,
                law: Law::rotated(&section.C, &R0),
            })
        };
        let mut rule = gauss(NN - 1).into_iter().map(point);
        let Some(first) = rule.next() else {
            return Err(BeamError::Nodes(NN));
        };
        let (first, others) = (first?, rule.collect::<Result<_, _>>()?);
        let masses = if section.inertia.is_zero() {
            None
        } else {
            let mass = |at: (f64, f64)| {
                point(at).map(|p| MassPoint {
                    N: p.N,
                    weight: p.weight,
                    inertia: section.inertia.rotated(&p.R0),
                })
            };
            let masses: Vec<_> = gauss(NN).into_iter().map(mass).collect::<Result<_, _>>()?;
            masses.try_into().ok()
        };
        Ok(Self {
            first,
            others,
            rotations: I::new(positions, masses),
            damping: section.damping,
        })
    }

    /// The integration points of internal forces.
    #[inline]
    fn points(&self) -> impl Iterator<Item = &GaussPoint<NN>> {
        std::iter::once(&self.first).chain(&self.others)
    }

    /// x′, Ψ, Ψ′ at an integration point.
    #[inline]
    fn line(p: &GaussPoint<NN>, x: &[f64]) -> Gradients {
        Self::gradients(p, p.X_prime, x)
    }

    /// x′ of displacements from a line with `x_prime`, Ψ and Ψ′ at an integration point; their rates from velocities and zero.
    #[inline]
    fn gradients(p: &GaussPoint<NN>, x_prime: Vector3<f64>, x: &[f64]) -> Gradients {
        let mut out = Gradients {
            x_prime,
            psi: Vector3::zeros(),
            psi_prime: Vector3::zeros(),
        };
        for (i, x) in x.chunks_exact(6).take(NN).enumerate() {
            let (d, psi) = (three(x, 0), three(x, 3));
            out.x_prime += d * p.dN[i];
            out.psi += psi * p.N[i];
            out.psi_prime += psi * p.dN[i];
        }
        out
    }

    /// The strains and stresses at an integration point in the interpolated coordinates, with those of damping if it
    /// moves.
    #[inline]
    fn strained(
        &self,
        p: &GaussPoint<NN>,
        line: &Gradients,
        v: &[f64],
    ) -> (Strained, Option<Viscous>) {
        let mut strained = Strained::new(line, &p.X_prime, &p.law);
        let beta = self.damping.stiffness;
        let viscous = (beta > 0.0 && !v.is_empty()).then(|| {
            let rates = Self::gradients(p, Vector3::zeros(), v);
            Viscous::new(&mut strained, line, &rates, &p.law, beta)
        });
        (strained, viscous)
    }

    /// Whether stresses depend on velocities.
    pub(super) fn is_viscous(&self, at: &Motion<'_>) -> bool {
        self.damping.stiffness > 0.0 && !at.v.is_empty()
    }

    /// Adds the forces and tangents of the strains in interpolated coordinates x̂, velocities only if stresses depend
    /// on them.
    ///
    /// Stresses of the tangent are extrapolated from x̂ₚ of the previous iterate to `predicted`, x̂ₚ + B(xₚ) (x − xₚ).
    /// Their residual is added to `r_sigma`, unless it is empty: that of K_σ of the interpolation.
    ///
    /// # Errors
    /// [`DomainError`] at the edge of the chart.
    #[inline]
    pub fn strain(
        &self,
        at: &Motion<'_>,
        predicted: &[f64],
        [r, r_sigma]: [&mut [f64]; 2],
        tangents: &mut CombinedTangents<'_>,
    ) -> Result<(), DomainError> {
        // Their tangents are added after the mirror, as they are not symmetric.
        let mut viscous: [Option<Viscous>; 3] = [None, None, None];
        for (p, viscous) in self.points().zip(&mut viscous) {
            let line = Self::line(p, at.x);
            let psi = line.psi.norm();
            DomainError::within(LARGEST_ANGLE - psi, CHART_EDGE)?;
            let mut strained;
            (strained, *viscous) = self.strained(p, &line, at.v);
            p.subtract(&strained.forces(), r);
            // Viscous stresses are not extrapolated.
            if let Some(x) = at.previous.filter(|_| viscous.is_none()) {
                let (from, to) = (Self::line(p, x), Self::line(p, predicted));
                (strained.N, strained.M) = extrapolated(&from, &to, &p.X_prime, &p.law);
            }
            if !r_sigma.is_empty() {
                p.subtract(&strained.forces(), r_sigma);
            }
            for (weights, K) in tangents.iter_mut().flatten() {
                if weights.K != 0.0 {
                    let D = strained.stiffness(&line, &p.law);
                    p.spread(&D, p.weight * weights.K, K);
                }
            }
        }
        for (_, K) in tangents.iter_mut().flatten().filter(|t| t.0.K != 0.0) {
            mirror::<NN>(K);
        }
        for (p, viscous) in self.points().zip(&viscous) {
            if let Some(viscous) = viscous {
                viscous.add_tangents(&p.N, &p.dN, p.weight, tangents);
            }
        }
        Ok(())
    }
}

impl<const NN: usize, I: Rotations<NN>> Element for Beam<NN, I> {
    fn dim(&self) -> usize {
        6 * NN
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let (r, mut tangents) = out.parts();
        self.add(at, r, &mut tangents)
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            combined: Some(self),
            energies: Some(self),
            sections: Some(self),
            ..Abilities::default()
        }
    }
}

impl<const NN: usize, I: Rotations<NN>> ElementEnergies for Beam<NN, I> {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        let seen = self.rotations.seen(at.x, &[]);
        let line = |p| Self::line(p, seen.x.as_flattened());
        self.points()
            .map(|p| p.weight * strain_energy(&line(p), &p.X_prime, &p.law))
            .sum()
    }

    fn kinetic_energy(&self, at: &Motion<'_>) -> Option<f64> {
        Some(match at.v.is_empty() {
            true => 0.0,
            false => self.rotations.kinetic_energy(at),
        })
    }

    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        if self.damping == Damping::default() || at.v.is_empty() {
            return 0.0;
        }
        let seen = self.rotations.seen(at.x, at.v);
        let viscous = |p: &GaussPoint<NN>| {
            let line = Self::line(p, seen.x.as_flattened());
            let (_, viscous) = self.strained(p, &line, seen.v.as_flattened());
            viscous.map_or(0.0, |viscous| p.weight * viscous.power())
        };
        // The power of the drag α M ẋ is 2 α times the kinetic energy.
        let drag = match self.damping.mass > 0.0 {
            true => 2.0 * self.damping.mass * self.rotations.kinetic_energy(at),
            false => 0.0,
        };
        self.points().map(viscous).sum::<f64>() + drag
    }
}

impl<const NN: usize, I: Rotations<NN>> CrossSections for Beam<NN, I> {
    fn section_states(&self, at: &Motion<'_>, out: &mut Vec<SectionState>) {
        let seen = self.rotations.seen(at.x, at.v);
        let v = match at.v.is_empty() {
            true => &[],
            false => seen.v.as_flattened(),
        };
        for p in self.points() {
            let line = Self::line(p, seen.x.as_flattened());
            let (s, _) = self.strained(p, &line, v);
            let nodes = at.x.chunks_exact(6).zip(&p.N);
            let d: Vector3<f64> = nodes.map(|(x, n)| three(x, 0) * *n).sum();
            let section = |v: &Vector3<f64>| p.R0.tr_mul(v);
            out.push(SectionState {
                reference: p.X,
                position: p.X + d,
                frame: seen.R * so3::rotation(&line.psi) * p.R0,
                Gamma: section(&s.Gamma),
                K: section(&s.K),
                N: section(&s.N),
                M: section(&s.M),
            });
        }
    }
}

impl<const NN: usize, I: Rotations<NN>> Combined for Beam<NN, I> {
    #[inline]
    fn add(
        &self,
        at: &Motion<'_>,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    ) -> Result<(), DomainError> {
        I::pull_back(self, at, r, tangents)?;
        if !at.v.is_empty() {
            self.rotations.inertia(at, self.damping.mass, r, tangents);
        }
        Ok(())
    }
}
