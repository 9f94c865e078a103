//! `pullback compare`.

use super::{Exit, FAILED, INTERRUPTED, complain, print, refuse};
use crate::input::{Analysis, Registry, closest};
use crate::method::Method;
use crate::studies::compare::{
    self, Candidate, CompareError, Comparison, ComparisonOptions, Hooks, Subject,
};
use crate::studies::gallery;
use crate::terminal::{self, ProgressLine, tell};
use std::ffi::OsString;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Arguments of `pullback compare`.
#[derive(clap::Args)]
pub(super) struct CompareArguments {
    /// Model file (TOML; see docs/model_file.md) with a dynamic analysis, or the name of a model of
    /// the gallery, such as top or elbow. Several models make one page, and a directory of results each.
    #[arg(required = true)]
    models: Vec<PathBuf>,
    /// Schemes, such as newmark, hht:-0.1, ga:0.8; an unknown name lists all of them.
    /// A prefix selects the formulation of rotations: ul-ga:0.8 (updated
    /// Lagrangian), lie-ga:0.8 (Lie group), wm-ga:0.8 (parameters of Wiener and Milenković),
    /// spin-newmark (sums of spatial spins), mixed-newmark (the same with rates in the body).
    /// diffsol-bdf and diffsol-esdirk are general solvers, in programs built with the feature diffsol.
    #[arg(long, value_delimiter = ',', required = true)]
    schemes: Vec<String>,
    /// Step sizes, from large to small; with the suffix x multiples of the model file's own step: 2x,1x,0.5x.
    #[arg(
        long,
        value_delimiter = ',',
        required = true,
        allow_hyphen_values = true
    )]
    steps: Vec<Size>,
    /// Scheme of the reference solution, with an optional prefix for its formulation; radau by default.
    #[arg(long)]
    reference: Option<String>,
    /// CSV file of an exact solution that replaces the reference: see docs/comparing_schemes.md.
    #[arg(long, conflicts_with = "reference")]
    exact: Option<PathBuf>,
    /// Directory of the results; `MODEL.compare` beside the (first) model file by default.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Runs at a time; one per core by default. Results do not depend on it.
    #[arg(long, value_parser = threads, allow_negative_numbers = true)]
    threads: Option<NonZeroUsize>,
    /// Repeats each run alone on the machine to measure its time.
    #[arg(long)]
    timed: bool,
    /// Tolerance of the residual relative to forces, where smaller than the model file's.
    #[arg(long, allow_negative_numbers = true)]
    residual: Option<f64>,
    /// Also runs every scheme with the largest step for this multiple of the duration, to show
    /// the drift of energies and momenta.
    #[arg(long, value_name = "TIMES", allow_negative_numbers = true)]
    long: Option<f64>,
    /// Also runs every scheme at every step size with charts of rotations that are kept until three
    /// quarters of a turn instead of half a turn, to show what changes of chart cost.
    #[arg(long)]
    charts: bool,
    /// Prints errors only.
    #[arg(long, short)]
    quiet: bool,
}

/// A step size, or a multiple of the model file's.
#[derive(Clone, Copy, Debug)]
enum Size {
    Own(f64),
    Multiple(f64),
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let read = match text.trim().strip_suffix('x') {
            Some(factor) => factor.parse().map(Self::Multiple),
            None => text.trim().parse().map(Self::Own),
        };
        read.map_err(|_| {
            "it is not a step size: give a number, such as 0.01, or a multiple of the model's own step, such as 2x"
                .to_owned()
        })
    }
}

/// Runs at a time, from the command line.
fn threads(text: &str) -> Result<NonZeroUsize, String> {
    text.parse()
        .map_err(|_| "give a whole number of runs at a time, 1 or more".to_owned())
}

/// The scheme of the reference, in any formulation; it has no tolerance.
fn reference(word: &str) -> Result<Method, CompareError> {
    let candidate: Candidate = word.parse()?;
    match candidate {
        Candidate::Method(method) => Ok(method),
        other => Err(CompareError::ReferenceForm {
            name: other.to_string(),
        }),
    }
}

impl CompareArguments {
    /// What is compared on a model whose own step is `step`.
    fn options(&self, step: f64) -> Result<ComparisonOptions, CompareError> {
        let schemes = self.schemes.iter().map(|name| name.parse());
        let size = |size: &Size| match size {
            Size::Own(h) => *h,
            Size::Multiple(factor) => factor * step,
        };
        Ok(ComparisonOptions {
            schemes: schemes.collect::<Result<_, _>>()?,
            steps: self.steps.iter().map(size).collect(),
            reference: self.reference.as_deref().map(reference).transpose()?,
            exact: None,
            threads: self.threads,
            timed: self.timed,
            long: self.long,
            charts: self.charts,
            residual: self.residual,
        })
    }

