//! Sweeps: one model with many values of its parameters.

mod table;

pub use table::{SweepTable, TableError};

use super::compare::side_by_side;
use crate::input::{InputError, Job, Registry, with_parameters};
use crate::modes::Eigenvalues;
use crate::output::{Ending, History};
use crate::run::{Recorded, record_job};
use pullback_integrators::linearization::Mode;
use serde::Serialize;
use std::fmt;
use std::ops::ControlFlow;
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Most runs of a sweep; more are taken for a typing error.
const MOST_RUNS: usize = 10_000_000;

/// A parameter and its values.
///
/// As a text `PATH=VALUES`, with the path of [`with_parameters`] and values as `linspace(FROM,TO,COUNT)`,
/// `geomspace(FROM,TO,COUNT)`, or a list `[A,B,...]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Axis {
    /// Path of the parameter.
    pub path: String,
    /// Its values, as in a model file.
    pub values: Vec<String>,
}

/// What is kept of a probe.
///
/// As a text `last`, `max`, `min` or `at(T)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub enum Reduction {
    /// The value of the last row.
    Last,
    /// The largest value of all rows.
    Max,
    /// The smallest value of all rows.
    Min,
    /// The value at a load parameter or time, linear between two rows; of a path, where it passes it first.
    At(f64),
}

/// A sweep: all combinations of the values, the last parameter varying fastest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sweep {
    /// Name of the model file in messages.
    pub model: String,
    /// Its text.
    pub text: String,
    /// The parameters.
    pub axes: Vec<Axis>,
    /// What is kept of each probe.
    pub reductions: Vec<Reduction>,
}

/// One run of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepRow {
    /// Its number, from 0.
    pub run: usize,
    /// The values of the parameters, as in a model file.
    pub parameters: Vec<String>,
    /// `complete`, or why the run has not come to its end.
    pub outcome: String,
    /// Load parameter or time of its last row.
    pub t: f64,
    /// Wall-clock time, in seconds.
    pub seconds: f64,
    /// The columns of [`Sweep::columns`]; not a number where the run has none.
    pub values: Vec<f64>,
    /// Its warnings, with semicolons between them.
    pub warnings: String,
}

/// Why a sweep or a part of it cannot be understood.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{text:?}: {expected}")]
pub struct SweepError {
    /// The text, or what it is about.
    pub text: String,
    /// What is expected instead.
    pub expected: &'static str,
}

impl FromStr for Axis {
    type Err = SweepError;

    fn from_str(text: &str) -> Result<Self, SweepError> {
        let refuse = |expected| SweepError {
            text: text.to_owned(),
            expected,
        };
        let split = text.split_once('=');
        let (path, values) = split.ok_or_else(|| refuse("a parameter is PATH=VALUES"))?;
        let spaced = |geometric| {
            let inner = values.trim().trim_end_matches(')');
            let inner = inner.split_once('(').map_or("", |(_, inner)| inner);
            range(inner, geometric).map_err(refuse)
        };
        let values = match values.trim() {
            v if v.starts_with("linspace(") => spaced(false)?,
            v if v.starts_with("geomspace(") => spaced(true)?,
            list => {
                let list = list.parse::<toml_edit::Value>().ok();
                let list = list.as_ref().and_then(toml_edit::Value::as_array);
                let expected =
                    "values are linspace(FROM,TO,COUNT), geomspace(FROM,TO,COUNT) or [A,B,...]";
                let values = list.ok_or_else(|| refuse(expected))?.iter();
                let values = values.map(|value| value.clone().decorated("", "").to_string());
                values.collect()
            }
        };
        Ok(Self {
            path: path.trim().to_owned(),
            values,
        })
    }
}

/// Equidistant numbers, or numbers with equal ratios, from "FROM,TO,COUNT"; or what is expected instead.
fn range(inner: &str, geometric: bool) -> Result<Vec<String>, &'static str> {
    let parts: Vec<&str> = inner.split(',').map(str::trim).collect();
    let [from, to, count] = parts[..] else {
        return Err("a range is linspace(FROM,TO,COUNT) or geomspace(FROM,TO,COUNT)");
    };
    let number = |text: &str| text.parse().ok().filter(|x: &f64| x.is_finite());
    let (Some(from), Some(to)) = (number(from), number(to)) else {
        return Err("a range begins and ends with a finite number");
    };
    let count = count.parse().ok().filter(|n| (1..=MOST_RUNS).contains(n));
    let count = count.ok_or("the count of a range is a whole number from 1 to 10000000")?;
    if geometric && from * to <= 0.0 {
        return Err("both ends of geomspace have one sign, and neither is zero");
    }
    let value = |k: usize| match k as f64 / (count.max(2) - 1) as f64 {
        1.0 => to,
        s if geometric => from * (to / from).powf(s),
        s => from + s * (to - from),
    };
    Ok((0..count).map(|k| format!("{:?}", value(k))).collect())
}

