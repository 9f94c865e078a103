//! The beam element with two, three or four nodes, by the same code.

#![allow(non_snake_case)]

use super::mass::MassPoint;
use super::orientation::oriented;
use super::section::{Damping, Section};
use super::shape::{gauss, lagrange};
use super::strain::{Law, Line, Stiffness, Strained, extrapolated, strain_energy};
use super::viscous::Viscous;
use crate::element::{Combined, EDGE, Element, ElementError, Motion, Response, SectionState};
use nalgebra::{Matrix3, Vector3};
use pullback_manifold::so3;
use pullback_manifold::system::Weights;

/// Why a beam element cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BeamError {
    /// Two nodes stand at the same place.
    #[error("its length is zero: nodes at {at:?} coincide")]
    ZeroLength {
        /// Where.
        at: [f64; 3],
    },
    /// The number of nodes does not exist.
    #[error("a beam element has two, three or four nodes, not {0}")]
    Nodes(usize),
    /// The given orientation is not a rotation, or not one along the beam.
    #[error(
        "the section's orientation is not usable: it must be a rotation whose E1 is within 60 \
         degrees of the tangent {tangent:?}, got E1 = {first:?}"
    )]
    Orientation {
        /// Tangent of the reference line.
        tangent: [f64; 3],
        /// First axis given.
        first: [f64; 3],
    },
}

/// One integration point: shape functions, reference shape, section law.
#[derive(Clone, Debug)]
struct GaussPoint<const NN: usize> {
    /// Shape functions N_i and their derivatives with respect to the arc length.
    N: [f64; NN],
    dN: [f64; NN],
    /// Weight times length per unit of ξ.
    weight: f64,
    /// Reference place, tangent of unit length, section axes.
    X: Vector3<f64>,
    X_prime: Vector3<f64>,
    R0: Matrix3<f64>,
    law: Law,
}

impl<const NN: usize> GaussPoint<NN> {
    /// Adds the stiffness over (x′, Ψ′, Ψ) to the nodes: upper blocks only, the lower ones are
    /// their mirror images.
    #[inline]
    fn spread(&self, D: &Stiffness, weight: f64, K: &mut [f64]) {
        let n = 6 * NN;
        for j in 0..NN {
            for i in 0..=j {
                let dd = weight * self.dN[i] * self.dN[j];
                let dn = weight * self.dN[i] * self.N[j];
                let nd = weight * self.N[i] * self.dN[j];
                let nn = weight * self.N[i] * self.N[j];
                let xx = D.xx * dd;
                let xr = D.xp * dd + D.xq * dn;
                let rx = (D.xp * dd + D.xq * nd).transpose();
                let rr = D.pp * dd + D.pq * dn + (D.pq * nd).transpose() + D.qq * nn;
                for c in 0..3 {
                    let start = 6 * i + (6 * j + c) * n;
                    for (top, bottom, start) in [(&xx, &rx, start), (&xr, &rr, start + 3 * n)] {
                        let K = &mut K[start..start + 6];
                        for r in 0..3 {
                            K[r] += top[(r, c)];
                            K[3 + r] += bottom[(r, c)];
                        }
                    }
                }
            }
        }
    }
}

/// The tangents asked for, each with the weights of K, C and M in it: the parts, or their sum.
pub(super) type Tangents<'a> = [Option<(Weights, &'a mut [f64])>; 3];

/// Reissner's beam with NN nodes: d and Ψ interpolated alike, NN − 1 Gauss points for the
/// internal force and its tangent (no shear or membrane locking).
///
/// Coordinates are (d₁, Ψ₁, …) in global components.
#[derive(Clone, Debug)]
pub struct Beam<const NN: usize> {
    /// The first integration point, the only one of two nodes, stands in the element itself: an
    /// assembly waits for every detour through memory.
    first: GaussPoint<NN>,
    others: Vec<GaussPoint<NN>>,
    /// Points of inertia, where the section has mass.
    masses: Option<[MassPoint<NN>; NN]>,
    damping: Damping,
}

