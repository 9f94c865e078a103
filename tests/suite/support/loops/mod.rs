//! Shared by the tests of closed loops: bars on pins, runs that watch the constraint.

pub mod four_bar;
pub mod linkage;

use crate::support::dynamics::*;
use crate::support::prelude::*;

pub const G: f64 = 9.81;

pub fn ground(b: &mut ModelBuilder) -> NodeId {
    let ground = b.node("ground", [0.0; 3]).unwrap();
    b.support(ground, &Dof::ALL);
    ground
}

/// Weight along −e2 of whatever can be weighed.
pub const DOWN: [f64; 3] = [0.0, -G, 0.0];

/// A uniform bar of length l along e1 where its angle is zero, on a pin at `position`.
pub fn bar(
    b: &mut ModelBuilder,
    on: NodeId,
    position: [f64; 3],
    angle: NodeId,
    l: f64,
    m: f64,
) -> NodeId {
    let name = format!("bar at {}", b.node_name(angle));
    let pin = b.offset(format!("pin of {name}"), on, position).unwrap();
    let hinge = Revolute::new([0.0, 0.0, 1.0]).unwrap();
    let frame = b.add_joint_frame(name.clone(), pin, hinge, &[angle]);
    let frame = frame.unwrap();
    let J = Matrix3::from_diagonal(&Vector3::new(0.0, 1.0, 1.0)) * (m * l * l / 12.0);
    let body = RigidBody::new(m, J, Vector3::new(0.5 * l, 0.0, 0.0)).unwrap();
    weighed(b, &name, frame, body, DOWN);
    frame
}

pub fn pick<const X: usize>(b: &mut ModelBuilder, x: NodeId, k: usize, kind: Quantity) -> NodeId {
    let map = Linear::<X, 1>::pick(k, 0.0).boxed();
    b.mapped_coordinates(format!("x{k}"), &[kind], map, &[x])
        .unwrap()
}

/// What a run leaves behind.
pub struct Run {
    /// x and ẋ at the end.
    pub end: Vec<f64>,
    /// Largest change of the energy.
    pub drift: f64,
    /// Largest residual of the constraint on the way.
    pub residual: f64,
    /// What the map said of itself, and from when on.
    pub notes: Vec<(f64, String)>,
    pub progress: Progress,
}

/// Runs a model whose loop coordinates are those of the node `x`.
pub fn run<const X: usize>(
    mut context: Context,
    x: NodeId,
    velocity: &[f64],
    h: &dyn Fn(&SVector<f64, X>) -> f64,
    [to, step]: [f64; 2],
) -> Run {
    let zero = vec![0.0; context.pattern().dim()];
    let mut options = tight(Scheme::default(), to, step);
    options.newton.absolute = 1e-13;
    let mut notes: Vec<(f64, String)> = context.describe(x).map(|n| (0.0, n)).into_iter().collect();
    let (mut end, mut residual, mut drift) = (Vec::new(), 0.0_f64, 0.0_f64);
    let mut start = None;
    let progress = observed(
        &mut context,
        [&zero, velocity],
        &options,
        &mut |context, step| {
            let both: [[f64; 2]; X] = std::array::from_fn(|k| context.coordinate(x, k).unwrap());
            residual = residual.max(h(&SVector::from_fn(|k, _| both[k][0])));
            end = (0..2 * X).map(|k| both[k % X][k / X]).collect();
            let note = context.describe(x).unwrap();
            if notes.last().is_none_or(|last| last.1 != note) {
                notes.push((step.progress.state.t, note));
            }
            let at = point(&step.progress.state);
            let audit = context.energies_and_momentum(at).unwrap();
            let energy = audit.energies.kinetic + audit.energies.stored + audit.load_potential;
            drift = drift.max((energy - *start.get_or_insert(energy)).abs());
        },
    );
    Run {
        end,
        drift,
        residual,
        notes,
        progress,
    }
}

pub fn gap(found: &[f64], exact: &[f64]) -> f64 {
    assert_eq!(found.len(), exact.len());
    let gaps = found.iter().zip(exact).map(|(a, b)| (a - b).abs());
    gaps.fold(0.0, f64::max)
}

/// Accelerations of one coordinate: M θ̈ + ½ M′ θ̇² + V′ = 0.
pub fn one_freedom(M: Moving<0>, V: Moving<0>, rate: f64) -> f64 {
    -(0.5 * M.x[1] * rate * rate + V.x[1]) / M.x[0]
}
