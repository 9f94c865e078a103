//! Shared by the tests of dynamics: runs, spatial quantities, slopes, independent integration.

use nalgebra::{Matrix3, SVector, Vector3};
use pullback::elements::beam::Section;
use pullback::elements::body::RigidBody;
use pullback::elements::joint::{JointNodes, Revolute};
use pullback::elements::model::{
    Context, Dof, Formulation, ModelBuilder, NodeId, NodeState, RigidMotion,
};
use pullback::elements::spring::{CoordinateLaw, CoordinateSpring};
use pullback::elements::time::{Constant, Sine};
use pullback::input::{self, Job, Plan, assemble_text};
use pullback::integrators::dynamics::{
    DynamicOptions, NewtonOptions, Progress, Scheme, State, StepReport, integrate, start,
};
use pullback::manifold::system::{Point, System};
use std::fmt::Display;
use std::ops::ControlFlow;

/// Equal steps of size `h` until `to`, equilibrium nearly to round-off.
pub fn tight(scheme: Scheme, to: f64, h: f64) -> DynamicOptions {
    DynamicOptions {
        scheme,
        newton: NewtonOptions {
            relative: 1e-12,
            ..NewtonOptions::default()
        },
        energies: false,
        ..DynamicOptions::new(to, h)
    }
}

/// All schemes of order 2 that the tests go through.
pub fn second_order() -> [Scheme; 5] {
    [
        Scheme::newmark(0.25, 0.5).unwrap(),
        Scheme::hht(-0.1).unwrap(),
        Scheme::wbz(0.8).unwrap(),
        Scheme::chung_hulbert(0.8).unwrap(),
        Scheme::bathe(2.0 - 2.0_f64.sqrt()).unwrap(),
    ]
}

/// Something with a model inside that can be asked where its nodes are.
pub trait Modelled: System {
    fn model(&mut self) -> &mut Context;
}

impl Modelled for Context {
    fn model(&mut self) -> &mut Context {
        self
    }
}

/// A state as the argument of an evaluation.
pub fn point(state: &State) -> Point<'_> {
    Point {
        t: state.t,
        q: &state.q,
        v: &state.v,
        a: &state.a,
    }
}

/// Brings the model to a state, for questions.
pub fn configure(context: &mut Context, state: &State) {
    context.configure(point(state)).unwrap();
}

/// Runs a system; the observer sees it configured at each accepted step.
pub fn observed<Y: Modelled>(
    system: &mut Y,
    [q, v]: [&[f64]; 2],
    options: &DynamicOptions,
    observe: &mut dyn FnMut(&mut Context, &StepReport<'_>),
) -> Progress {
    let mut progress = Progress::new(start(system, 0.0, q, v).unwrap());
    let watch = &mut |system: &mut Y, step: &StepReport<'_>| {
        configure(system.model(), &step.progress.state);
        observe(system.model(), step);
        ControlFlow::Continue(())
    };
    integrate(system, &mut progress, options, watch).unwrap();
    assert_eq!(progress.summary.failed, 0, "steps were halved");
    progress
}

/// Spatial states of `nodes` at `count` equidistant times, all of them ends of steps, and the run.
pub fn history<Y: Modelled>(
    system: &mut Y,
    nodes: &[NodeId],
    from: [&[f64]; 2],
    options: &DynamicOptions,
    count: usize,
) -> (Vec<NodeState>, Progress) {
    let steps = (options.to / options.step).round() as usize;
    assert_eq!(steps % count, 0);
    let mut out = Vec::new();
    let progress = observed(system, from, options, &mut |model, step| {
        if step.progress.summary.steps % (steps / count) == 0 {
            out.extend(nodes.iter().map(|&n| model.node_state(n)));
        }
    });
    assert_eq!(out.len(), count * nodes.len());
    (out, progress)
}

/// What a node's state consists of, in the fixed frame: nothing here knows of charts.
pub const QUANTITIES: [&str; 5] = [
    "position",
    "rotation",
    "velocity",
    "angular velocity",
    "acceleration",
];

