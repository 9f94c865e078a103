//! `pullback compare`.

use super::{FAILED, INTERRUPTED, REFUSED, complain, print};
use crate::compare::{self, CompareError, Options, Watch};
use crate::input::Registry;
use crate::terminal::{Interrupt, Progress};
use std::ffi::OsString;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// What a command line asks of a comparison.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Model file (TOML; see docs/model_file.md) with a dynamic analysis.
    model: PathBuf,
    /// Schemes by their words, such as newmark, hht:-0.1, ga:0.8; an unknown word is answered by
    /// all there are. A prefix chooses the formulation of rotations: ul-ga:0.8 (updated
    /// Lagrangian), lie-ga:0.8 (Lie group), spin-newmark (Simo & Vu-Quoc). diffsol-bdf and diffsol-esdirk are general
    /// solvers, in programs built with the feature diffsol.
    #[arg(long, value_delimiter = ',', required = true)]
    schemes: Vec<String>,
    /// Step sizes, from large to small.
    #[arg(
        long,
        value_delimiter = ',',
        required = true,
        allow_hyphen_values = true
    )]
    steps: Vec<f64>,
    /// Scheme of the reference; radau by default.
    #[arg(long)]
    reference: Option<String>,
    /// CSV file of an exact solution in place of the reference: see docs/comparing_schemes.md.
    #[arg(long, conflicts_with = "reference")]
    exact: Option<PathBuf>,
    /// Directory of the results; beside the model file by default, `MODEL.compare`.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Runs at a time; as many as there are cores by default. Results do not depend on it.
    #[arg(long)]
    threads: Option<NonZeroUsize>,
    /// Makes each run again, alone on the machine, to take its time.
    #[arg(long)]
    timed: bool,
    /// Says nothing unless something goes wrong.
    #[arg(long, short)]
    quiet: bool,
}

impl Arguments {
    fn options(&self) -> Result<Options, CompareError> {
        let schemes = self.schemes.iter().map(|name| name.parse());
        Ok(Options {
            schemes: schemes.collect::<Result<_, _>>()?,
            steps: self.steps.clone(),
            reference: self.reference.as_deref().map(str::parse).transpose()?,
            threads: self.threads,
            exact: None,
            timed: self.timed,
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
        model, out, quiet, ..
    } = &asked;
    let directory = out.clone();
    let directory = directory.unwrap_or_else(|| compare::default_directory(model));
    let interrupt = Interrupt::install();
    let progress = Progress::new(*quiet);
    let watch = Watch {
        flow: &|| interrupt.flow(),
        ended: &|done, all, name| progress.say(&format!("{done} of {all} runs, {name}")),
    };
    let source = model.display().to_string();
    let ran = asked.options().and_then(|mut options| {
        // Every run has a model of its own, of the file as it is now.
        let file = registry.load(model)?.file;
        let make = |formulation| registry.job_in(&source, &file, formulation);
        if let Some(path) = &asked.exact {
            let (nodes, times) = compare::looked_at(&make, &options.steps)?;
            options.exact = Some(compare::read_exact(path, &nodes, &times)?);
        }
        compare::run(&make, &source, Some(command), &directory, &options, &watch)
    });
    progress.clear();
    let comparison = match ran {
        Ok(comparison) => comparison,
        Err(CompareError::Input(error)) => {
            complain(&error);
            return REFUSED;
        }
        Err(error) => {
            eprintln!("error: {error}");
            return REFUSED;
        }
    };
    let kept = directory.display();
    if !comparison.complete {
        eprintln!("interrupted: what was found is kept in {kept}, marked incomplete");
        return INTERRUPTED;
    }
    if let Some(failure) = &comparison.reference_failure {
        eprintln!("error: there is no reference, hence no error: {failure}\nresults are in {kept}");
        return FAILED;
    }
    if *quiet {
        return 0;
    }
    let orders = compare::summary(&comparison);
    print(&format!("{orders}\nthe page is {kept}/compare.html\n"))
}