impl FromStr for Reduction {
    type Err = SweepError;

    fn from_str(text: &str) -> Result<Self, SweepError> {
        let time = text
            .strip_prefix("at(")
            .and_then(|rest| rest.strip_suffix(')'));
        let time = time.and_then(|t| t.trim().parse().ok());
        match (text, time.filter(|t: &f64| t.is_finite())) {
            (_, Some(t)) => Ok(Self::At(t)),
            ("last", _) => Ok(Self::Last),
            ("max", _) => Ok(Self::Max),
            ("min", _) => Ok(Self::Min),
            _ => Err(SweepError {
                text: text.to_owned(),
                expected: "of a probe last, max, min or at(T) is kept",
            }),
        }
    }
}

impl fmt::Display for Reduction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Last => f.write_str("last"),
            Self::Max => f.write_str("max"),
            Self::Min => f.write_str("min"),
            Self::At(t) => write!(f, "at({t})"),
        }
    }
}

impl Reduction {
    /// Of a column of a history; not a number without rows, or outside them.
    fn of(self, history: &History, column: usize) -> f64 {
        let mut values = history.column(column);
        match self {
            Self::Last => values.next_back().unwrap_or(f64::NAN),
            Self::Max => values.fold(f64::NAN, f64::max),
            Self::Min => values.fold(f64::NAN, f64::min),
            Self::At(at) => {
                let times = history.find("t").map(|t| history.column(t));
                let rows: Vec<(f64, f64)> = times.into_iter().flatten().zip(values).collect();
                let between = rows.windows(2).find_map(|pair| {
                    let [(t0, x0), (t1, x1)] = [pair[0], pair[1]];
                    let s = (at - t0) / (t1 - t0);
                    (0.0..=1.0).contains(&s).then_some(x0 + s * (x1 - x0))
                });
                let only = rows.first().filter(|(t, _)| *t == at).map(|(_, x)| *x);
                between.or(only).unwrap_or(f64::NAN)
            }
        }
    }
}

impl Sweep {
    /// A sweep over axes that have values.
    ///
    /// # Errors
    /// [`SweepError`], also for more than ten million runs.
    pub fn new(
        model: String,
        text: String,
        axes: Vec<Axis>,
        reductions: Vec<Reduction>,
    ) -> Result<Self, SweepError> {
        let refuse = |text, expected| Err(SweepError { text, expected });
        if let Some(empty) = axes.iter().find(|axis| axis.values.is_empty()) {
            return refuse(empty.path.clone(), "a parameter has one value or more");
        }
        let sweep = Self {
            model,
            text,
            axes,
            reductions,
        };
        match sweep.runs() {
            runs if runs > MOST_RUNS => {
                refuse(runs.to_string(), "a sweep has at most 10000000 runs")
            }
            _ => Ok(sweep),
        }
    }

    /// Number of runs.
    pub fn runs(&self) -> usize {
        let counts = self.axes.iter().map(|axis| axis.values.len());
        counts.fold(1, usize::saturating_mul)
    }

    /// The values of the parameters in a run.
    pub fn parameters(&self, run: usize) -> Vec<String> {
        let mut rest = run;
        let mut values: Vec<String> = (self.axes.iter().rev())
            .filter_map(|axis| {
                let k = rest % axis.values.len().max(1);
                rest /= axis.values.len().max(1);
                axis.values.get(k).cloned()
            })
            .collect();
        values.reverse();
        values
    }

