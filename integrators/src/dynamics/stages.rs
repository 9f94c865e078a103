//! Prediction and correction of the stages of a scheme.

use super::scheme::{STAGES, Stage, inverse};
use super::step::Stepper;
use super::{Predictor, Scheme, State};
use std::ops::Range;

/// Largest change of velocities by accelerations in a step, relative to the velocities, with which these
/// predict coordinates.
const SMOOTH: f64 = 0.02;

#[derive(Clone)]
pub(super) struct StageState {
    pub state: State,
    /// Coordinates of the previous iterate.
    pub before: Vec<f64>,
}

/// A step in progress: scheme, old state and size.
#[derive(Clone, Copy)]
pub(super) struct Attempt<'a> {
    pub scheme: &'a Scheme,
    pub state: &'a State,
    pub h: f64,
}

/// Stages that are solved together; one in most schemes.
#[derive(Clone, Copy)]
pub(super) struct StageGroup {
    pub start: usize,
    pub end: usize,
    /// Inverse of the weights of their accelerations in their coordinates; none if explicit.
    pub inverse: Option<[[f64; STAGES]; STAGES]>,
    /// The unknowns are h² y over this: coordinates if a single implicit stage.
    pub unit: f64,
    /// Whether neither coordinates nor velocities depend on their accelerations: the equations
    /// are linear in these.
    pub linear: bool,
}

impl StageGroup {
    pub fn new(scheme: &Scheme, range: &Range<usize>) -> Self {
        let inverse = inverse(scheme.stages(), range);
        let alone = inverse.filter(|_| range.len() == 1);
        let own = |row: &Stage| row.q[1 + range.start] == 0.0 && row.v[1 + range.start] == 0.0;
        Self {
            start: range.start,
            end: range.end,
            inverse,
            unit: alone.map_or(1.0, |inverse| inverse[0][0]),
            linear: range.len() == 1 && own(&scheme.stages()[range.start]),
        }
    }

    pub fn len(&self) -> usize {
        self.end - self.start
    }

    pub fn range(&self) -> Range<usize> {
        self.start..self.end
    }
}

impl Stepper {
    /// Predicts qᵢ by the predictor, and yᵢ, q̇ᵢ and q̈ᵢ by the scheme. Explicit stages keep y, which
    /// determines qᵢ.
    pub(super) fn predict(&mut self, step: Attempt<'_>, group: &StageGroup) {
        let Attempt { scheme, state, h } = step;
        let rows = scheme.stages();
        let filter = scheme.filter();
        let (done, rest) = self.stages.split_at_mut(group.start);
        let origin = done.last().map_or(state, |stage| &stage.state);
        let factors = match self.options.predictor {
            Predictor::Keep => [0.0; 2],
            Predictor::Velocity if is_smooth(origin, h, &self.inverse_scale) => [1.0, 0.5],
            Predictor::Velocity => [1.0, 0.0],
        };
        let shift = |h: f64, v: f64, a: f64| h * (factors[0] * v + factors[1] * h * a);
        if let ([row], Some(inverse), [stage]) = (rows, &group.inverse, &mut *rest) {
            return predict_one(step, row, inverse[0][0], shift, &mut stage.state);
        }
        for c in 0..state.q.len() {
            let y_old = state.algorithmic[c];
            // The known parts of qᵢ − qₙ and of q̇ᵢ, and the predicted qᵢ − qₙ.
            let (mut known, mut target) = ([[0.0; STAGES]; 2], [0.0; STAGES]);
            for (i, row) in rows[group.range()].iter().enumerate() {
                let mut sums = [row.q[0] * y_old, row.v[0] * y_old];
                for (j, stage) in done.iter().enumerate() {
                    let y = stage.state.algorithmic[c];
                    sums = [sums[0] + row.q[1 + j] * y, sums[1] + row.v[1 + j] * y];
                }
                known[0][i] = row.c * h * state.v[c] + h * h * sums[0];
                known[1][i] = state.v[c] + h * sums[1];
                let shift = shift(rest[i].state.t - origin.t, origin.v[c], origin.a[c]);
                target[i] = origin.q[c] - state.q[c] + shift;
            }
            let mut y = [origin.algorithmic[c]; STAGES];
            if let Some(inverse) = &group.inverse {
                for (y, row) in y.iter_mut().zip(inverse) {
                    let sum: f64 = (0..group.len())
                        .map(|j| row[j] * (target[j] - known[0][j]))
                        .sum();
                    *y = sum / (h * h);
                }
            }
            for (i, row) in rows[group.range()].iter().enumerate() {
                let stage = &mut rest[i].state;
                let sum = |w: &[f64; 1 + STAGES]| -> f64 {
                    (0..group.len())
                        .map(|j| w[1 + group.start + j] * y[j])
                        .sum()
                };
                stage.q[c] = state.q[c]
                    + match group.inverse {
                        Some(_) => target[i],
                        None => known[0][i] + h * h * sum(&row.q),
                    };
                stage.v[c] = known[1][i] + h * sum(&row.v);
                stage.algorithmic[c] = y[i];
                stage.a[c] = filter[0] * y[i] + filter[1] * y_old + filter[2] * state.filtered[c];
            }
        }
    }

