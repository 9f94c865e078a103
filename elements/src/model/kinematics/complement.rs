//! Changes of rotation chart inside an assembly: \[M04\] definition 15 and section 4.1.1.

use nalgebra::{Matrix3, Vector3};
use pullback_manifold::chart::Complement;
use pullback_manifold::jet::Moving;
use pullback_manifold::map::Map;
use pullback_manifold::pullback;
use pullback_manifold::scalar::Scalar;
use std::ops::Range;

/// Operators of the complement map for one node of an element in the other chart.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::model) struct ComplementOperators {
    psi: Vector3<f64>,
    /// B, Ḃ, B̈.
    B: [Matrix3<f64>; 3],
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
        self.B = [k.B, k.B_dot, k.B_ddot];
    }

    /// Pulls back what an element has found in its own chart: tangents, ∂r/∂t if there is one, and the residual. Ψ is
    /// at `psi` among its coordinates.
    pub(in crate::model) fn pull_back(
        &self,
        psi: Range<usize>,
        tangents: &mut [&mut [f64]],
        r_t: Option<&mut [f64]>,
        r: &mut [f64],
    ) {
        let n = r.len();
        let moment = &mut r[psi.clone()];
        let f = Vector3::from_column_slice(moment);
        if !tangents.is_empty() {
            let K_sigma = Complement.geometric_stiffness(0.0, &self.psi, &f);
            pullback::tangents(tangents, n, psi.start, &self.B, &K_sigma);
        }
        if let Some(r_t) = r_t {
            // d/dt (Bᵀ r) at fixed unknowns = Bᵀ ∂r/∂t + Ḃᵀ r.
            let own = &mut r_t[psi];
            let rate = self.B[0].tr_mul(&Vector3::from_column_slice(own)) + self.B[1].tr_mul(&f);
            own.copy_from_slice(rate.as_slice());
        }
        moment.copy_from_slice(self.B[0].tr_mul(&f).as_slice());
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
