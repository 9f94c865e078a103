//! The analysis of the file as options of the solver.

use super::file::{
    Analysis, ArcLength, Branch, BucklingAnalysis, Direction, Dynamic, ModalAnalysis,
    NewtonSettings, Predictor, Static, Stop, TangentRule,
};
use super::names::Names;
use super::parts::Assembly;
use super::{InputError, InputProblem, Location};
use pullback_elements::model::{Model, NodeId};
use pullback_elements::time::Input;
use pullback_integrators::dynamics::{self as integrator, Adaptivity, DynamicOptions, Scheme};
use pullback_integrators::statics::{ArcLengthOptions, Event, StaticNewtonOptions, StaticOptions};
use std::f64::consts::PI;

/// Largest number of steps accepted.
const MOST_STEPS: f64 = 1e9;

/// The analysis to run.
#[allow(
    clippy::large_enum_variant,
    reason = "there is one in a run: its size costs nothing"
)]
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Plan {
    /// Load stepping.
    Static(StaticOptions),
    /// The equilibrium in a steady rotation with a speed, an input, at time 0.
    Steady(Input, StaticOptions),
    /// Path following, with a name for each of its events.
    Path(ArcLengthOptions, Vec<String>),
    /// Motion in time.
    Dynamic(DynamicPlan),
}

/// A dynamic analysis and the frequency of its output.
#[derive(Clone, Copy, Debug)]
pub struct DynamicPlan {
    /// Options of the integrator.
    pub options: DynamicOptions,
    /// A row every this many steps, where the options have no interval.
    pub record_every: usize,
    /// A checkpoint every this many steps; 0 for one at the end only.
    pub checkpoint_every: usize,
}

impl Plan {
    /// Load parameter at the start.
    pub fn start(&self) -> f64 {
        match self {
            Self::Static(options) => options.from,
            Self::Path(options, _) => options.from,
            Self::Steady(..) | Self::Dynamic(_) => 0.0,
        }
    }

    /// Residual relative to loads and reactions at which a step has converged.
    pub fn relative(&self) -> f64 {
        match self {
            Self::Static(options) | Self::Steady(_, options) => options.newton.relative,
            Self::Path(options, _) => options.newton.relative,
            Self::Dynamic(plan) => plan.options.newton.relative,
        }
    }

    /// Name of the independent variable, for messages and axes.
    pub fn parameter(&self) -> &'static str {
        match self {
            Self::Dynamic(_) => "time",
            _ => "load parameter",
        }
    }
}

pub(super) fn plan(assembly: &Assembly<'_>, model: &Model) -> Result<Plan, InputError> {
    let analysis = &assembly.file.analysis;
    let at = location(assembly.at("analysis"), analysis);
    match analysis.stepwise() {
        Some(Analysis::Static(s)) => load_steps(&at.at("static"), s).map(Plan::Static),
        Some(Analysis::ArcLength(a)) => path(&at.at("arc_length"), model, &assembly.nodes, a),
        Some(Analysis::Dynamic(d)) => dynamic(&at.at("dynamic"), d).map(Plan::Dynamic),
        Some(Analysis::Modes(_)) => Err(unknown(&at, "modes", &STEPWISE)),
        Some(Analysis::Buckling(_)) => Err(unknown(&at, "buckling", &STEPWISE)),
        Some(Analysis::Campbell(_)) => Err(unknown(&at, "campbell", &STEPWISE)),
        None => Ok(match (analysis, assembly.speed) {
            (Analysis::Campbell(c), Some(speed)) => Plan::Steady(speed, only(c.from)),
            _ => Plan::Static(only(0.0)),
        }),
    }
}

/// One equilibrium, at this load parameter or speed.
pub(super) fn only(at: f64) -> StaticOptions {
    StaticOptions {
        from: at,
        to: at,
        ..StaticOptions::default()
    }
}

/// The analyses that make steps.
const STEPWISE: [&str; 3] = ["static", "arc_length", "dynamic"];

pub(super) fn unknown(at: &Location<'_>, found: &str, known: &[&str]) -> InputError {
    at.at(found).refuse_key(InputProblem::UnknownKey {
        found: found.to_owned(),
        known: known.iter().map(|&key| key.to_owned()).collect(),
    })
}

/// Location of the analysis that is solved step by step.
pub(super) fn location<'a>(at: Location<'a>, analysis: &Analysis) -> Location<'a> {
    match analysis {
        Analysis::Modes(_) => at.at("modes").at("after"),
        Analysis::Buckling(_) => at.at("buckling").at("after"),
        _ => at,
    }
}

