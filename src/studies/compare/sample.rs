//! Samples of runs: spatial quantities, independent of charts.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use pullback_elements::model::{Context, NodeState};
use pullback_manifold::so3;
use pullback_manifold::system::{Point, SystemError};
use serde::ser::{Serialize, Serializer};

/// A quantity whose error is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorQuantity {
    /// Positions of nodes, a length.
    Position,
    /// Rotations of nodes: the angle of the relative rotation, in radians.
    Rotation,
    /// Velocities of nodes.
    Velocity,
    /// Angular velocities of nodes, global components.
    AngularVelocity,
    /// Accelerations of nodes.
    Acceleration,
    /// Rates of the angular velocities of nodes, global components.
    AngularAcceleration,
    /// Kinetic and stored energy, and the potential of the loads that have one.
    Energy,
}

/// Number of quantities.
pub(super) const QUANTITIES: usize = 7;

impl ErrorQuantity {
    /// All of them, in the order of [`Values`].
    pub const ALL: [Self; QUANTITIES] = [
        Self::Position,
        Self::Rotation,
        Self::Velocity,
        Self::AngularVelocity,
        Self::Acceleration,
        Self::AngularAcceleration,
        Self::Energy,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        [
            "position",
            "rotation",
            "velocity",
            "angular velocity",
            "acceleration",
            "angular acceleration",
            "energy",
        ][self as usize]
    }

    /// Its key in CSV and JSON.
    pub fn key(self) -> String {
        self.name().replace(' ', "_")
    }
}

/// A value per [`ErrorQuantity`]; unknown ones are NaN, and null in JSON.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Values<T = f64>(pub [T; QUANTITIES]);

impl<T: Copy> Values<T> {
    /// That of a quantity.
    pub fn of(&self, quantity: ErrorQuantity) -> T {
        self.0[quantity as usize]
    }

    /// From one value each for positions and rotations, for velocities, and for accelerations. The energy has that of
    /// the positions: errors of velocities due to equations between coordinates are normal to these equations, where
    /// momenta have no component.
    pub fn of_levels([position, velocity, acceleration]: [T; 3]) -> Self {
        Self([
            position,
            position,
            velocity,
            velocity,
            acceleration,
            acceleration,
            position,
        ])
    }
}

impl<T: Copy + Serialize> Serialize for Values<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(ErrorQuantity::ALL.map(|q| (q.key(), self.of(q))))
    }
}

/// A node in motion, global components, independent of charts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameSample {
    /// Position.
    pub position: Vector3<f64>,
    /// Rotation from the reference orientation.
    pub R: Matrix3<f64>,
    /// Velocity.
    pub velocity: Vector3<f64>,
    /// Angular velocity.
    pub omega: Vector3<f64>,
    /// Acceleration.
    pub acceleration: Vector3<f64>,
    /// Rate of the angular velocity.
    pub omega_dot: Vector3<f64>,
}

impl FrameSample {
    /// A frame in its reference position and orientation, at rest.
    pub fn at_rest() -> Self {
        Self::uniform(Vector3::zeros(), Matrix3::identity())
    }

    /// All vectors the same.
    fn uniform(vector: Vector3<f64>, R: Matrix3<f64>) -> Self {
        Self {
            position: vector,
            R,
            velocity: vector,
            omega: vector,
            acceleration: vector,
            omega_dot: vector,
        }
    }
}

impl From<NodeState> for FrameSample {
    fn from(node: NodeState) -> Self {
        Self {
            position: node.position,
            R: node.R,
            velocity: node.velocity,
            omega: node.omega,
            acceleration: node.acceleration,
            omega_dot: node.omega_dot,
        }
    }
}

/// The state of a model at a common time.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Time.
    pub t: f64,
    /// All frame nodes, in the order of their definition.
    pub nodes: Vec<FrameSample>,
    /// Kinetic and stored energy, and the potential of the loads that have one.
    pub energy: f64,
    /// The sum of the magnitudes of these three: the scale of round-off in the energy.
    pub gross_energy: f64,
    /// Defect of the balance of energy so far, if known.
    pub defect: Option<f64>,
    /// Linear momentum, and angular momentum about the origin, global components.
    pub momenta: [Vector3<f64>; 2],
    /// The largest residual |h| of the equations of loops, each relative to its size, if there are any.
    pub violation: Option<f64>,
}

impl Sample {
    /// A sample with nothing known but the time.
    pub fn unknown(t: f64, nodes: usize) -> Self {
        let vector = Vector3::repeat(f64::NAN);
        Self {
            t,
            nodes: vec![FrameSample::uniform(vector, Matrix3::repeat(f64::NAN)); nodes],
            energy: f64::NAN,
            gross_energy: f64::NAN,
            defect: None,
            momenta: [vector; 2],
            violation: None,
        }
    }

