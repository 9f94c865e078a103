//! What looks doubtful about a model or its results, in words: for the terminal and `result.json`.

#![allow(non_snake_case)]

mod turns;

pub(crate) use turns::{Turn, Turns};

use crate::input::{Joint, ModelFile, Time};
use crate::output::Row;
use crate::probe::Answers;
use crate::solve::Counts;
use pullback_elements::element::SectionState;
use pullback_elements::model::Model;
use pullback_integrators::dynamics::{Progress, State};
use pullback_integrators::significant;
use pullback_manifold::system::{Evaluation, Point, System};
use std::fmt::Write;

/// A change of the number of unstable directions along a path.
#[derive(Clone, Copy, Debug)]
struct Change {
    /// Load parameters before and after it.
    between: [f64; 2],
    /// Unstable directions before and after it.
    directions: [usize; 2],
    /// Whether the load turns there.
    turns: bool,
}

/// Sees the rows of a static analysis as they are recorded.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    /// Load parameter and unstable directions of the last row that knows them.
    stability: (f64, usize),
    /// Load parameter of the last row, and its change to there.
    last: f64,
    sense: f64,
    /// Whether the load has turned since the last row that knows its stability.
    turns: bool,
    changes: Vec<Change>,
    /// Converged rows.
    rows: usize,
    /// Whether anything has moved, and whether a support has had anything to hold.
    stirred: bool,
    held: bool,
    /// Element, 1 + Γ₁ and load parameter of the first row with an element inside out.
    inverted: Option<(String, f64, f64)>,
    /// Element, strain and load parameter of the first row with a large strain.
    strained: Option<(String, f64, f64)>,
    /// Residual relative to loads and reactions at which a step has converged, unless what is left is
    /// rounding.
    relative: f64,
    /// Residual force and moment, and load parameter, of the first row where they are no smaller than
    /// that part of loads and reactions.
    unresolved: Option<([f64; 2], f64)>,
}

/// Residuals from this part of loads and reactions on leave too few correct digits.
const UNRESOLVED: f64 = 1e-3;

/// Names that a message lists.
const LISTED: usize = 4;

/// Elongation or shear beyond which a linear law of the section is doubtful.
const LARGE_STRAIN: f64 = 0.2;

impl Watch {
    /// Begins at a load parameter, with a structure that is stable; `relative` is the tolerance of the
    /// residual.
    pub(crate) fn new(t: f64, relative: f64) -> Self {
        Self {
            stability: (t, 0),
            last: t,
            sense: 0.0,
            turns: false,
            changes: Vec::new(),
            rows: 0,
            stirred: false,
            held: false,
            inverted: None,
            strained: None,
            relative,
            unresolved: None,
        }
    }

    /// A converged row, with the model in its configuration.
    pub(crate) fn see(&mut self, model: &Model, answers: &Answers, row: &Row) {
        let t = row.t;
        self.rows += 1;
        if row.ratio * self.relative >= UNRESOLVED && self.unresolved.is_none() {
            self.unresolved = Some((row.residual, t));
        }
        self.stirred = self.stirred || answers.strain_energy() != 0.0 || moved(model);
        let mut reactions = answers.reactions().iter();
        self.held |= reactions.any(|r| r.force.norm() + r.moment.norm() > 0.0);
        for (id, state) in answers.sections() {
            let about = |value| Some((model.element(*id).0.to_owned(), value, t));
            let stretch = 1.0 + state.Gamma.x;
            if stretch <= 0.0 && self.inverted.is_none() {
                self.inverted = about(stretch);
            }
            if state.Gamma.amax() > LARGE_STRAIN && self.strained.is_none() {
                self.strained = about(state.Gamma.amax());
            }
        }
        let sense = t - self.last;
        let located = row.event.as_deref() == Some("turning-point");
        self.turns |= located || sense * self.sense < 0.0;
        (self.last, self.sense) = (t, sense);
        let Some(now) = row.unstable else { return };
        let (before, directions) = self.stability;
        let turns = std::mem::take(&mut self.turns);
        if now != directions {
            self.changes.push(Change {
                between: [before, t],
                directions: [directions, now],
                turns,
            });
        }
        self.stability = (t, now);
    }

