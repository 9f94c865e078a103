//! Warnings about a model or its results, for the terminal and `result.json`.

mod diagnostics;
mod joint_rates;

pub(crate) use diagnostics::Diagnostics;
pub(crate) use joint_rates::{JointRates, RateChange};

use crate::input::{Job, Joint, ModelFile, Time};
use crate::solve::Counts;
use crate::terminal::plural;
use pullback_elements::element::SectionState;
use pullback_elements::joint::JointNodes;
use pullback_elements::model::{BEFORE_START, Context, NodeId};
use pullback_integrators::dynamics::{Progress, State};
use pullback_manifold::system::{Evaluation, Point, System};

/// Most names in a message.
const LISTED: usize = 4;

/// Defect of the energy balance over the largest energy, above which results are doubtful.
const DOUBTFUL: f64 = 0.1;

/// A warning about the energy balance of a motion, or about a model at rest.
pub(crate) fn unbalanced(counts: &Counts) -> Option<&'static str> {
    let energy = counts.energy?;
    if energy.largest_defect <= DOUBTFUL * energy.largest || energy.is_rounding(counts.steps) {
        let now = energy.now.kinetic + energy.now.stored;
        let still = energy.start == 0.0 && energy.gross == 0.0 && now == 0.0;
        return (still && counts.steps > 0).then_some(
            "nothing with mass or stiffness moves: loads, if there are any, are in balance, nothing that is prescribed \
             moves, and all starts at rest. See `loads`, `prescribed` and `initial`",
        );
    }
    Some(if energy.defect() > 0.0 {
        "the balance of energy is off by much compared with the energy of the motion: energy is not \
         conserved, but grows, or the power of prescribed motions changes much in a step; take smaller steps, or a \
         scheme that damps high frequencies (more)"
    } else {
        "the balance of energy is off by much compared with the energy of the motion: energy is lost, as \
         the scheme damps what its steps do not resolve (waves of a sudden start, say), or dampers and \
         prescribed motions take it faster than that; take smaller steps, or a scheme that damps less"
    })
}

/// Why the stability of static equilibria is unknown.
pub(crate) fn stability_unknown(context: &Context) -> Option<String> {
    let names: Vec<String> = context.asymmetric().map(str::to_owned).collect();
    (!names.is_empty()).then(|| {
        format!(
            "the column `unstable` stays empty: moments and follower loads have no potential and make \
             the tangent unsymmetric ({})",
            listed(&names)
        )
    })
}

/// Whether any released coordinate of the joint is an unknown of its own (true), or depends on those of
/// a loop (false).
fn has(own: bool, context: &Context, joint: &JointNodes) -> bool {
    (joint.coordinates.iter()).any(|&node| context.is_own(node) == own)
}

/// Supports and joints, with their numbers, whose prescribed motion has a value (0) or a rate (1) at the start.
fn prescribed(file: &ModelFile, order: usize) -> impl Iterator<Item = (String, Option<usize>)> {
    let start = [0.0, BEFORE_START][order];
    let off = move |time: &Time| {
        time.function(&file.inputs)
            .is_ok_and(|f| f.at(start, &[])[order].abs() > 0.0)
    };
    let supports = file.supports.iter().filter(move |s| {
        let prescribed = s.prescribed.as_ref();
        prescribed.is_some_and(|d| d.given().any(|(_, time)| off(time)))
    });
    let moved = move |j: &Joint| j.acts_any(|a| a.prescribed.as_ref().is_some_and(off));
    let joints = (file.joints.iter().enumerate()).filter(move |(_, j)| moved(j));
    (supports.map(|s| (format!("support of {}", s.node), None)))
        .chain(joints.map(|(k, j)| (format!("joint {}", j.name), Some(k))))
}

