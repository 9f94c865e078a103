//! The bent coupler and the bent rod of the gallery solved by other means: the numbers that it compares with.
//!
//! Reissner's rod in its plane with the forces on faces halfway between nodes balanced around the nodes,
//! where all inertia sits. An end rides on a crank, a rocker or a slider, whose angle or way is its only
//! coordinate besides its own angle: no constraint is left. As no force depends on velocities, Nyström's
//! method of order four. Nothing is shared with the program: no shape function, no quadrature, no chart, no
//! tangent, no joint map, no integrator.

use crate::support::extrapolated;
use crate::support::independent::{assert_published, rows};
use std::array::from_fn;
use std::f64::consts::{FRAC_PI_2, TAU};

const AXIAL: f64 = 1e6;
const SHEAR: f64 = 4e5;
const BENDING: f64 = 100.0;
const MASS: f64 = 1.0;
const INERTIA: f64 = 1e-4;
const G: f64 = 9.81;

/// Position and angle of a node; of the first and the last node the coordinate of what carries it, nothing, and
/// the angle.
type Node = [f64; 3];

/// What carries the two ends of a rod, by a coordinate each.
trait Carriers {
    /// The coordinates at the start.
    const START: [f64; 2];

    /// Positions of the ends.
    fn positions(t: f64, u: [f64; 2]) -> [[f64; 2]; 2];

    /// Second derivatives of the coordinates where the rod pulls with these forces and leaves its end
    /// this mass.
    fn rates(u: [f64; 2], forces: [[f64; 2]; 2], mass: f64) -> [f64; 2];
}

/// A crank of length and inertia about its axis, turned by a force at its end and its own weight.
fn turned([x, y]: [f64; 2], angle: f64, length: f64, [own, end]: [f64; 2]) -> f64 {
    let (s, c) = angle.sin_cos();
    let moment = (c * y - s * x - 0.5 * own * G * c) * length;
    moment / ((own / 3.0 + end) * length * length)
}

/// A four-bar linkage: uniform crank and rocker.
struct FourBar;

const CRANK: f64 = 1.0;
/// The rocker goes from (1.6, 0) to (1.2, 1.9).
const ROCKER: f64 = 1.941_648_783_894_76;

impl Carriers for FourBar {
    /// Minus 0.4 is the cosine of the second times the rocker's length.
    const START: [f64; 2] = [FRAC_PI_2, 1.778_292_553_230_099_3];

    fn positions(_: f64, [crank, rocker]: [f64; 2]) -> [[f64; 2]; 2] {
        let [(s, c), (t, d)] = [crank.sin_cos(), rocker.sin_cos()];
        [[CRANK * c, CRANK * s], [1.6 + ROCKER * d, ROCKER * t]]
    }

    fn rates([crank, rocker]: [f64; 2], [first, last]: [[f64; 2]; 2], mass: f64) -> [f64; 2] {
        [
            turned(first, crank, CRANK, [2.0, mass]),
            turned(last, rocker, ROCKER, [1.2, mass]),
        ]
    }
}

/// A slider-crank mechanism whose crank is run up from rest to 12 within 1.
struct SliderCrank;

impl Carriers for SliderCrank {
    const START: [f64; 2] = [0.0, 1.4];

    fn positions(t: f64, [_, way]: [f64; 2]) -> [[f64; 2]; 2] {
        let angle = if t < 1.0 {
            12.0 * (0.5 * t * t + ((TAU * t).cos() - 1.0) / (TAU * TAU))
        } else {
            12.0 * (t - 0.5)
        };
        [[0.4 * angle.cos(), 0.4 * angle.sin()], [way, 0.0]]
    }

    fn rates(_: [f64; 2], [_, last]: [[f64; 2]; 2], mass: f64) -> [f64; 2] {
        [0.0, last[0] / (0.8 + mass)]
    }
}

/// Nodes with their places, where the ends are.
fn placed<C: Carriers>(t: f64, nodes: &[Node]) -> Vec<Node> {
    let mut placed = nodes.to_vec();
    let n = nodes.len() - 1;
    let ends = C::positions(t, [nodes[0][0], nodes[n][0]]);
    for (k, [x, y]) in [(0, ends[0]), (n, ends[1])] {
        [placed[k][0], placed[k][1]] = [x, y];
    }
    placed
}

