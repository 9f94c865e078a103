//! Time integration schemes: tables of one step routine.
//!
//! A step of size h has stages at the times tₙ + cᵢ h, in each of which equilibrium holds, r(tᵢ,
//! qᵢ, q̇ᵢ, q̈ᵢ) = 0. Coordinates and velocities of a stage are those at tₙ plus weighted
//! accelerations y, with y₀ the old one and yⱼ those of the stages:
//!
//! ```text
//! qᵢ = qₙ + cᵢ h q̇ₙ + h² Σ Qᵢⱼ yⱼ,      q̇ᵢ = q̇ₙ + h Σ Vᵢⱼ yⱼ
//! ```
//!
//! The last stage is the new state. Stages that depend on each other's accelerations are solved
//! together, all others one after the other; a stage whose coordinates do not depend on its own
//! acceleration is explicit. So Newmark's scheme, composite schemes, Runge-Kutta methods and the
//! central difference are tables ([`Stage`]); runs, checkpoints and changes of chart are independent of them.

mod bathe;
mod central_difference;
mod generalised_alpha;
mod list;
mod projected_newmark;
mod radau;
mod stage;
mod tsitouras;

pub use generalised_alpha::Coefficients;
pub use list::{Family, SCHEMES, Stability};
pub(super) use stage::inverse;
pub use stage::{STAGES, Stage};

use super::DynamicsError;
use std::fmt;
use std::ops::Range;

/// Stated properties of a scheme; the conformance kit measures them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SchemeProperties {
    /// Order of accuracy of coordinates and velocities.
    pub order: usize,
    /// Largest Ω = ω h at which undamped vibrations do not grow; `None` for a scheme that is
    /// stable at every step size.
    pub limit: Option<f64>,
    /// Whether a step back with −h undoes a step with h.
    pub symmetric: bool,
}

/// A time integration scheme: a table of stages, with the filter of accelerations of the
/// generalised-α method,
///
/// ```text
/// (1−α_m) yₙ₊₁ + α_m yₙ = (1−α_f) q̈ₙ₊₁ + α_f q̈ₙ                  [M04] ch. 5, Arnold & Brüls 2007
/// ```
///
/// and y = q̈ for all others. Created by its constructors, by [`Scheme::new`] from a table, or from
/// a word of [`SCHEMES`] such as `ga:0.8`:
///
/// ```
/// # use pullback_integrators::dynamics::Scheme;
/// let scheme: Scheme = "hht:-0.1".parse()?;
/// assert_eq!(scheme, Scheme::hht(-0.1)?);
/// assert_eq!(scheme.to_string(), "hht:-0.1");
/// assert!("ga:1.5".parse::<Scheme>().is_err());
/// # Ok::<(), pullback_integrators::dynamics::DynamicsError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// Name for output.
    pub name: &'static str,
    word: &'static str,
    arguments: [Option<f64>; 2],
    properties: SchemeProperties,
    alpha_m: f64,
    alpha_f: f64,
    stages: [Stage; STAGES],
    count: usize,
    /// Whether steps are projected onto energy and momenta.
    projected: bool,
    /// Orders with multipliers where they differ.
    multiplier_orders: Option<[usize; 2]>,
    embedded: Option<Stage>,
}

impl Default for Scheme {
    /// The trapezoidal rule: Newmark(1/4, 1/2).
    fn default() -> Self {
        Self::trapezoidal()
    }
}

impl Scheme {
    /// A scheme by its table, y = q̈.
    ///
    /// # Errors
    /// [`DynamicsError::Table`] for an invalid table: no stages or too many, weights that are not
    /// finite or belong to no stage, the name of another scheme, an end other than c = 1, stages
    /// that cannot be solved for their accelerations.
    pub fn new(
        name: &'static str,
        stages: &[Stage],
        properties: SchemeProperties,
    ) -> Result<Self, DynamicsError> {
        let scheme = Self::table(name, name, stages, properties);
        match scheme.problem(stages.len()) {
            None => Ok(scheme),
            Some(problem) => Err(DynamicsError::Table { name, problem }),
        }
    }

