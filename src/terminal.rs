//! Progress display and interrupts of the program.

use crate::modes::{Eigenvalues, ModelModes};
use crate::solve::{Advance, Counts};
use crate::studies::gallery::CaseRow;
use indicatif::{ProgressBar, ProgressStyle};
use pullback_integrators::linearization::{BucklingMode, CampbellDiagram, Mode};
use std::fmt::Display;
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

/// Writes a line to standard error; errors are ignored.
pub fn tell(what: impl Display) {
    writeln!(io::stderr(), "{what}").ok();
}

/// A progress line; silent if standard error is not a terminal.
pub struct ProgressLine {
    bar: ProgressBar,
    /// The end of a motion.
    to: Option<f64>,
}

/// Number of positions of a progress bar.
const WHOLE: u64 = 1000;

impl ProgressLine {
    /// A line, or none.
    pub fn new(quiet: bool) -> Self {
        let bar = match quiet {
            true => ProgressBar::hidden(),
            false => ProgressBar::new_spinner(),
        };
        let line = Self { bar, to: None };
        line.style("{spinner} {elapsed_precise} {msg}");
        line
    }

    fn style(&self, template: &str) {
        if let Ok(style) = ProgressStyle::with_template(template) {
            self.bar.set_style(style);
        }
    }

    /// Adds a bar to the line, for a motion that ends at the time `to`.
    pub fn until(&mut self, to: f64) {
        self.to = Some(to);
        self.bar.set_length(WHOLE);
        self.style("{spinner} {elapsed_precise} [{bar:20}] {percent} %, {eta} left  {msg}");
    }

    /// Adds a bar with the time left to the line, for runs of which some are done.
    pub fn count(&mut self, runs: usize, done: usize) {
        self.bar.set_length(runs as u64);
        self.bar.set_position(done as u64);
        self.bar.reset_eta();
        self.style("{spinner} {elapsed_precise} [{bar:20}] {pos} of {len} runs, {eta} left");
    }

    /// Shows that one more run is done.
    pub fn one(&self) {
        self.bar.inc(1);
    }

    /// Shows a converged step.
    pub fn step(&self, step: &Advance<'_>) {
        if let Some(to) = self.to {
            self.bar.set_position((WHOLE as f64 * step.part(to)) as u64);
        }
        self.bar.set_message(step.describe());
        self.bar.tick();
    }

    /// Shows a text.
    pub fn say(&self, what: &str) {
        self.bar.set_message(what.to_owned());
        self.bar.tick();
    }

    /// Prints a text permanently, above the line.
    pub fn tell(&self, what: &str) {
        self.bar.suspend(|| tell(what));
    }

    /// Removes the line.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Whether to continue. From the first call on, the first Ctrl-C, SIGTERM or SIGHUP stops the analysis after the
/// present step, the second ends the program at once.
pub fn flow() -> ControlFlow<()> {
    static LISTENING: Once = Once::new();
    LISTENING.call_once(listen);
    match INTERRUPTED.load(Ordering::Relaxed) {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    }
}

fn listen() {
    let installed = ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(crate::cli::INTERRUPTED));
        }
        tell("\nstopping after this step (Ctrl-C again stops at once)");
    });
    if let Err(error) = installed {
        tell(format_args!(
            "warning: Ctrl-C will stop the program without saving: {error}"
        ));
    }
}

