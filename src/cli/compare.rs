//! `pullback compare`.

use super::{FAILED, INTERRUPTED, REFUSED, complain, print};
use crate::input::{Analysis, Registry, closest};
use crate::method::Method;
use crate::studies::compare::{self, CompareError, Contender, Options, Subject, Watch};
use crate::studies::gallery;
use crate::terminal::{Interrupt, Progress, tell};
use std::ffi::OsString;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// What a command line asks of a comparison.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Model file (TOML; see docs/model_file.md) with a dynamic analysis, or the name of a model of
    /// the gallery, such as top or elbow. Several of them make one page; what belongs to each goes to
    /// a directory of its name.
    #[arg(required = true)]
    models: Vec<PathBuf>,
    /// Schemes by their words, such as newmark, hht:-0.1, ga:0.8; an unknown word is answered by
    /// all there are. A prefix chooses the formulation of rotations: ul-ga:0.8 (updated
    /// Lagrangian), lie-ga:0.8 (Lie group), spin-newmark (sums of spatial spins).
    /// diffsol-bdf and diffsol-esdirk are general solvers, in programs built with the feature diffsol.
    #[arg(long, value_delimiter = ',', required = true)]
    schemes: Vec<String>,
    /// Step sizes, from large to small; with an x behind them multiples of the model file's own
    /// step: 2x,1x,0.5x.
    #[arg(
        long,
        value_delimiter = ',',
        required = true,
        allow_hyphen_values = true
    )]
    steps: Vec<Size>,
    /// Scheme of the reference, with the prefix of a formulation where it is to have one; radau by default.
    #[arg(long)]
    reference: Option<String>,
    /// CSV file of an exact solution in place of the reference: see docs/comparing_schemes.md.
    #[arg(long, conflicts_with = "reference")]
    exact: Option<PathBuf>,
    /// Directory of the results; beside the (first) model file by default, `MODEL.compare`.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Runs at a time; as many as there are cores by default. Results do not depend on it.
    #[arg(long, value_parser = threads)]
    threads: Option<NonZeroUsize>,
    /// Makes each run again, alone on the machine, to take its time.
    #[arg(long)]
    timed: bool,
    /// Residual over forces that runs are converged to, where it is smaller than the model file's.
    #[arg(long)]
    residual: Option<f64>,
    /// Runs every scheme once more with the largest step, for so many times the duration, to see
    /// what becomes of energies and momenta.
    #[arg(long, value_name = "TIMES")]
    long: Option<f64>,
    /// Runs every scheme once more at every step size with charts of rotations that are kept until
    /// three quarters of a turn, in place of half a one, to see what changes of chart cost.
    #[arg(long)]
    charts: bool,
    /// Says nothing unless something goes wrong.
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
            "it is no step size: give a number, such as 0.01, or a multiple of the model's own step, such as 2x"
                .to_owned()
        })
    }
}

/// Runs at a time, from the command line.
fn threads(text: &str) -> Result<NonZeroUsize, String> {
    text.parse()
        .map_err(|_| "give a whole number of runs at a time, 1 or more".to_owned())
}

/// The scheme of the reference, in whatever formulation; it has no tolerance.
fn reference(word: &str) -> Result<Method, CompareError> {
    let contender: Contender = word.parse()?;
    match contender {
        Contender::Method(method) => Ok(method),
        other => Err(CompareError::ReferenceForm {
            name: other.to_string(),
        }),
    }
}

