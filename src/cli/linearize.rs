//! `pullback linearize`.

use super::parameters::ModelArguments;
use super::{Exit, INTERRUPTED, complain, fail, print, refuse};
use crate::input::{Analysis, EigenvaluePlan, Job, Registry};
use crate::linear::{equations, warnings};
use crate::modes::steady_rotation;
use crate::output::{Directory, OutputError};
use crate::probe::{Answers, Probe};
use crate::run::{ReachError, reach};
use crate::terminal::{self, plural, tell};
use nalgebra::DMatrix;
use pullback_elements::model::Context;
use pullback_elements::time::Input;
use pullback_integrators::linearization::{
    CampbellOptions, Linearized, OutputDerivatives, StateSpace, StateSpaceError,
    linearize as linearized, output_derivatives,
};
use pullback_manifold::system::{Point, SystemError};
use std::fmt::{Display, Write};
use std::path::PathBuf;

/// The files, by which an earlier run is recognised.
const FILES: [&str; 12] = [
    "K.mtx",
    "C.mtx",
    "M.mtx",
    "inputs.mtx",
    "coordinates.txt",
    "inputs.txt",
    "outputs.txt",
    "state_A.mtx",
    "state_B.mtx",
    "state_C.mtx",
    "state_D.mtx",
    "state_basis.mtx",
];

/// Why there is no first-order form in multi-blade coordinates.
const PERIODIC: &str = "inputs and outputs of a rotor on parts that do not rotate are periodic: there is no first-order form \
                        with constant matrices. Leave out --first-order for K, C and M in multi-blade coordinates";

/// Why there is none of a rotor whose inputs or outputs are fixed in space.
const FIXED_IN_SPACE: &str = "coordinates rotate, and an input or output does not, as a force or displacement along a fixed axis: its \
                              matrices are periodic, and there is no first-order form. Leave out --first-order, or take inputs and \
                              outputs that rotate, as those of joints, follower loads, or components along the axis";

/// Arguments of `pullback linearize`.
#[derive(clap::Args)]
pub(super) struct LinearizeArguments {
    #[command(flatten)]
    file: ModelArguments,
    /// Load parameter, time, or speed of a Campbell diagram, instead of the end of the analysis.
    #[arg(long, allow_hyphen_values = true)]
    at: Option<f64>,
    /// Directory of the matrices; `MODEL.linear` beside the model file by default.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Also writes the first-order form: A, B, C and D, with the probes as outputs.
    #[arg(long)]
    first_order: bool,
}

/// Solves up to the state, and writes the matrices; returns the exit code.
pub(super) fn linearize(registry: &Registry, args: &LinearizeArguments) -> Exit {
    let mut job = args.file.load(registry).map_err(complain)?;
    let rotation = match &job.eigenvalues {
        Some(EigenvaluePlan::Campbell(speed, options)) => Some((*speed, options.clone())),
        _ => None,
    };
    let reached = reach(
        &mut job,
        args.at.filter(|_| rotation.is_none()),
        &mut |_| terminal::flow(),
    );
    let mut progress = reached.map_err(|error| match error {
        ReachError::At(_) => refuse(format!("--at: {error}")),
        ReachError::Start(_) => refuse(error),
        ReachError::Interrupted | ReachError::Failed(_) => end(error),
    })?;
    let out = (args.out.clone()).unwrap_or_else(|| args.file.model.with_extension("linear"));
    let rotated = match rotation {
        Some(rotation) => equations_at_speed(&mut job, rotation, &mut progress.state.q, args)?,
        None => None,
    };
    let at = progress.state.point();
    let (lin, speed) = match rotated {
        Some(rotated) => rotated,
        None => (equations(&mut job.context, at).map_err(fail)?, 0.0),
    };
    let first_order = match args.first_order {
        true => Some(first_order(&mut job, (&lin, at), speed)?),
        false => None,
    };
    for warning in warnings(&mut job, at).map_err(fail)? {
        tell(format!("warning: {warning}"));
    }
    let mut inputs = job.file.inputs.keys().cloned().collect::<Vec<_>>();
    if let Analysis::Campbell(campbell) = &job.file.analysis {
        inputs.push(format!("speed of {}", campbell.joint));
    }
    write(&lin, &inputs, first_order.as_ref(), &out).map_err(refuse)?;
    Ok(print(&format!(
        "{}, {} in {}\n",
        plural(lin.dim(), "coordinate"),
        plural(lin.r_u.len(), "input"),
        out.display()
    )))
}

/// Prints why there are no matrices, Ctrl-C or an error; returns the exit code.
fn end(error: impl Display) -> u8 {
    if terminal::flow().is_continue() {
        return fail(error);
    }
    tell("interrupted: nothing is written");
    INTERRUPTED
}

/// Solves for a steady rotation from coordinates `q`, which end as those there; returns its linear equations and speed.
fn equations_at_speed(
    job: &mut Job,
    (speed, mut options): (Input, CampbellOptions),
    q: &mut Vec<f64>,
    args: &LinearizeArguments,
) -> Result<Option<(Linearized, f64)>, u8> {
    if let (Some(at), Some(&first)) = (args.at, options.speeds.first()) {
        // The equilibrium of the diagram, which follows from those before.
        (options.speeds).retain(|speed| *speed == first || (speed - first) * (at - speed) > 0.0);
        options.speeds.push(at);
    }
    let observer = &mut || terminal::flow();
    let diagram = steady_rotation(&mut job.context, q, speed, &options, observer).map_err(end)?;
    if diagram.multi_blade && args.first_order {
        return Err(refuse(PERIODIC));
    }
    if diagram.multi_blade {
        tell(
            "coordinates of rotating parts are multi-blade coordinates, inputs are those at angle zero",
        );
    }
    Ok(diagram.last.zip(options.speeds.last().copied()))
}

