//! Initial conditions of the file as vectors of the model.

mod requests;
mod values;
mod velocities;

use super::file::Initial;
use super::parts::Assembly;
use super::{InputError, InputProblem, Location, settings};
use nalgebra::Vector3;
use pullback_elements::model::{Context, NodeId};
use pullback_integrators::dynamics::{self as integrator, DynamicsError, Progress};
use pullback_integrators::statics::{Step, StepParameter, solve_statics};
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use velocities::Velocities;

/// Tolerance of velocities, relative to the largest.
const VELOCITY_TOLERANCE: f64 = 1e-9;

/// Coordinates and velocities at the start.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Start {
    /// Coordinates.
    pub q: Vec<f64>,
    /// Velocities.
    pub v: Vec<f64>,
    /// Number of unstable directions, in an equilibrium.
    pub unstable: Option<usize>,
}

impl Start {
    /// The beginning of a motion from here.
    pub(crate) fn motion(&self, context: &Context) -> Result<Progress, DynamicsError> {
        integrator::start(context, 0.0, &self.q, &self.v).map(Progress::new)
    }
}

pub(super) fn start(assembly: &Assembly<'_>, context: &mut Context) -> Result<Start, InputError> {
    let file = assembly.file;
    let mut q = context.initial().to_vec();
    // All positions come before all velocities, whatever their order in the file.
    let (mut entries, mut placed) = (Vec::new(), Vec::new());
    for (k, initial) in file.initial.iter().enumerate() {
        let at = assembly.at("initial").at(k);
        check(&at, initial)?;
        let node = match &initial.node {
            Some(name) => Some(assembly.nodes.find(&at.at("node"), name)?),
            None => None,
        };
        if let Some(node) = node {
            check_attached(&at, context, node, initial)?;
            position(&at, context, node, initial, &mut q)?;
            for (given, of) in [
                (initial.displacement, [true, false]),
                (initial.rotation, [false, true]),
            ] {
                let unknowns = requests::unknowns(context, node, of);
                placed.extend(given.map(|_| unknowns.collect::<Vec<_>>()));
            }
        }
        let line_nodes = match &initial.line {
            Some(name) => {
                let line = assembly.lines.find(&at.at("line"), name)?;
                Some(assembly.geometry.lines[line].nodes.clone())
            }
            None => node.map(|node| vec![node]),
        };
        entries.push(Entry {
            at,
            initial,
            node,
            line_nodes,
        });
    }
    values::start(assembly, context, &mut q, &placed.concat())?;
    let unstable = match file.analysis.begins_in_equilibrium() {
        true => balance(assembly, context, &mut q)?,
        false => None,
    };
    let Some(velocities) = Velocities::at(&q, assembly, context, &entries)? else {
        return Ok(Start {
            v: vec![0.0; q.len()],
            q,
            unstable,
        });
    };
    let start = requests::project(assembly, context, velocities, &placed)?;
    Ok(Start { unstable, ..start })
}

/// Moves the initial coordinates to the equilibrium at t = 0; the number of its unstable directions.
fn balance(
    assembly: &Assembly<'_>,
    context: &mut Context,
    q: &mut Vec<f64>,
) -> Result<Option<usize>, InputError> {
    let mut unstable = None;
    let mut each = |_: &mut Context, step: &Step<'_>| {
        unstable = step.unstable;
        ControlFlow::Continue(())
    };
    let solved = solve_statics(context, q, &settings::only(0.0), &mut each);
    solved.map(|_| unstable).map_err(|source| {
        let source = source.of(StepParameter::Time);
        let at = settings::location(assembly.at("analysis"), &assembly.file.analysis);
        let at = at.at("dynamic").at("from_equilibrium");
        at.refuse_key(InputProblem::Equilibrium { source })
    })
}

/// An entry of `[[initial]]`: of a node, of the nodes of a line, or of all.
struct Entry<'a> {
    at: Location<'a>,
    initial: &'a Initial,
    node: Option<NodeId>,
    line_nodes: Option<Vec<NodeId>>,
}

fn check(at: &Location<'_>, initial: &Initial) -> Result<(), InputError> {
    let position = [
        ("displacement", initial.displacement.is_some()),
        ("rotation", initial.rotation.is_some()),
        (
            "body_angular_velocity",
            initial.body_angular_velocity.is_some(),
        ),
    ];
    for (key, given) in position {
        if given && initial.node.is_none() {
            return Err((at.at(key)).refuse_key(InputProblem::InitialNode { key }));
        }
    }
    if initial.node.is_some() && initial.line.is_some() {
        let (first, second) = ("node", "line");
        return Err((at.at(second)).refuse_key(InputProblem::InitialTwice { first, second }));
    }
    if initial.angular_velocity.is_some() && initial.body_angular_velocity.is_some() {
        let (first, second) = ("angular_velocity", "body_angular_velocity");
        return Err((at.at(second)).refuse_key(InputProblem::InitialTwice { first, second }));
    }
    let says = position.iter().any(|p| p.1)
        || initial.velocity.is_some()
        || initial.angular_velocity.is_some();
    if !says {
        return Err(at.refuse(InputProblem::InitialNothing));
    }
    Ok(())
}

/// Refuses coordinates that a node attached to a joint does not have.
fn check_attached(
    at: &Location<'_>,
    context: &Context,
    node: NodeId,
    initial: &Initial,
) -> Result<(), InputError> {
    let turns = context.is_own(context.free_rotation_of(node));
    for (key, given, own) in [
        ("displacement", initial.displacement, context.is_own(node)),
        ("rotation", initial.rotation, turns),
    ] {
        if given.is_some() && !own {
            let node = initial.node.clone().unwrap_or_default();
            return Err((at.at(key)).refuse_key(InputProblem::InitialAttached { node, key }));
        }
    }
    Ok(())
}

/// The rotation vector of the same rotation with an angle of at most π.
fn folded(psi: [f64; 3]) -> [f64; 3] {
    let psi = Vector3::from(psi);
    let angle = psi.norm();
    let turns = (angle / TAU).round();
    if turns == 0.0 || !angle.is_finite() {
        psi.into()
    } else {
        (psi * (1.0 - turns * TAU / angle)).into()
    }
}

/// Initial displacement and rotation of a node.
fn position(
    at: &Location<'_>,
    context: &Context,
    node: NodeId,
    initial: &Initial,
    q: &mut [f64],
) -> Result<(), InputError> {
    let (free, first) = requests::rotation(context, node);
    for (key, node, first, values) in [
        ("displacement", node, 0, initial.displacement),
        ("rotation", free, first, initial.rotation.map(folded)),
    ] {
        for (i, value) in values.into_iter().flatten().enumerate() {
            if !context.set(q, node, first + i, value) && value != 0.0 {
                let node = initial.node.clone().unwrap_or_default();
                return Err((at.at(key)).refuse(InputProblem::InitialHeld { node, key }));
            }
        }
    }
    Ok(())
}