    /// What there is to say; that nothing moves only of a run that is complete.
    pub(crate) fn warnings(&self, complete: bool) -> Vec<String> {
        let idle = || {
            (complete && self.rows > 0 && !self.stirred).then(|| {
                if self.held {
                    "all loads act on coordinates that supports hold: nothing moves, and only \
                     reactions are computed. Load free nodes, or free these coordinates"
                } else {
                    "no load acts and nothing is driven: nothing moves. See `loads`, `driven`, and \
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
        let unresolved = self.unresolved.map(|([force, moment], t)| {
            format!(
                "forces are no larger than rounding errors at load parameter {}: the residual (force \
                 {force:.1e}, moment {moment:.1e}) cannot be made smaller with such stiffnesses, and \
                 forces and reactions of this size, and what they move, have no correct digits. Load \
                 it more, or make stiff parts softer or rigid",
                significant(t)
            )
        });
        (self.instability().into_iter())
            .chain(idle())
            .chain(inverted)
            .chain(strained)
            .chain(unresolved)
            .collect()
    }

    fn instability(&self) -> Option<String> {
        let (first, others) = self.changes.split_first()?;
        let span = |change: &Change| {
            let [a, b] = change.between.map(significant);
            format!("between load parameter {a} and {b}")
        };
        let directions = |n: usize| match n {
            0 => "stable again".to_owned(),
            1 => "unstable in 1 direction".to_owned(),
            n => format!("unstable in {n} directions"),
        };
        let [what, then] = if first.turns {
            [
                "limit point",
                "would snap through under a load that does not turn there",
            ]
        } else {
            [
                "limit point or bifurcation",
                "would leave this path. To follow the branch that it takes, add a small imperfection \
                 (a lateral load, nodes off the line) and take a smaller `max_step`",
            ]
        };
        let mut out = format!(
            "{what} {}: the equilibrium found is {} after it (negative pivots of the tangent, column \
             `unstable`), and a structure {then}",
            span(first),
            directions(first.directions[1])
        );
        for change in others.iter().take(LISTED) {
            // Writing to a string cannot fail.
            let _ = write!(
                out,
                "; {} {}",
                span(change),
                directions(change.directions[1])
            );
        }
        if let more @ 1.. = others.len().saturating_sub(LISTED) {
            let _ = write!(out, "; and {more} more");
        }
        Some(out)
    }
}

/// Error of the energy over the energy supplied that makes results doubtful.
const DOUBTFUL: f64 = 0.1;

/// What there is to say of the balance of energy of a motion, or of one without any.
pub(crate) fn unbalanced(counts: &Counts) -> Option<&'static str> {
    let energy = counts.energy?;
    let doubtful = DOUBTFUL * energy.start.max(energy.work.abs());
    if energy.largest_defect <= doubtful || energy.is_rounding() {
        let now = energy.now.kinetic + energy.now.stored;
        let still = energy.start == 0.0 && energy.gross == 0.0 && now == 0.0;
        return (still && counts.steps > 0).then_some(
            "nothing moves: no load acts on anything free, nothing is driven, and all starts at \
             rest. See `loads`, `driven` and `initial`",
        );
    }
    Some(if energy.defect() > 0.0 {
        "the balance of energy is off by much compared with the energy supplied: energy has come from \
         nowhere; take smaller steps, or a scheme that damps high frequencies (more)"
    } else {
        "the balance of energy is off by much compared with the energy supplied: energy is lost, as \
         the scheme damps what its steps do not resolve (waves of a sudden start, say), or dampers \
         take it faster than that; take smaller steps, or a scheme that damps less"
    })
}

/// Whether any node is elsewhere than where it is drawn.
fn moved(model: &Model) -> bool {
    model.frames().any(|(id, _)| {
        let state = model.node_state(id);
        state.d.norm() + state.psi.norm() > 0.0
    })
}

/// Whether any released coordinate of the joint is an unknown of its own (true), or depends on those of
/// a loop (false).
fn has(own: bool, model: &Model, joint: &Joint) -> bool {
    let prefix = format!("{} ", joint.name);
    let of_joint = |name: &str| name.starts_with(&prefix);
    (model.released()).any(|(node, name, _)| model.is_own(node) == own && of_joint(name))
}

/// Supports and joints whose prescribed motion has a value (0) or a rate (1) at the start.
fn driven(file: &ModelFile, order: usize) -> impl Iterator<Item = (String, Option<&Joint>)> {
    let off = move |time: &Time| time.function().is_ok_and(|f| f.at(0.0)[order] != 0.0);
    let supports = file.supports.iter().filter(move |s| {
        let driven = s.driven.as_ref();
        driven.is_some_and(|d| d.given().any(|(_, time)| off(time)))
    });
    let joints = (file.joints.iter()).filter(move |j| j.driven.as_ref().is_some_and(off));
    (supports.map(|s| (format!("support of {}", s.node), None)))
        .chain(joints.map(|j| (format!("joint {}", j.name), Some(j))))
}

/// The first names of several, and how many more there are.
fn listed(names: &[String]) -> String {
    let first = names[..names.len().min(LISTED)].join("; ");
    match names.len().saturating_sub(LISTED) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

/// Names with their verb.
fn are(names: &[String]) -> String {
    let verb = if names.len() == 1 { "is" } else { "are" };
    format!("{} {verb}", names.join(", "))
}

/// A word about what starts with a velocity because it hangs by a joint from something driven.
pub(crate) fn carried(model: &Model, file: &ModelFile) -> Option<String> {
    let driven: Vec<String> = driven(file, 1).map(|(name, _)| name).collect();
    if !file.initial.is_empty() || driven.is_empty() {
        return None;
    }
    let moves = |name: &str| {
        model.find(name).is_some_and(|node| {
            let state = model.node_state(node);
            state.velocity.norm() + state.omega.norm() > 0.0
        })
    };
    let carried = (file.joints.iter()).filter(|j| {
        j.rate.is_none() && j.driven.is_none() && has(true, model, j) && moves(&j.name)
    });
    let carried: Vec<String> = carried.map(|j| j.name.clone()).collect();
    (!carried.is_empty()).then(|| {
        format!(
            "{} driven with a velocity at t = 0: what hangs from there by {} starts with it, as rates \
             of joints are 0. [[initial]] with velocity = [0, 0, 0] lets it start at rest in space",
            are(&driven),
            listed(&carried)
        )
    })
}

/// A word about lines that stay behind where a joint at their end starts with a rate.
pub(crate) fn left_behind(file: &ModelFile) -> impl Iterator<Item = String> {
    let rated = (file.joints.iter()).filter(|j| j.rate.is_some_and(|rate| rate != 0.0));
    rated.filter(|_| file.initial.is_empty()).flat_map(|j| {
        let child = j.child.as_ref();
        let ends = move |end: &String| *end == j.name || Some(end) == child;
        let lines = file.lines.iter();
        let lines = lines.filter(move |l| ends(&l.from) || ends(&l.to));
        lines.map(|l| {
            format!(
                "joint {} starts with a rate, and the rest of line {} at rest, which jerks it: \
                 [[initial]] with line = {:?} and an angular_velocity (about the joint) or a velocity \
                 sets all of it in motion, and the joint with it",
                j.name, l.name, l.name
            )
        })
    })
}

/// A word about energy that is stored at the start of a motion because driven coordinates, or
/// initial values, are not where the model is drawn.
pub(crate) fn strained(model: &Model, file: &ModelFile, progress: &Progress) -> Vec<String> {
    let stored = progress.summary.energy.map_or(0.0, |e| e.now.stored);
    let valued = (file.joints.iter()).filter(|j| j.value.is_some_and(|x| x != 0.0));
    let valued = valued.map(|j| (format!("joint {}", j.name), Some(j)));
    let names: Vec<String> = driven(file, 0)
        .chain(valued)
        // The coordinates of a loop are where they are together.
        .filter(|(_, joint)| joint.is_none_or(|j| !has(false, model, j)))
        .map(|(name, _)| name)
        .collect();
    // A joint that is let go with its own spring tight is what it seems.
    let tight = |(_, s): &(_, SectionState)| s.N.norm() + s.M.norm() > 0.0;
    let parts = !file.springs.is_empty() || model.section_states(0.0).iter().any(tight);
    if stored <= 0.0 || names.is_empty() || !parts {
        return Vec::new();
    }
    vec![format!(
        "{} not where the model is drawn at t = 0, which stores the energy {stored:.3e} in it; draw \
         it in that position, or start at 0",
        are(&names)
    )]
}

/// A word about loops that cannot move.
pub(crate) fn immobile(model: &Model) -> impl Iterator<Item = String> {
    model.locked().into_iter().map(|(joint, x, equations)| {
        format!(
            "the loop closed by joint {joint} cannot move: its {equations} equations leave none of \
             {x} coordinates free. If it should, see whether axes and places are given with all \
             their digits; if not, weld it"
        )
    })
}

/// Part of the forces on a model that rounding errors of a gap may be.
const ROUGH: f64 = 1e-3;

/// A word about penalties with which rounding errors of the gap are no small forces.
pub(crate) fn drowned(model: &mut Model, file: &ModelFile, progress: &Progress) -> Option<String> {
    let State { t, q, v, .. } = &progress.state;
    let a = vec![0.0; q.len()];
    let (at, mut r) = (Point { t: *t, q, v, a: &a }, a.clone());
    model.evaluate(at, Evaluation::residual(&mut r)).ok()?;
    let scales = model.scales();
    let most = ROUGH * scales.measures()[0] / (f64::EPSILON * scales.coordinate[0]);
    let joints = file.joints.iter();
    let large = joints.filter(|j| most > 0.0 && j.penalty.is_some_and(|p| p > most));
    let names: Vec<String> = large.map(|j| j.name.clone()).collect();
    (!names.is_empty()).then(|| {
        format!(
            "penalty of {}: rounding errors of the gap are forces that drown those of the model; \
             keep it below {most:.0e}",
            listed(&names)
        )
    })
}

/// A word about coordinates on which no mass acts.
pub(crate) fn massless(model: &mut Model, progress: &Progress) -> Option<String> {
    let state = &progress.state;
    // A state outside of a domain is told of by the first step.
    let names = model.massless(state.t, &state.q, &state.v).ok()?;
    (!names.is_empty()).then(|| {
        format!(
            "no mass acts on {}: they follow forces at once. Mass of lines is `rho` of a \
             material, or `mass` with A_rho and J beside a `stiffness`; angles of joints need bodies \
             with `inertia` (or lines), others any body",
            listed(&names)
        )
    })
}
