//! Cross-sections: the linear law between strains and stress resultants, and mass per length.

use crate::Asymmetry;
use crate::inertia::{Inertia, InertiaError};
use nalgebra::{Matrix3, Matrix6, Vector3};
use std::f64::consts::PI;

/// A cross-section in its own axes E₁ (along the beam), E₂, E₃.
///
/// The law is (N, M) = C (Γ, K) with a symmetric positive definite 6×6 matrix C; rows and columns
/// are normal force, two shear forces, torque, two bending moments (\[M04\] section 3.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Section stiffness C, 6×6.
    pub C: Matrix6<f64>,
    /// Inertia per unit length about the axis: Aρ, first moment S, J, in the section axes.
    pub inertia: Inertia,
    /// Viscous damping; none by default.
    pub damping: Damping,
}

/// Rayleigh's damping, proportional to mass and stiffness.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Damping {
    /// Factor of the momentum per unit length: a force −α (Aρ ẋ, TᵀJΩ) against the absolute
    /// velocity, in 1/time.
    pub mass: f64,
    /// Factor of the section's stiffness: Kelvin-Voigt stresses β C (Γ̇, K̇), in time.
    pub stiffness: f64,
}

/// Error of a section.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum SectionError {
    #[error("{quantity} must be positive and finite, got {value}")]
    NotPositive { quantity: &'static str, value: f64 },
    #[error("{quantity} must be zero or positive, and finite, got {value}")]
    Negative { quantity: &'static str, value: f64 },
    #[error("Poisson's ratio must lie in (-1, 0.5], got {0}")]
    PoissonRatio(f64),
    #[error("a tube needs 0 < inner radius < outer radius, got {inner} and {outer}")]
    Tube { inner: f64, outer: f64 },
    #[error("{source}")]
    Inertia { source: InertiaError },
    #[error("the section stiffness must be symmetric, but {0}")]
    NotSymmetric(Asymmetry),
    #[error("the section stiffness must be positive definite; the diagonal is {diagonal:?}")]
    NotPositiveDefinite { diagonal: [f64; 6] },
}

/// An isotropic material: Young's modulus E, Poisson's ratio ν, density ρ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus.
    pub E: f64,
    /// Poisson's ratio.
    pub nu: f64,
    /// Density (zero without inertia and weight).
    pub rho: f64,
}

impl Material {
    /// Shear modulus G = E / 2(1+ν).
    pub fn G(&self) -> f64 {
        self.E / (2.0 * (1.0 + self.nu))
    }

    fn check(&self) -> Result<(), SectionError> {
        positive("Young's modulus E", self.E)?;
        if !(self.nu > -1.0 && self.nu <= 0.5) {
            return Err(SectionError::PoissonRatio(self.nu));
        }
        not_negative("density rho", self.rho)
    }
}

fn positive(quantity: &'static str, value: f64) -> Result<(), SectionError> {
    match value > 0.0 && value.is_finite() {
        true => Ok(()),
        false => Err(SectionError::NotPositive { quantity, value }),
    }
}

fn not_negative(quantity: &'static str, value: f64) -> Result<(), SectionError> {
    match value >= 0.0 && value.is_finite() {
        true => Ok(()),
        false => Err(SectionError::Negative { quantity, value }),
    }
}

impl Section {
    /// A general symmetric section law; no mass.
    ///
    /// # Errors
    /// [`SectionError`] if C is not symmetric (to 1e-12 of its largest diagonal pair) or not
    /// positive definite.
    pub fn new(C: Matrix6<f64>) -> Result<Self, SectionError> {
        let diagonal: [f64; 6] = std::array::from_fn(|i| C[(i, i)]);
        if C.iter().any(|c| !c.is_finite()) || diagonal.iter().any(|&c| c <= 0.0) {
            return Err(SectionError::NotPositiveDefinite { diagonal });
        }
        let tolerance = |i: usize, j: usize| 1e-12 * (diagonal[i] * diagonal[j]).sqrt();
        if let Some(asymmetry) = Asymmetry::of(&C, tolerance) {
            return Err(SectionError::NotSymmetric(asymmetry));
        }
        // Definiteness does not depend on the units: test the law scaled to a unit diagonal.
        let scaled = Matrix6::from_fn(|i, j| C[(i, j)] / (diagonal[i].sqrt() * diagonal[j].sqrt()));
        if scaled.symmetric_eigenvalues().min() <= 1e-14 {
            return Err(SectionError::NotPositiveDefinite { diagonal });
        }
        Ok(Self {
            C: (C + C.transpose()) * 0.5,
            inertia: Inertia::default(),
            damping: Damping::default(),
        })
    }

    /// The diagonal law N = diag(EA, GA₂, GA₃) Γ, M = diag(GJ, EI₂, EI₃) K; no mass.
    ///
    /// EI₂ belongs to bending about E₂ (fibres at a distance along E₃), GA₂ to shear along E₂.
    ///
    /// # Errors
    /// [`SectionError::NotPositive`] with the name of the stiffness.
    pub fn diagonal(EA: f64, GA: [f64; 2], GJ: f64, EI: [f64; 2]) -> Result<Self, SectionError> {
        positive("axial stiffness EA", EA)?;
        positive("shear stiffness GA2", GA[0])?;
        positive("shear stiffness GA3", GA[1])?;
        positive("torsional stiffness GJ", GJ)?;
        positive("bending stiffness EI2", EI[0])?;
        positive("bending stiffness EI3", EI[1])?;
        Self::new(Matrix6::from_diagonal(
            &[EA, GA[0], GA[1], GJ, EI[0], EI[1]].into(),
        ))
    }

