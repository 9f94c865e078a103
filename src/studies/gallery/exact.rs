//! Motions of the gallery's models that are known, by Jacobi's elliptic functions.

use crate::studies::compare::{Exact, FrameSample};
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::FRAC_PI_2;

/// The exact motion of a model of the gallery, with its frame nodes by name, if it is known: of
/// `pendulum` and `free_body`.
pub fn exact(model: &str, nodes: &[String]) -> Option<Exact> {
    let position = |name: &str| nodes.iter().position(|node| node == name);
    match model {
        "pendulum" => {
            let [ground, pivot, rod] = [position("ground"), position("pivot"), position("rod")];
            let (pivot, rod) = (pivot?, rod?);
            Some(Exact::new("Jacobi's elliptic functions", move |sample| {
                let [hinge, bob] = pendulum(sample.t);
                sample.nodes[pivot] = hinge;
                sample.nodes[rod] = bob;
                if let Some(ground) = ground {
                    sample.nodes[ground] = FrameSample::at_rest();
                }
                // It starts at rest at height zero.
                sample.energy = 0.0;
                sample.gross_energy = -2.0 * GRAVITY * bob.position.z;
            }))
        }
        "free_body" => {
            let node = position("O")?;
            Some(Exact::new("Jacobi's elliptic functions", move |sample| {
                sample.nodes[node] = free_body(sample.t);
                sample.energy = 0.5 * INERTIA.dot(&SPIN.component_mul(&SPIN));
                sample.gross_energy = sample.energy;
                sample.momenta = [Vector3::zeros(), INERTIA.component_mul(&SPIN)];
            }))
        }
        _ => None,
    }
}

const GRAVITY: f64 = 9.81;

/// The hinge and the bob of the pendulum of length 1, from rest at the horizontal: with θ from the lowest
/// position sin(θ/2) = k sn(K − ωt), k = sin 45°.
fn pendulum(t: f64) -> [FrameSample; 2] {
    let (m, omega) = (0.5_f64, GRAVITY.sqrt());
    let [sn, cn, _] = jacobi(first_kind(FRAC_PI_2, m) - omega * t, m);
    let theta = 2.0 * (m.sqrt() * sn).asin();
    let rate = -2.0 * m.sqrt() * omega * cn;
    let spin = |rate: f64| Vector3::new(0.0, rate, 0.0);
    let (omega, omega_dot) = (spin(rate), spin(-GRAVITY * theta.sin()));
    let position = Vector3::new(-theta.sin(), 0.0, -theta.cos());
    let hinge = FrameSample {
        R: *Rotation3::new(spin(theta - FRAC_PI_2)).matrix(),
        omega,
        omega_dot,
        ..FrameSample::at_rest()
    };
    let velocity = omega.cross(&position);
    let bob = FrameSample {
        position,
        velocity,
        acceleration: omega_dot.cross(&position) + omega.cross(&velocity),
        ..hinge
    };
    [hinge, bob]
}

/// Principal moments of the free body and its angular velocity at the start, which is near the middle
/// axis and on the side of the third: L² > 2 E J₂.
const INERTIA: Vector3<f64> = Vector3::new(1.0, 2.0, 3.0);
const SPIN: Vector3<f64> = Vector3::new(0.1, 10.0, 0.1);

/// Angular velocity in axes of the body over time: Landau & Lifshitz, Mechanics, (37.10).
fn euler() -> impl Fn(f64) -> Vector3<f64> {
    let (J, L2) = (INERTIA, INERTIA.component_mul(&SPIN).norm_squared());
    let E2 = INERTIA.dot(&SPIN.component_mul(&SPIN));
    let (high, low) = (E2 * J.z - L2, L2 - E2 * J.x);
    let size = Vector3::new(
        high / (J.x * (J.z - J.x)),
        high / (J.y * (J.z - J.y)),
        low / (J.z * (J.z - J.x)),
    )
    .map(f64::sqrt);
    let m = (J.y - J.x) * high / ((J.z - J.y) * low);
    // am τ at the start.
    let phase = (SPIN.y / size.y).atan2(SPIN.x / size.x);
    let rate = ((J.z - J.y) * low / (J.x * J.y * J.z)).sqrt();
    let start = first_kind(phase, m);
    move |t| {
        let [sn, cn, dn] = jacobi(rate * t + start, m);
        size.component_mul(&Vector3::new(cn, sn, dn))
    }
}

