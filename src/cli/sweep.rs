//! `pullback sweep`.

use super::parameters::ModelArguments;
use super::{Exit, FAILED, INTERRUPTED, complain, print, refuse};
use crate::input::Registry;
use crate::studies::sweep::{Axis, Reduction, Sweep, SweepRow, SweepTable};
use crate::terminal::{self, ProgressLine, plural, tell};
use std::collections::HashSet;
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Arguments of `pullback sweep`.
#[derive(clap::Args)]
pub(super) struct SweepArguments {
    #[command(flatten)]
    file: ModelArguments,
    /// A parameter and its values: PATH=linspace(FROM,TO,COUNT), PATH=geomspace(FROM,TO,COUNT) or PATH=[A,B,...].
    /// Of several parameters all combinations are run.
    #[arg(
        long,
        value_name = "PATH=VALUES",
        required = true,
        allow_hyphen_values = true
    )]
    over: Vec<Axis>,
    /// What is kept of each probe: last, max, min or at(T); several by repetition or with commas.
    #[arg(long, default_value = "last", value_delimiter = ',')]
    keep: Vec<Reduction>,
    /// Runs at a time; by default as many as there are processors.
    #[arg(long, allow_negative_numbers = true)]
    workers: Option<NonZeroUsize>,
    /// Directory of the results; `MODEL.sweep` beside the model file by default. A sweep that was stopped goes on there.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Prints errors only.
    #[arg(long, short)]
    quiet: bool,
}

/// Runs a sweep; returns the exit code.
pub(super) fn sweep(registry: &Registry, args: SweepArguments) -> Exit {
    let out = (args.out).unwrap_or_else(|| args.file.model.with_extension("sweep"));
    let text = args.file.text().map_err(complain)?;
    let model = args.file.model.display().to_string();
    let sweep = Sweep::new(model, text, args.over, args.keep).map_err(refuse)?;
    let columns = sweep.columns(registry).map_err(complain)?;
    let mut table = SweepTable::open(&sweep, &columns, &out).map_err(refuse)?;
    let done: HashSet<usize> = table.rows().iter().map(|row| row.run).collect();
    let runs: Vec<usize> = (0..sweep.runs())
        .filter(|run| !done.contains(run))
        .collect();
    let mut progress = ProgressLine::new(args.quiet);
    progress.count(sweep.runs(), done.len());
    let processors = std::thread::available_parallelism().ok();
    let threads = args.workers.or(processors).map_or(1, NonZeroUsize::get);
    let mut unsaved = None;
    let mut each = |row| {
        progress.one();
        match table.add(row) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                unsaved = Some(error);
                ControlFlow::Break(())
            }
        }
    };
    let swept = sweep.run(registry, &runs, threads, &mut each, &terminal::flow);
    progress.clear();
    if let Some(error) = unsaved {
        return Err(refuse(error));
    }
    swept.map_err(complain)?;
    let rows = table.finish().map_err(refuse)?;
    Ok(report(&rows, sweep.runs(), &out, args.quiet))
}

/// Tells how a sweep ended; returns the exit code.
fn report(rows: &[SweepRow], all: usize, out: &Path, quiet: bool) -> u8 {
    let failed = || rows.iter().filter(|row| row.outcome != "complete");
    let count = failed().count();
    if let Some(row) = failed().next() {
        tell(format_args!(
            "warning: {count} of {} did not end as planned, the first one, run {}: {}",
            plural(rows.len(), "run"),
            row.run,
            row.outcome
        ));
    }
    let warned = || rows.iter().filter(|row| !row.warnings.is_empty());
    if let Some(row) = warned().next() {
        tell(format_args!(
            "warning: {} of {} with warnings, the first one, run {}: {}",
            warned().count(),
            plural(rows.len(), "run"),
            row.run,
            row.warnings
        ));
    }
    if rows.len() < all {
        tell(format_args!(
            "interrupted: {} of {} kept in {}; the same command goes on from there",
            rows.len(),
            plural(all, "run"),
            out.display()
        ));
        return INTERRUPTED;
    }
    let code = match count > 0 && count == rows.len() {
        true => FAILED,
        false => 0,
    };
    match quiet {
        true => code,
        false => code.max(print(&format!(
            "{} in {}\n",
            plural(rows.len(), "run"),
            out.join("sweep.csv").display()
        ))),
    }
}
