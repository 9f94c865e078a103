//! A two-node beam defined by its energies, with any measure of strain.

#![allow(non_snake_case)]

use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3};
use pullback_elements::beam::{BeamError, Damping, Section, oriented};
use pullback_elements::energy::{ByEnergy, EnergyElement, EnergySample, inside_chart, rate};
use pullback_elements::inertia::Inertia;
use pullback_manifold::domain::DomainError;
use pullback_manifold::quotients::TangentQuotients;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3;

/// Strains of a cross-section: the function that defines a beam theory.
pub trait StrainMeasure: Send + Sync {
    /// The six strains (elongation, two shears; twist, two bendings per length) conjugate to the
    /// resultants (N, M), from
    ///
    /// - g = R₀ᵀRᵀx′, the derivative of the position by the reference arc length in the section axes:
    ///   (1, 0, 0) in the unstrained state;
    /// - k = R₀ᵀTΨ′, the curvature in the section axes, 1/L.
    fn strains<S: Scalar>(&self, g: &Vector3<S>, k: &Vector3<S>) -> SVector<S, 6>;
}

/// Reissner's strains: Γ = Rᵀx′ − E₁, K = TΨ′; \[M04\] (118).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reissner;

impl StrainMeasure for Reissner {
    fn strains<S: Scalar>(&self, g: &Vector3<S>, k: &Vector3<S>) -> SVector<S, 6> {
        SVector::<S, 6>::new(g.x - 1.0, g.y, g.z, k.x, k.y, k.z)
    }
}

/// The elongation of Green and Lagrange on the centre line, ½(x′·x′ − 1), with Reissner's shears and
/// curvatures.
///
/// With ½EA of the square of this strain a bar has the force EA ½(λ² − 1) λ at the stretch λ, with
/// Reissner's EA (λ − 1).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GreenLagrange;

impl StrainMeasure for GreenLagrange {
    fn strains<S: Scalar>(&self, g: &Vector3<S>, k: &Vector3<S>) -> SVector<S, 6> {
        SVector::<S, 6>::new((g.dot(g) - 1.0) * 0.5, g.y, g.z, k.x, k.y, k.z)
    }
}

/// Strain energy ½ ε·Cε per length, and its viscous counterpart ½ β ε̇·Cε̇, in y = R₀ᵀ(x′, Ψ′, Ψ).
///
/// In these components R(Ψ) needs no R₀: R(R₀ᵀΨ) = R₀ᵀR(Ψ)R₀.
#[derive(Clone, Copy, Debug)]
pub struct SectionEnergy<M> {
    measure: M,
    C: Matrix6<f64>,
    beta: f64,
}

fn triple<S: Scalar, const N: usize>(y: &SVector<S, N>, i: usize) -> Vector3<S> {
    Vector3::new(y[i], y[i + 1], y[i + 2])
}

impl<M: StrainMeasure> SectionEnergy<M> {
    fn strains<S: Scalar>(&self, y: &SVector<S, 9>) -> SVector<S, 6> {
        let [x_prime, psi_prime, psi] = [0, 3, 6].map(|i| triple(y, i));
        let c = TangentQuotients::new(psi.dot(&psi));
        let g = so3::turned(&-psi, &x_prime, &c);
        self.measure.strains(&g, &so3::spun(&psi, &psi_prime, &c))
    }

    /// ½ e·Ce without the terms that are absent from C.
    fn quadratic<S: Scalar>(&self, e: &SVector<S, 6>) -> S {
        let mut sum = S::zero();
        for i in 0..6 {
            let mut half = e[i] * (0.5 * self.C[(i, i)]);
            for j in (0..i).filter(|&j| self.C[(i, j)] != 0.0) {
                half += e[j] * self.C[(i, j)];
            }
            sum += e[i] * half;
        }
        sum
    }
}

impl<M: StrainMeasure> EnergyElement<9> for SectionEnergy<M> {
    const KINETIC: bool = false;

    fn potential<S: Scalar>(&self, _t: S, y: &SVector<S, 9>) -> S {
        self.quadratic(&self.strains(y))
    }

    fn dissipation<S: Scalar>(&self, y: &SVector<S, 9>, y_dot: &SVector<S, 9>) -> S {
        if self.beta == 0.0 {
            return S::zero();
        }
        self.quadratic(&rate(|y| self.strains(y), y, y_dot)) * self.beta
    }

    fn domain(&self, y: &SVector<f64, 9>) -> Result<(), DomainError> {
        inside_chart(&triple(y, 6))
    }
}

