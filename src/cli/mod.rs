//! The program `pullback`, and programs that add joints of their own.

mod compare;
pub mod gallery;
mod linearize;
mod parameters;
mod spectrum;
mod sweep;

use crate::input::{InputError, Plan, Registry};
use crate::output::Ending;
use crate::run::{Outcome, default_directory, run_job};
use crate::solve::Advance;
use crate::terminal::{self, ProgressLine, tell};
use clap::{CommandFactory, Parser, Subcommand};
use clap_complete::Shell;
use parameters::ModelArguments;
use pullback_integrators::significant;
use std::ffi::OsString;
use std::io::{self, IsTerminal, Write};
use std::iter;
use std::path::PathBuf;
use std::process::ExitCode;

/// The analysis failed, or a gallery case is off.
const FAILED: u8 = 1;
/// The model file is refused, or results cannot be written.
const REFUSED: u8 = 2;
/// Stopped by Ctrl-C, SIGTERM or SIGHUP.
pub(crate) const INTERRUPTED: u8 = 130;

/// Flexible multibody dynamics on manifolds.
#[derive(Parser)]
#[command(version, about)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Runs a model file and writes history, results, figures and ParaView files.
    ///
    /// Exit code 0: complete; 1: the analysis failed; 2: the model file is refused or the results
    /// cannot be written; 130: interrupted. After a failure, Ctrl-C, SIGTERM or SIGHUP the converged steps
    /// are kept, and result.json marks them as incomplete; a dynamic analysis can be resumed.
    Run(RunArguments),
    /// Checks every element, load and joint of a model file and the assembled system: tangents
    /// against residuals, symmetry, objectivity, changes of chart, the balance of power.
    ///
    /// Prints one line for each component with the property closest to failing, and for a failure the
    /// wrong blocks and their errors. Exit code 0: all is well; 1: something is wrong; 2: the model file is refused.
    Check(CheckArguments),
    /// Compares schemes of time integration on model files, at several step sizes: errors against
    /// a reference solution, observed orders, cost, drift of invariants.
    ///
    /// Writes compare.html (one self-contained page), compare.json, compare.csv and figures;
    /// several model files make one page, with a directory of other results each.
    /// A scheme that fails at a step size is a row with the reason. Exit code 0: complete; 1: there
    /// is no reference, or no run came to its end; 2: the model or an argument is refused, or the
    /// results cannot be written; 130: interrupted.
    Compare(compare::CompareArguments),
    /// Shows spectra of schemes of time integration over Ω = ω h: spectral radius, algorithmic
    /// damping ratio, period elongation, overshoot of the first step; measured from the steps that
    /// runs make, beside the closed forms of theory.
    ///
    /// Prints a table; with --out it writes spectrum.json, spectrum.csv and figures too. Exit code
    /// 0: complete; 2: an argument is refused, or the files cannot be written.
    Spectrum(spectrum::SpectrumArguments),
    /// Writes the linear equations of motion M q̈ + C q̇ + K q = (∂r/∂u) u about the state at the end of the analysis.
    ///
    /// K, C, M and ∂r/∂u in Matrix Market format, and the names of the coordinates. Exit code 0: complete; 1: the
    /// analysis failed, or the state is not in balance; 2: the model is refused or the files cannot be written; 130:
    /// interrupted.
    Linearize(linearize::LinearizeArguments),
    /// Runs a model file with many values of its parameters, several runs at a time.
    ///
    /// Writes sweep.csv: a row for each run with the values, its outcome, and what is kept of each probe; frequencies and critical
    /// loads of an analysis that finds them. A run that fails is a row with its message. A sweep that was stopped goes on
    /// with the same command. Exit code 0: complete; 1: no run came to its end; 2: the model or an argument is
    /// refused, or the rows cannot be written; 130: interrupted.
    Sweep(sweep::SweepArguments),
    /// Prints the JSON Schema of the model file.
    Schema,
    /// Prints the completion script of a shell.
    Completions {
        /// Name of the shell.
        shell: Shell,
    },
    /// Prints the manual pages of the program and its commands, for `man -l -`.
    Man,
    /// Computes the built-in cases and compares them with published or exact results.
    #[command(after_help = gallery::cases())]
    Gallery {
        /// Names of cases; all by default.
        cases: Vec<String>,
        /// Prints the rows as JSON.
        #[arg(long)]
        json: bool,
        /// Directory for plots.
        #[arg(long)]
        out: Option<PathBuf>,
    },
}

#[derive(clap::Args)]
struct RunArguments {
    #[command(flatten)]
    file: ModelArguments,
    /// Directory of the results; `MODEL.out` beside the model file by default.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Resumes from the checkpoint in the directory of the results (dynamic analyses): the
    /// results are bitwise those of an uninterrupted run.
    #[arg(long)]
    resume: bool,
    /// Prints errors only.
    #[arg(long, short)]
    quiet: bool,
}

#[derive(clap::Args)]
struct CheckArguments {
    #[command(flatten)]
    file: ModelArguments,
    /// Seed of the random states and directions.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    seed: u64,
    /// Prints a line for each property of each component.
    #[arg(long)]
    all: bool,
    /// Prints the rows as JSON.
    #[arg(long)]
    json: bool,
}

/// The program: all commands of `pullback`, for model files with the joints of a registry.
///
/// Give it to `main` of a program of your own; see [`Registry`].
pub fn main(registry: &Registry) -> ExitCode {
    ExitCode::from(run(registry, std::env::args_os()))
}

/// The exit code of a command, also where it ends early, with the reason printed.
type Exit = Result<u8, u8>;

