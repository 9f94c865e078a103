//! Changes of rotation chart inside an assembly: \[M04\] definition 15 and section 4.1.1.

#![allow(non_snake_case)]

use nalgebra::{Matrix3, Vector3};
use pullback_manifold::chart::Complement;
use pullback_manifold::jet::Moving;
use pullback_manifold::map::{Kinematics, Map};
use pullback_manifold::pullback::Slot;
use pullback_manifold::scalar::Scalar;

/// Operators of the complement map for one node of an element in the other chart.
#[derive(Clone, Copy, Debug)]
pub(in crate::model) struct ComplementOperators {
    psi: Vector3<f64>,
    kinematics: Kinematics<3, 3>,
    K_sigma: Matrix3<f64>,
}

impl Default for ComplementOperators {
    fn default() -> Self {
        let zero = Matrix3::zeros();
        Self {
            psi: Vector3::zeros(),
            kinematics: Kinematics {
                x: Vector3::zeros(),
                x_dot: Vector3::zeros(),
                x_ddot: Vector3::zeros(),
                B: zero,
                B_dot: zero,
                B_ddot: zero,
            },
            K_sigma: zero,
        }
    }
}

impl ComplementOperators {
    /// Ψ, Ψ̇, Ψ̈ ↦ Ψᶜ, Ψ̇ᶜ, Ψ̈ᶜ, in place.
    pub(in crate::model) fn apply(&mut self, psi: &mut [f64], v: &mut [f64], a: &mut [f64]) {
        self.psi = Vector3::from_column_slice(psi);
        let k = Complement.kinematics(
            0.0,
            &self.psi,
            &Vector3::from_column_slice(v),
            &Vector3::from_column_slice(a),
        );
        psi.copy_from_slice(k.x.as_slice());
        v.copy_from_slice(k.x_dot.as_slice());
        a.copy_from_slice(k.x_ddot.as_slice());
        self.kinematics = k;
    }

    /// Computes K_σ for the moment that the element exerts in its own chart.
    pub(in crate::model) fn load(&mut self, f: &[f64]) {
        self.K_sigma =
            Complement.geometric_stiffness(0.0, &self.psi, &Vector3::from_column_slice(f));
    }

    pub(in crate::model) fn slot(&self) -> Slot<'_> {
        Slot {
            n: 3,
            d: 3,
            B: Some(self.kinematics.B.as_slice()),
            B_dot: self.kinematics.B_dot.as_slice(),
            B_ddot: self.kinematics.B_ddot.as_slice(),
            K_sigma: self.K_sigma.as_slice(),
        }
    }

    /// out += Ḃᵀ f.
    pub(in crate::model) fn add_rate(&self, f: &[f64], out: &mut [f64]) {
        let df = self.kinematics.B_dot.tr_mul(&Vector3::from_column_slice(f));
        for (o, d) in out.iter_mut().zip(df.iter()) {
            *o += d;
        }
    }
}

/// Subtracts whole turns from a prescribed rotation vector: Ψ ↦ (1 − 2πk/ψ) Ψ with its derivatives.
pub(in crate::model) fn fold(turns: i32, psi: &mut [f64], v: &mut [f64], a: &mut [f64]) {
    if turns == 0 {
        return;
    }
    let jets = Vector3::from_fn(|i, _| Moving::<0>::given([psi[i], v[i], a[i]]));
    let angle = jets.dot(&jets).sqrt();
    let factor = -(angle.recip() * (std::f64::consts::TAU * f64::from(turns))) + 1.0;
    for (i, jet) in jets.iter().enumerate() {
        let folded = *jet * factor;
        [psi[i], v[i], a[i]] = folded.x;
    }
}