impl Arguments {
    /// What is compared on a model whose own step is `step`.
    fn options(&self, step: f64) -> Result<Options, CompareError> {
        let schemes = self.schemes.iter().map(|name| name.parse());
        let size = |size: &Size| match size {
            Size::Own(h) => *h,
            Size::Multiple(factor) => factor * step,
        };
        Ok(Options {
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

    /// A model and what is compared on it.
    fn subject<'a>(
        &self,
        registry: &'a Registry,
        path: &Path,
    ) -> Result<Subject<'a>, CompareError> {
        let model = path.display().to_string();
        // Every run has a model of its own, of the file as it is now.
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
        let make = move |formulation| registry.job_in(&source, &file, formulation);
        if let Some(path) = &self.exact {
            let (nodes, times) = compare::looked_at(&make, &options.steps)?;
            options.exact = Some(compare::read_exact(path, &nodes, &times)?);
        } else if built_in.is_some() && options.reference.is_none() {
            let (nodes, _) = compare::looked_at(&make, &options.steps)?;
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

/// A command line as a shell would take it, the program by its bare name.
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

/// Compares, and tells how it ended; the exit code.
pub(super) fn compare(registry: &Registry, asked: Arguments, command: &str) -> u8 {
    let Arguments {
        models, out, quiet, ..
    } = &asked;
    let directory = out.clone();
    let directory = directory.unwrap_or_else(|| compare::default_directory(&models[0]));
    let progress = Progress::new(*quiet);
    let watch = Watch {
        // As in a run, from the first step on.
        flow: &|| Interrupt::install().flow(),
        ended: &|done, all, name| progress.say(&format!("{done} of {all} runs, {name}")),
        refused: &|name, why| {
            let why = why.lines().next().unwrap_or_default();
            progress.tell(&format!("{name} cannot begin: {why}"));
        },
    };
    let subjects = models.iter().map(|path| {
        asked.subject(registry, path).map_err(|error| match error {
            CompareError::Static => error.of(&path.display().to_string()),
            error => error,
        })
    });
    let subjects: Result<Vec<_>, _> = subjects.collect();
    let ran = subjects.and_then(|subjects| match &subjects[..] {
        [only] => {
            let Subject {
                model,
                make,
                options,
                ..
            } = only;
            let one = compare::run(&**make, model, Some(command), &directory, options, &watch)?;
            Ok(vec![one])
        }
        several => compare::run_several(several, Some(command), &directory, &watch),
    });
    progress.clear();
    let comparisons = match ran {
        Ok(comparisons) => comparisons,
        Err(CompareError::Input(error)) => {
            complain(&error);
            return REFUSED;
        }
        Err(error) => {
            tell(format_args!("error: {error}"));
            return REFUSED;
        }
    };
    let kept = directory.display();
    if comparisons.iter().any(|c| !c.complete) {
        tell(format_args!(
            "interrupted: what was found is kept in {kept}, marked incomplete"
        ));
        return INTERRUPTED;
    }
    for comparison in &comparisons {
        if let Some(failure) = &comparison.reference_failure {
            let model = &comparison.model;
            tell(format_args!(
                "error: {model}: there is no reference, hence no error: {failure}\nresults are in \
                 {kept}"
            ));
            return FAILED;
        }
    }
    if let Some(comparison) = comparisons.iter().find(|c| !c.is_known()) {
        let model = &comparison.model;
        let why = compare::unknown(comparison).unwrap_or_default();
        tell(format_args!("error: {model}: {why}\nresults are in {kept}"));
        return FAILED;
    }
    for comparison in &comparisons {
        let failures = comparison.rows.iter().map(|row| row.failure.as_deref());
        if let Some([first, ..]) = failures.collect::<Option<Vec<_>>>().as_deref() {
            let (model, name) = (&comparison.model, &comparison.rows[0].scheme);
            tell(format_args!(
                "error: {model}: no run came to its end; {name}: {first}\nresults are in {kept}"
            ));
            return FAILED;
        }
    }
    if *quiet {
        return 0;
    }
    let mut text = String::new();
    for comparison in &comparisons {
        if comparisons.len() > 1 {
            text += &format!("{}\n", comparison.model);
        }
        text += &format!("{}\n", compare::summary(comparison));
    }
    print(&format!("{text}the page is {kept}/compare.html\n"))
}
