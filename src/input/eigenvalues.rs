//! Modes and critical loads of the file as options of the solver.

use super::file::{Analysis, CampbellAnalysis, ModalAnalysis};
use super::parts::Assembly;
use super::settings::unknown;
use super::{InputError, InputProblem, Location};
use pullback_elements::time::Input;
use pullback_integrators::linearization::{CampbellOptions, ModeOptions, Selection};
use pullback_integrators::statics::StaticOptions;
use std::f64::consts::TAU;

/// What is found at the end of the steps.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum EigenvaluePlan {
    /// Modes.
    Modes(ModeOptions),
    /// This many critical loads.
    Buckling(usize),
    /// Modes over a speed, an input.
    Campbell(Input, CampbellOptions),
}

impl EigenvaluePlan {
    /// Names of the two values of each mode, and the number of modes, where it is known.
    pub(crate) fn columns(&self) -> ([&'static str; 2], usize) {
        let of_modes = ["frequency", "damping_ratio"];
        match self {
            Self::Modes(options) => match options.selection {
                Selection::Nearest { count, .. } => (of_modes, count),
                Selection::Range(_) => ([""; 2], 0),
            },
            Self::Buckling(count) => (["load", "error"], *count),
            // Those at the last speed.
            Self::Campbell(_, options) => (of_modes, options.count),
        }
    }
}

/// What to find at the end of the steps of an analysis.
pub(super) fn plan(assembly: &Assembly<'_>) -> Result<Option<EigenvaluePlan>, InputError> {
    let (at, analysis) = (assembly.at("analysis"), &assembly.file.analysis);
    match analysis {
        Analysis::Modes(m) => {
            mode_options(&at.at("modes"), m).map(|m| Some(EigenvaluePlan::Modes(m)))
        }
        Analysis::Buckling(b) => {
            let at = at.at("buckling");
            check_count(&at, b.count)?;
            if analysis.is_dynamic() {
                let known = ["static", "arc_length"];
                return Err(unknown(&at.at("after"), "dynamic", &known));
            }
            Ok(Some(EigenvaluePlan::Buckling(b.count)))
        }
        Analysis::Campbell(c) => {
            let at = at.at("campbell");
            let speed = assembly.speed.ok_or_else(|| {
                let joints = assembly.file.joints.iter();
                at.at("joint").refuse(InputProblem::UnknownName {
                    what: "joint",
                    name: c.joint.clone(),
                    known: joints.map(|joint| joint.name.clone()).collect(),
                })
            })?;
            Ok(Some(EigenvaluePlan::Campbell(speed, speeds(&at, c)?)))
        }
        _ => Ok(None),
    }
}

fn speeds(at: &Location<'_>, c: &CampbellAnalysis) -> Result<CampbellOptions, InputError> {
    check_count(at, c.count)?;
    at.positive("steps", c.steps as f64)?;
    for (key, speed) in [("from", c.from), ("to", c.to)] {
        let expected = "a speed in radians per unit of time";
        at.refuse_if(!speed.is_finite(), key, speed, expected)?;
    }
    let many = c.steps > MOST;
    at.refuse_if(many, "steps", c.steps as f64, "at most 100000 steps")?;
    let steps = if c.from == c.to { 0 } else { c.steps };
    let part = |k: usize| k as f64 / steps.max(1) as f64;
    Ok(CampbellOptions {
        t: 0.0,
        speeds: (0..=steps)
            .map(|k| c.from + part(k) * (c.to - c.from))
            .collect(),
        count: c.count,
        statics: StaticOptions::default(),
        rotor: None,
    })
}

/// Most modes, and most speeds of a diagram; more are taken for a typing error.
const MOST: usize = 100_000;

fn check_count(at: &Location<'_>, count: usize) -> Result<(), InputError> {
    let sensible = (1..=MOST).contains(&count);
    at.refuse_if(
        !sensible,
        "count",
        count as f64,
        "a number from 1 to 100000",
    )
}

fn mode_options(at: &Location<'_>, m: &ModalAnalysis) -> Result<ModeOptions, InputError> {
    let selection = match m.range {
        Some([from, to]) if !(0.0 <= from && from < to && to.is_finite()) => {
            return Err(at.range(
                "range",
                format!("[{from}, {to}]"),
                "two frequencies, zero or positive, the smaller one first",
            ));
        }
        Some(range) => {
            for (key, given) in [("count", m.count.is_some()), ("near", m.near.is_some())] {
                if given {
                    return Err(at.exclude(key, "range"));
                }
            }
            Selection::Range(range.map(|f| TAU * f))
        }
        None => {
            let (count, near) = (m.count.unwrap_or(10), m.near.unwrap_or(0.0));
            check_count(at, count)?;
            let usable = near >= 0.0 && near.is_finite();
            at.refuse_if(!usable, "near", near, "a frequency, zero or positive")?;
            Selection::Nearest {
                count,
                omega: TAU * near,
            }
        }
    };
    Ok(ModeOptions {
        selection,
        undamped: m.undamped,
    })
}
