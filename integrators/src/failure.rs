//! Report of a failed step: position, cause, iterations and the worst residuals.

use crate::abilities::{charts, events};
use crate::linear_solver::{LinearError, null_vector};
use crate::statics::{Iteration, solutions};
use pullback_manifold::domain::DomainError;
use pullback_manifold::system::{Quantity, System, SystemError};
use std::fmt;

/// The parameter that a step advances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StepParameter {
    /// The load parameter of statics.
    Load,
    /// Time.
    Time,
    /// The speed of a steady motion.
    Speed,
}

/// The cause of a failed step.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Cause {
    /// The system cannot be evaluated there.
    System(SystemError),
    /// The tangent is singular or the linear solver failed.
    Linear {
        /// The error of the solver.
        error: LinearError,
        /// Components of the mechanism by name, largest first.
        mechanism: Vec<(String, f64)>,
    },
    /// Corrections grow even when damped.
    Diverged,
    /// The path turns too sharply for the step.
    OffPath,
    /// No convergence within the allowed iterations.
    TooManyIterations,
    /// The local error needs steps below the smallest one.
    Inaccurate,
    /// The path passes an event within the step that cannot be located.
    Unlocated {
        /// The event, in words.
        position: String,
    },
}

/// Report of a failed step.
#[derive(Clone, Debug, PartialEq)]
pub struct FailedStep {
    /// Number of the step, from 1; 0 is the equilibrium at the start of statics.
    pub step: usize,
    /// The parameter that the step advances.
    pub parameter: StepParameter,
    /// Its value at the last converged step.
    pub from: f64,
    /// The attempted value.
    pub to: f64,
    /// The cause.
    pub cause: Cause,
    /// Iterations of the last attempt.
    pub history: Vec<Iteration>,
    /// Per quantity: name of the coordinate with the largest residual, and that residual.
    pub worst: Vec<(Quantity, String, f64)>,
    /// Number of failed attempts so far.
    pub rejected: usize,
    /// The smallest allowed step, if it prevents another halving; in statics.
    pub min_step: Option<f64>,
    /// A kink or jump of a function of the load parameter within the step.
    pub kink: Option<f64>,
    /// Warnings of the system ([`Charts::singularity_warnings`](pullback_manifold::system::Charts::singularity_warnings)).
    pub singularity_warnings: Vec<String>,
    /// Number of evaluations of the system so far.
    pub evaluations: usize,
    /// Number of factorisations so far.
    pub factorisations: usize,
}

impl Cause {
    /// The tangent cannot be solved with; the report finds the mechanism.
    pub(crate) fn linear(error: LinearError) -> Self {
        Self::Linear {
            error,
            mechanism: Vec::new(),
        }
    }
}

/// An attempt at a step that failed.
pub(crate) struct FailureContext<'a> {
    pub cause: Cause,
    pub r: &'a [f64],
    pub S: &'a [f64],
    pub history: &'a [Iteration],
    pub parameter: StepParameter,
    /// Value of the parameter at the beginning, and the attempted one.
    pub span: [f64; 2],
    /// Numbers of steps and of failed attempts before this one.
    pub steps: usize,
    pub rejected: usize,
    pub evaluations: usize,
    pub factorisations: usize,
}

impl FailedStep {
    /// Reports a failure.
    pub(crate) fn new(system: &mut dyn System, context: FailureContext<'_>) -> Box<Self> {
        let mut cause = context.cause;
        match &mut cause {
            Cause::Linear {
                error: LinearError::NonFinite { unknown, .. },
                ..
            } => {
                let what = system.name(*unknown);
                cause = Cause::System(SystemError::NotFinite { what });
            }
            Cause::Linear { mechanism, .. } => *mechanism = find_mechanism(system, context.S),
            _ => {}
        }
        let [from, to] = context.span;
        Box::new(Self {
            step: context.steps + 1,
            parameter: context.parameter,
            from,
            to,
            history: context.history.to_vec(),
            worst: worst(system, context.r),
            rejected: context.rejected,
            min_step: None,
            // An evaluation error gives the reason itself.
            singularity_warnings: match cause {
                Cause::System(_) => Vec::new(),
                _ => charts(system).singularity_warnings(),
            },
            kink: match context.parameter {
                StepParameter::Load => (events(system).kinks().into_iter())
                    .find(|k| (from.min(to)..=from.max(to)).contains(k) && *k != from),
                StepParameter::Time | StepParameter::Speed => None,
            },
            cause,
            evaluations: context.evaluations,
            factorisations: context.factorisations,
        })
    }