    /// Names of the values of a run: reductions of probes, and those of modes or critical loads; the model is assembled with
    /// the parameters of the first run.
    ///
    /// # Errors
    /// [`InputError`] if the model is refused, or a parameter unknown.
    pub fn columns(&self, registry: &Registry) -> Result<Vec<String>, InputError> {
        let job = self.job(registry, 0)?;
        let probes = job.probes.iter().flat_map(|probe| probe.columns());
        let mut columns: Vec<String> = probes
            .flat_map(|probe| self.reductions.iter().map(move |r| format!("{probe}.{r}")))
            .collect();
        if let Some((names, count)) = job.eigenvalues.map(|wanted| wanted.columns()) {
            columns.extend((1..=count).flat_map(|k| names.map(|name| format!("{name}_{k}"))));
        }
        Ok(columns)
    }

    fn job(&self, registry: &Registry, run: usize) -> Result<Job, InputError> {
        let paths = self.axes.iter().map(|axis| &axis.path);
        let text = with_parameters(&self.text, paths.zip(self.parameters(run)))?;
        registry.assemble_text(&self.model, &text)
    }

    /// Makes the runs of these numbers in several threads. Rows are given to `each` as they are finished, in any
    /// order; it may stop the sweep, then the runs at work are given up. Each run is by itself: its row does not depend on the number of threads.
    ///
    /// # Errors
    /// As [`Sweep::columns`], before the first run. A run that is refused or fails is a row.
    pub fn run(
        &self,
        registry: &Registry,
        runs: &[usize],
        threads: usize,
        each: &mut (dyn FnMut(SweepRow) -> ControlFlow<()> + Send),
        flow: &(dyn Fn() -> ControlFlow<()> + Sync),
    ) -> Result<(), InputError> {
        let columns = self.columns(registry)?.len();
        let stopped = AtomicBool::new(false);
        let each = Mutex::new(each);
        let flow = || match stopped.load(Ordering::Relaxed) || flow().is_break() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        side_by_side(runs, threads, &|run| {
            if flow().is_break() {
                return;
            }
            let Some(row) = self.row(registry, run, columns, &flow) else {
                return;
            };
            let mut each = each.lock().unwrap_or_else(PoisonError::into_inner);
            if flow().is_continue() && each(row).is_break() {
                stopped.store(true, Ordering::Relaxed);
            }
        });
        Ok(())
    }

    /// One run; none if it is stopped.
    fn row(
        &self,
        registry: &Registry,
        run: usize,
        columns: usize,
        flow: &dyn Fn() -> ControlFlow<()>,
    ) -> Option<SweepRow> {
        let started = Instant::now();
        let recorded = self.job(registry, run).map_err(|error| error.to_string());
        let recorded = recorded.and_then(|job| {
            record_job(job, &mut |_| {}, &mut |_| flow()).map_err(|error| error.to_string())
        });
        let (outcome, t, mut values, warnings) = match &recorded {
            Err(message) => (message.clone(), f64::NAN, Vec::new(), String::new()),
            Ok(recorded) => {
                if let Ending::Interrupted { .. } = recorded.ending {
                    return None;
                }
                let problem = recorded.ending.problem();
                let outcome = problem.unwrap_or_else(|| "complete".to_owned());
                let t = recorded.history.find("t");
                let t = t.and_then(|t| recorded.history.column(t).next_back());
                let warnings = recorded.warnings.join("; ");
                let values = self.values(recorded);
                (outcome, t.unwrap_or(f64::NAN), values, warnings)
            }
        };
        values.resize(columns, f64::NAN);
        Some(SweepRow {
            run,
            parameters: self.parameters(run),
            outcome: outcome.replace('\n', " "),
            t,
            seconds: started.elapsed().as_secs_f64(),
            values,
            warnings: warnings.replace('\n', " "),
        })
    }

    fn values(&self, recorded: &Recorded) -> Vec<f64> {
        let history = &recorded.history;
        let mut values = Vec::new();
        for column in history.probes() {
            values.extend(self.reductions.iter().map(|r| r.of(history, column)));
        }
        let found = match &recorded.eigenvalues {
            Some(Eigenvalues::Modes(found)) => found,
            Some(Eigenvalues::Campbell(found)) => &found.last,
            Some(Eigenvalues::Critical(found)) => {
                values.extend(found.modes.iter().flat_map(|mode| [mode.load, mode.error]));
                return values;
            }
            None => return values,
        };
        let of = |m: &Mode| [m.frequency(), m.damping_ratio()];
        values.extend(found.modes.iter().flat_map(|mode| of(&mode.mode)));
        values
    }
}