/// The first of several names, and the number of the others.
fn listed(names: &[String]) -> String {
    let first = names[..names.len().min(LISTED)].join("; ");
    match names.len().saturating_sub(LISTED) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

/// Names, followed by "is" or "are".
fn are(names: &[String]) -> String {
    let verb = if names.len() == 1 { "is" } else { "are" };
    format!("{} {verb}", names.join(", "))
}

/// Whether a node is in motion.
fn moves(context: &Context, node: NodeId) -> bool {
    let state = context.node_state(node);
    state.velocity.norm() + state.omega.norm() > 0.0
}

/// A warning about bodies that start with a velocity as joints attach them to something prescribed.
pub(crate) fn prescribed_start(job: &Job) -> Option<String> {
    let Job { context, file, .. } = job;
    let prescribed: Vec<String> = prescribed(file, 1).map(|(name, _)| name).collect();
    if !file.initial.is_empty() || prescribed.is_empty() {
        return None;
    }
    // Rates of loops depend on prescribed motion.
    let rests = |&node: &NodeId| {
        let mut rates = (0..).map_while(|k| context.coordinate(node, k));
        rates.all(|[_, rate, _]| rate == 0.0)
    };
    let carried = (file.joints.iter().zip(&job.joints)).filter(|(j, nodes)| {
        let given = j.acts_any(|a| a.rate.is_some() || a.prescribed.is_some());
        let free = !given && has(true, context, nodes);
        free && nodes.coordinates.iter().all(rests) && moves(context, nodes.frame)
    });
    let carried: Vec<String> = carried.map(|(j, _)| j.name.clone()).collect();
    (!carried.is_empty()).then(|| {
        format!(
            "{} prescribed with a velocity just before t = 0: what is attached to it by {} starts with it, as rates \
             of joints are 0. [[initial]] with velocity = [0, 0, 0] lets it start at rest in space",
            are(&prescribed),
            listed(&carried)
        )
    })
}

/// Warnings about lines of which nothing but ends moves at the start, with rates of joints and no [[initial]].
pub(crate) fn lines_at_rest(job: &Job) -> impl Iterator<Item = String> {
    let Job { context, file, .. } = job;
    let rates = |j: &Joint| j.acts_any(|a| a.rate.is_some_and(|rate| rate != 0.0));
    let rated = file.initial.is_empty() && file.joints.iter().any(rates);
    let lines = job.geometry.lines.iter().filter(move |_| rated);
    lines.filter_map(move |line| {
        let (last, nodes) = (line.nodes.len() - 1, &line.nodes);
        let moving: Vec<usize> = (0..=last).filter(|&k| moves(context, nodes[k])).collect();
        let ends = moving.iter().all(|&k| k == 0 || k == last);
        let names: Vec<&str> = moving.iter().map(|&k| context.node(nodes[k]).name()).collect();
        (ends && (1..=last).contains(&moving.len())).then(|| {
            format!(
                "line {} starts at rest but for its end at {}, which jerks it: [[initial]] with line = {:?} \
                 and an angular_velocity (about a hinge) or a velocity sets all of it in motion",
                line.name,
                names.join(" and at "),
                line.name
            )
        })
    })
}

/// Corner of a chain of chords beyond which a slide is warned of, in degrees: on a quarter of a circle it costs some
/// 0.25 % of the speed.
const CORNER: f64 = 0.5;

/// A warning about slides on arcs, whose two-node elements are chords.
pub(crate) fn corners(file: &ModelFile) -> impl Iterator<Item = String> {
    let on = |name: &String| file.lines.iter().find(|line| line.name == *name);
    file.joints.iter().flat_map(move |j| {
        j.lines.iter().filter_map(on).filter_map(|line| {
            let corner = line.arc?.angle_deg.abs() / line.elements as f64;
            (corner > CORNER).then(|| {
                format!(
                    "joint {} slides over corners of {corner:.1} degrees between the elements of the arc {}: each takes \
                     speed from a mass, in the whole in proportion to this angle; take more elements, or a joint \
                     `on_curve`",
                    j.name, line.name
                )
            })
        })
    })
}

/// A warning about energy stored at the start of a motion because prescribed coordinates or
/// initial values differ from the reference configuration.
pub(crate) fn strained(job: &Job, progress: &Progress) -> Vec<String> {
    let Job { context, file, .. } = job;
    let stored = progress.summary.energy.map_or(0.0, |e| e.now.stored);
    let values = |j: &Joint| j.acts_any(|a| a.value.is_some_and(|x| x != 0.0));
    let valued = (file.joints.iter().enumerate()).filter(|(_, j)| values(j));
    let valued = valued.map(|(k, j)| (format!("joint {}", j.name), Some(k)));
    let names: Vec<String> = prescribed(file, 0)
        .chain(valued)
        // The coordinates of a loop are compatible.
        .filter(|(_, joint)| joint.is_none_or(|k| !has(false, context, &job.joints[k])))
        .map(|(name, _)| name)
        .collect();
    // The energy of a joint's own spring is intended.
    let tight = |(_, s): &(_, SectionState)| s.N.norm() + s.M.norm() > 0.0;
    let parts = !file.springs.is_empty() || context.section_states(0.0).iter().any(tight);
    let intended = file.analysis.begins_in_equilibrium() || !parts;
    if stored <= 0.0 || names.is_empty() || intended {
        return Vec::new();
    }
    vec![format!(
        "{} not where the model is drawn at t = 0, which stores the energy {stored:.3e} in it; draw \
         it in that position, or start at 0",
        are(&names)
    )]
}

/// A warning about an unstable equilibrium at the start of a motion.
pub(crate) fn unstable_start(job: &Job) -> Option<String> {
    let directions = plural(job.start.unstable.filter(|&n| n > 0)?, "direction");
    Some(format!(
        "the equilibrium at t = 0 is unstable in {directions} (negative pivots of the tangent): a disturbance leads away from it. \
         An initial configuration nearer to a stable one leads there"
    ))
}

/// Warnings about loops that cannot move.
pub(crate) fn immobile(context: &Context) -> impl Iterator<Item = String> {
    context.locked().into_iter().map(|(joint, x, equations)| {
        format!(
            "the loop closed by joint {joint} cannot move: its {equations} equations leave none of \
             {x} coordinates free. If it should, see whether axes and positions are given with all \
             their digits; if not, weld it"
        )
    })
}

/// A warning about supports that do not hold a structure.
pub(crate) fn unsupported(context: &Context) -> Option<String> {
    let (node, motion) = context.free_motion()?;
    Some(format!(
        "supports do not hold the part of the structure that contains node {}: it can still move as a rigid body \
         ({motion}) unless loads hold it, as gravity holds a cable; add supports that prevent this",
        context.node(node).name()
    ))
}

/// Largest acceptable ratio of rounding errors of a gap to the forces on a model.
const ROUGH: f64 = 1e-3;

/// A warning about penalties for which rounding errors of the gap are large forces.
pub(crate) fn too_stiff(
    context: &mut Context,
    file: &ModelFile,
    progress: &Progress,
) -> Option<String> {
    let State { t, q, v, .. } = &progress.state;
    let a = vec![0.0; q.len()];
    let (at, mut r) = (Point { t: *t, q, v, a: &a }, a.clone());
    context.evaluate(at, Evaluation::residual(&mut r)).ok()?;
    let scales = context.scales();
    let most = ROUGH * scales.measures()[0] / (f64::EPSILON * scales.length);
    let joints = file.joints.iter();
    let large = joints.filter(|j| most > 0.0 && j.penalty.is_some_and(|p| p > most));
    let names: Vec<String> = large.map(|j| j.name.clone()).collect();
    (!names.is_empty()).then(|| {
        format!(
            "penalty of {}: rounding errors of the gap are forces larger than those of the model; \
             keep it below {most:.0e}",
            listed(&names)
        )
    })
}

/// A warning about coordinates on which no mass acts, except for those of joints that a penalty closes.
pub(crate) fn massless(job: &mut Job, progress: &Progress) -> Option<String> {
    let State { t, q, v, .. } = &progress.state;
    let joints = job.file.joints.iter().zip(&job.joints);
    let closing = joints.filter(|(j, _)| j.penalty.is_some());
    let closing: Vec<NodeId> = closing.flat_map(|(_, n)| n.coordinates.clone()).collect();
    // A state outside of a domain is reported by the first step.
    let names = (job.context.massless(*t, q, v, &closing)).ok()?;
    (!names.is_empty()).then(|| {
        format!(
            "no mass acts on {}: without mass a coordinate follows forces at once. Mass of lines is `rho` of a \
             material, or `mass` with A_rho and J beside a `stiffness`; angles of joints need bodies \
             with `inertia` (or lines), others any body",
            listed(&names)
        )
    })
}