/// Second derivatives of all nodes' coordinates; `l` is the length of an element.
fn rates<C: Carriers>(t: f64, nodes: &[Node], l: f64) -> Vec<Node> {
    let x = placed::<C>(t, nodes);
    let n = nodes.len() - 1;
    let mut f = vec![[0.0; 3]; n + 1];
    for a in 0..n {
        let b = a + 1;
        let [dx, dy] = from_fn(|i| x[b][i] - x[a][i]);
        let (s, c) = (0.5 * (x[a][2] + x[b][2])).sin_cos();
        let N = AXIAL * ((c * dx + s * dy) / l - 1.0);
        let Q = SHEAR * (c * dy - s * dx) / l;
        let M = BENDING * (x[b][2] - x[a][2]) / l;
        let (fx, fy) = (c * N - s * Q, s * N + c * Q);
        let lever = 0.5 * (dx * fy - dy * fx);
        for (k, sign) in [(a, 1.0), (b, -1.0)] {
            f[k][0] += sign * fx;
            f[k][1] += sign * fy;
            f[k][2] += sign * M + lever;
        }
    }
    // Nodes at the ends have half a cell.
    let size = |k: usize| if k == 0 || k == n { 0.5 * l } else { l };
    for (k, [fx, fy, m]) in f.iter_mut().enumerate() {
        let mass = MASS * size(k);
        *fy -= mass * G;
        *m /= INERTIA * size(k);
        if k != 0 && k != n {
            (*fx, *fy) = (*fx / mass, *fy / mass);
        }
    }
    let forces = [f[0], f[n]].map(|[x, y, _]| [x, y]);
    let ends = C::rates([nodes[0][0], nodes[n][0]], forces, MASS * 0.5 * l);
    for (k, rate) in [(0, ends[0]), (n, ends[1])] {
        [f[k][0], f[k][1]] = [rate, 0.0];
    }
    f
}

/// Position of the far end, and how far the middle is to the left of the line between the ends, at these times.
fn motion<C: Carriers>(elements: usize, times: [f64; 3]) -> [[f64; 3]; 3] {
    let [a, b] = C::positions(0.0, C::START);
    let [dx, dy] = from_fn(|i| b[i] - a[i]);
    let l = dx.hypot(dy) / elements as f64;
    let along = |k: usize| {
        let s = k as f64 / elements as f64;
        [a[0] + s * dx, a[1] + s * dy, dy.atan2(dx)]
    };
    let mut q: Vec<Node> = (0..=elements).map(along).collect();
    for (k, start) in [(0, C::START[0]), (elements, C::START[1])] {
        [q[k][0], q[k][1]] = [start, 0.0];
    }
    let mut v = vec![[0.0; 3]; elements + 1];
    // A wave passes 0.8 elements of the stiffest kind in a step, with all times ends of steps.
    let per_second = 1024 * elements;
    let h = 1.0 / per_second as f64;
    let moved = |q: &[Node], v: &[Node], a: &[Node], h: f64, g: f64| -> Vec<Node> {
        let all = q.iter().zip(v).zip(a);
        all.map(|((q, v), a)| from_fn(|i| q[i] + h * v[i] + g * a[i]))
            .collect()
    };
    let mut found = [[f64::NAN; 3]; 3];
    for step in 1..=(times[2] * per_second as f64) as usize {
        let t = (step - 1) as f64 * h;
        let k1 = rates::<C>(t, &q, l);
        let k2 = rates::<C>(t + 0.5 * h, &moved(&q, &v, &k1, 0.5 * h, h * h / 8.0), l);
        let k3 = rates::<C>(t + h, &moved(&q, &v, &k2, h, 0.5 * h * h), l);
        for k in 0..=elements {
            for i in 0..3 {
                q[k][i] += h * v[k][i] + h * h / 6.0 * (k1[k][i] + 2.0 * k2[k][i]);
                v[k][i] += h / 6.0 * (k1[k][i] + 4.0 * k2[k][i] + k3[k][i]);
            }
        }
        for (found, time) in found.iter_mut().zip(times) {
            if step == (time * per_second as f64) as usize {
                let x = placed::<C>(time, &q);
                let (a, b, middle) = (x[0], x[elements], x[elements / 2]);
                let [dx, dy] = from_fn(|i| b[i] - a[i]);
                let [rx, ry] = from_fn(|i| middle[i] - a[i]);
                *found = [b[0], b[1], (dx * ry - dy * rx) / dx.hypot(dy)];
            }
        }
    }
    found
}

/// Values at no size of elements. With 64 and 128 elements they are within 4e-6 of those with 128 and 192;
/// the gallery has six decimals of them.
fn compare<C: Carriers>(case: &str, times: [f64; 3], [what, part]: [&str; 2], positions: usize) {
    let [coarse, fine] = [64, 128].map(|elements| motion::<C>(elements, times));
    let rows = rows(case);
    for (k, t) in times.into_iter().enumerate() {
        let limit = extrapolated(coarse[k], fine[k]);
        let what = format!("{what} at t = {t}, bent {part}");
        assert_published(&rows, &what, &limit[..positions], 5e-6);
        let middle = format!("middle off the line between the ends at t = {t}");
        assert_published(&rows, &middle, &limit[2..], 5e-6);
    }
}

#[test]
fn the_numbers_of_the_bent_coupler() {
    compare::<FourBar>("four-bar-flexible", [0.5, 1.25, 2.0], ["tip", "coupler"], 2);
}

#[test]
fn the_numbers_of_the_bent_rod() {
    compare::<SliderCrank>(
        "slider-crank-flexible",
        [0.5, 1.0, 2.0],
        ["slider", "rod"],
        1,
    );
}
