//! Warnings about the equilibria of a static analysis.

use super::LISTED;
use crate::output::HistoryRow;
use crate::probe::Answers;
use crate::terminal::plural;
use pullback_elements::model::Context;
use pullback_integrators::significant;
use pullback_manifold::system::System;

/// What a path has passed between two rows with a known stability.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Passed {
    #[default]
    Unknown,
    /// The load reverses.
    LimitPoint,
    /// Located, with the branch that is followed from there or without.
    Bifurcation,
}

/// A change of the number of unstable directions along a path.
#[derive(Clone, Copy, Debug)]
struct Change {
    /// Load parameters before and after it.
    between: [f64; 2],
    /// Unstable directions before and after it.
    directions: [usize; 2],
    passed: Passed,
}

/// Records the rows of a static analysis.
#[derive(Clone, Debug, Default)]
pub(crate) struct Diagnostics {
    /// Load parameter and number of unstable directions of the last row that has it.
    stability: (f64, usize),
    /// Load parameter of the last row, and its last change.
    last: f64,
    sense: f64,
    /// Since the last row with a known stability.
    passed: Passed,
    changes: Vec<Change>,
    /// Converged rows after the start.
    rows: usize,
    /// Whether anything has moved, and whether any reaction is nonzero.
    moved: bool,
    has_reactions: bool,
    /// Load parameters of rows of a model with multipliers whose stability is not known.
    unknown: Vec<f64>,
    /// Element, 1 + Γ₁ and load parameter of the first row with an element inside out.
    inverted: Option<(String, f64, f64)>,
    /// Element, strain and load parameter of the first row with a large strain.
    strained: Option<(String, f64, f64)>,
    /// Tolerance of the residual, relative to loads and reactions.
    relative: f64,
    /// Residual force and moment, their ratio to loads and reactions, and load parameter of
    /// rows in which rounding errors are that large.
    unresolved: Vec<([f64; 2], f64, f64)>,
    /// Largest loads and reactions of all rows: forces and moments.
    largest: [f64; 2],
}

/// Ratio of residuals to loads and reactions above which too few digits are correct.
const UNRESOLVED: f64 = 1e-5;

/// Elongation or shear beyond which a linear law of the section is doubtful.
const LARGE_STRAIN: f64 = 0.2;

impl Diagnostics {
    /// Until a row tells, the structure counts as stable at the first load parameter `t`; `relative` is the tolerance of the
    /// residual.
    pub(crate) fn new(t: f64, relative: f64) -> Self {
        Self {
            stability: (t, 0),
            last: t,
            relative,
            ..Self::default()
        }
    }

    /// Records a converged row, with the model in its configuration.
    pub(crate) fn record(&mut self, context: &Context, answers: &Answers, row: &HistoryRow) {
        let t = row.t;
        self.rows += usize::from(row.step > 0);
        for (most, now) in self.largest.iter_mut().zip(context.scales().measures()) {
            *most = most.max(now);
        }
        // Above the tolerance nothing but rounding errors was left.
        let part = row.ratio * self.relative;
        if row.ratio > 1.0 && part >= UNRESOLVED {
            self.unresolved.push((row.residual, part, t));
        }
        self.moved = self.moved || answers.strain_energy != 0.0 || moved(context);
        let mut reactions = answers.reactions.iter();
        self.has_reactions |= reactions.any(|r| r.force.norm() + r.moment.norm() > 0.0);
        for (id, state) in &answers.sections {
            let about = |value| Some((context.element(*id).0.to_owned(), value, t));
            let stretch = 1.0 + state.Gamma.x;
            if stretch <= 0.0 && self.inverted.is_none() {
                self.inverted = about(stretch);
            }
            if state.Gamma.amax() > LARGE_STRAIN && self.strained.is_none() {
                self.strained = about(state.Gamma.amax());
            }
        }
        let mut sense = t - self.last;
        let event = row.event.as_deref();
        if event == Some("bifurcation") {
            // The load of another branch may fall from there on.
            sense = 0.0;
            if self.passed == Passed::Unknown {
                (self.passed, self.stability.0) = (Passed::Bifurcation, t);
            }
        } else if event == Some("turning_point") || sense * self.sense < 0.0 {
            self.passed = Passed::LimitPoint;
        }
        (self.last, self.sense) = (t, sense);
        let Some(now) = row.unstable else {
            let symmetric = context.has_multipliers() && context.is_symmetric();
            self.unknown
                .extend((symmetric && event.is_none()).then_some(t));
            return;
        };
        let (before, directions) = self.stability;
        let passed = std::mem::take(&mut self.passed);
        if now != directions {
            self.changes.push(Change {
                between: [before, t],
                directions: [directions, now],
                passed,
            });
        }
        self.stability = (t, now);
    }

