//! Refusals of model files: the problem, its position, a suggestion.

use super::joints::BoxedError;
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use pullback_elements::beam::SectionError;
use pullback_elements::inertia::InertiaError;
use pullback_elements::model::ModelError;
use pullback_elements::spring::SpringError;
use pullback_elements::time::TimeFunctionError;
use pullback_integrators::statics::StaticsError;
use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

/// What is wrong with a model file.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say it")]
#[non_exhaustive]
pub enum InputProblem {
    #[error("cannot read {}: {source}", path.display())]
    Unreadable {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("{} is not UTF-8 text: byte {byte} (line {line}) fits no character", path.display())]
    NotUtf8 {
        path: PathBuf,
        byte: usize,
        line: usize,
    },
    #[error("cannot read shapes from {}: {message}", path.display())]
    Shapes { path: PathBuf, message: String },
    #[error(
        "the shape of an imperfection displaces joint \"{joint}\" against its parent, where its coordinates are 0; take a \
         shape without that, or hold the joint where the shape is computed"
    )]
    ShapeOfJoint { joint: String },
    #[error(
        "\"{path}\" is not the path of a parameter; in it, a name with other signs than letters, digits, _ and - stands in quotes"
    )]
    Path { path: String },
    #[error("{} and {} give one parameter two values", paths[0], paths[1])]
    Repeated { paths: [String; 2] },
    #[error("{}", missing(path, within, found))]
    Parameter {
        path: String,
        within: String,
        found: String,
        known: Vec<String>,
    },
    #[error("the model file is empty")]
    Empty,
    #[error("{0}")]
    Toml(String),
    #[error("unknown key or word `{found}`")]
    UnknownKey { found: String, known: Vec<String> },
    #[error("the number {number} cannot be used")]
    Number { number: String },
    #[error("invalid length {found}, expected an array of length {expected}")]
    Components { found: usize, expected: usize },
    #[error("the model has no {what}")]
    Missing { what: &'static str },
    #[error("there is no {what} named \"{name}\"")]
    UnknownName {
        what: &'static str,
        name: String,
        known: Vec<String>,
    },
    #[error("there are two {what} named \"{name}\"")]
    Duplicate { what: &'static str, name: String },
    #[error("the {what} name \"{name}\" cannot be used")]
    Name { what: &'static str, name: String },
    #[error(
        "section \"{section}\" needs exactly one definition, but has {}",
        list(keys)
    )]
    SectionKind {
        section: String,
        keys: Vec<&'static str>,
    },
    #[error("section \"{section}\": a {shape} needs a material")]
    NoMaterial {
        section: String,
        shape: &'static str,
    },
    #[error("section \"{section}\" has a material, which only a rectangle, circle or tube uses")]
    UselessMaterial { section: String },
    #[error("section \"{section}\": {source}")]
    Section {
        section: String,
        source: SectionError,
    },
    #[error("line \"{line}\" has zero length: nodes \"{from}\" and \"{to}\" stand at {at:?}")]
    ZeroLength {
        line: String,
        from: String,
        to: String,
        at: [f64; 3],
    },
    #[error("line \"{line}\": {key} {vector:?} gives no direction")]
    NoDirection {
        line: String,
        key: &'static str,
        vector: [f64; 3],
    },
    #[error("line \"{line}\": twist_deg is for straight lines, this one is an arc")]
    TwistedArc { line: String },
    #[error("{key} = {value} is out of range")]
    Range {
        key: &'static str,
        value: String,
        expected: &'static str,
    },
    #[error("the support of node \"{node}\" has neither `fix` nor `prescribed`")]
    UselessSupport { node: String },
    #[error("coordinate {dof} of node \"{node}\" is prescribed twice")]
    PrescribedTwice { node: String, dof: &'static str },
    #[error(
        "coordinate {dof} of node \"{node}\" is prescribed, or follows from a joint: the path cannot \
         be measured by it"
    )]
    PrescribedEvent { node: String, dof: &'static str },
    #[error("this load has {}", list(keys))]
    LoadKind { keys: Vec<&'static str> },
    #[error("this load has {load}, which acts on a {needs}")]
    LoadTarget {
        load: &'static str,
        needs: &'static str,
    },
    #[error("gravity cannot turn with the structure")]
    FollowerGravity,
    #[error("gravity acts on line \"{line}\", but its section \"{section}\" has no mass")]
    NoMass { line: String, section: String },
    #[error("body \"{body}\": {source}")]
    Body { body: String, source: InertiaError },
    #[error("spring {spring}: {source}")]
    Spring { spring: String, source: SpringError },
    #[error("spring \"{spring}\" must be either one along a line or a bushing")]
    SpringKind { spring: String },
    #[error("joint \"{joint}\": a joint of type {kind} needs {key}")]
    JointNeeds {
        joint: String,
        kind: String,
        key: String,
    },
    #[error("joint \"{joint}\": a joint of type {kind} has no use for {key}")]
    JointKey {
        joint: String,
        kind: String,
        key: String,
        known: Vec<String>,
    },
    #[error("joint \"{joint}\": {source}")]
    Joint { joint: String, source: BoxedError },
    #[error(
        "{dof} = {value} is never reached: rotation vectors change their chart at half a turn, where they are π long"
    )]
    FarEvent { dof: &'static str, value: f64 },
    #[error("joint \"{joint}\" is prescribed, so {key} has no effect")]
    PrescribedJoint { joint: String, key: &'static str },
    #[error(
        "joint \"{joint}\" cannot slide along line \"{line}\": lines must have elements of order 1 \
         (this one has {order}), begin where the one before ends and have its interpolation"
    )]
    SlideLine {
        joint: String,
        line: String,
        order: usize,
    },
    #[error("lines and joints wait for each other's nodes: {}", names.join(", "))]
    Cycle { names: Vec<String> },
    #[error("{key} is for a single node")]
    InitialNode { key: &'static str },
    #[error("an initial condition has either {first} or {second}")]
    InitialTwice {
        first: &'static str,
        second: &'static str,
    },
    #[error("this initial condition is empty")]
    InitialNothing,
    #[error("joint \"{joint}\" follows another one through a gear: its {key} cannot be chosen")]
    Geared { joint: String, key: &'static str },
    #[error("the node \"{node}\" is attached to a joint and has no {key} of its own")]
    InitialAttached { node: String, key: &'static str },
    #[error(
        "node \"{node}\" is held there, or is attached to a joint that does not allow it: its {key} cannot be chosen"
    )]
    InitialHeld { node: String, key: &'static str },
    #[error(
        "the initial rates of {of} contradict each other: their loops leave a difference of {left:.3e}"
    )]
    LoopRates { of: String, left: f64 },
    #[error("the initial rate of {of} is not possible: its loop leaves it no freedom")]
    LoopLocked { of: String },
    #[error("the initial velocities contradict the joints at {joint}, which cannot move like that")]
    LoopMotion { joint: String },
    #[error(
        "line \"{line}\" is drawn from node \"{node}\", which the joints above carry elsewhere at t = 0, \
         to nodes that stay where they are drawn"
    )]
    DrawnApart { line: String, node: String },
    #[error("joint \"{joint}\" cannot rotate with a constant speed: {why}")]
    NoRotation { joint: String, why: String },
    #[error("{source}")]
    Equilibrium { source: StaticsError },
    #[error("initial conditions belong to a dynamic analysis")]
    InitialStatics,
    #[error("{message}")]
    Scheme { message: String },
    #[error("the history has another column \"{column}\"")]
    Column { column: String },
    #[error("a prescribed coordinate cannot jump")]
    Jump,
    #[error("{0}")]
    Time(#[from] TimeFunctionError),
    #[error("the probe \"{probe}\" records {quantity}, which needs {needs}")]
    ProbeTarget {
        probe: String,
        quantity: &'static str,
        needs: &'static str,
    },
    #[error("component \"{component}\" does not exist for {quantity}")]
    ProbeComponent {
        component: String,
        quantity: &'static str,
        expected: &'static str,
    },
    #[error("node \"{node}\" has no support, so it has no reaction")]
    NoReaction { node: String },
    #[error("joint \"{joint}\": {key} needs {needs}")]
    ClosureKey {
        joint: String,
        key: &'static str,
        needs: &'static str,
    },
    #[error("node \"{node}\" is attached to no joint")]
    NoJoint { node: String },
    #[error("the probe \"{probe}\" records {quantity}, which is zero in statics")]
    DynamicProbe {
        probe: String,
        quantity: &'static str,
    },
    #[error("{0}")]
    Model(#[from] ModelError),
}

/// Why a path is not that of a parameter.
fn missing(path: &str, within: &str, found: &str) -> String {
    match found {
        "" => format!("{path} is a whole part of the model, not a parameter: name a key of it"),
        _ => format!("{path} is not a parameter of the model: {within} has no {found}"),
    }
}

/// Items joined by commas.
fn list(words: &[&'static str]) -> String {
    match words {
        [] => "none".to_owned(),
        [one] => (*one).to_owned(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}

/// A refusal of a model file, with the text that it refers to.
#[derive(Debug)]
pub struct InputError {
    /// What is wrong.
    pub problem: Box<InputProblem>,
    /// The part of the text that it concerns, in bytes.
    pub span: Option<Range<usize>>,
    /// Name and text of the file.
    source: Option<(String, String)>,
}

impl InputError {
    /// A problem of the file as a whole.
    pub(super) fn whole(problem: InputProblem) -> Self {
        Self {
            problem: Box::new(problem),
            span: None,
            source: None,
        }
    }

    /// A problem at a position of the text.
    pub(super) fn at(
        problem: InputProblem,
        span: Option<Range<usize>>,
        name: &str,
        text: &str,
    ) -> Self {
        // The first line represents a span over many lines (a whole table).
        let span = span.map(|s| {
            let start = s.start.min(text.len());
            let end = s.end.clamp(start, text.len());
            let line = text.get(start..end).and_then(|t| t.find('\n'));
            let next = text.get(start..).and_then(|t| t.chars().next());
            let next = next
                .filter(|c| *c != '\n')
                .map_or(start, |c| start + c.len_utf8());
            start..line.map_or(end, |k| start + k).max(next)
        });
        Self {
            problem: Box::new(problem),
            span,
            source: Some((name.to_owned(), text.to_owned())),
        }
    }

    /// Line and column of the position, from 1.
    pub fn line_column(&self) -> Option<(usize, usize)> {
        let start = self.span.as_ref()?.start;
        let before = self.source.as_ref()?.1.get(..start)?;
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
        Some((line, column))
    }

    /// The refusal with its position in the file and a suggestion, for a terminal.
    pub fn report(&self, color: bool) -> String {
        let message = self.to_string();
        let mut report = Group::with_title(Level::ERROR.primary_title(&message));
        if let (Some((name, text)), Some(span)) = (&self.source, &self.span) {
            let here = AnnotationKind::Primary.span(span.clone()).label("here");
            report = report.element(Snippet::source(text).path(name).annotation(here));
        }
        if let Some(advice) = self.problem.advice() {
            report = report.element(Level::HELP.message(advice));
        }
        let renderer = if color {
            Renderer::styled()
        } else {
            Renderer::plain()
        };
        renderer.render(&[report])
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.problem.fmt(f)
    }
}

impl std::error::Error for InputError {}