/// Names of outputs, and the matrices of the first-order form.
type FirstOrder = (Vec<String>, StateSpace);

/// The first-order form with the probes as outputs, in a steady rotation with a speed, or the exit code.
fn first_order(
    job: &mut Job,
    (lin, at): (&Linearized, Point<'_>),
    speed: f64,
) -> Result<FirstOrder, u8> {
    let names: Vec<String> = job.probes.iter().flat_map(Probe::columns).collect();
    let outputs = outputs(job, at).map_err(end)?;
    if speed != 0.0 {
        let t = at.t + 1.0 / speed;
        let turned = Point { t, ..at };
        let inputs = linearized(&mut job.context, turned).map_err(fail)?.r_u;
        // The angle depends on the speed, the last input.
        let of = |outputs: &OutputDerivatives| {
            let u = outputs.u.columns(0, inputs.len() - 1).into_owned();
            [outputs.q.clone(), outputs.v.clone(), outputs.a.clone(), u]
        };
        let others = of(&self::outputs(job, turned).map_err(end)?);
        let mut all = of(&outputs).into_iter().zip(others);
        let rows = |r_u: &[Vec<f64>]| DMatrix::from_fn(r_u.len(), lin.dim(), |k, i| r_u[k][i]);
        if !all.all(|(a, b)| alike(&a, &b)) || !alike(&rows(&lin.r_u), &rows(&inputs)) {
            return Err(refuse(FIXED_IN_SPACE));
        }
    }
    let space = lin.state_space(&outputs).map_err(|error| match error {
        StateSpaceError::Reaction(k) => fail(format!("{}: {error}", names[k - 1])),
        error => fail(error),
    });
    Ok((names, space?))
}

/// Whether the rows of two matrices are the same, but for errors of differences.
fn alike(a: &DMatrix<f64>, b: &DMatrix<f64>) -> bool {
    let least = 1e-9 * a.amax();
    (a.row_iter().zip(b.row_iter())).all(|(a, b)| (a - b).amax() <= 1e-5 * a.amax() + least)
}

/// Derivatives of the probes.
fn outputs(job: &mut Job, at: Point<'_>) -> Result<OutputDerivatives, SystemError> {
    let probes = &mut job.probes;
    output_derivatives(&mut job.context, at, |context: &mut Context, at| {
        if terminal::flow().is_break() {
            return Err(SystemError::Request {
                what: "outputs",
                expected: "all".to_owned(),
                found: "an interruption".to_owned(),
            });
        }
        let balance = context.energies_and_momentum(at)?;
        let mut answers = Answers::of(context, at.t);
        answers.motion = Some((balance, 0.0));
        let mut values = Vec::new();
        for probe in &mut *probes {
            probe.record(context, &answers, &mut values);
        }
        Ok(values)
    })
}

fn write(
    lin: &Linearized,
    inputs: &[String],
    first_order: Option<&FirstOrder>,
    out: &std::path::Path,
) -> Result<(), OutputError> {
    let mut directory = Directory::open_for(out, &FILES)?;
    let n = lin.dim();
    for (name, values) in ["K.mtx", "C.mtx", "M.mtx"]
        .iter()
        .zip([&lin.K, &lin.C, &lin.M])
    {
        let entries = lin.pattern.triplets(values);
        directory.write(name, &matrix_market([n, n], entries))?;
    }
    let columns = lin.r_u.iter().enumerate();
    let entries = columns.flat_map(|(c, r_u)| r_u.iter().enumerate().map(move |(r, x)| (r, c, *x)));
    directory.write("inputs.mtx", &matrix_market([n, lin.r_u.len()], entries))?;
    let lines =
        |names: &[String]| -> String { names.iter().map(|name| format!("{name}\n")).collect() };
    directory.write("coordinates.txt", &lines(&lin.names))?;
    directory.write("inputs.txt", &lines(inputs))?;
    let Some((outputs, space)) = first_order else {
        return Ok(());
    };
    directory.write("outputs.txt", &lines(outputs))?;
    for (name, matrix) in [
        ("state_A.mtx", &space.A),
        ("state_B.mtx", &space.B),
        ("state_C.mtx", &space.C),
        ("state_D.mtx", &space.D),
        ("state_basis.mtx", &space.N),
    ] {
        let rows = matrix.nrows();
        let entries = matrix.iter().enumerate();
        let entries = entries.map(|(k, x)| (k % rows, k / rows, *x));
        directory.write(name, &matrix_market([rows, matrix.ncols()], entries))?;
    }
    Ok(())
}

/// A sparse matrix in Matrix Market exchange format (Boisvert, Pozo & Remington 1996, NISTIR 5935).
fn matrix_market(
    [rows, columns]: [usize; 2],
    entries: impl Iterator<Item = (usize, usize, f64)>,
) -> String {
    let (mut body, mut count) = (String::new(), 0);
    for (r, c, x) in entries.filter(|(_, _, x)| *x != 0.0) {
        count += 1;
        // Writing to a string cannot fail.
        let _ = writeln!(body, "{} {} {x:?}", r + 1, c + 1);
    }
    format!("%%MatrixMarket matrix coordinate real general\n{rows} {columns} {count}\n{body}")
}