    /// A model and the options of its comparison.
    fn subject<'a>(
        &self,
        registry: &'a Registry,
        path: &Path,
    ) -> Result<Subject<'a>, CompareError> {
        let model = path.display().to_string();
        // Every run builds its own model, from the file as it is now.
        let built_in = gallery::model(path).filter(|_| !path.is_file());
        let file = match built_in {
            Some(text) => registry.assemble_text(&model, text)?.file,
            None if !path.exists()
                && path.components().count() == 1
                && path.extension().is_none() =>
            {
                let names = || gallery::MODELS.iter().map(|(name, _)| *name);
                return Err(CompareError::NoModel {
                    near: closest(&model, names()),
                    known: names().collect::<Vec<_>>().join(", "),
                    name: model,
                });
            }
            None => registry.load(path)?.file,
        };
        let Analysis::Dynamic(analysis) = &file.analysis else {
            return Err(CompareError::Static);
        };
        let mut options = self.options(analysis.step)?;
        let source = model.clone();
        let make = move |formulation| registry.job(&source, &file, Some(formulation));
        if let Some(path) = &self.exact {
            let (nodes, times) = compare::sampling(&make, &options.steps)?;
            options.exact = Some(compare::read_exact(path, &nodes, &times)?);
        } else if built_in.is_some() && options.reference.is_none() {
            let (nodes, _) = compare::sampling(&make, &options.steps)?;
            options.exact = gallery::exact(&model, &nodes);
        }
        Ok(Subject {
            name: path
                .file_stem()
                .map_or_else(String::new, |s| s.to_string_lossy().into()),
            model,
            make: Box::new(make),
            options,
        })
    }
}

/// A command line in shell syntax, with the bare name of the program.
pub(super) fn quoted(arguments: &[OsString]) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./:,=+@%".contains(c);
    let word = |(k, word): (usize, &OsString)| {
        let word = match (k, Path::new(word).file_name()) {
            (0, Some(name)) => name.to_string_lossy(),
            _ => word.to_string_lossy(),
        };
        match !word.is_empty() && word.chars().all(plain) {
            true => word.into_owned(),
            false => format!("'{}'", word.replace('\'', "'\\''")),
        }
    };
    let words: Vec<String> = arguments.iter().enumerate().map(word).collect();
    words.join(" ")
}

/// Runs the comparison and prints its outcome; returns the exit code.
pub(super) fn compare(registry: &Registry, args: CompareArguments, command: &str) -> Exit {
    let models = &args.models;
    let directory = args.out.clone();
    let directory = directory.unwrap_or_else(|| models[0].with_extension("compare"));
    let progress = ProgressLine::new(args.quiet);
    let hooks = Hooks {
        // Interrupts are handled from the first step on, as in a run.
        flow: &terminal::flow,
        ended: &|done, all, name| progress.say(&format!("{done} of {all} runs, {name}")),
        refused: &|name, why| {
            let why = why.lines().next().unwrap_or_default();
            progress.tell(&format!("{name} cannot begin: {why}"));
        },
    };
    let subjects = models.iter().map(|path| {
        args.subject(registry, path).map_err(|error| match error {
            CompareError::Static => error.of(&path.display().to_string()),
            error => error,
        })
    });
    let subjects: Result<Vec<_>, _> = subjects.collect();
    let ran = subjects.and_then(|subjects| match &subjects[..] {
        [only] => {
            let (make, model, options) = (&*only.make, &only.model, &only.options);
            let one = compare::run(make, model, Some(command), &directory, options, &hooks)?;
            Ok(vec![one])
        }
        several => compare::run_several(several, Some(command), &directory, &hooks),
    });
    progress.clear();
    let comparisons = ran.map_err(|error| match error {
        CompareError::Input(error) => complain(error),
        error => refuse(error),
    })?;
    let kept = directory.display();
    if comparisons.iter().any(|c| !c.complete) {
        tell(format_args!(
            "interrupted: what was found is kept in {kept}, marked incomplete"
        ));
        return Err(INTERRUPTED);
    }
    if let Some(problem) = problem(&comparisons) {
        tell(format_args!("error: {problem}\nresults are in {kept}"));
        return Err(FAILED);
    }
    if args.quiet {
        return Ok(0);
    }
    let named = |comparison: &Comparison| match comparisons.len() {
        1 => format!("{}\n", compare::summary(comparison)),
        _ => format!("{}\n{}\n", comparison.model, compare::summary(comparison)),
    };
    let text: String = comparisons.iter().map(named).collect();
    Ok(print(&format!("{text}the page is {kept}/compare.html\n")))
}

/// The first reason why comparisons are of no use.
fn problem(comparisons: &[Comparison]) -> Option<String> {
    let find = |why: fn(&Comparison) -> Option<String>| comparisons.iter().find_map(why);
    find(unreferenced)
        .or_else(|| find(unknown))
        .or_else(|| find(unfinished))
}

/// Why a comparison has no reference at all.
fn unreferenced(comparison: &Comparison) -> Option<String> {
    let failure = comparison.reference_failure.as_ref()?;
    let model = &comparison.model;
    Some(format!(
        "{model}: there is no reference, hence no error: {failure}"
    ))
}

/// Why the reference of a comparison knows nothing.
fn unknown(comparison: &Comparison) -> Option<String> {
    let why = compare::unknown(comparison).unwrap_or_default();
    (!comparison.is_known()).then(|| format!("{}: {why}", comparison.model))
}

/// The first failure of a comparison in which no run came to its end.
fn unfinished(comparison: &Comparison) -> Option<String> {
    let failures = comparison.rows.iter().map(|row| row.failure.as_deref());
    let first = *failures.collect::<Option<Vec<_>>>()?.first()?;
    let (model, name) = (&comparison.model, &comparison.rows[0].scheme);
    Some(format!("{model}: no run came to its end; {name}: {first}"))
}
