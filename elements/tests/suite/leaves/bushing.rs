//! The operators of a bushing against its map, differentiated over jets.

#![allow(non_snake_case)]

use crate::support::{moving, response};
use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};
use pullback_conformance::Random;
use pullback_elements::element::{Element, Response};
use pullback_elements::spring::Bushing;
use pullback_manifold::map::{Map, derived};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3;

type Vector12 = SVector<f64, 12>;
type Matrix12 = SMatrix<f64, 12, 12>;

/// (x₁, x₂) → y = (u, θ), u = R₁ᵀ(x₂ − x₁) − u₀, θ = log(R₁ᵀR₂).
#[derive(Clone)]
struct Relative {
    u0: Vector3<f64>,
}

impl Map<12, 6> for Relative {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 12>) -> SVector<S, 6> {
        let triple = |i: usize| Vector3::new(q[i], q[i + 1], q[i + 2]);
        let (first, second) = (triple(3), triple(9));
        let u0 = self.u0.map(S::constant);
        let u = so3::rotation(&first).tr_mul(&(triple(6) - triple(0) + u0)) - u0;
        let turn = so3::quaternion(&first)
            .conjugate()
            .product(&so3::quaternion(&second));
        let theta = so3::log_quaternion(&turn);
        SVector::<S, 6>::new(u.x, u.y, u.z, theta.x, theta.y, theta.z)
    }
}

const MAP: Relative = Relative {
    u0: Vector3::new(0.9, 0.7, -0.7),
};

/// Residual, K and C of a bushing with stiffness k and damping d, both times the identity.
fn evaluated([k, d]: [f64; 2], x: &Vector12, v: &Vector12) -> (Vector12, [Matrix12; 2]) {
    let one = Matrix6::identity();
    let positions = [Vector3::zeros(), MAP.u0];
    let bushing = Bushing::new(&positions, &Matrix3::identity(), &(one * k), &(one * d)).unwrap();
    let mut r = Vector12::zeros();
    let [mut K, mut C] = [Matrix12::zeros(); 2];
    let at = moving(x.as_slice(), v.as_slice(), &[]);
    let mut out = Response {
        K: Some(K.as_mut_slice()),
        C: Some(C.as_mut_slice()),
        ..response(r.as_mut_slice())
    };
    bushing.evaluate(&at, &mut out).unwrap();
    (r, [K, C])
}

#[test]
fn its_operators_are_those_of_the_map() {
    let mut random = Random::default();
    for scale in [0.0, 1e-8, 0.7, 2.0] {
        let x: Vector12 = random.vector::<12>() * scale;
        let v: Vector12 = random.vector();
        let exact = derived::kinematics(&MAP, 0.0, &x, &v, &Vector12::zeros());
        let B = exact.B;
        let stiffness = |f: &Vector6<f64>| derived::geometric_stiffness(&MAP, 0.0, &x, f);
        let (r, [K, _]) = evaluated([1.0, 0.0], &x, &v);
        let (r_damped, [K_damped, C]) = evaluated([0.0, 1.0], &x, &v);
        for (what, error) in [
            ("y", (r + B.tr_mul(&exact.x)).amax()),
            ("K", (K - B.tr_mul(&B) - stiffness(&exact.x)).amax()),
            ("y_dot", (r_damped + B.tr_mul(&exact.x_dot)).amax()),
            ("B", (C - B.tr_mul(&B)).amax()),
            (
                "B_dot",
                (K_damped - B.tr_mul(&exact.B_dot) - stiffness(&exact.x_dot)).amax(),
            ),
        ] {
            assert!(error < 1e-13, "{what} at {scale}: {error:e}");
        }
    }
}