fn dynamic(at: &Location<'_>, d: &Dynamic) -> Result<DynamicPlan, InputError> {
    let min_step = d.min_step.unwrap_or(1e-6 * d.step);
    for (key, value) in [("to", d.to), ("step", d.step), ("min_step", min_step)] {
        at.positive(key, value)?;
    }
    let n = d.newton;
    check_newton(&at.at("newton"), n.relative, n.absolute, n.max_iterations)?;
    at.positive("record_every", d.record_every as f64)?;
    record_interval(at, d)?;
    let adaptivity = d.adaptive.map(|a| Adaptivity {
        tolerance: a.tolerance,
        max_step: a.max_step.unwrap_or(100.0 * d.step),
    });
    if let Some(a) = adaptivity {
        let at = at.at("adaptive");
        at.positive("tolerance", a.tolerance)?;
        at.positive("max_step", a.max_step)?;
    }
    let apart = d.step > d.to || min_step > d.step;
    at.refuse_if(apart, "step", d.step, "a step between min_step and to")?;
    let many = d.adaptive.is_none() && d.to / d.step > MOST_STEPS;
    at.refuse_if(many, "step", d.step, "at most 1e9 steps")?;
    Ok(DynamicPlan {
        options: DynamicOptions {
            interval: d.record_interval,
            min_step,
            scheme: scheme(at, d)?,
            adaptivity,
            newton: integrator::NewtonOptions {
                relative: n.relative,
                absolute: n.absolute,
                max_iterations: n.max_iterations,
                tangent: match n.tangent {
                    TangentRule::Every => integrator::TangentUpdate::Every,
                    TangentRule::Once => integrator::TangentUpdate::Once,
                },
                predictor: match n.predictor {
                    Predictor::Velocity => integrator::Predictor::Velocity,
                    Predictor::Keep => integrator::Predictor::Keep,
                },
            },
            ..DynamicOptions::new(d.to, d.step)
        },
        record_every: d.record_every,
        checkpoint_every: d.checkpoint_every,
    })
}

/// The scheme, which must estimate its error if step sizes are adaptive.
fn scheme(at: &Location<'_>, d: &Dynamic) -> Result<Scheme, InputError> {
    let refuse = |message| at.at("scheme").refuse(InputProblem::Scheme { message });
    let method = d.scheme.method();
    let scheme = method.map_err(|error| refuse(error.to_string()))?.scheme();
    if d.adaptive.is_some() && !scheme.estimates_error() {
        let name = scheme.name;
        return Err(refuse(format!(
            "{name} has no estimate of the local error, which schemes of order 1 or 2 and tsitouras have; take \
             equal steps, or another scheme"
        )));
    }
    Ok(scheme)
}

/// Refuses invalid intervals of rows.
fn record_interval(at: &Location<'_>, d: &Dynamic) -> Result<(), InputError> {
    let Some(interval) = d.record_interval else {
        return Ok(());
    };
    let key = "record_interval";
    at.positive(key, interval)?;
    if d.record_every != 1 {
        return Err(at.exclude(key, "record_every"));
    }
    let expected = "an interval that makes at most 1e9 rows";
    at.refuse_if(d.to / interval > MOST_STEPS, key, interval, expected)
}

/// Refuses invalid settings of Newton's method, and tolerances that are too loose for equilibrium.
fn check_newton(
    at: &Location<'_>,
    relative: f64,
    absolute: f64,
    max_iterations: usize,
) -> Result<(), InputError> {
    at.positive("relative", relative)?;
    let expected = "a tenth of the forces at most (1e-9 is the default)";
    let loose = relative > StaticNewtonOptions::LOOSEST;
    at.refuse_if(loose, "relative", relative, expected)?;
    at.positive("max_iterations", max_iterations as f64)?;
    at.not_negative("absolute", absolute)
}

fn newton(at: &Location<'_>, n: &NewtonSettings) -> Result<StaticNewtonOptions, InputError> {
    check_newton(at, n.relative, n.absolute, n.max_iterations)?;
    let (most, expected) = (n.max_iterations as f64, "at most 1000 iterations");
    at.refuse_if(most > 1000.0, "max_iterations", most, expected)?;
    Ok(StaticNewtonOptions {
        relative: n.relative,
        absolute: n.absolute,
        max_iterations: n.max_iterations,
        ..StaticNewtonOptions::default()
    })
}

