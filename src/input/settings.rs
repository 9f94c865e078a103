//! The analysis of the file as options of the solver.

use super::file::{
    Analysis, ArcLength, Direction, Dynamic, NewtonSettings, Predictor, Static, Stop, TangentRule,
};
use super::names::Names;
use super::{InputError, Problem, Text};
use pullback_elements::model::{Model, NodeId};
use pullback_integrators::dynamics::{self as integrator, Adaptivity, DynamicOptions};
use pullback_integrators::statics::{ArcLengthOptions, Event, StaticNewtonOptions, StaticOptions};

/// Largest number of steps accepted.
const MOST_STEPS: f64 = 1e9;

/// The analysis to run.
#[allow(
    clippy::large_enum_variant,
    reason = "there is one in a run: its size costs nothing"
)]
#[derive(Clone, Debug)]
pub enum Plan {
    /// Load stepping.
    Static(StaticOptions),
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
            Self::Dynamic(_) => 0.0,
        }
    }

    /// Residual relative to loads and reactions at which a step has converged.
    pub fn relative(&self) -> f64 {
        match self {
            Self::Static(options) => options.newton.relative,
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

pub(super) fn plan(
    source: &Text<'_>,
    model: &Model,
    nodes: &Names<NodeId>,
    analysis: &Analysis,
) -> Result<Plan, InputError> {
    match analysis {
        Analysis::Static(s) => load_steps(source, s).map(Plan::Static),
        Analysis::ArcLength(a) => path(source, model, nodes, a),
        Analysis::Dynamic(d) => dynamic(source, d).map(Plan::Dynamic),
    }
}

fn dynamic(source: &Text<'_>, d: &Dynamic) -> Result<DynamicPlan, InputError> {
    let (at, newton) = (["analysis", "dynamic"], ["analysis", "dynamic", "newton"]);
    let min_step = d.min_step.unwrap_or(1e-6 * d.step);
    for (key, value) in [("to", d.to), ("step", d.step), ("min_step", min_step)] {
        source.positive(&at, key, value)?;
    }
    tight(source, &newton, d.newton.relative)?;
    let iterations = d.newton.max_iterations as f64;
    source.positive(&newton, "max_iterations", iterations)?;
    source.not_negative(&newton, "absolute", d.newton.absolute)?;
    source.positive(&at, "record_every", d.record_every as f64)?;
    record_interval(source, d)?;
    let adaptivity = d.adaptive.map(|a| Adaptivity {
        tolerance: a.tolerance,
        max_step: a.max_step.unwrap_or(100.0 * d.step),
    });
    if let Some(a) = adaptivity {
        let at = ["analysis", "dynamic", "adaptive"];
        source.positive(&at, "tolerance", a.tolerance)?;
        source.positive(&at, "max_step", a.max_step)?;
    }
    if d.step > d.to || min_step > d.step {
        return Err(source.range(&at, "step", d.step, "a step between min_step and to"));
    }
    if d.adaptive.is_none() && d.to / d.step > MOST_STEPS {
        return Err(source.range(&at, "step", d.step, "at most 1e9 steps"));
    }
    let at = |key: &'static str| ["analysis", "dynamic", key];
    let method = d.scheme.method().map_err(|error| {
        let message = error.to_string();
        source.value(&at("scheme"), Problem::Scheme { message })
    })?;
    let scheme = method.scheme();
    if d.adaptive.is_some() && !scheme.estimates_error() {
        let name = scheme.name;
        let message = format!(
            "{name} has no estimate of the local error, which schemes of order 2 and tsitouras have; take \
             equal steps, or another scheme"
        );
        return Err(source.value(&at("scheme"), Problem::Scheme { message }));
    }
    Ok(DynamicPlan {
        options: DynamicOptions {
            interval: d.record_interval,
            min_step,
            scheme,
            adaptivity,
            newton: integrator::NewtonOptions {
                relative: d.newton.relative,
                absolute: d.newton.absolute,
                max_iterations: d.newton.max_iterations,
                tangent: match d.newton.tangent {
                    TangentRule::Every => integrator::Tangent::Every,
                    TangentRule::Once => integrator::Tangent::Once,
                },
                predictor: match d.newton.predictor {
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

/// Refuses invalid intervals of rows.
fn record_interval(source: &Text<'_>, d: &Dynamic) -> Result<(), InputError> {
    let Some(interval) = d.record_interval else {
        return Ok(());
    };
    let (at, key) = (["analysis", "dynamic"], "record_interval");
    source.positive(&at, key, interval)?;
    let expected = match d.to / interval {
        _ if d.record_every != 1 => "no record_every beside record_interval",
        rows if rows > MOST_STEPS => "an interval that makes at most 1e9 rows",
        _ => return Ok(()),
    };
    Err(source.range(&at, key, interval, expected))
}

/// Refuses tolerances of Newton's method that are too loose for equilibrium.
fn tight(source: &Text<'_>, newton: &[&str], relative: f64) -> Result<(), InputError> {
    source.positive(newton, "relative", relative)?;
    if relative <= StaticNewtonOptions::LOOSEST {
        return Ok(());
    }
    let expected = "a tenth of the forces at most (1e-9 is the default)";
    Err(source.range(newton, "relative", relative, expected))
}

fn newton(
    source: &Text<'_>,
    kind: &str,
    settings: &NewtonSettings,
) -> Result<StaticNewtonOptions, InputError> {
    let at = ["analysis", kind, "newton"];
    tight(source, &at, settings.relative)?;
    let (key, iterations) = ("max_iterations", settings.max_iterations as f64);
    source.positive(&at, key, iterations)?;
    source.not_negative(&at, "absolute", settings.absolute)?;
    if iterations > 1000.0 {
        return Err(source.range(&at, key, iterations, "at most 1000 iterations"));
    }
    Ok(StaticNewtonOptions {
        relative: settings.relative,
        absolute: settings.absolute,
        max_iterations: settings.max_iterations,
        ..StaticNewtonOptions::default()
    })
}

fn load_steps(source: &Text<'_>, s: &Static) -> Result<StaticOptions, InputError> {
    let at = ["analysis", "static"];
    let range = (s.to - s.from).abs();
    if range == 0.0 || !range.is_finite() {
        let expected = "a load parameter that differs from the one it starts from";
        return Err(source.range(&at, "to", s.to, expected));
    }
    let given = [
        ("first_step", s.first_step),
        ("max_step", s.max_step),
        ("min_step", s.min_step),
    ];
    for (key, value) in given {
        let Some(value) = value else { continue };
        source.positive(&at, key, value)?;
        if s.steps.is_some() && key != "min_step" {
            return Err(source.key(&[at[0], at[1], key], Problem::StepsTwice { key }));
        }
    }
    let steps = s.steps.map(|steps| steps as f64);
    if let Some(steps) = steps {
        source.positive(&at, "steps", steps)?;
        if steps > MOST_STEPS {
            return Err(source.range(&at, "steps", steps, "at most 1e9 steps"));
        }
    }
    let equal = steps.map(|steps| range / steps);
    let max_step = equal
        .or(s.max_step)
        .unwrap_or_else(|| (0.25 * range).max(s.first_step.unwrap_or(0.0)));
    let first_step = equal
        .or(s.first_step)
        .unwrap_or_else(|| (0.1 * range).min(max_step));
    let min_step = s.min_step.unwrap_or(1e-6 * range).min(first_step);
    if first_step > max_step {
        let expected = "a first step that is not larger than max_step";
        return Err(source.range(&at, "first_step", first_step, expected));
    }
    Ok(StaticOptions {
        from: s.from,
        to: s.to,
        first_step,
        min_step,
        max_step,
        newton: newton(source, "static", &s.newton)?,
        ..StaticOptions::default()
    })
}

/// Writes defaults that depend on other keys into the settings that a run reports.
pub(super) fn fill_in(plan: &Plan, analysis: &mut Analysis) {
    if let (Plan::Static(options), Analysis::Static(s)) = (plan, analysis) {
        s.min_step = Some(options.min_step);
        if s.steps.is_none() {
            s.first_step = Some(options.first_step);
            s.max_step = Some(options.max_step);
        }
    }
}

fn path(
    source: &Text<'_>,
    model: &Model,
    nodes: &Names<NodeId>,
    a: &ArcLength,
) -> Result<Plan, InputError> {
    let kind = "arc_length";
    let numbers = [
        ("first_step", a.first_step),
        ("max_step", a.max_step),
        ("min_step", a.min_step),
        ("load_scale", a.load_scale),
        ("max_steps", a.max_steps as f64),
        ("target_iterations", a.target_iterations as f64),
    ];
    for (key, value) in numbers {
        source.positive(&["analysis", kind], key, value)?;
    }
    if a.stop.is_empty() {
        let expected = "at least one position to stop at, such as { load = 1.0 }";
        return Err(source.range(&["analysis", kind], "stop", 0.0, expected));
    }
    let mut events = Vec::new();
    let mut names = Vec::new();
    for (list, stops, ends) in [("stop", &a.stop, true), ("record", &a.record, false)] {
        for (k, stop) in stops.iter().enumerate() {
            let index = k.to_string();
            let at = ["analysis", kind, list, index.as_str()];
            let (event, name) = event(source, &at, model, nodes, stop)?;
            events.push((event, ends));
            names.push(name);
        }
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
        forward: a.direction == Direction::Forward,
        newton: newton(source, kind, &a.newton)?,
    };
    Ok(Plan::Path(options, names))
}

fn event(
    source: &Text<'_>,
    at: &[&str],
    model: &Model,
    nodes: &Names<NodeId>,
    stop: &Stop,
) -> Result<(Event, String), InputError> {
    Ok(match stop {
        Stop::TurningPoint => (Event::TurningPoint, "turning_point".to_owned()),
        Stop::Load(load) => (Event::Load(*load), format!("load = {load}")),
        Stop::Coordinate(c) => {
            let path = [at, &["coordinate", "node"]].concat();
            let node = nodes.find(source, &path, &c.node)?;
            let unknown = model.unknown(node, c.dof.dof()).ok_or_else(|| {
                let problem = Problem::PrescribedEvent {
                    node: c.node.clone(),
                    dof: c.dof.key(),
                };
                source.value(at, problem)
            })?;
            let name = format!("{} of {} = {}", c.dof.key(), c.node, c.value);
            let value = c.value;
            (Event::Coordinate { unknown, value }, name)
        }
    })
}