    /// The warnings; that nothing moves only for a complete run.
    pub(crate) fn warnings(&self, complete: bool) -> Vec<String> {
        let unloaded = || {
            (complete && self.rows > 0 && !self.moved).then(|| {
                if self.has_reactions {
                    "nothing moves: supports and joints bear all loads, and only reactions are \
                     computed. Load what is free to move, or free it"
                } else {
                    "no load acts and nothing is prescribed: nothing moves. See `loads`, `prescribed`, and \
                     whether a `time` is zero over the whole range of the load parameter"
                }
                .to_owned()
            })
        };
        let inverted = self.inverted.as_ref().map(|(element, stretch, t)| {
            format!(
                "element {element} is turned inside out from load parameter {} on: its axis is \
                 stretched by 1 + Γ₁ = {stretch:.3}, which no beam can be. The load is too large for \
                 EA, or in other units than the section",
                significant(*t)
            )
        });
        let strained = self.strained.as_ref().map(|(element, strain, t)| {
            format!(
                "element {element} is elongated or sheared by {:.0} % at load parameter {}: beyond \
                 {:.0} % the linear law of its section is doubtful. See the units of load and section",
                100.0 * strain,
                significant(*t),
                100.0 * LARGE_STRAIN
            )
        });
        let strained = strained.filter(|_| inverted.is_none());
        // Rounding errors are all there is where loads are zero for a while.
        let counts = |(left, whole): (&f64, f64)| *left >= UNRESOLVED * whole;
        let mut rows = self.unresolved.iter();
        let unresolved = rows.find(|row| row.0.iter().zip(self.largest).any(counts));
        let unresolved = unresolved.map(|([force, moment], part, t)| {
            format!(
                "the balance of forces ends at rounding errors at load parameter {}: the residual (force \
                 {force:.1e}, moment {moment:.1e}) is {part:.0e} of loads and reactions and cannot be made \
                 smaller with such stiffnesses; forces and reactions, and what they move, have no more \
                 correct digits. Load it more, or make stiff parts softer or rigid",
                significant(*t)
            )
        });
        let unknown = self.unknown.first().map(|t| {
            format!(
                "whether the equilibrium is stable is not known in {} from load parameter {} on (column `unstable`), \
                 and bifurcations there are not found: rounding errors of multipliers beside stiff members are larger than \
                 what decides. Close loops by a map, or make stiff members softer",
                plural(self.unknown.len(), "row"),
                significant(*t)
            )
        });
        (self.instability().into_iter())
            .chain(unknown)
            .chain(unloaded())
            .chain(inverted)
            .chain(strained)
            .chain(unresolved)
            .collect()
    }

    fn instability(&self) -> Option<String> {
        let (first, others) = self.changes.split_first()?;
        let span = |change: &Change| {
            let [a, b] = change.between.map(significant);
            match a == b {
                true => format!("at or before load parameter {b}"),
                false => format!("between load parameter {a} and {b}"),
            }
        };
        let directions = |n: usize| match n {
            0 => "stable again".to_owned(),
            1 => "unstable in 1 direction".to_owned(),
            n => format!("unstable in {n} directions"),
        };
        let [what, then] = match first.passed {
            Passed::LimitPoint => [
                "limit point",
                "would snap through under a load that does not turn there",
            ],
            Passed::Bifurcation => [
                "bifurcation",
                "would leave this path, for the other branch (`branch = \"switch\"`) or, where this is that \
                 branch, for a distant equilibrium",
            ],
            Passed::Unknown => [
                "limit point or bifurcation",
                "would leave this path. To follow the branch that it takes, use arc-length steps with \
                 `branch = \"switch\"`, or add a small imperfection (a lateral load, nodes off the line) \
                 and take a smaller `max_step`",
            ],
        };
        let mut out = format!(
            "{what} {}: the equilibrium found is {} after it (negative pivots of the tangent, column \
             `unstable`), and a structure {then}",
            span(first),
            directions(first.directions[1])
        );
        for change in others.iter().take(LISTED) {
            out += &format!("; {} {}", span(change), directions(change.directions[1]));
        }
        if let more @ 1.. = others.len().saturating_sub(LISTED) {
            out += &format!("; and {more} more");
        }
        Some(out)
    }
}

/// Whether any node has moved from its reference configuration.
fn moved(context: &Context) -> bool {
    context.frames().any(|(id, _)| {
        let state = context.node_state(id);
        state.d.norm() + state.psi.norm() > 0.0
    })
}