fn load_steps(at: &Location<'_>, s: &Static) -> Result<StaticOptions, InputError> {
    let range = (s.to - s.from).abs();
    let expected = "a load parameter that differs from the one it starts from";
    let none = range == 0.0 || !range.is_finite();
    at.refuse_if(none, "to", s.to, expected)?;
    let given = [
        ("first_step", s.first_step),
        ("max_step", s.max_step),
        ("min_step", s.min_step),
    ];
    for (key, value) in given {
        let Some(value) = value else { continue };
        at.positive(key, value)?;
        if s.steps.is_some() && key != "min_step" {
            return Err(at.exclude(key, "steps"));
        }
    }
    let steps = s.steps.map(|steps| steps as f64);
    if let Some(steps) = steps {
        at.positive("steps", steps)?;
        at.refuse_if(steps > MOST_STEPS, "steps", steps, "at most 1e9 steps")?;
    }
    let equal = steps.map(|steps| range / steps);
    let max_step = equal
        .or(s.max_step)
        .unwrap_or_else(|| (0.25 * range).max(s.first_step.unwrap_or(0.0)));
    let first_step = equal
        .or(s.first_step)
        .unwrap_or_else(|| (0.1 * range).min(max_step));
    let min_step = s.min_step.unwrap_or(1e-6 * range).min(first_step);
    let expected = "a first step that is not larger than max_step";
    at.refuse_if(first_step > max_step, "first_step", first_step, expected)?;
    Ok(StaticOptions {
        from: s.from,
        to: s.to,
        first_step,
        min_step,
        max_step,
        newton: newton(&at.at("newton"), &s.newton)?,
    })
}

/// Writes defaults that depend on other keys into the settings that a run reports.
pub(super) fn fill_in(plan: &Plan, analysis: &mut Analysis) {
    let analysis = match analysis {
        Analysis::Modes(ModalAnalysis { after, .. })
        | Analysis::Buckling(BucklingAnalysis { after, .. }) => match after {
            Some(after) => &mut **after,
            None => return,
        },
        own => own,
    };
    if let (Plan::Static(options), Analysis::Static(s)) = (plan, analysis) {
        s.min_step = Some(options.min_step);
        if s.steps.is_none() {
            s.first_step = Some(options.first_step);
            s.max_step = Some(options.max_step);
        }
    }
}

fn path(
    at: &Location<'_>,
    model: &Model,
    nodes: &Names<NodeId>,
    a: &ArcLength,
) -> Result<Plan, InputError> {
    let numbers = [
        ("first_step", a.first_step),
        ("max_step", a.max_step),
        ("min_step", a.min_step),
        ("load_scale", a.load_scale),
        ("max_steps", a.max_steps as f64),
        ("target_iterations", a.target_iterations as f64),
    ];
    for (key, value) in numbers {
        at.positive(key, value)?;
    }
    let expected = "at least one event that ends the analysis, such as { load = 1.0 }";
    at.refuse_if(a.stop.is_empty(), "stop", 0.0, expected)?;
    let mut events = Vec::new();
    let mut names = Vec::new();
    for (list, stops, ends) in [("stop", &a.stop, true), ("record", &a.record, false)] {
        for (k, stop) in stops.iter().enumerate() {
            let (event, name) = event(&at.at(list).at(k), model, nodes, stop)?;
            events.push((event, ends));
            names.push(name);
        }
    }
    let switch_branch = a.branch == Branch::Switch;
    if switch_branch && !events.contains(&(Event::Bifurcation, false)) {
        events.push((Event::Bifurcation, false));
        names.push("bifurcation".to_owned());
    }
    let options = ArcLengthOptions {
        from: a.from,
        first_step: a.first_step,
        max_step: a.max_step,
        min_step: a.min_step,
        max_steps: a.max_steps,
        load_scale: a.load_scale,
        target_iterations: a.target_iterations,
        events,
        switch_branch,
        forward: a.direction == Direction::Forward,
        newton: newton(&at.at("newton"), &a.newton)?,
    };
    Ok(Plan::Path(options, names))
}

/// An event of the path, and its name in the history.
fn event(
    at: &Location<'_>,
    model: &Model,
    nodes: &Names<NodeId>,
    stop: &Stop,
) -> Result<(Event, String), InputError> {
    Ok(match stop {
        Stop::TurningPoint => (Event::TurningPoint, "turning_point".to_owned()),
        Stop::Bifurcation => (Event::Bifurcation, "bifurcation".to_owned()),
        Stop::Load(load) => (Event::Load(*load), format!("load = {load}")),
        Stop::Coordinate(c) => {
            let (dof, value) = (c.dof.key(), c.value);
            let node = nodes.find(&at.at("coordinate").at("node"), &c.node)?;
            let unknown = model.unknown(node, c.dof.dof()).ok_or_else(|| {
                let node = c.node.clone();
                at.refuse(InputProblem::PrescribedEvent { node, dof })
            })?;
            if c.dof.dof().index() >= 3 && value.abs() >= PI {
                return Err(at.refuse(InputProblem::FarEvent { dof, value }));
            }
            let name = format!("{dof} of {} = {value}", c.node);
            (Event::Coordinate { unknown, value }, name)
        }
    })
}