/// Root mean square distance of two histories per quantity of [`QUANTITIES`].
pub fn distances(a: &[NodeState], b: &[NodeState]) -> [f64; 5] {
    assert_eq!(a.len(), b.len());
    let mut sum = [0.0; 5];
    for (a, b) in a.iter().zip(b) {
        for (s, d) in sum.iter_mut().zip([
            (a.position - b.position).norm_squared(),
            (a.R - b.R).norm_squared(),
            (a.velocity - b.velocity).norm_squared(),
            (a.omega - b.omega).norm_squared(),
            (a.acceleration - b.acceleration).norm_squared(),
        ]) {
            *s += d;
        }
    }
    sum.map(|s| (s / a.len() as f64).sqrt())
}

/// Slopes of log error over log h for errors at h, h/2, h/4, ...
pub fn slopes(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect()
}

/// Asserts that the slopes of errors at h, h/2, h/4, ... are within `tolerance` of `order`.
#[track_caller]
pub fn assert_order(what: impl Display, errors: &[f64], order: f64, tolerance: f64) {
    let slopes = slopes(errors);
    let near = slopes.iter().all(|slope| (slope - order).abs() < tolerance);
    assert!(near, "{what}: errors {errors:?} have the slopes {slopes:?}");
}

/// Asserts the same of every quantity.
#[track_caller]
pub fn assert_slopes(what: &str, names: &[&str], errors: &[Vec<f64>], order: f64, tolerance: f64) {
    for (k, name) in names.iter().enumerate() {
        let e: Vec<f64> = errors.iter().map(|e| e[k]).collect();
        assert_order(format!("{what}, {name}"), &e, order, tolerance);
    }
}

/// Order of convergence of `history` (a function of the number of steps) against a fine solution.
///
/// The fine solution is Richardson's extrapolation from n and 2n steps; before it counts, the
/// solutions with n/2, n and 2n steps have to agree to order 2 with each other.
pub fn richardson(n: usize, history: &mut dyn FnMut(usize) -> Vec<NodeState>) -> Vec<NodeState> {
    let [coarse, medium, fine] = [n / 2, n, 2 * n].map(history);
    let errors = [distances(&coarse, &medium), distances(&medium, &fine)].map(Vec::from);
    assert_slopes("the reference itself", &QUANTITIES, &errors, 2.0, 0.05);
    let towards = |a: &Vector3<f64>, b: &Vector3<f64>| b + (b - a) / 3.0;
    let pairs = medium.iter().zip(&fine);
    pairs
        .map(|(a, b)| NodeState {
            position: towards(&a.position, &b.position),
            R: b.R + (b.R - a.R) / 3.0,
            velocity: towards(&a.velocity, &b.velocity),
            omega: towards(&a.omega, &b.omega),
            acceleration: towards(&a.acceleration, &b.acceleration),
            ..*b
        })
        .collect()
}

/// A body with three different moments of inertia, centre of mass at `center` from its node, and
/// its weight along −e3.
pub fn heavy_body(b: &mut ModelBuilder, name: &str, node: NodeId, mass: f64, center: [f64; 3]) {
    let J = Matrix3::new(0.3, 0.02, 0.03, 0.02, 0.4, -0.04, 0.03, -0.04, 0.5) * mass;
    let made = RigidBody::new(mass, J, center.into()).unwrap();
    body(b, name, node, made);
}

/// A rigid body and its weight of 9.81 per mass along −e3.
pub fn body(b: &mut ModelBuilder, name: &str, node: NodeId, body: RigidBody) {
    weighed(b, name, node, body, [0.0, 0.0, -9.81]);
}

/// A rigid body and its weight.
pub fn weighed(b: &mut ModelBuilder, name: &str, node: NodeId, body: RigidBody, g: [f64; 3]) {
    let weight = body.weight(g, Constant(1.0));
    b.element(name, body, &[node]).unwrap();
    let name = format!("weight of {name}");
    b.element(name, weight, &[node]).unwrap();
}

