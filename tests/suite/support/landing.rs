//! Shared by the tests of landings: beads on polygons of wire, and their exact motions.

use crate::support::prelude::*;

pub const G: f64 = 9.81;

/// Mass of a bead.
pub const MASS: f64 = 1.3;

/// A polygon of wire in a vertical plane, held or moved with a constant velocity.
pub struct Track {
    pub positions: Vec<Vector3<f64>>,
    /// Velocity of all its nodes.
    pub velocity: Vector3<f64>,
}

impl Track {
    /// From the origin, side after side: length, and slope against the horizontal (rad, upwards).
    pub fn of(sides: &[[f64; 2]]) -> Self {
        let mut positions = vec![Vector3::zeros()];
        for [length, slope] in sides {
            let side = Vector3::new(slope.cos(), 0.0, slope.sin()) * *length;
            positions.push(positions[positions.len() - 1] + side);
        }
        let velocity = Vector3::zeros();
        Self {
            positions,
            velocity,
        }
    }

    /// Arc lengths of the corners.
    pub fn corners(&self) -> Vec<f64> {
        let mut s = vec![0.0];
        for pair in self.positions.windows(2) {
            s.push(s[s.len() - 1] + (pair[1] - pair[0]).norm());
        }
        s
    }

    /// Position of arc length s.
    pub fn at(&self, s: f64) -> Vector3<f64> {
        let corners = self.corners();
        let k = corners.partition_point(|c| *c <= s);
        let k = k.clamp(1, corners.len() - 1) - 1;
        let part = (s - corners[k]) / (corners[k + 1] - corners[k]);
        self.positions[k] + (self.positions[k + 1] - self.positions[k]) * part
    }

    /// Its nodes in a model.
    pub fn nodes(&self, b: &mut ModelBuilder, name: &str) -> Vec<NodeId> {
        let nodes = self.positions.iter().enumerate();
        let nodes: Vec<NodeId> = nodes
            .map(|(k, position)| b.node(format!("{name} {k}"), (*position).into()).unwrap())
            .collect();
        for &node in &nodes {
            b.support(node, &Dof::ROTATIONS);
            for (k, dof) in [Dof::X, Dof::Y, Dof::Z].into_iter().enumerate() {
                b.prescribe(node, dof, Proportional(self.velocity[k]));
            }
        }
        nodes
    }

    /// A model of heavy beads that start at these arc lengths.
    pub fn model(&self, starts: &[f64]) -> (Context, Vec<JointNodes>) {
        let mut b = ModelBuilder::new();
        let nodes = self.nodes(&mut b, "wire");
        let beads = starts.iter().enumerate();
        let beads = beads
            .map(|(k, start)| bead(&mut b, &format!("bead {k}"), &nodes, *start))
            .collect();
        (Context::new(b.build().unwrap()), beads)
    }

    /// Tangential accelerations of its sides under its weight.
    fn pulls(&self) -> Vec<f64> {
        let rise = |p: &[Vector3<f64>]| (p[1].z - p[0].z) / (p[1] - p[0]).norm();
        self.positions.windows(2).map(|p| -G * rise(p)).collect()
    }

    /// Arc length and its rate at time t of a bead that starts at s with rate v: parabolas from corner
    /// to corner, over which it goes with the same speed.
    pub fn exact(&self, s: f64, v: f64, t: f64) -> Vector2<f64> {
        let (corners, pulls) = (self.corners(), self.pulls());
        let (mut s, mut v, mut left) = (s, v, t);
        let mut k = corners.partition_point(|c| *c <= s).clamp(1, pulls.len()) - 1;
        if s == corners[k] && k > 0 && (v < 0.0 || (v == 0.0 && pulls[k] < 0.0)) {
            k -= 1;
        }
        loop {
            let a = pulls[k];
            // The first time at which it leaves the side at either end, moving outwards.
            let out = [-1.0, 1.0].map(|sign| {
                let way = sign * (corners[k + usize::from(sign > 0.0)] - s);
                let (v, a) = (sign * v, sign * a);
                let speed = (v * v + 2.0 * a * way).sqrt();
                let time = if v > 0.0 {
                    2.0 * way / (v + speed)
                } else if a > 0.0 {
                    (speed - v) / a
                } else {
                    f64::INFINITY
                };
                (if time >= 0.0 { time } else { f64::INFINITY }, speed)
            });
            let up = out[1].0 < out[0].0;
            let (time, speed) = out[usize::from(up)];
            if time >= left {
                return Vector2::new(s + left * (v + 0.5 * a * left), v + a * left);
            }
            left -= time;
            (s, v) = (
                corners[k + usize::from(up)],
                if up { speed } else { -speed },
            );
            k = if up { k + 1 } else { k - 1 };
        }
    }
}

/// A heavy point mass that slides over these nodes.
pub fn bead(b: &mut ModelBuilder, name: &str, nodes: &[NodeId], start: f64) -> JointNodes {
    let bead = b.slide(name, nodes, start, Interpolation::Total).unwrap();
    let mass = PointMass::new(MASS).unwrap();
    let weight = mass.weight([0.0, 0.0, -G], Constant(1.0));
    b.element(format!("mass of {name}"), mass, &[bead.frame])
        .unwrap();
    b.element(format!("weight of {name}"), weight, &[bead.frame])
        .unwrap();
    bead
}

/// Sides of half a metre, each steeper than the one before.
pub fn bowl() -> Track {
    Track::of(&[[0.5, 0.2], [0.5, 0.35], [0.5, 0.6], [0.5, 0.9]])
}
