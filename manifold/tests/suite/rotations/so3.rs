//! Rotation vectors: against an independent implementation, against exact forward derivatives, and
//! the identities that tie the tensors together.

use crate::support::{relative as close, *};
use pullback_manifold::so3::{tangent, *};

type V3 = Vector3<f64>;
type M3 = Matrix3<f64>;

/// As `close`, in absolute terms: Ṫ holds c₄Ψ̇~, which leaves a last position in ṪΨ̇ though Ψ̇~Ψ̇ = 0,
/// so for small Ψ the definitions of ṪΨ̇ and C₄ (both O(ψ)) are not relatively accurate themselves.
#[track_caller]
fn close_to_unit<const C: usize>(
    name: &str,
    value: &nalgebra::SMatrix<f64, 3, C>,
    expected: &nalgebra::SMatrix<f64, 3, C>,
    tolerance: f64,
) {
    let error = (value - expected).amax() / expected.amax().max(1.0);
    assert!(
        error <= tolerance,
        "{name}: {error:e}\n{value:e}{expected:e}"
    );
}

/// C₄(Ψ̇,Ψ) = D_Ψ̇(Ṫ Ψ̇), Ψ fixed; \[M04\] (63).
fn C4(Psi_dot: &V3, Psi: &V3, c: &Quotients) -> M3 {
    A_varied([0.0, 1.0, 0.0], Psi_dot, &V3::zeros(), Psi, c)
}

/// C₅(Ψ̇,Ψ) = D_Ψ(Ṫ Ψ̇), Ψ̇ fixed; \[M04\] (63).
fn C5(Psi_dot: &V3, Psi: &V3, c: &Quotients) -> M3 {
    A_varied([1.0, 0.0, 0.0], Psi_dot, &V3::zeros(), Psi, c)
}

/// Rotation vectors at the angles where formulas are apt to fail, in random directions.
fn rotation_vectors() -> Vec<V3> {
    let mut random = Random::default();
    let mut angles = vec![
        0.0, 1e-300, 1e-160, 1e-100, 1e-20, 1e-8, 1e-4, 1e-2, 0.3, 1.0,
    ];
    angles.extend([2.4, 2.449, 2.45, 2.5, 3.0, PI.next_down(), PI.next_up()]);
    angles.extend([-1e-4, -1e-9, 0.0, 1e-9, 1e-4].map(|gap| PI + gap));
    angles.extend([3.5, 4.493_409_457_909_064, 5.0, 5.763_459_196_894_55, 6.0]);
    angles.extend([TAU - 0.1, TAU - 0.05]);
    angles.extend((0..100).map(|_| random.range(0.0, TAU - 0.05)));
    let mut vectors: Vec<V3> = angles
        .iter()
        .map(|psi| random.vector::<3>().normalize() * *psi)
        .collect();
    // The axes, where entries vanish exactly.
    for i in 0..3 {
        for psi in [1e-8, 1.0, PI, 5.0] {
            vectors.push(V3::ith(i, psi));
            vectors.push(V3::ith(i, -psi));
        }
    }
    vectors
}

#[test]
fn agree_with_the_reference() {
    for row in reference("rotation") {
        let get = |key: &str| vector::<3>(&row[key]);
        let (Psi, v, Psi_dot, Psi_ddot) = (get("psi"), get("v"), get("psi_dot"), get("psi_ddot"));
        let Psi_prime = get("psi_prime");
        let c = Quotients::new(Psi.norm());
        let a = InverseQuotients::new(Psi.norm());
        let expect = |key: &str, value: M3| close(key, &value, &matrix(&row[key]), 1e-13);
        expect("R", rotation(&Psi));
        expect("R", R(&Psi, &c.tangent()));
        expect("T", tangent(&Psi));
        expect("T", T(&Psi, &c.tangent()));
        expect("T_inverse", tangent_inverse(&Psi));
        expect("T_inverse", T_inverse(&Psi, &a));
        expect("C1", C1(&v, &Psi, &c));
        expect("C2", C2(&v, &Psi, &c));
        expect("C3", C3(&v, &Psi_prime, &Psi, &c));
        expect("T_dot", T_dot(&Psi_dot, &Psi, &c));
        expect("C4", C4(&Psi_dot, &Psi, &c));
        expect("C5", C5(&Psi_dot, &Psi, &c));
        expect("C6", C6(&v, &Psi, &a));
        let T = tangent(&Psi);
        close("Omega", &(T * Psi_dot), &get("Omega"), 1e-13);
        let A = T * Psi_ddot + T_dot_psi_dot(&Psi_dot, &Psi, &c);
        close("A", &A, &get("angular_acceleration"), 1e-13);
    }
}

