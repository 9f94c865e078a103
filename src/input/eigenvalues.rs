//! Modes and critical loads of the file as options of the solver.

use super::file::{Analysis, ModalAnalysis};
use super::settings::unknown;
use super::{InputError, Location};
use pullback_integrators::linearization::{ModeOptions, Selection};
use std::f64::consts::TAU;

/// What is found at the end of the steps.
#[derive(Clone, Copy, Debug)]
pub enum EigenvaluePlan {
    /// Modes.
    Modes(ModeOptions),
    /// This many critical loads.
    Buckling(usize),
}

/// What to find at the end of the steps of an analysis.
pub(super) fn plan(
    at: &Location<'_>,
    analysis: &Analysis,
) -> Result<Option<EigenvaluePlan>, InputError> {
    let at = at.at("analysis");
    match analysis {
        Analysis::Modes(m) => {
            mode_options(&at.at("modes"), m).map(|m| Some(EigenvaluePlan::Modes(m)))
        }
        Analysis::Buckling(b) => {
            let at = at.at("buckling");
            at.positive("count", b.count as f64)?;
            if analysis.is_dynamic() {
                let known = ["static", "arc_length"];
                return Err(unknown(&at.at("after"), "dynamic", &known));
            }
            Ok(Some(EigenvaluePlan::Buckling(b.count)))
        }
        _ => Ok(None),
    }
}

fn mode_options(at: &Location<'_>, m: &ModalAnalysis) -> Result<ModeOptions, InputError> {
    at.positive("count", m.count as f64)?;
    if !(m.near >= 0.0 && m.near.is_finite()) {
        return Err(at.range("near", m.near, "a frequency, zero or positive"));
    }
    let selection = match m.range {
        Some([from, to]) if !(0.0 <= from && from < to && to.is_finite()) => {
            return Err(at.range(
                "range",
                to,
                "two frequencies, zero or positive, the smaller one first",
            ));
        }
        Some(range) => Selection::Range(range.map(|f| TAU * f)),
        None => Selection::Nearest {
            count: m.count,
            omega: TAU * m.near,
        },
    };
    Ok(ModeOptions {
        selection,
        undamped: m.undamped,
    })
}
