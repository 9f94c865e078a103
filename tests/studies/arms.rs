//! The robot arms of the gallery solved by other means: the numbers that it compares with.
//!
//! Reissner's beam with the forces on faces halfway between nodes balanced around the nodes, where all
//! inertia sits, quaternions, and the classical Runge-Kutta method. Nothing is shared with the program:
//! no shape function, no rotation vector, no chart, no tangent, no joint map.

use crate::support::extrapolated;
use crate::support::independent::{assert_published, rows};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// Position, velocity, orientation and angular velocity in axes of the body, or the rates of these.
#[derive(Clone, Copy)]
struct Node {
    x: Vector3<f64>,
    v: Vector3<f64>,
    p: Quaternion<f64>,
    omega: Vector3<f64>,
}

/// Two links of length 5 along e1, of equal elements; the last node of the first and the first node of
/// the second are one position.
struct Arm {
    /// Elements of a link.
    elements: usize,
    /// Whether the second link turns about e3 of the first only.
    revolute: bool,
}

const LINK: f64 = 5.0;
const AXIAL: f64 = 1e6;
const BENDING: f64 = 1e5;

fn inertia() -> Vector3<f64> {
    Vector3::new(2.0, 1.0, 1.0)
}

impl Arm {
    fn start(&self) -> Vec<Node> {
        let nodes = (0..2).flat_map(|link| (0..=self.elements).map(move |k| (link, k)));
        let position =
            |(link, k): (usize, usize)| LINK * (link as f64 + k as f64 / self.elements as f64);
        let at_rest = |x: f64| Node {
            x: Vector3::new(x, 0.0, 0.0),
            v: Vector3::zeros(),
            p: Quaternion::identity(),
            omega: Vector3::zeros(),
        };
        nodes.map(position).map(at_rest).collect()
    }

    /// Turns and lifts the base.
    fn drive(nodes: &mut [Node], t: f64) {
        let angle = 3.0 * t.min(0.5);
        nodes[0].x = Vector3::new(0.0, 0.0, 2.0 * angle);
        nodes[0].p = *UnitQuaternion::from_scaled_axis(Vector3::z() * angle).quaternion();
    }

    /// Rates of all nodes but the driven one.
    fn rates(&self, nodes: &[Node]) -> Vec<Node> {
        let l = LINK / self.elements as f64;
        let n = self.elements + 1;
        let mut force = vec![Vector3::zeros(); 2 * n];
        let mut moment = force.clone();
        for a in (0..2 * n - 1).filter(|a| *a != n - 1) {
            let b = a + 1;
            let [p, q] = [a, b].map(|k| UnitQuaternion::from_quaternion(nodes[k].p));
            let relative = p.inverse() * q;
            let K = relative.scaled_axis() / l;
            let middle = p.nlerp(&q, 0.5);
            let chord = nodes[b].x - nodes[a].x;
            let strain = middle.inverse() * chord / l - Vector3::x();
            let N = middle * (strain * AXIAL);
            let M = middle * (K * BENDING);
            let lever = 0.5 * chord.cross(&N);
            force[a] += N;
            force[b] -= N;
            moment[a] += M + lever;
            moment[b] -= M - lever;
        }
        // Nodes at the ends of links have half a cell.
        let ends = [0, n - 1, n, 2 * n - 1];
        let size = |k: usize| if ends.contains(&k) { 0.5 * l } else { l };
        let mut rates: Vec<Node> = (0..2 * n)
            .map(|k| {
                let Node { v, p, omega, .. } = nodes[k];
                let J = inertia() * size(k);
                let turn = UnitQuaternion::from_quaternion(p);
                let rest = turn.inverse() * moment[k] - omega.cross(&J.component_mul(&omega));
                Node {
                    x: v,
                    v: force[k] / size(k),
                    p: p * Quaternion::from_imag(omega) * 0.5,
                    omega: rest.component_div(&J),
                }
            })
            .collect();
        // The halves of one position move together.
        let (one, two) = (n - 1, n);
        let shared = 0.5 * (rates[one].v + rates[two].v);
        [rates[one].v, rates[two].v] = [shared; 2];
        if self.revolute {
            let J = inertia() * (0.5 * l);
            [rates[one].omega, rates[two].omega] = hinged(
                J,
                [&nodes[one], &nodes[two]],
                [one, two].map(|k| rates[k].omega.component_mul(&J)),
            );
        }
        rates[0] = Node {
            x: Vector3::zeros(),
            v: Vector3::zeros(),
            p: Quaternion::from_parts(0.0, Vector3::zeros()),
            omega: Vector3::zeros(),
        };
        rates
    }