    fn problem(&self, count: usize) -> Option<&'static str> {
        let rows = self.stages();
        let numbers = || rows.iter().flat_map(|s| s.q.iter().chain(&s.v));
        let family = self.word.split(':').next().unwrap_or_default();
        let beyond = |w: &[f64; 1 + STAGES]| w[1 + self.count..].iter().any(|w| *w != 0.0);
        if count == 0 || count > STAGES {
            Some("it has no stages, or more than `STAGES`")
        } else if !numbers()
            .chain(rows.iter().map(|s| &s.c))
            .all(|w| w.is_finite())
        {
            Some("a number in it is not finite")
        } else if SCHEMES.iter().any(|f| [f.word, f.long].contains(&family)) {
            Some("a scheme of the list has this name")
        } else if rows.iter().any(|s| beyond(&s.q) || beyond(&s.v)) {
            Some("a weight belongs to a stage that it does not have")
        } else if rows.iter().any(|s| !(s.c > 0.0 && s.c <= 1.0)) || rows[count - 1].c != 1.0 {
            Some("its stages must lie within the step (0 < c <= 1), the last one at c = 1")
        } else if self
            .groups()
            .any(|g| g.len() > 1 && inverse(rows, &g).is_none())
        {
            Some("the weights of stages that depend on each other are singular")
        } else {
            None
        }
    }

    fn table(
        name: &'static str,
        word: &'static str,
        stages: &[Stage],
        properties: SchemeProperties,
    ) -> Self {
        let count = stages.len().min(STAGES);
        let mut all = [Stage::default(); STAGES];
        all[..count].copy_from_slice(&stages[..count]);
        Self {
            name,
            word,
            arguments: [None; 2],
            properties,
            alpha_m: 0.0,
            alpha_f: 0.0,
            stages: all,
            count,
            projected: false,
            multiplier_orders: None,
            embedded: None,
        }
    }

    /// The rows of the table.
    pub fn stages(&self) -> &[Stage] {
        &self.stages[..self.count]
    }

    /// Stated properties.
    pub fn properties(&self) -> SchemeProperties {
        self.properties
    }

    /// Order of accuracy.
    pub fn order(&self) -> usize {
        self.properties.order
    }

    /// Orders of accuracy of positions and velocities with multipliers, whose equations between
    /// coordinates (index 3) reduce the order of some schemes. Accelerations and multipliers follow from
    /// both, and have the order of velocities.
    pub fn orders_with_multipliers(&self) -> [usize; 2] {
        self.multiplier_orders.unwrap_or([self.order(); 2])
    }

    /// The same scheme with stated orders of positions and velocities with multipliers. By default they
    /// equal those without multipliers.
    #[must_use]
    pub fn under_multipliers(mut self, orders: [usize; 2]) -> Self {
        self.multiplier_orders = Some(orders);
        self
    }

    /// The same scheme with an embedded method of one order less: a row that ends the step with other
    /// weights of the same accelerations. The difference estimates the local error for adaptive steps.
    #[must_use]
    pub fn with_embedded(mut self, row: Stage) -> Self {
        self.embedded = Some(row);
        self
    }

    /// The row of the embedded method, if there is one ([`Scheme::with_embedded`]).
    pub fn embedded(&self) -> Option<&Stage> {
        self.embedded.as_ref()
    }

    /// Spectral radius ρ∞ at infinite frequencies: factor per step of a disturbance of the
    /// velocities and accelerations of coordinates that are held (by infinite stiffness, or by
    /// multipliers). Infinite for an explicit scheme.
    pub fn spectral_radius(&self) -> f64 {
        // With q fixed, (h q̇, h² y) is multiplied by a matrix, and q̈ by −α_f/(1−α_f).
        let mut columns = [[0.0; 2]; 2];
        for (k, column) in columns.iter_mut().enumerate() {
            let v = if k == 0 { 1.0 } else { 0.0 };
            let mut y = [0.0; 1 + STAGES];
            y[0] = 1.0 - v;
            let sum = |w: &[f64; 1 + STAGES], y: &[f64; 1 + STAGES]| -> f64 {
                w.iter().zip(y).map(|(w, y)| w * y).sum()
            };
            for group in self.groups() {
                let Some(inverse) = inverse(self.stages(), &group) else {
                    return f64::INFINITY;
                };
                let known = y;
                for (i, row) in inverse.iter().enumerate().take(group.len()) {
                    let parts = self.stages[group.clone()].iter().zip(row);
                    y[1 + group.start + i] = parts
                        .map(|(stage, x)| -x * (stage.c * v + sum(&stage.q, &known)))
                        .sum();
                }
            }
            let last = self.count - 1;
            *column = [v + sum(&self.stages[last].v, &y), y[self.count]];
        }
        let [[a, b], [c, d]] = columns;
        let (half, determinant) = (0.5 * (a + d), a * d - b * c);
        let discriminant = half * half - determinant;
        let largest = if discriminant > 0.0 {
            half.abs() + discriminant.sqrt()
        } else {
            determinant.abs().sqrt()
        };
        largest.max((self.alpha_f / (1.0 - self.alpha_f)).abs())
    }

    /// Whether the local error can be estimated for adaptive steps: the order is 1 or 2, or there is
    /// an embedded method.
    pub fn estimates_error(&self) -> bool {
        self.error_estimate().is_some()
    }

    /// Groups of stages that are solved together, in order.
    pub(crate) fn groups(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let mut start = 0;
        std::iter::from_fn(move || {
            let from = start;
            if from == self.count {
                return None;
            }
            start += 1;
            let mut k = from;
            while k < start {
                let Stage { q, v, .. } = self.stages[k];
                let needed = (0..self.count)
                    .rev()
                    .find(|j| q[1 + j] != 0.0 || v[1 + j] != 0.0);
                start = start.max(needed.map_or(0, |j| j + 1));
                k += 1;
            }
            Some(from..start)
        })
    }

    /// Weights of y, yₙ and q̈ₙ in the acceleration of a stage.
    pub(super) fn filter(&self) -> [f64; 3] {
        let f = 1.0 - self.alpha_f;
        [
            (1.0 - self.alpha_m) / f,
            self.alpha_m / f,
            -self.alpha_f / f,
        ]
    }

    /// Delay of y after its stage, as a part of a step: α_m − α_f for the generalised-α method,
    /// otherwise zero.
    pub fn lateness(&self) -> f64 {
        self.alpha_m - self.alpha_f
    }

    /// Factor of h³ q⃛ in the local error of qₙ₊₁ for accelerations linear in time: β − 1/6 for
    /// Newmark (Zienkiewicz & Xie 1991), β + (α_m − α_f)/2 − 1/6 for the generalised-α method.
    pub fn cubic_error(&self) -> f64 {
        let end = self.stages()[self.count - 1];
        let late = self.lateness();
        let weights = end.q[1..].iter().zip(self.stages());
        let sum: f64 = weights.map(|(q, stage)| q * (stage.c + late)).sum();
        end.q[0] * late + sum - 1.0 / 6.0
    }

    /// Weights of h² y and h y in the estimate of the local errors of qₙ₊₁ and q̇ₙ₊₁, and the power
    /// of h with which these fall: the difference to the embedded method, the factor of h² yₙ₊₁ in qₙ₊₁ for a scheme of
    /// order one, or that of h²(yₙ₊₁ − yₙ). `None` if these factors vanish, as for a scheme of higher order.
    pub(super) fn error_estimate(&self) -> Option<(Stage, usize)> {
        if let Some(embedded) = &self.embedded {
            return Some((self.stages[self.count - 1].less(embedded), self.order()));
        }
        let quadratic = self.stages[self.count - 1].q.iter().sum::<f64>() - 0.5;
        if quadratic.abs() > 1e-12 {
            let mut row = Stage::new(1.0, [0.0], [0.0]);
            row.q[self.count] = quadratic;
            return Some((row, 2));
        }
        let factor = self.cubic_error();
        let mut row = Stage::new(1.0, [-factor], [0.0]);
        row.q[self.count] = factor;
        (factor.abs() > 1e-12).then_some((row, 3))
    }
}

impl fmt::Display for Scheme {
    /// The word of the scheme, such as `ga:0.8`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word)?;
        let arguments = self.arguments.iter().flatten();
        arguments.into_iter().try_for_each(|x| write!(f, ":{x}"))
    }
}