/// A linear spring at a coordinate.
pub fn spring(b: &mut ModelBuilder, k: f64, coordinate: NodeId) {
    let law = CoordinateLaw {
        k,
        ..CoordinateLaw::default()
    };
    let spring = CoordinateSpring::new(law).unwrap();
    b.element("spring", spring, &[coordinate]).unwrap();
}

/// A section of which no vibration is too fast to be resolved, its stiffness times a factor.
pub fn soft(stiff: f64) -> Section {
    let [EA, GA, GJ, EI2, EI3] = [60.0, 30.0, 4.0, 4.0, 6.0].map(|k| k * stiff);
    let J = Matrix3::from_diagonal(&Vector3::new(0.2, 0.1, 0.1));
    let section = Section::diagonal(EA, [GA; 2], GJ, [EI2, EI3]);
    section.unwrap().with_mass(1.0, J).unwrap()
}

/// A builder, and a node at the origin that is held.
pub fn grounded() -> (ModelBuilder, NodeId) {
    let mut b = ModelBuilder::new();
    let ground = ground(&mut b);
    (b, ground)
}

/// A node at the origin that is held.
pub fn ground(b: &mut ModelBuilder) -> NodeId {
    let ground = b.node("ground", [0.0; 3]).unwrap();
    b.support(ground, &Dof::ALL);
    ground
}

/// A frame on a revolute joint, and its angle.
pub fn revolute(b: &mut ModelBuilder, name: &str, parent: NodeId, axis: [f64; 3]) -> JointNodes {
    let joint = Revolute::new(axis).unwrap();
    b.attach(name, parent, joint).unwrap()
}

/// The context at the start of a model in time, its initial state and the options of its analysis.
pub fn motion_of(text: &str) -> (Context, State, DynamicOptions) {
    let job = assemble_text("model.toml", text).unwrap();
    let Plan::Dynamic(plan) = job.plan else {
        panic!("a motion");
    };
    let first = start(&job.context, 0.0, &job.start.q, &job.start.v).unwrap();
    (job.context, first, plan.options)
}

/// The model of a text in a formulation.
pub fn formulated(text: &str, formulation: Formulation) -> Job {
    let file = input::parse("model.toml", text).unwrap();
    input::job("model.toml", &file, Some(formulation)).unwrap()
}

/// The rates of all unknowns at a configuration where the whole turns about the origin.
pub fn turning(context: &mut Context, q: &[f64], omega: Vector3<f64>) -> Vec<f64> {
    let motion = RigidMotion {
        omega,
        ..RigidMotion::default()
    };
    moving(context, q, &motion)
}

/// The rates of all unknowns at a configuration in a rigid motion of the whole.
pub fn moving(context: &mut Context, q: &[f64], motion: &RigidMotion) -> Vec<f64> {
    let mut v = vec![0.0; q.len()];
    context.set_velocity(q, &mut v, None, motion);
    v
}

pub fn sine(amplitude: f64, omega: f64, phase: f64) -> Sine {
    Sine {
        amplitude,
        omega,
        phase,
        offset: 0.0,
    }
}

/// Integrates ẏ = f(t, y) from 0 to `to` in `n` steps of the classical Runge–Kutta method.
pub fn integrate_ode<const N: usize>(
    f: &dyn Fn(f64, &SVector<f64, N>) -> SVector<f64, N>,
    mut y: SVector<f64, N>,
    to: f64,
    n: usize,
) -> SVector<f64, N> {
    let h = to / n as f64;
    for k in 0..n {
        let t = k as f64 * h;
        let k1 = f(t, &y);
        let k2 = f(t + 0.5 * h, &(y + k1 * (0.5 * h)));
        let k3 = f(t + 0.5 * h, &(y + k2 * (0.5 * h)));
        let k4 = f(t + h, &(y + k3 * h));
        y += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0);
    }
    y
}