/// The free body. Its attitude by Euler's angles about the angular momentum L: the nutation and the spin
/// follow from J Ω, the precession is the integral of L (J₁Ω₁² + J₂Ω₂²)/(J₁²Ω₁² + J₂²Ω₂²) (Landau &
/// Lifshitz, (37.14)), found by Gauss's rule.
fn free_body(t: f64) -> FrameSample {
    let euler = euler();
    let L = INERTIA.component_mul(&SPIN).norm();
    let precession = |t: f64| {
        let Omega = euler(t);
        let spins = INERTIA.component_mul(&Omega);
        let energies = spins.component_mul(&Omega);
        L * (energies.x + energies.y) / (spins.x.powi(2) + spins.y.powi(2))
    };
    let parts = (t.abs() / 0.02).ceil().max(1.0) as usize;
    let h = t / parts as f64;
    let angle: f64 = (0..parts)
        .map(|k| {
            let middle = (k as f64 + 0.5) * h;
            let points = GAUSS.map(|(x, w)| w * precession(middle + 0.5 * h * x));
            0.5 * h * points.iter().sum::<f64>()
        })
        .sum();
    let attitude = |Omega: &Vector3<f64>, precession: f64| {
        let l = INERTIA.component_mul(Omega) / L;
        let about_z = |angle: f64| Rotation3::new(Vector3::z() * angle);
        let nutation = Rotation3::new(Vector3::x() * l.x.hypot(l.y).atan2(l.z));
        about_z(precession) * nutation * about_z(l.x.atan2(l.y))
    };
    let Omega = euler(t);
    let R = attitude(&euler(0.0), 0.0).inverse() * attitude(&Omega, angle);
    let Omega_dot = -Omega
        .cross(&INERTIA.component_mul(&Omega))
        .component_div(&INERTIA);
    FrameSample {
        R: *R.matrix(),
        omega: R * Omega,
        omega_dot: R * Omega_dot,
        ..FrameSample::at_rest()
    }
}

/// Gauss's rule of five points on [−1, 1]: positions and weights.
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// F(φ | m), the elliptic integral of the first kind, by the arithmetic-geometric mean and Landen's
/// descending transformation of the angle (Abramowitz & Stegun 17.6); 0 ≤ m < 1.
pub(super) fn first_kind(phi: f64, m: f64) -> f64 {
    let (mut a, mut b, mut phi, mut two) = (1.0, (1.0 - m).sqrt(), phi, 1.0);
    while (a - b).abs() > 1e-16 * a && two < 1e3 {
        // The angle that belongs to tan ψ = (b/a) tan φ, in the same quarter as φ.
        let quarters = (phi / std::f64::consts::PI).round() * std::f64::consts::PI;
        phi += quarters + (b / a * (phi - quarters).tan()).atan();
        (a, b, two) = (0.5 * (a + b), f64::sqrt(a * b), 2.0 * two);
    }
    phi / (two * a)
}

/// sn, cn and dn of u with the parameter m, by the arithmetic-geometric mean (Abramowitz & Stegun 16.4).
fn jacobi(u: f64, m: f64) -> [f64; 3] {
    let (mut a, mut b) = ([1.0; 16], (1.0 - m).sqrt());
    let mut ratio = [0.0; 16];
    let mut n = 0;
    while n + 1 < a.len() && (n == 0 || f64::abs(ratio[n]) > 1e-16) {
        let last = a[n];
        n += 1;
        a[n] = 0.5 * (last + b);
        ratio[n] = 0.5 * (last - b) / a[n];
        b = (last * b).sqrt();
    }
    let mut phi = a[n] * u * f64::from(1_u32 << n);
    for c in ratio[1..=n].iter().rev() {
        phi = 0.5 * (phi + (c * phi.sin()).asin());
    }
    let (sn, cn) = phi.sin_cos();
    [sn, cn, (1.0 - m * sn * sn).sqrt()]
}