    /// The same section with mass per length Aρ and inertia per length J (section axes).
    ///
    /// # Errors
    /// As of [`Section::with_inertia`].
    pub fn with_mass(self, A_rho: f64, J: Matrix3<f64>) -> Result<Self, SectionError> {
        self.with_inertia(Inertia::about_centre(A_rho, Vector3::zeros(), J))
    }

    /// The same section with any inertia per length; the mass centre may be off the axis.
    ///
    /// # Errors
    /// [`SectionError::Inertia`] for one that is negative, not symmetric or not finite.
    pub fn with_inertia(mut self, inertia: Inertia) -> Result<Self, SectionError> {
        self.inertia = inertia
            .checked()
            .map_err(|source| SectionError::Inertia { source })?;
        Ok(self)
    }

    /// The same section with viscous damping.
    ///
    /// # Errors
    /// [`SectionError::Negative`] for a factor that is negative or not finite.
    pub fn with_damping(mut self, damping: Damping) -> Result<Self, SectionError> {
        not_negative("mass-proportional damping", damping.mass)?;
        let stiffness = damping.stiffness;
        not_negative("stiffness-proportional damping", stiffness)?;
        self.damping = damping;
        Ok(self)
    }

    /// Rectangle of `width` along E₂ and `height` along E₃.
    ///
    /// Shear factor 10(1+ν)/(12+11ν) (Cowper 1966, J. Appl. Mech. 33, table 1); torsion constant
    /// by Saint-Venant's series ([`rectangle_torsion`]).
    ///
    /// # Errors
    /// [`SectionError`] for a material or a side that is not positive.
    pub fn rectangle(material: Material, width: f64, height: f64) -> Result<Self, SectionError> {
        material.check()?;
        positive("width", width)?;
        positive("height", height)?;
        let nu = material.nu;
        let k = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu);
        let area = width * height;
        let I = [width * height.powi(3) / 12.0, height * width.powi(3) / 12.0];
        Self::from_geometry(material, area, k, rectangle_torsion(width, height), I)
    }

    /// Solid circle. Shear factor 6(1+ν)/(7+6ν) (Cowper 1966).
    ///
    /// # Errors
    /// [`SectionError`] for a material or a radius that is not positive.
    pub fn circle(material: Material, radius: f64) -> Result<Self, SectionError> {
        material.check()?;
        positive("radius", radius)?;
        let nu = material.nu;
        let k = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu);
        let I = PI * radius.powi(4) / 4.0;
        Self::from_geometry(material, PI * radius * radius, k, 2.0 * I, [I, I])
    }

    /// Circular tube. Shear factor 6(1+ν)(1+m²)² / ((7+6ν)(1+m²)² + (20+12ν)m²) with the ratio
    /// of radii m (Cowper 1966).
    ///
    /// # Errors
    /// [`SectionError`] for a material or radii out of range.
    pub fn tube(material: Material, inner: f64, outer: f64) -> Result<Self, SectionError> {
        material.check()?;
        positive("outer radius", outer)?;
        if !(inner > 0.0 && inner < outer) {
            return Err(SectionError::Tube { inner, outer });
        }
        let nu = material.nu;
        let m2 = (inner / outer).powi(2);
        let s = (1.0 + m2).powi(2);
        let k = 6.0 * (1.0 + nu) * s / ((7.0 + 6.0 * nu) * s + (20.0 + 12.0 * nu) * m2);
        let I = PI * (outer.powi(4) - inner.powi(4)) / 4.0;
        let area = PI * (outer * outer - inner * inner);
        Self::from_geometry(material, area, k, 2.0 * I, [I, I])
    }

    /// Section stiffness and mass from area, shear factor, torsion constant and second moments I₂, I₃.
    fn from_geometry(
        material: Material,
        area: f64,
        k: f64,
        torsion: f64,
        I: [f64; 2],
    ) -> Result<Self, SectionError> {
        let Material { E, rho, .. } = material;
        let G = material.G();
        let shear = k * G * area;
        let J = Vector3::new(I[0] + I[1], I[0], I[1]) * rho;
        Self::diagonal(E * area, [shear, shear], G * torsion, [E * I[0], E * I[1]])?
            .with_mass(rho * area, Matrix3::from_diagonal(&J))
    }
}

/// Torsion constant of a rectangle with sides a ≥ b:
/// a b³ [1/3 − (64/π⁵)(b/a) Σ_{n odd} tanh(nπa/2b)/n⁵]
/// (Timoshenko & Goodier, Theory of Elasticity, art. 109).
pub fn rectangle_torsion(width: f64, height: f64) -> f64 {
    let (a, b) = (width.max(height), width.min(height));
    // Σ 1/n⁵ over odd n is 31 ζ(5)/32; 1 − tanh decays exponentially.
    const ODD: f64 = 31.0 / 32.0 * 1.036_927_755_143_37;
    let rest: f64 = (0..12)
        .map(|k| {
            let n = f64::from(2 * k + 1);
            // 1 − tanh x = 2/(e^{2x} + 1).
            2.0 / (((n * PI * a / b).exp() + 1.0) * n.powi(5))
        })
        .sum();
    let sum = ODD - rest;
    a * b.powi(3) * (1.0 / 3.0 - 64.0 / PI.powi(5) * b / a * sum)
}