/// The rows of the gallery as text.
pub fn table(rows: &[CaseRow]) -> String {
    let case = longest(rows.iter().map(|r| &*r.case));
    let quantity = longest(rows.iter().map(|r| &*r.quantity));
    let mut out = format!(
        "{:case$}  {:quantity$}  {:>14}  {:>14}  {:>10}  {:>9}      source\n",
        "case", "quantity", "computed", "published", "difference", "tolerance"
    );
    for row in rows {
        out += &format!(
            "{:case$}  {:quantity$}  {:>14.6}  {:>14.6}  {:>10.2e}  {:>9.1e}  {}  {}\n",
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
    let cases = rows.chunk_by(|a, b| a.case == b.case);
    let cases: Vec<&CaseRow> = cases.filter_map(|rows| rows.first()).collect();
    let total: f64 = cases.iter().map(|row| row.seconds).sum();
    let times = cases
        .iter()
        .map(|row| format!("{} {:.2} s", row.case, row.seconds));
    let times = times.collect::<Vec<_>>().join(", ");
    let off = rows.iter().filter(|row| !row.passed()).count();
    out += &format!("time: {times}\n");
    out += &format!(
        "{} comparisons in {} cases, {off} off, {total:.1} s\n",
        rows.len(),
        cases.len()
    );
    out
}

/// The number of characters of the longest text.
pub fn longest<'a>(texts: impl IntoIterator<Item = &'a str>) -> usize {
    let lengths = texts.into_iter().map(|text| text.chars().count());
    lengths.max().unwrap_or(0)
}

/// A number with its noun.
pub fn plural(count: usize, thing: &str) -> String {
    match count {
        1 => format!("1 {thing}"),
        n => format!("{n} {thing}s"),
    }
}

/// A table of modes or critical loads.
pub fn eigenvalues(found: &Eigenvalues) -> String {
    match found {
        Eigenvalues::Modes(found) => modes(found),
        Eigenvalues::Campbell(found) => campbell(&found.diagram),
        Eigenvalues::Critical(found) => {
            let mut out = "\nmode  critical load parameter     error\n".to_owned();
            for (k, BucklingMode { load, error, .. }) in found.modes.iter().enumerate() {
                out += &format!("{:4}  {load:23.9e}  {error:8.1e}\n", k + 1);
            }
            out
        }
    }
}

/// Frequencies at the first and the last speed.
fn campbell(diagram: &CampbellDiagram) -> String {
    let number = |mode: Option<&Mode>, value: fn(&Mode) -> f64| match mode {
        Some(mode) => format!("{:.6e}", value(mode)),
        None => "-".to_owned(),
    };
    let mut out = "\nline  first frequency  last frequency  last damping ratio\n".to_owned();
    for (k, line) in diagram.lines.iter().enumerate() {
        let [first, last] = [line.first(), line.last()].map(|mode| mode.and_then(Option::as_ref));
        out += &format!(
            "{:4}  {:>15}  {:>14}  {:>18}\n",
            k + 1,
            number(first, Mode::frequency),
            number(last, Mode::frequency),
            number(last, Mode::damping_ratio)
        );
    }
    if diagram.multi_blade {
        out += "frequencies are those seen from parts that do not rotate: coordinates of the rotor are multi-blade coordinates\n";
    }
    out
}

fn modes(found: &ModelModes) -> String {
    let mut out = "\nmode     frequency  damping ratio  residual\n".to_owned();
    for (k, mode) in found.modes.iter().enumerate() {
        let (number, mode) = (k + 1, &mode.mode);
        let (frequency, zeta) = (mode.frequency(), mode.damping_ratio());
        out += &format!(
            "{number:4}  {frequency:12.6e}  {zeta:13.3e}  {:8.1e}\n",
            mode.residual
        );
    }
    if let Some(counted) = found.counted {
        out += &format!(
            "none is missing: {} by Sylvester's law of inertia\n",
            plural(counted, "eigenvalue")
        );
    }
    out
}

/// Statistics of an analysis, in lines; none where no step was tried, as for modes of a model as drawn.
pub fn counts(counts: &Counts) -> String {
    if counts.steps + counts.rejected + counts.inaccurate == 0 {
        return String::new();
    }
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
        out += &format!(
            "energy: kinetic {:.6e}, stored {:.6e}; supplied less dissipated {:.6e}; balance off by \
             {:.2e} at most\n",
            energy.now.kinetic, energy.now.stored, energy.work, energy.largest_defect
        );
    }
    if let Some(stable) = counts.stable_step {
        out += &format!("stable for steps of at most {stable:.6e} at its start\n");
    }
    out
}