    /// Corrects the stages of a group; returns the largest correction relative to the scales of the
    /// coordinates.
    pub(super) fn correct(&mut self, step: Attempt<'_>, group: &StageGroup) -> f64 {
        let Attempt { scheme, h, .. } = step;
        let mut largest = 0.0_f64;
        for k in group.range() {
            let row = &scheme.stages()[k];
            let StageState { state, before } = &mut self.stages[k];
            before.copy_from_slice(&state.q);
            let implicit = group.inverse.is_some();
            let coordinates = state.q.iter_mut().zip(&mut state.v);
            let accelerations = state.algorithmic.iter_mut().zip(&mut state.a);
            let all = coordinates.zip(accelerations).zip(&self.inverse_scale);
            if group.len() == 1 {
                let by = Gains::new(scheme, group, [row.q[1 + k], row.v[1 + k], 1.0], h);
                for ((((q, v), (y, a)), scale), d) in all.zip(&self.dq) {
                    by.add(*d, [q, v, y, a]);
                    // The unknown of an explicit stage is h² y.
                    let size = if implicit { by.q * d } else { by.unit * d };
                    largest = largest.max((size * scale).abs());
                }
                continue;
            }
            for (c, (((q, v), (y, a)), scale)) in all.enumerate() {
                let before = *q;
                for (i, j) in group.range().enumerate() {
                    let own = f64::from(j == k);
                    let by = Gains::new(scheme, group, [row.q[1 + j], row.v[1 + j], own], h);
                    by.add(self.dq[i * self.r.len() + c], [q, v, y, a]);
                }
                largest = largest.max(((*q - before) * scale).abs());
            }
        }
        largest
    }
}

/// Predicts the only stage of a scheme, as most schemes have: the general rule in one pass.
fn predict_one(
    step: Attempt<'_>,
    row: &Stage,
    inverse: f64,
    shift: impl Fn(f64, f64, f64) -> f64,
    out: &mut State,
) {
    let (given, h, filter) = (step.state, step.h, step.scheme.filter());
    let old = given.v.iter().zip(&given.filtered).zip(&given.algorithmic);
    let rates = out.v.iter_mut().zip(&mut out.a).zip(&mut out.algorithmic);
    let positions = out.q.iter_mut().zip(&given.q);
    for (((q, q_old), ((v, a), y)), ((v_old, a_old), y_old)) in positions.zip(rates).zip(old) {
        let target = shift(h, *v_old, *a_old);
        let known = row.c * h * v_old + h * h * row.q[0] * y_old;
        *y = inverse * (target - known) / (h * h);
        *q = q_old + target;
        *v = v_old + h * (row.v[0] * y_old + row.v[1] * *y);
        *a = filter[0] * *y + filter[1] * y_old + filter[2] * a_old;
    }
}

/// Whether accelerations change velocities little in a step: they are then smooth, not oscillations of the
/// scheme.
fn is_smooth(state: &State, h: f64, inverse_scale: &[f64]) -> bool {
    let largest = |x: &[f64]| {
        let sizes = x.iter().zip(inverse_scale).map(|(x, s)| (x * s).abs());
        sizes.fold(0.0, f64::max)
    };
    h * largest(&state.a) <= SMOOTH * largest(&state.v)
}

/// Change of the motion of a stage by an unknown of its group.
struct Gains {
    /// To h² y.
    unit: f64,
    q: f64,
    v: f64,
    y: f64,
    a: f64,
}

impl Gains {
    /// From the weights of the unknown's y in q, q̇ and y of the stage.
    fn new(scheme: &Scheme, group: &StageGroup, [q, v, y]: [f64; 3], h: f64) -> Self {
        let unit = group.unit * y;
        Self {
            unit,
            q: group.unit * q,
            v: group.unit * v / h,
            y: unit / (h * h),
            a: scheme.filter()[0] * unit / (h * h),
        }
    }

    #[inline(always)]
    fn add(&self, d: f64, [q, v, y, a]: [&mut f64; 4]) {
        *q += self.q * d;
        *v += self.v * d;
        *y += self.y * d;
        *a += self.a * d;
    }
}