/// Kinetic energy ½ m ẋ·ẋ + ẋ·R(Ω×S) + ½ Ω·JΩ of a frame with mass, and its drag α T, in y = (x,
/// Ψ); a rigid body, or a cross-section per length. \[M04\] (119).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameInertia {
    /// Mass, first and second moments, components as those of y.
    pub inertia: Inertia,
    /// Factor α of the drag, 1/T: a force −α p with the momentum p = ∂T/∂ẏ.
    pub drag: f64,
}

impl EnergyElement<6> for FrameInertia {
    fn kinetic<S: Scalar>(&self, y: &SVector<S, 6>, y_dot: &SVector<S, 6>) -> S {
        let Inertia { mass, S: first, J } = &self.inertia;
        let (psi, x_dot) = (triple(y, 3), triple(y_dot, 0));
        let c = TangentQuotients::new(psi.dot(&psi));
        let Omega = so3::spun(&psi, &triple(y_dot, 3), &c);
        let mut double = x_dot.dot(&x_dot) * *mass;
        for i in 0..3 {
            let mut momentum = Omega[i] * J[(i, i)];
            for j in (0..i).filter(|&j| J[(i, j)] != 0.0) {
                momentum += Omega[j] * (2.0 * J[(i, j)]);
            }
            double += Omega[i] * momentum;
        }
        if *first != Vector3::zeros() {
            let around = Omega.cross(&first.map(S::constant));
            double += x_dot.dot(&so3::turned(&psi, &around, &c)) * 2.0;
        }
        double * 0.5
    }

    fn dissipation<S: Scalar>(&self, y: &SVector<S, 6>, y_dot: &SVector<S, 6>) -> S {
        if self.drag == 0.0 {
            return S::zero();
        }
        self.kinetic(y, y_dot) * self.drag
    }

    fn domain(&self, y: &SVector<f64, 6>) -> Result<(), DomainError> {
        inside_chart(&triple(y, 3))
    }
}

/// A two-node beam between reference `positions` (global components, L) with the section's axes in
/// the columns of `R0`, the first of which is rotated to the beam's direction; coordinates (d₁, Ψ₁,
/// d₂, Ψ₂), interpolated linearly. It has one integration point for strains and two for inertia.
///
/// # Errors
/// [`BeamError`] for coinciding nodes and an impossible orientation.
pub fn strain_beam<M: StrainMeasure + Copy + 'static>(
    measure: M,
    positions: &[Vector3<f64>; 2],
    R0: &Matrix3<f64>,
    section: &Section,
) -> Result<ByEnergy<12>, BeamError> {
    let along = positions[1] - positions[0];
    let length = along.norm();
    let size = positions[0].amax().max(positions[1].amax());
    if length.is_nan() || length <= 1e-12 * size {
        return Err(BeamError::ZeroLength {
            at: positions[0].into(),
        });
    }
    let X_prime = along / length;
    let R0 = oriented(R0, &X_prime)?;
    // Nodes' shape functions at ξ, and their derivatives by arc length.
    let values = |xi: f64| [0.5 * (1.0 - xi), 0.5 * (1.0 + xi)];
    let slopes = [-1.0 / length, 1.0 / length];
    let Damping {
        mass: drag,
        stiffness: beta,
    } = section.damping;
    let energies = SectionEnergy {
        measure,
        C: section.C,
        beta,
    };
    let mut A = SMatrix::<f64, 9, 12>::zeros();
    put(&mut A, &R0, 0, 0, slopes);
    put(&mut A, &R0, 3, 3, slopes);
    put(&mut A, &R0, 6, 3, values(0.0));
    let mut y0 = SVector::<f64, 9>::zeros();
    // R₀ᵀX′ is the first axis.
    y0[0] = 1.0;
    let strained = EnergySample::new(energies, length, y0, &A);
    let inertia = FrameInertia {
        inertia: section.inertia,
        drag,
    };
    let xi = (1.0_f64 / 3.0).sqrt();
    let massive = [-xi, xi].map(|xi| {
        let mut A = SMatrix::<f64, 6, 12>::zeros();
        put(&mut A, &R0, 0, 0, values(xi));
        put(&mut A, &R0, 3, 3, values(xi));
        EnergySample::new(inertia, 0.5 * length, SVector::zeros(), &A)
    });
    let massive = massive.into_iter().filter(|_| !section.inertia.is_zero());
    Ok(ByEnergy::new([strained].into_iter().chain(massive)))
}

/// Writes Nᵢ R₀ᵀ for the triple of each node that starts at `first` in its six coordinates.
fn put<const D: usize>(
    A: &mut SMatrix<f64, D, 12>,
    R0: &Matrix3<f64>,
    row: usize,
    first: usize,
    N: [f64; 2],
) {
    for (node, N) in N.into_iter().enumerate() {
        A.fixed_view_mut::<3, 3>(row, 6 * node + first)
            .copy_from(&(R0.transpose() * N));
    }
}