    /// Whether the residual was falling by orders of magnitude when the iterations ended.
    fn was_converging(&self) -> bool {
        matches!(&self.history[..], [.., before, last] if last.ratio < 0.1 * before.ratio)
    }

    /// Writes the position of the step and the number of attempts.
    fn heading(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parameter = match self.parameter {
            StepParameter::Load => "load parameter",
            StepParameter::Time => "time",
            StepParameter::Speed => "speed",
        };
        let [from, to] = [self.from, self.to].map(significant);
        if self.step == 0 {
            return write!(
                f,
                "no equilibrium is found at the start, {parameter} {from}: "
            );
        }
        let known = if self.step == 1 { "start" } else { "converged" };
        write!(f, "step {} failed ", self.step)?;
        // A step may be too small to be seen in these digits.
        if from == to {
            write!(f, "right after {parameter} {from} ({known})")?;
        } else {
            write!(f, "between {parameter} {from} ({known}) and {to}")?;
        }
        write!(f, " (smallest step {:.1e})", self.to - self.from)?;
        match self.rejected {
            0 => {}
            1 => write!(f, " after 1 rejected attempt")?,
            n => write!(f, " after {n} rejected attempts")?,
        }
        if let Some(min) = self.min_step {
            write!(f, "; half of this step is below min_step = {min:?}")?;
        }
        f.write_str(": ")
    }
}

/// The largest residual of each quantity that is out of balance, with the name of its coordinate.
fn worst(system: &dyn System, r: &[f64]) -> Vec<(Quantity, String, f64)> {
    let mut worst: [Option<(usize, f64)>; 3] = [None; 3];
    for (i, r) in r.iter().enumerate() {
        let entry = &mut worst[system.pattern().coordinates()[i].quantity.index()];
        if entry.is_none_or(|(_, largest)| r.abs() > largest) {
            *entry = Some((i, r.abs()));
        }
    }
    let found = Quantity::ALL.into_iter().zip(worst);
    let found = found.filter_map(|(quantity, worst)| {
        let (i, r) = worst.filter(|(_, r)| *r > 0.0)?;
        Some((quantity, system.name(i), r))
    });
    found.collect()
}

/// The largest components of the null vector, with names.
pub(crate) fn find_mechanism(system: &dyn System, values: &[f64]) -> Vec<(String, f64)> {
    let Some(null) = null_vector(system.pattern(), values) else {
        return Vec::new();
    };
    let mut order: Vec<usize> = (0..null.vector.len()).collect();
    order.sort_by(|&a, &b| null.vector[b].abs().total_cmp(&null.vector[a].abs()));
    order
        .into_iter()
        .take(4)
        .filter(|&i| null.vector[i].abs() > 1e-3)
        .map(|i| (system.name(i), null.vector[i]))
        .collect()
}

/// The components of a mechanism, each on a line.
pub(crate) fn names(mechanism: &[(String, f64)]) -> String {
    match mechanism {
        // Its component of a vector of length one says nothing.
        [(name, _)] => format!("\n    {name}"),
        all => all
            .iter()
            .map(|(name, entry)| format!("\n    {name} ({entry:+.3})"))
            .collect(),
    }
}

/// Why a tangent cannot be solved with, with the mechanism, if there is one, and its remedy.
pub(crate) fn unresisted(error: &LinearError, mechanism: &[(String, f64)], remedy: &str) -> String {
    let solved = format!("the tangent cannot be solved with: {error}");
    match mechanism {
        [] => solved,
        _ => {
            let names = names(mechanism);
            format!("what moves without resistance:{names}\n  {remedy}\n  ({solved})")
        }
    }
}