    /// Evaluates a model.
    pub(super) fn of(
        context: &mut Context,
        at: Point<'_>,
        defect: Option<f64>,
    ) -> Result<Self, SystemError> {
        let balance = context.energies_and_momentum(at)?;
        let nodes = (context.frames()).map(|(id, _)| context.node_state(id).into());
        let (kinetic, stored) = (balance.energies.kinetic, balance.energies.stored);
        Ok(Self {
            t: at.t,
            nodes: nodes.collect(),
            energy: kinetic + stored + balance.load_potential,
            gross_energy: kinetic + stored.abs() + balance.load_potential.abs(),
            defect,
            momenta: [balance.momentum.linear, balance.momentum.angular],
            violation: context.violation(),
        })
    }
}

/// The angle between two rotations, exact to round-off where it is small: ‖R_a − R_b‖² is
/// 8 sin²(θ/2).
fn angle(a: &FrameSample, b: &FrameSample) -> f64 {
    let half = (a.R - b.R).norm() / 8f64.sqrt();
    // Not `min`, which would hide NaN.
    2.0 * if half > 1.0 { 1.0 } else { half }.asin()
}

fn node_distances(a: &FrameSample, b: &FrameSample) -> [f64; QUANTITIES - 1] {
    [
        (a.position - b.position).norm(),
        angle(a, b),
        (a.velocity - b.velocity).norm(),
        (a.omega - b.omega).norm(),
        (a.acceleration - b.acceleration).norm(),
        (a.omega_dot - b.omega_dot).norm(),
    ]
}

/// Root mean square over common times and nodes of the distances of two runs. Values unknown in one of them
/// are left out; a quantity without any known value is NaN.
pub(super) fn distances(a: &[Sample], b: &[Sample]) -> Values {
    let (mut sum, mut count) = ([0.0; QUANTITIES], [0_usize; QUANTITIES]);
    let mut add = |k: usize, d: f64| {
        if !d.is_nan() {
            sum[k] += d * d;
            count[k] += 1;
        }
    };
    for (a, b) in a.iter().zip(b) {
        for (a, b) in a.nodes.iter().zip(&b.nodes) {
            for (k, d) in node_distances(a, b).into_iter().enumerate() {
                add(k, d);
            }
        }
        add(ErrorQuantity::Energy as usize, a.energy - b.energy);
    }
    Values(std::array::from_fn(|k| (sum[k] / count[k] as f64).sqrt()))
}

/// The largest size of each quantity in a run: the scale of its round-off.
pub(super) fn sizes(samples: &[Sample]) -> Values {
    let mut largest = [0.0_f64; QUANTITIES];
    for sample in samples {
        for n in &sample.nodes {
            let vectors = [n.position, n.velocity, n.omega, n.acceleration, n.omega_dot];
            for (k, size) in [0, 2, 3, 4, 5].into_iter().zip(vectors.map(|x| x.norm())) {
                largest[k] = largest[k].max(size);
            }
        }
        largest[1] = 1.0;
        let energy = &mut largest[ErrorQuantity::Energy as usize];
        *energy = energy.max(sample.gross_energy);
    }
    Values(largest)
}

/// Richardson's extrapolation of two runs of an order p, the second with half the step of the
/// first: b + (b − a)/(2ᵖ − 1), or b itself if p is infinite; rotations are continued by this fraction of the relative
/// rotation. Momenta have the order of velocities.
pub(super) fn extrapolate(a: &[Sample], b: &[Sample], order: Values) -> Vec<Sample> {
    let parts = order.0.map(|p| p.exp2() - 1.0);
    let towards = |k: usize, a: &Vector3<f64>, b: &Vector3<f64>| b + (b - a) / parts[k];
    let node = |(a, b): (&FrameSample, &FrameSample)| {
        let relative =
            UnitQuaternion::from(Rotation3::from_matrix_unchecked(a.R.tr_mul(&b.R))).scaled_axis();
        FrameSample {
            position: towards(0, &a.position, &b.position),
            R: b.R * so3::rotation(&(relative / parts[1])),
            velocity: towards(2, &a.velocity, &b.velocity),
            omega: towards(3, &a.omega, &b.omega),
            acceleration: towards(4, &a.acceleration, &b.acceleration),
            omega_dot: towards(5, &a.omega_dot, &b.omega_dot),
        }
    };
    let samples = a.iter().zip(b).map(|(a, b)| Sample {
        nodes: a.nodes.iter().zip(&b.nodes).map(node).collect(),
        energy: b.energy + (b.energy - a.energy) / parts[ErrorQuantity::Energy as usize],
        momenta: [0, 1].map(|k| towards(2, &a.momenta[k], &b.momenta[k])),
        ..*b
    });
    samples.collect()
}
