//! Errors of comparisons.

use crate::input::InputError;
use crate::output::OutputError;
use pullback_integrators::dynamics::DynamicsError;
use pullback_integrators::significant;

/// Why a comparison cannot be made. The failure of a scheme at a step size is not among them: it is a
/// row with the reason.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum CompareError {
    /// The model file is refused.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Any other error, with its model.
    #[error("{model}: {error}")]
    Of { model: String, error: Box<Self> },
    #[error(
        "the analysis of this model is not dynamic: give it [analysis.dynamic] with `to` and `step`"
    )]
    Static,
    #[error("no scheme to compare: name one at least, such as `newmark`")]
    NoScheme,
    #[error("no scheme can begin this motion; {name}: {why}")]
    NoneBegins { name: String, why: String },
    #[error("scheme `{name}` is given twice: name it once")]
    SchemeTwice { name: String },
    #[error(
        "scheme `{name}` cannot be the reference: take one of order 2 or more that is stable at every step"
    )]
    Reference { name: String },
    #[error(
        "the reference is three runs in steps of halves, and `{name}` chooses its own steps: take `radau`, say"
    )]
    ReferenceForm { name: String },
    #[error(
        "there is no file `{name}`, and no model of the gallery has this name{} gallery has {known}",
        near.as_ref().map_or("; the".to_owned(), |near| format!(": did you mean `{near}`? The"))
    )]
    NoModel {
        name: String,
        near: Option<String>,
        known: String,
    },
    #[error("step size {} makes one step of the whole motion: take smaller ones", significant(*value))]
    OneStep { value: f64 },
    #[error("an order takes two step sizes at least, {found} given: name them from large to small")]
    FewSteps { found: usize },
    #[error("step size {} is not usable: it must be positive and finite", significant(*value))]
    Step { value: f64 },
    #[error("step sizes must decrease, and {} comes after {}", significant(*after), significant(*before))]
    Order { before: f64, after: f64 },
    #[error(
        "step size {} is larger than the duration {} of the motion: take smaller ones",
        significant(*value), significant(*to)
    )]
    Long { value: f64, to: f64 },
    #[error("step size {} makes more than {most:e} steps: take larger ones", significant(*value))]
    Many { value: f64, most: f64 },
    #[error(
        "a run of {} times the duration makes more than {most:e} steps: take it shorter",
        significant(*value)
    )]
    TooLong { value: f64, most: f64 },
    #[error(
        "step sizes {before} and {after} both come to {count} equal steps: take sizes further apart"
    )]
    Close {
        before: f64,
        after: f64,
        count: usize,
    },
    #[error("the exact solution {}: {problem}", path.display())]
    Exact {
        path: std::path::PathBuf,
        problem: String,
    },
    #[error("a long run of {} times the duration: give a finite number, 1 or more", significant(*value))]
    Longer { value: f64 },
    #[error("residual {value} is not usable: it must be positive and finite, such as 1e-10")]
    Residual { value: f64 },
    #[error(
        "residual {value:e} is below the rounding of forces, {:.1e} of them: no run reaches it; take 1e-10, for example",
        f64::EPSILON
    )]
    Rounding { value: f64 },
    #[error(
        "two models are called `{name}`: results of each go to a directory of its name; rename a file, or compare \
         on one of them alone"
    )]
    NameTwice { name: String },
    /// An unknown scheme, or a motion that cannot start.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    /// The report cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl CompareError {
    /// The same error with the name of its model; errors of model files contain it already.
    #[must_use]
    pub fn of(self, model: &str) -> Self {
        match self {
            Self::Input(_) | Self::Of { .. } => self,
            error => Self::Of {
                model: model.to_owned(),
                error: Box::new(error),
            },
        }
    }
}