impl FailedStep {
    /// Writes the cause, with a remedy.
    fn explain(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.cause {
            Cause::System(error) => self.explain_system(error, f),
            Cause::Linear { error, mechanism } => f.write_str(&unresisted(
                error,
                mechanism,
                match self.parameter {
                    StepParameter::Speed => "hold it, or begin at a speed that holds it",
                    _ if self.step == 0 => "hold it by a support, a spring or a prescribed motion",
                    StepParameter::Load => {
                        "hold it by a support, a spring, a prescribed motion, or loads that act from the start; if this \
                         is a limit point, follow the path with arc-length control"
                    }
                    StepParameter::Time => "give it mass or stiffness, or hold it",
                },
            )),
            Cause::Diverged => f.write_str(match self.parameter {
                StepParameter::Speed => {
                    "Newton's corrections grow however they are damped; near a critical speed deflections grow \
                     without bounds: begin beyond it, or make the imbalance smaller"
                }
                _ if self.step == 0 => {
                    "Newton's corrections grow however they are damped; let the loads and prescribed \
                     displacements that are there grow from zero, or make them smaller"
                }
                StepParameter::Load => {
                    "Newton's corrections grow however they are damped; a limit point may lie ahead \
                     (try arc-length control), or the load is too large"
                }
                StepParameter::Time => "Newton's corrections grow; take smaller steps",
            }),
            Cause::OffPath => f.write_str(
                "the path turns too sharply for steps of this size, branches or ends, or elements of total rotation vectors \
                 change their charts and jump (those with `interpolation = \"geodesic\"` do not jump); with a larger \
                 load_scale displacements measure steps more than loads do, which helps at limit points of shallow or stiff \
                 structures together with a max_step and a first_step below their displacements over their size; an \
                 imperfection makes branches smooth",
            ),
            Cause::Inaccurate => f.write_str(
                "the estimate of the local error asks for steps below min_step; raise the tolerance",
            ),
            Cause::Unlocated { position } => write!(
                f,
                "the path passes {position} in this step, but no equilibrium is found there: it may \
                 jump or branch, and then an imperfection makes it smooth; or displacements are too \
                 small beside the loads, and then a larger load_scale makes steps follow them"
            ),
            Cause::TooManyIterations => {
                let word = match solutions(&self.history) {
                    1 => "1 iteration".to_owned(),
                    n => format!("{n} iterations"),
                };
                write!(f, "Newton's method did not converge in {word}")?;
                if self.was_converging() {
                    write!(f, "; it was converging fast: raise max_iterations")?;
                }
                Ok(())
            }
        }
    }

    fn explain_system(&self, error: &SystemError, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match error {
            // There are no steps before the start that could be smaller.
            SystemError::Domain {
                what,
                why: DomainError::Beyond { limit, .. },
            } if self.step == 0 => write!(
                f,
                "{what} left {limit}: let the loads and prescribed displacements that are there grow \
                 from zero, or make them smaller"
            ),
            error if self.step == 0 || self.min_step.is_none() => write!(f, "{error}"),
            error => write!(
                f,
                "{error}\n  where halving does not help the load is far too large (units?), or the \
                 structure is a mechanism"
            ),
        }
    }
}

impl fmt::Display for FailedStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.heading(f)?;
        self.explain(f)?;
        if let (Some(kink), Some(_)) = (self.kink, self.min_step) {
            write!(
                f,
                "\n  a function of t has a jump or kink at {}, within this step: where a load jumps \
                 no step is small enough; let it grow by a ramp",
                significant(kink)
            )?;
        }
        for warning in &self.singularity_warnings {
            write!(f, "\n  {warning}")?;
        }
        for (quantity, name, residual) in &self.worst {
            let conjugate = quantity.conjugate();
            write!(
                f,
                "\n  largest {conjugate} out of balance: {residual:.3e} at {name}"
            )?;
        }
        if self.history.is_empty() {
            return Ok(());
        }
        let occurs = |k: usize| self.history.iter().any(|i| i.residual[k] != 0.0);
        let quantities = Quantity::ALL.into_iter().filter(|x| occurs(x.index()));
        write!(f, "\n  iteration")?;
        for quantity in quantities.clone() {
            write!(f, "  {:>10}", quantity.conjugate())?;
        }
        write!(f, "  over tolerance  correction  damping")?;
        for (k, i) in self.history.iter().enumerate() {
            write!(f, "\n  {k:9}")?;
            for quantity in quantities.clone() {
                write!(f, "  {:10.3e}", i.residual[quantity.index()])?;
            }
            write!(
                f,
                "  {:14.3e}  {:10.3e}  {:7.3}",
                i.ratio, i.correction, i.damping
            )?;
        }
        Ok(())
    }
}

/// Formats a number for messages: at most seven significant digits.
pub fn significant(x: f64) -> String {
    let rounded = format!("{x:.6e}").parse().unwrap_or(x);
    // Debug writes the shortest digits, with an exponent instead of many zeros.
    let text = format!("{:?}", rounded + 0.0);
    match text.strip_suffix(".0") {
        Some(whole) => whole.to_owned(),
        None => text,
    }
}