#[test]
fn identities_hold() {
    let mut random = Random::default();
    let I = M3::identity();
    for Psi in rotation_vectors() {
        let (R, T) = (rotation(&Psi), tangent(&Psi));
        let c = Quotients::new(Psi.norm());
        let (V, W) = (random.vector(), random.vector());
        close("orthogonal", &(R.transpose() * R), &I, 2e-15);
        assert!((R.determinant() - 1.0).abs() < 4e-15);
        close("R T = Tᵀ (38)", &(R * T), &T.transpose(), 4e-15);
        close("R Ψ = Ψ", &(R * Psi), &Psi, 2e-15);
        // T⁻¹ grows as 1/(2π − ψ) and with it the error of the product.
        let size = tangent_inverse(&Psi).amax();
        close("T T⁻¹ = I", &(T * tangent_inverse(&Psi)), &I, 4e-15 * size);
        let turn = c.tangent();
        close("R V", &turned(&Psi, &V, &turn), &(R * V), 4e-15);
        close("Rᵀ V", &turned(&-Psi, &V, &turn), &R.tr_mul(&V), 4e-15);
        close("T V", &spun(&Psi, &V, &turn), &(T * V), 4e-15);
        let C2_V = C1(&(R * V), &Psi, &c) - T.transpose() * skew(&V) * T;
        close("(49)", &C2(&V, &Psi, &c), &C2_V, 1e-14);
        let C3 = C3(&V, &W, &Psi, &c);
        close("C₃ symmetric", &C3, &C3.transpose(), 0.0);
        let quadratic = T_dot_psi_dot(&V, &Psi, &c);
        // C₁ d may be much smaller than its terms.
        let C1_V = C1(&V, &Psi, &c);
        let gap = (T_varied(&V, &W, &Psi, &c) - C1_V * W).amax();
        assert!(gap <= 2e-15 * C1_V.norm() * W.norm(), "C₁ d: {gap:e}");
        let (C1, C4, C5) = (C1(&W, &Psi, &c), C4(&V, &Psi, &c), C5(&V, &Psi, &c));
        let weights = [0.7, -1.3, 0.4];
        let parts = (C5 + C1) * weights[0] + C4 * weights[1] + T * weights[2];
        close("DA", &A_varied(weights, &V, &W, &Psi, &c), &parts, 1e-14);
        close_to_unit("ṪΨ̇", &(T_dot(&V, &Psi, &c) * V), &quadratic, 2e-15);
        close("quaternion", &quaternion(&Psi).rotation(), &R, 2e-15);
        let other = rotation(&W);
        let product = quaternion(&Psi).product(&quaternion(&W));
        close("product", &product.rotation(), &(R * other), 4e-15);
        let back = quaternion(&Psi).conjugate().rotation();
        close("conjugate", &back, &R.transpose(), 2e-15);
        assert!((product.dot(&product) - 1.0).abs() < 2e-15);
    }
}

#[test]
fn the_complement_is_the_same_rotation() {
    for Psi in rotation_vectors() {
        if Psi.norm() < 1e-4 {
            continue;
        }
        let other = complement(&Psi);
        assert!((other.norm() - (TAU - Psi.norm())).abs() < 2e-15);
        close("R(Ψᶜ) = R(Ψ)", &rotation(&other), &rotation(&Psi), 3e-15);
        // 2π − ψ is rounded to an ulp of 2π.
        assert!((complement(&other) - Psi).norm() < 3e-15);
        let (p, q) = (quaternion(&Psi), quaternion(&other));
        assert!((p.dot(&q) + 1.0).abs() < 2e-15, "opposite quaternions");
        // T on both branches gives the same material spin.
        let (I, B, B_back) = (M3::identity(), B_s(&Psi), B_s(&other));
        let size = B.amax() + B_back.amax();
        close("B_s(Ψᶜ) B_s(Ψ) = I", &(B_back * B), &I, 2e-15 * size);
        let T = tangent(&Psi);
        close("T(Ψᶜ) B_s = T", &(tangent(&other) * B), &T, 2e-15 * size);
    }
}

#[test]
fn logarithm_inverts_both_sheets() {
    for Psi in rotation_vectors() {
        let psi = Psi.norm();
        let q = quaternion(&Psi);
        // At π itself the branch is a matter of the last position; either vector is right.
        let expected = |log: &V3| {
            let on_sheet = (psi - PI).abs() > 1e-15 || log.dot(&Psi) > 0.0;
            if on_sheet { Psi } else { complement(&Psi) }
        };
        let log = log_quaternion(&q);
        // Close to 2π the vector part is small and only absolutely accurate to the last position of 2π.
        let edge = 1.0 + 1.0 / (TAU - psi);
        close("log of quaternion", &log, &expected(&log), 1e-15 * edge);
        // The opposite quaternion lies on the other branch.
        if psi > 1e-4 && (psi - PI).abs() > 1e-15 {
            let log = log_quaternion(&q.opposite());
            let edge = 1.0 + 1.0 / psi;
            assert!((log - complement(&Psi)).norm() <= 2e-15 * edge);
        }
    }
}

/// Ψ with unit gradient in its three components.
fn seeded(Psi: &V3) -> Vector3<Grad<f64, 3>> {
    Vector3::from_fn(|i, _| Grad::variable(Psi[i], i))
}