impl Beam<2> {
    /// A beam element through two, three or four reference places (equidistant in the parameter)
    /// with the section's orientation as a function of ξ ∈ [−1, 1] (columns E₁, E₂, E₃).
    ///
    /// E₁ is turned into the tangent of the interpolated reference line; E₂ stays in its plane
    /// with it.
    ///
    /// # Errors
    /// [`BeamError`] for coinciding nodes, an impossible orientation or number of nodes.
    pub fn along(
        places: &[Vector3<f64>],
        frame: &dyn Fn(f64) -> Matrix3<f64>,
        section: &Section,
    ) -> Result<Box<dyn Element>, BeamError> {
        match *places {
            [a, b] => Ok(Box::new(Beam::<2>::new(&[a, b], frame, section)?)),
            [a, b, c] => Ok(Box::new(Beam::<3>::new(&[a, b, c], frame, section)?)),
            [a, b, c, d] => Ok(Box::new(Beam::<4>::new(&[a, b, c, d], frame, section)?)),
            _ => Err(BeamError::Nodes(places.len())),
        }
    }
}

impl<const NN: usize> Beam<NN> {
    /// See [`Beam::along`].
    ///
    /// # Errors
    /// As there.
    pub fn new(
        places: &[Vector3<f64>; NN],
        frame: &dyn Fn(f64) -> Matrix3<f64>,
        section: &Section,
    ) -> Result<Self, BeamError> {
        let size = places.iter().fold(0.0_f64, |s, p| s.max(p.amax()));
        // The length at an integration point does not tell whether nodes coincide.
        for (i, a) in places.iter().enumerate() {
            let gap = |b: &Vector3<f64>| (a - b).norm();
            if let Some(b) = places[..i].iter().find(|b| gap(b) <= 1e-12 * size) {
                return Err(BeamError::ZeroLength { at: (*b).into() });
            }
        }
        let point = |(xi, weight): (f64, f64)| {
            let (N, dN) = lagrange::<NN>(xi);
            let sum =
                |c: &[f64; NN]| -> Vector3<f64> { places.iter().zip(c).map(|(p, c)| p * *c).sum() };
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
                point(at).map(|p| MassPoint::new(p.N, p.weight, section.inertia.rotated(&p.R0)))
            };
            let masses: Vec<_> = gauss(NN).into_iter().map(mass).collect::<Result<_, _>>()?;
            masses.try_into().ok()
        };
        Ok(Self {
            first,
            others,
            masses,
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
    fn line(p: &GaussPoint<NN>, x: &[f64]) -> Line {
        let mut line = Line {
            x_prime: p.X_prime,
            psi: Vector3::zeros(),
            psi_prime: Vector3::zeros(),
        };
        for (i, x) in x.chunks_exact(6).take(NN).enumerate() {
            let d = Vector3::new(x[0], x[1], x[2]);
            let psi = Vector3::new(x[3], x[4], x[5]);
            line.x_prime += d * p.dN[i];
            line.psi += psi * p.N[i];
            line.psi_prime += psi * p.dN[i];
        }
        line
    }

    /// Adds residual and tangents; with a `previous` iterate, K_σ takes its stresses extrapolated.
    #[inline]
    fn add(
        &self,
        previous: Option<&[f64]>,
        at: &Motion<'_>,
        r: &mut [f64],
        tangents: &mut Tangents<'_>,
    ) -> Result<(), ElementError> {
        // Their tangents are added after the mirror: they are not symmetric.
        let mut viscous: [Option<Viscous>; 3] = [None, None, None];
        let damped = self.damping.stiffness > 0.0 && !at.v.is_empty();
        for (p, viscous) in self.points().zip(&mut viscous) {
            let line = Self::line(p, at.x);
            let psi = line.psi.norm();
            if psi > EDGE {
                return Err(ElementError::OutsideChart { psi });
            }
            let mut strained = Strained::new(&line, &p.X_prime, &p.law);
            if damped {
                let (rates, beta) = (Self::rates(p, at.v), self.damping.stiffness);
                *viscous = Some(Viscous::new(&mut strained, &line, &rates, &p.law, beta));
            }
            let f = strained.forces();
            for (i, r) in r.chunks_exact_mut(6).enumerate() {
                let (a, b) = (p.weight * p.dN[i], p.weight * p.N[i]);
                for k in 0..3 {
                    r[k] -= a * f.x_prime[k];
                    r[3 + k] -= a * f.psi_prime[k] + b * f.psi[k];
                }
            }
            for (weights, K) in tangents.iter_mut().flatten() {
                if weights.K == 0.0 {
                    continue;
                }
                // Viscous stresses are not extrapolated.
                let (N, M) = match previous.filter(|_| !damped) {
                    None => (strained.N, strained.M),
                    Some(x) => extrapolated(&Self::line(p, x), &line, &p.X_prime, &p.law),
                };
                let D = strained.stiffness(&line, &p.law, &N, &M);
                p.spread(&D, p.weight * weights.K, K);
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
        if !at.v.is_empty() {
            for p in self.masses.iter().flatten() {
                p.add(at, self.damping.mass, r, tangents);
            }
        }
        Ok(())
    }

    /// ẋ′, Ψ̇, Ψ̇′ at an integration point.
    fn rates(p: &GaussPoint<NN>, v: &[f64]) -> Line {
        let mut rates = Self::line(p, v);
        rates.x_prime -= p.X_prime;
        rates
    }
}

impl<const NN: usize> Element for Beam<NN> {
    fn dim(&self) -> usize {
        6 * NN
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), ElementError> {
        let (r, mut tangents) = parts(out);
        self.add(None, at, r, &mut tangents)
    }

    fn evaluate_from(
        &self,
        previous: &[f64],
        at: &Motion<'_>,
        out: &mut Response<'_>,
    ) -> Result<(), ElementError> {
        let (r, mut tangents) = parts(out);
        self.add(Some(previous), at, r, &mut tangents)
    }

    fn combined(&self) -> Option<&dyn Combined> {
        Some(self)
    }

    fn energy(&self, at: &Motion<'_>) -> f64 {
        self.points()
            .map(|p| p.weight * strain_energy(&Self::line(p, at.x), &p.X_prime, &p.law))
            .sum()
    }

    fn kinetic_energy(&self, at: &Motion<'_>) -> Option<f64> {
        let masses = self.masses.iter().flatten();
        Some(masses.map(|p| p.kinetic_energy(at)).sum())
    }

    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        if self.damping == Damping::default() || at.v.is_empty() {
            return 0.0;
        }
        let stiffness = self.damping.stiffness;
        let viscous = |p: &GaussPoint<NN>| {
            let line = Self::line(p, at.x);
            let mut s = Strained::new(&line, &p.X_prime, &p.law);
            let rates = Self::rates(p, at.v);
            p.weight * Viscous::new(&mut s, &line, &rates, &p.law, stiffness).power()
        };
        let drag = |p: &MassPoint<NN>| p.drag_power(at, self.damping.mass);
        self.points().map(viscous).sum::<f64>()
            + self.masses.iter().flatten().map(drag).sum::<f64>()
    }

    fn section_states(&self, at: &Motion<'_>, out: &mut Vec<SectionState>) {
        for p in self.points() {
            let line = Self::line(p, at.x);
            let s = Strained::new(&line, &p.X_prime, &p.law);
            let d: Vector3<f64> =
                at.x.chunks_exact(6)
                    .zip(&p.N)
                    .map(|(x, n)| Vector3::new(x[0], x[1], x[2]) * *n)
                    .sum();
            let section = |v: &Vector3<f64>| p.R0.tr_mul(v);
            out.push(SectionState {
                reference: p.X,
                place: p.X + d,
                frame: so3::rotation(&line.psi) * p.R0,
                Gamma: section(&s.Gamma),
                K: section(&s.K),
                N: section(&s.N),
                M: section(&s.M),
            });
        }
    }
}

impl<const NN: usize> Combined for Beam<NN> {
    fn evaluate_combined(
        &self,
        previous: Option<&[f64]>,
        at: &Motion<'_>,
        weights: Weights,
        r: &mut [f64],
        S: &mut [f64],
    ) -> Result<(), ElementError> {
        self.add(previous, at, r, &mut [Some((weights, S)), None, None])
    }
}

/// The residual and the parts K, C, M of the tangent that a response asks for.
fn parts<'a>(out: &'a mut Response<'_>) -> (&'a mut [f64], Tangents<'a>) {
    let one = |K, C, M| Weights { K, C, M };
    let K = out.K.as_deref_mut().map(|K| (one(1.0, 0.0, 0.0), K));
    let C = out.C.as_deref_mut().map(|C| (one(0.0, 1.0, 0.0), C));
    let M = out.M.as_deref_mut().map(|M| (one(0.0, 0.0, 1.0), M));
    (&mut *out.r, [K, C, M])
}

/// Copies the blocks above the diagonal below it.
#[inline]
fn mirror<const NN: usize>(K: &mut [f64]) {
    let n = 6 * NN;
    for j in 1..NN {
        for i in 0..j {
            for c in 0..6 {
                for r in 0..6 {
                    K[6 * j + c + (6 * i + r) * n] = K[6 * i + r + (6 * j + c) * n];
                }
            }
        }
    }
}