    /// Displacement of the tip at t = 1, 2 and 3.
    fn tips(&self) -> Vec<Vector3<f64>> {
        // The highest frequency is 400 `elements`, so that the limit of the method is 141 `elements` steps; the jerk
        // at t = 0.5 and all times are ends of steps.
        let per_second = 200 * self.elements;
        let h = 1.0 / per_second as f64;
        let mut nodes = self.start();
        let along = |s: &[Node], d: &[Node], h: f64, t: f64| {
            let sum = |(s, d): (&Node, &Node)| Node {
                x: s.x + d.x * h,
                v: s.v + d.v * h,
                p: s.p + d.p * h,
                omega: s.omega + d.omega * h,
            };
            let mut moved: Vec<Node> = s.iter().zip(d).map(sum).collect();
            Self::drive(&mut moved, t);
            moved
        };
        let mut tips = Vec::new();
        for k in 0..3 * per_second {
            let t = h * k as f64;
            let k1 = self.rates(&nodes);
            let k2 = self.rates(&along(&nodes, &k1, 0.5 * h, t + 0.5 * h));
            let k3 = self.rates(&along(&nodes, &k2, 0.5 * h, t + 0.5 * h));
            let k4 = self.rates(&along(&nodes, &k3, h, t + h));
            for (part, rates) in [(6.0, k1), (3.0, k2), (3.0, k3), (6.0, k4)] {
                nodes = along(&nodes, &rates, h / part, t + h);
            }
            if (k + 1) % per_second == 0 {
                tips.push(nodes[nodes.len() - 1].x - Vector3::x() * (2.0 * LINK));
            }
        }
        tips
    }
}

/// Accelerations of two halves that share the axis e3, from the moments on them (in axes of each,
/// gyroscopic ones taken off). With Q = R₁ᵀR₂ and the rate r about the axis,
/// Ω̇₂ = Qᵀ Ω̇₁ − r e3 × QᵀΩ₁ + ṙ e3; nothing but the axis is free of the moment between them.
fn hinged(J: Vector3<f64>, nodes: [&Node; 2], moments: [Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
    let e3 = Vector3::z();
    let [R, S] = nodes.map(|s| UnitQuaternion::from_quaternion(s.p).to_rotation_matrix());
    let Q = (R.inverse() * S).into_inner();
    let [first, second] = moments;
    let rate = (nodes[1].omega - nodes[0].omega).z;
    let c = -rate * e3.cross(&(Q.transpose() * nodes[0].omega));
    let J = Matrix3::from_diagonal(&J);
    let both = J + Q * J * Q.transpose() - e3 * e3.transpose() * J[(2, 2)];
    let moment = first + Q * (second - J * c) - e3 * second.z;
    let one = both.lu().solve(&moment).unwrap();
    let other = Q.transpose() * one + c;
    // About the axis the second half follows its own moment alone.
    [one, Vector3::new(other.x, other.y, second.z / J[(2, 2)])]
}

fn compare(case: &str, revolute: bool) {
    let [coarse, fine] = [40, 80].map(|elements| Arm { elements, revolute }.tips());
    let rows = rows(case);
    for (k, t) in [1, 2, 3].into_iter().enumerate() {
        let limit = extrapolated(coarse[k].into(), fine[k].into());
        // The gallery has three decimals of it.
        assert_published(&rows, &format!("tip at t = {t},"), &limit, 1e-3);
    }
}

#[test]
fn the_numbers_of_the_spherical_arm() {
    compare("arm-spherical", false);
}

#[test]
fn the_numbers_of_the_revolute_arm() {
    compare("arm-revolute", true);
}
