//! What the program shows while it works, and how it is stopped.

use crate::gallery::Comparison;
use crate::solve::{Advance, Counts};
use indicatif::{ProgressBar, ProgressStyle};
use pullback_integrators::significant;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

/// A line that tells where the analysis is; silent when standard error is no terminal.
pub struct Progress(ProgressBar);

impl Progress {
    /// A line, or none.
    pub fn new(quiet: bool) -> Self {
        if quiet {
            return Self(ProgressBar::hidden());
        }
        let bar = ProgressBar::new_spinner();
        if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed_precise} {msg}") {
            bar.set_style(style);
        }
        Self(bar)
    }

    /// Tells of a converged step.
    pub fn step(&self, step: &Advance<'_>) {
        let parameter = match step.progress {
            Some(_) => "time",
            None => "load parameter",
        };
        self.0.set_message(format!(
            "step {}  {parameter} {}  step size {:.3e}  {}",
            step.number,
            significant(step.t),
            step.step_size,
            plural(step.iterations, "iteration")
        ));
        self.0.tick();
    }

    /// Tells something.
    pub fn say(&self, what: &str) {
        self.0.set_message(what.to_owned());
        self.0.tick();
    }

    /// Removes the line.
    pub fn clear(&self) {
        self.0.finish_and_clear();
    }
}

/// Ctrl-C: the first asks the analysis to stop after the present step, the second ends the
/// program at once.
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on; a program has one ear, whatever it runs.
    pub fn install() -> Self {
        static ASKED: OnceLock<Arc<AtomicBool>> = OnceLock::new();
        Self(Arc::clone(ASKED.get_or_init(listen)))
    }

    /// Whether to go on.
    pub fn flow(&self) -> ControlFlow<()> {
        if self.0.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

fn listen() -> Arc<AtomicBool> {
    let asked = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&asked);
    let installed = ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(crate::cli::INTERRUPTED));
        }
        eprintln!("\nstopping after this step (Ctrl-C again stops at once)");
    });
    if let Err(error) = installed {
        eprintln!("warning: Ctrl-C will stop the program without saving: {error}");
    }
    asked
}

/// The rows of the gallery as text.
pub fn table(rows: &[Comparison]) -> String {
    let longest = |pick: fn(&Comparison) -> &str| {
        rows.iter()
            .map(|r| pick(r).chars().count())
            .max()
            .unwrap_or(0)
    };
    let (case, quantity) = (longest(|r| &r.case), longest(|r| &r.quantity));
    let mut out = format!(
        "{:case$}  {:quantity$}  {:>14}  {:>14}  {:>10}  {:>9}      source\n",
        "case", "quantity", "computed", "published", "difference", "tolerance"
    );
    for row in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "{:case$}  {:quantity$}  {:>14.6}  {:>14.6}  {:>10.2e}  {:>9.1e}  {}  {}",
            row.case,
            row.quantity,
            row.computed,
            row.published,
            row.difference,
            row.tolerance,
            if row.passed() { "ok" } else { "NO" },
            row.source
        );
    }
    let mut cases: Vec<&Comparison> = Vec::new();
    for row in rows {
        if cases.last().is_none_or(|last| last.case != row.case) {
            cases.push(row);
        }
    }
    let total: f64 = cases.iter().map(|row| row.seconds).sum();
    let times = cases
        .iter()
        .map(|row| format!("{} {:.2} s", row.case, row.seconds));
    let times = times.collect::<Vec<_>>().join(", ");
    let off = rows.iter().filter(|row| !row.passed()).count();
    let _ = writeln!(out, "time: {times}");
    let _ = writeln!(
        out,
        "{} comparisons in {} cases, {off} off, {total:.1} s",
        rows.len(),
        cases.len()
    );
    out
}

/// A number of things.
pub fn plural(count: usize, thing: &str) -> String {
    match count {
        1 => format!("1 {thing}"),
        n => format!("{n} {thing}s"),
    }
}

/// Error of the energy over the energy supplied that makes results doubtful.
const DOUBTFUL: f64 = 0.1;

/// What an analysis did, in lines.
pub fn counts(counts: &Counts) -> String {
    let mut out = format!(
        "{} ({} rejected), {}, {}, {}, {} of chart\n",
        plural(counts.steps, "step"),
        counts.rejected + counts.inaccurate,
        plural(counts.iterations, "iteration"),
        plural(counts.evaluations, "evaluation"),
        plural(counts.factorisations, "factorisation"),
        plural(counts.chart_changes, "change")
    );
    if let Some(energy) = counts.energy {
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "energy: kinetic {:.6e}, stored {:.6e}; supplied less dissipated {:.6e}; balance off by \
             {:.2e} at most",
            energy.now.kinetic, energy.now.stored, energy.work, energy.largest_defect
        );
        if energy.largest_defect > DOUBTFUL * energy.start.max(energy.work.abs()) {
            let _ = writeln!(
                out,
                "warning: that is much compared with the energy supplied; take smaller steps, or a \
                 scheme that damps high frequencies (more)"
            );
        }
    }
    out
}