/// Runs a command line, which begins with the program's name; returns the exit code.
pub fn run(registry: &Registry, arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let command_line = compare::quoted(&arguments);
    let command = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments.command,
        Err(error) => {
            // Help and version are no errors; a closed output is ignored.
            error.print().ok();
            return u8::from(error.use_stderr()) * REFUSED;
        }
    };
    let exit = match command {
        Command::Run(args) => run_model(registry, args),
        Command::Check(args) => check(registry, &args),
        Command::Compare(args) => compare::compare(registry, args, &command_line),
        Command::Linearize(args) => linearize::linearize(registry, &args),
        Command::Sweep(args) => sweep::sweep(registry, args),
        Command::Spectrum(args) => spectrum::spectrum(args, &command_line),
        Command::Schema => json("the schema", &registry.schema()).map(|text| print(&text)),
        Command::Completions { shell } => {
            let mut text = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "pullback", &mut text);
            Ok(print(&String::from_utf8_lossy(&text)))
        }
        Command::Man => {
            let text = manual().map_err(refuse);
            text.map(|text| print(&String::from_utf8_lossy(&text)))
        }
        Command::Gallery { cases, json, out } => gallery::gallery(&cases, json, out.as_deref()),
    };
    exit.unwrap_or_else(|code| code)
}

/// The manual pages of the program and of its commands, one after another.
fn manual() -> io::Result<Vec<u8>> {
    let mut program = Arguments::command().disable_help_subcommand(true);
    program.build();
    let mut text = Vec::new();
    for command in iter::once(&program).chain(program.get_subcommands()) {
        clap_mangen::Man::new(command.clone()).render(&mut text)?;
    }
    Ok(text)
}

/// Prints to standard output; a closed pipe (`| head`) is no failure.
fn print(text: &str) -> u8 {
    match io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            tell(format_args!("cannot write to standard output: {error}"));
            REFUSED
        }
        _ => 0,
    }
}

/// A value as JSON, or the exit code if it cannot be encoded.
fn json(what: &str, value: &impl serde::Serialize) -> Result<String, u8> {
    let text = serde_json::to_string_pretty(value).map_err(|error| {
        tell(format_args!("cannot encode {what}: {error}"));
        REFUSED
    });
    Ok(text? + "\n")
}

/// Prints an error; returns the exit code.
fn refuse(error: impl std::fmt::Display) -> u8 {
    tell(format_args!("error: {error}"));
    REFUSED
}

/// Prints the failure of an analysis; returns the exit code.
fn fail(error: impl std::fmt::Display) -> u8 {
    refuse(error);
    FAILED
}

/// Prints the refusal of a model file with the position in it; returns the exit code.
fn complain(error: InputError) -> u8 {
    tell(error.report(io::stderr().is_terminal()));
    REFUSED
}

fn run_model(registry: &Registry, args: RunArguments) -> Exit {
    let model = &args.file.model;
    let directory = args.out.unwrap_or_else(|| default_directory(model));
    let job = args.file.load(registry).map_err(complain)?;
    let mut progress = ProgressLine::new(args.quiet);
    if let Plan::Dynamic(motion) = &job.plan {
        progress.until(motion.options.to);
    }
    let mut observer = |step: &Advance<'_>| {
        progress.step(step);
        // Before the first step there is nothing to save: until then Ctrl-C ends the program at once.
        terminal::flow()
    };
    let source = model.display().to_string();
    let ran = run_job(job, &source, &directory, args.resume, &mut observer);
    progress.clear();
    Ok(report(&ran.map_err(refuse)?, args.quiet))
}

fn report(outcome: &Outcome, quiet: bool) -> u8 {
    let directory = outcome.directory.display();
    let (rows, t) = (
        terminal::plural(outcome.rows, "row"),
        significant(outcome.t),
    );
    let reached = format!("{rows} up to {} {t}", outcome.parameter);
    let again = match outcome.parameter {
        "time" => "; --resume continues from there",
        _ => "",
    };
    let mut code = 0;
    if !quiet {
        let notes = outcome.notes.iter().map(|note| format!("{note}\n"));
        code = print(&notes.collect::<String>());
    }
    for warning in &outcome.warnings {
        tell(format_args!("warning: {warning}"));
    }
    if !quiet && outcome.ending != Ending::Complete {
        print(&terminal::counts(&outcome.counts));
    }
    let kept = format!("kept in {directory}: {reached}, marked incomplete{again}");
    match &outcome.ending {
        Ending::Complete if quiet => 0,
        Ending::Complete => code.max(print(&format!(
            "complete: {reached} in {directory}\n{}{}",
            terminal::counts(&outcome.counts),
            outcome
                .eigenvalues
                .as_ref()
                .map_or_else(String::new, terminal::eigenvalues)
        ))),
        Ending::Interrupted { .. } => {
            tell(format_args!("interrupted: {kept}"));
            INTERRUPTED
        }
        ending => {
            if let Some(problem) = ending.problem() {
                tell(format_args!("error: {problem}\n{kept}"));
            }
            FAILED
        }
    }
}

fn check(registry: &Registry, args: &CheckArguments) -> Exit {
    let mut job = args.file.load(registry).map_err(complain)?;
    let mut notes = String::new();
    if job.context.mapped_frames().next().is_some() {
        notes = job.context.descriptions().join("\n") + "\n";
        notes = format!("{}{}\n\n", notes.trim_start(), job.context.mobility());
    }
    let report = crate::check::job(&mut job, args.seed);
    let text = match (args.json, args.all) {
        (true, _) => json("the rows", &crate::check::entries(&report))?,
        (_, true) => notes + &crate::check::table(&report),
        _ => notes + &crate::check::summary(&report),
    };
    let code = if report.is_ok() { 0 } else { FAILED };
    Ok(code.max(print(&text)))
}