/// The gradient of a vector function: row i holds that of component i.
fn gradient(y: &Vector3<Grad<f64, 3>>) -> M3 {
    M3::from_fn(|i, j| y[i].g[j])
}

fn constant<S: pullback_manifold::scalar::Scalar>(v: &V3) -> Vector3<S> {
    v.map(S::constant)
}

#[test]
fn tensors_are_exact_derivatives() {
    let mut random = Random::default();
    for Psi in rotation_vectors() {
        let psi = Psi.norm();
        if psi > TAU - 0.1 + 1e-9 {
            continue;
        }
        let (V, W) = (random.vector(), random.vector());
        let c = Quotients::new(psi);
        let a = InverseQuotients::new(psi);
        let x = seeded(&Psi);
        let v = constant(&V);
        let expect = |name: &str, value: M3, y: Vector3<Grad<f64, 3>>| {
            close(name, &value, &gradient(&y), 1e-13);
        };
        expect("C₁", C1(&V, &Psi, &c), tangent(&x) * v);
        expect("C₂", C2(&V, &Psi, &c), tangent(&x).transpose() * v);
        // Of V = Tᵀ T⁻ᵀ V.
        let inverse = tangent_inverse(&Psi).transpose();
        let C6_V = -inverse * C2(&(inverse * V), &Psi, &c);
        close("C₆", &C6(&V, &Psi, &a), &C6_V, 1e-13);
        // D_Ψ(R V) = −R V~ T.
        let D = -rotation(&Psi) * skew(&V) * tangent(&Psi);
        expect("D(R V)", D, rotation(&x) * v);
        // C₃ is the Hessian of V·T(Ψ)Ψ′.
        let x = Vector3::from_fn(|i, _| Hess::<3>::coordinate(Psi[i], i));
        let energy = constant(&V).dot(&(tangent(&x) * constant(&W)));
        let hessian = M3::from_fn(|i, j| energy.xx[i.max(j)][i.min(j)]);
        close("C₃", &C3(&V, &W, &Psi, &c), &hessian, 1e-13);
        // Ṫ and T̈ along Ψ + Ψ̇ t + Ψ̈ t²/2, and ṪΨ̇ as a function of Ψ̇ (C₄) and of Ψ (C₅).
        let t = Vector3::from_fn(|i, _| Moving::<0>::given([Psi[i], V[i], W[i]]));
        let [rate, second] = [1, 2].map(|k| tangent(&t).map(|y| y.x[k]));
        close("Ṫ", &T_dot(&V, &Psi, &c), &rate, 1e-13);
        close("T̈", &T_ddot(&V, &W, &Psi, &c), &second, 1e-13);
        let spin_rate = |Psi: Vector3<Grad<f64, 3>>, Psi_dot: Vector3<Grad<f64, 3>>| {
            let motion = Vector3::from_fn(|i, _| Grad {
                v: Psi[i],
                g: [Psi_dot[i]],
            });
            tangent(&motion).map(|y| y.g[0]) * Psi_dot
        };
        let y = gradient(&spin_rate(constant(&Psi), seeded(&V)));
        close_to_unit("C₄", &C4(&V, &Psi, &c), &y, 1e-13);
        let y = spin_rate(seeded(&Psi), constant(&V));
        expect("C₅", C5(&V, &Psi, &c), y);
    }
}

#[test]
fn complement_and_logarithm_have_exact_derivatives() {
    let mut random = Random::default();
    for Psi in rotation_vectors() {
        let psi = Psi.norm();
        if psi > TAU - 0.1 + 1e-9 {
            continue;
        }
        let (V, W) = (random.vector(), random.vector());
        let x = seeded(&Psi);
        if (psi - PI).abs() >= 1e-15 {
            let size = 1.0 + 1.0 / (TAU - psi);
            let D = gradient(&log_quaternion(&quaternion(&x)));
            close("D log q", &D, &M3::identity(), 1e-14 * size * size);
        }
        if psi < 1e-4 {
            continue;
        }
        close("B_s", &B_s(&Psi), &gradient(&complement(&x)), 1e-14);
        let t = Vector3::from_fn(|i, _| Moving::<3>::variable([Psi[i], V[i], W[i]], i));
        let y = complement(&t);
        let rates = |k: usize| M3::from_fn(|i, j| y[i].g[k][j]);
        close("Ḃ_s", &B_s_dot(&V, &Psi), &rates(1), 1e-13);
        close("B̈_s", &B_s_ddot(&W, &V, &Psi), &rates(2), 1e-13);
        let h = complement(&Vector3::from_fn(|i, _| Hess::<3>::coordinate(Psi[i], i)));
        let fy = constant(&V).dot(&h);
        let hessian = M3::from_fn(|i, j| fy.xx[i.max(j)][i.min(j)]);
        close("K_σs", &K_sigma_s(&V, &Psi), &hessian, 1e-13);
    }
}
