//! `pullback linearize`.

use super::{FAILED, INTERRUPTED, complain, print, refuse};
use crate::input::{Plan, Registry};
use crate::output::{Directory, Ending, OutputError};
use crate::run::{RunError, ending, initial_progress};
use crate::solve::solve;
use crate::terminal::{self, plural, tell};
use pullback_integrators::linearization::{Linearized, linearize as linearized};
use std::fmt::Write;
use std::path::PathBuf;

/// The files, by which an earlier run is recognised.
const FILES: [&str; 5] = ["K.mtx", "C.mtx", "M.mtx", "inputs.mtx", "coordinates.txt"];

/// Arguments of `pullback linearize`.
#[derive(clap::Args)]
pub(super) struct LinearizeArguments {
    /// Model file (TOML; see docs/model_file.md).
    model: PathBuf,
    /// Load parameter or time of the state, instead of the end of the analysis.
    #[arg(long, allow_hyphen_values = true)]
    at: Option<f64>,
    /// Directory of the matrices; `MODEL.linear` beside the model file by default.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Solves up to the state, and writes the matrices; returns the exit code.
pub(super) fn linearize(registry: &Registry, args: &LinearizeArguments) -> u8 {
    let mut job = match registry.load(&args.model) {
        Ok(job) => job,
        Err(error) => return complain(&error),
    };
    match (&mut job.plan, args.at) {
        (_, None) => {}
        (Plan::Static(options), Some(at)) => options.to = at,
        (Plan::Dynamic(plan), Some(at)) => plan.options.to = at,
        (Plan::Path(..), Some(_)) => {
            return refuse(
                "--at: a path may pass a load several times; end it there by `stop` instead",
            );
        }
    }
    let out = args
        .out
        .clone()
        .unwrap_or_else(|| args.model.with_extension("linear"));
    let plan = &job.plan;
    let started = initial_progress(&mut job.context, plan, &job.start, None, &out);
    let mut progress = match started {
        Ok(progress) => progress,
        Err(RunError::Input(error)) => return complain(&error),
        Err(error) => return refuse(error),
    };
    let ended = solve(&mut job.context, plan, &mut progress, &mut |_, _| {
        terminal::flow()
    });
    match ending(&ended, progress.state.t) {
        Ending::Interrupted { .. } => {
            tell("interrupted: nothing is written");
            return INTERRUPTED;
        }
        Ending::StepLimit { max_steps, .. } => {
            refuse(format!(
                "no stop was reached within max_steps = {max_steps}"
            ));
            return FAILED;
        }
        Ending::Failed { message } => {
            refuse(message);
            return FAILED;
        }
        Ending::Complete | Ending::Running => {}
    }
    let lin = match linearized(&mut job.context, progress.state.point()) {
        Ok(lin) => lin,
        Err(error) => {
            refuse(error);
            return FAILED;
        }
    };
    match write(&lin, &out) {
        Ok(()) => print(&format!(
            "{}, {} in {}\n",
            plural(lin.dim(), "coordinate"),
            plural(lin.r_u.len(), "input"),
            out.display()
        )),
        Err(error) => refuse(error),
    }
}

fn write(lin: &Linearized, out: &std::path::Path) -> Result<(), OutputError> {
    let mut directory = Directory::open_for(out, &FILES)?;
    let n = lin.dim();
    for (name, values) in ["K.mtx", "C.mtx", "M.mtx"]
        .iter()
        .zip([&lin.K, &lin.C, &lin.M])
    {
        let entries = lin.triplets(values).filter(|(_, _, x)| *x != 0.0);
        directory.write(name, &matrix_market([n, n], entries))?;
    }
    let columns = lin.r_u.iter().enumerate();
    let entries = columns.flat_map(|(c, r_u)| r_u.iter().enumerate().map(move |(r, x)| (r, c, *x)));
    let entries = entries.filter(|(_, _, x)| *x != 0.0);
    directory.write("inputs.mtx", &matrix_market([n, lin.r_u.len()], entries))?;
    directory.write("coordinates.txt", &(lin.names.join("\n") + "\n"))
}

/// A sparse matrix in Matrix Market exchange format (Boisvert, Pozo & Remington 1996, NISTIR 5935).
fn matrix_market(
    [rows, columns]: [usize; 2],
    entries: impl Iterator<Item = (usize, usize, f64)>,
) -> String {
    let (mut body, mut count) = (String::new(), 0);
    for (r, c, x) in entries {
        count += 1;
        // Writing to a string cannot fail.
        let _ = writeln!(body, "{} {} {x:?}", r + 1, c + 1);
    }
    format!("%%MatrixMarket matrix coordinate real general\n{rows} {columns} {count}\n{body}")
}
