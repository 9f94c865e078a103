//! One step of any scheme: predict, evaluate, solve and correct its stages.

use super::coupled_stages::CoupledStages;
use super::stages::{Attempt, StageGroup, StageState};
use super::{
    DynamicOptions, DynamicsError, NewtonOptions, Progress, Scheme, State, Summary, TangentUpdate,
};
use crate::convergence::ConvergencePredictor;
use crate::failure::{Cause, FailedStep, FailureContext, StepParameter};
use crate::linear_solver::{AutoSolver, LinearSolver, MatrixSymmetry};
use crate::rounding::{ResidualTest, inverse_scales, is_rounding, largest, rounding_errors};
use crate::statics::{Iteration, solutions};
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::{Evaluation, Point, Quantity, System, SystemError, Weights};

/// The step routine: its linear solver and buffers.
pub(crate) struct Stepper {
    pub solver: AutoSolver,
    pub r: Vec<f64>,
    pub S: Vec<f64>,
    /// Residuals, then corrections, of the stages of a group, one after the other.
    pub(super) dq: Vec<f64>,
    /// The stages; the last one is the new state.
    pub(super) stages: Vec<StageState>,
    pub(super) groups: Vec<StageGroup>,
    /// The matrix of coupled stages, if the scheme has some.
    pub(super) coupled: Option<CoupledStages>,
    /// The new state.
    pub next: State,
    pub history: Vec<Iteration>,
    pub evaluations: usize,
    pub factorisations: usize,
    /// 1 / typical size of each coordinate; zero for multipliers, which are tested by their residuals.
    pub(super) inverse_scale: Vec<f64>,
    /// Whether all residuals of [`Quantity::Other`] are gaps of multipliers.
    gaps: bool,
    /// Scratch of the test for rounding errors.
    pub(super) work: [Vec<f64>; 2],
    pub(super) options: NewtonOptions,
}

impl Stepper {
    pub(crate) fn new(
        system: &dyn System,
        options: &DynamicOptions,
    ) -> Result<Self, DynamicsError> {
        // Gyroscopic and centrifugal tangents are not symmetric, even if the stiffness is.
        let solver = AutoSolver::new(system.pattern(), MatrixSymmetry::General)
            .map_err(|source| DynamicsError::Analysis { source })?;
        let (scheme, newton) = (&options.scheme, options.newton);
        let n = system.pattern().dim();
        let zeros = || vec![0.0; n];
        let next = State {
            t: 0.0,
            q: zeros(),
            v: zeros(),
            a: zeros(),
            algorithmic: zeros(),
            filtered: zeros(),
        };
        let groups = scheme.groups().map(|range| StageGroup::new(scheme, &range));
        let widest = scheme.groups().map(|g| g.len()).max().unwrap_or(1);
        let coupled = (widest > 1).then(|| CoupledStages::new(system.pattern(), widest));
        let stage = StageState {
            state: next.clone(),
            before: zeros(),
        };
        let count = scheme.stages().len();
        let coordinates = system.pattern().coordinates().iter();
        let mut others = (coordinates.filter(|c| c.quantity == Quantity::Other)).peekable();
        let gaps = others.peek().is_some() && others.all(|c| c.is_multiplier);
        Ok(Self {
            solver,
            r: zeros(),
            S: vec![0.0; system.pattern().len()],
            dq: vec![0.0; widest * n],
            stages: vec![stage; count],
            groups: groups.collect(),
            coupled: coupled
                .transpose()
                .map_err(|source| DynamicsError::Analysis { source })?,
            next,
            history: Vec::with_capacity(count * (newton.max_iterations.min(100) + 1)),
            evaluations: 0,
            factorisations: 0,
            inverse_scale: inverse_scales(system),
            gaps,
            work: [zeros(), zeros()],
            options: newton,
        })
    }

    /// Makes a step from `state` to the time `t`; the result is in `next`, `state` stays unchanged.
    pub(crate) fn step(
        &mut self,
        system: &mut dyn System,
        scheme: &Scheme,
        state: &State,
        t: f64,
    ) -> Result<(), Cause> {
        let h = t - state.t;
        let step = Attempt { scheme, state, h };
        self.history.clear();
        for (stage, row) in self.stages.iter_mut().zip(scheme.stages()) {
            stage.state.t = if row.c == 1.0 { t } else { state.t + row.c * h };
        }
        for k in 0..self.groups.len() {
            let group = self.groups[k];
            let earlier = self.history.len();
            self.predict(step, &group);
            if let Err(failure) = self.balance(system, step, &group) {
                self.history.drain(..earlier);
                return Err(failure);
            }
        }
        if let Some(last) = self.stages.last_mut() {
            std::mem::swap(&mut self.next, &mut last.state);
        }
        self.next.filtered.copy_from_slice(&self.next.a);
        self.determine_multipliers(system).map_err(Cause::System)
    }

    /// Report of a failed step, after those of a summary.
    pub(crate) fn fail(
        &self,
        system: &mut dyn System,
        cause: Cause,
        span: [f64; 2],
        summary: &Summary,
    ) -> DynamicsError {
        let context = FailureContext {
            cause,
            r: &self.r,
            S: &self.S,
            history: &self.history,
            parameter: StepParameter::Time,
            span,
            steps: summary.steps,
            rejected: summary.failed + summary.inaccurate,
            evaluations: summary.evaluations,
            factorisations: summary.factorisations,
        };
        DynamicsError::Step(FailedStep::new(system, context))
    }

    /// Newton's method for the stages of a group.
    fn balance(
        &mut self,
        system: &mut dyn System,
        step: Attempt<'_>,
        group: &StageGroup,
    ) -> Result<(), Cause> {
        let earlier = self.history.len();
        let mut test = ResidualTest::new(self.options.relative, self.options.absolute);
        let mut renewed = true;
        loop {
            let history = &self.history[earlier..];
            let first = history.is_empty();
            let every = self.options.tangent == TangentUpdate::Every;
            // No tangent is needed at a state that is in balance, or that the last tangent brings
            // there.
            let predictor = ConvergencePredictor::new(history, renewed);
            let wanted = first || (every && !predictor.without_tangent());
            let residual = match first || !group.linear {
                true => self.evaluate(system, step, group, first, wanted)?,
                false => self.linear_residual(system.pattern()),
            };
            if first && self.gaps {
                test.rounding = self.rounding_errors(system, step, group)?;
            }
            let ratio = test.ratio(residual, system.scales().measures());
            let stays = predictor.is_stagnation(residual, test.allowed, false);
            // One correction is made even if the prediction is in balance: a force that is always
            // small beside those that set the tolerance, as of a motor beside the bearings of a
            // fast rotor, would otherwise have no effect.
            let predicted = first && ratio > 0.0;
            let converged =
                (ratio <= 1.0 && !predicted) || (stays && self.is_rounding(system, step, group)?);
            if converged || self.history.len() - earlier >= self.options.max_iterations {
                self.record(residual, ratio, 0.0, 0.0);
                return converged.then_some(()).ok_or(Cause::TooManyIterations);
            }
            renewed = wanted;
            if every && !wanted && !predictor.serves(ratio) {
                self.evaluate(system, step, group, first, true)?;
                renewed = true;
            }
            self.solve(group, renewed)?;
            let correction = self.correct(step, group);
            self.record(residual, ratio, correction, 1.0);
            let start = self.history[earlier].ratio;
            // Rounding errors may grow from a residual that was zero by chance.
            let grows = ratio > 1e12 * start && correction > f64::EPSILON;
            if !correction.is_finite() || grows || ratio.is_nan() {
                return Err(Cause::Diverged);
            }
        }
    }

    /// Linear solutions of the last step.
    pub(super) fn iterations(&self) -> usize {
        solutions(&self.history)
    }

    /// Writes the residuals of the stages of a group to `dq`; returns their largest entries per
    /// quantity, with tangents if requested.
    fn evaluate(
        &mut self,
        system: &mut dyn System,
        step: Attempt<'_>,
        group: &StageGroup,
        first: bool,
        tangent: bool,
    ) -> Result<[f64; 3], Cause> {
        let Attempt { scheme, state, h } = step;
        let (done, rest) = self.stages.split_at_mut(group.start);
        let origin = done.last().map_or(state, |stage| &stage.state);
        if first {
            for stage in &mut rest[..group.len()] {
                stage.before.copy_from_slice(&origin.q);
            }
        }
        let from = first.then_some(origin.t);
        let mut residual = [0.0_f64; 3];
        for k in group.range() {
            // A state with several tangents counts as one evaluation.
            self.evaluations += 1;
            if tangent {
                let row = &scheme.stages()[k];
                let weights = |j: usize| Weights {
                    K: group.unit * row.q[1 + j],
                    C: group.unit * row.v[1 + j] / h,
                    M: if j == k {
                        group.unit * scheme.filter()[0] / (h * h)
                    } else {
                        0.0
                    },
                };
                // The stage's own tangent comes last, for the report of a failure.
                for j in group.range().filter(|j| *j != k).chain([k]) {
                    self.stage(system, k, from, Some(weights(j)))?;
                    if let (true, Some(coupled)) = (group.len() > 1, &mut self.coupled) {
                        let block = [k - group.start, j - group.start];
                        coupled.set(system.pattern(), block, &self.S);
                    }
                }
            } else {
                self.stage(system, k, from, None)?;
            }
            residual = largest(system.pattern(), &self.r, residual);
            let own = (k - group.start) * self.r.len();
            self.dq[own..own + self.r.len()].copy_from_slice(&self.r);
        }
        Ok(residual)
    }

    /// Residual of a linear group after the correction d, r − S d, without an evaluation.
    fn linear_residual(&mut self, pattern: &BlockPattern) -> [f64; 3] {
        pattern.multiply_add(-1.0, &self.S, &self.dq, &mut self.r);
        self.dq[..self.r.len()].copy_from_slice(&self.r);
        largest(pattern, &self.r, [0.0; 3])
    }

    /// Residual of a stage and a tangent; the first iteration of a step comes `from` another time.
    fn stage(
        &mut self,
        system: &mut dyn System,
        k: usize,
        from: Option<f64>,
        weights: Option<Weights>,
    ) -> Result<(), Cause> {
        let StageState { state, before } = &self.stages[k];
        let at = state.point();
        let out = Evaluation {
            r: &mut self.r,
            // The tangent may use the stresses of the previous iterate: large corrections of a slender
            // structure produce spurious stresses.
            previous: weights.map(|_| Point {
                t: from.unwrap_or(state.t),
                q: before,
                ..at
            }),
            S: weights.map(|w| (w, &mut self.S[..])),
            r_t: None,
            accelerations: None,
        };
        system.evaluate(at, out).map_err(Cause::System)?;
        match self.r.iter().position(|r| !r.is_finite()) {
            None => Ok(()),
            Some(i) => Err(Cause::System(SystemError::NotFinite {
                what: system.name(i),
            })),
        }
    }

    /// Residual of a stage and its tangent by coordinates: coupled stages have tangents by
    /// accelerations, in which the weight of the stage's own stiffness may be zero.
    fn by_coordinates(
        &mut self,
        system: &mut dyn System,
        Attempt { scheme, h, .. }: Attempt<'_>,
        k: usize,
    ) -> Result<(), Cause> {
        let weights = Weights {
            K: 1.0,
            C: 1.0 / h,
            M: scheme.filter()[0] / (h * h),
        };
        self.stage(system, k, None, Some(weights))
    }

    /// The largest rounding errors of the residuals at the first stage of a group.
    fn rounding_errors(
        &mut self,
        system: &mut dyn System,
        step: Attempt<'_>,
        group: &StageGroup,
    ) -> Result<[f64; 3], Cause> {
        if group.len() > 1 {
            self.by_coordinates(system, step, group.start)?;
        }
        let q = &self.stages[group.start].state.q;
        let [sizes, floor] = &mut self.work;
        Ok(rounding_errors(system, &self.S, q, [sizes, floor]))
    }

    /// Whether the residuals of a group are rounding errors.
    fn is_rounding(
        &mut self,
        system: &mut dyn System,
        step: Attempt<'_>,
        group: &StageGroup,
    ) -> Result<bool, Cause> {
        for (i, k) in group.range().enumerate() {
            if group.len() > 1 {
                self.by_coordinates(system, step, k)?;
            }
            let own = i * self.r.len()..(i + 1) * self.r.len();
            self.r.copy_from_slice(&self.dq[own]);
            let q = &self.stages[k].state.q;
            let [sizes, floor] = &mut self.work;
            if !is_rounding(system, &self.S, q, &self.r, [sizes, floor]) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Solves for the corrections of a group.
    fn solve(&mut self, group: &StageGroup, fresh: bool) -> Result<(), Cause> {
        self.factorisations += usize::from(fresh);
        let solved = match &mut self.coupled {
            Some(coupled) if group.len() > 1 => {
                let ready = if fresh { coupled.factorise() } else { Ok(()) };
                ready.and_then(|()| coupled.solve(&mut self.dq))
            }
            _ => {
                let b = &mut self.dq[..self.r.len()];
                if fresh {
                    self.solver.factorise_and_solve(&self.S, b)
                } else {
                    self.solver.solve(Some(&self.S), b)
                }
            }
        };
        solved.map_err(Cause::linear)
    }

    fn record(&mut self, residual: [f64; 3], ratio: f64, correction: f64, damping: f64) {
        self.history.push(Iteration {
            residual,
            ratio,
            correction,
            damping,
        });
    }
}

/// Moves the algorithmic acceleration, which belongs to the time tₙ + (α_m − α_f) h, to another
/// step size.
pub(super) fn rebase(progress: &mut Progress, h: f64) {
    let ratio = h / progress.last_step;
    if progress.last_step > 0.0 && (ratio - 1.0).abs() > 1e-9 {
        let State {
            algorithmic,
            filtered,
            ..
        } = &mut progress.state;
        for (old, a) in algorithmic.iter_mut().zip(filtered) {
            *old = *a + (*old - *a) * ratio;
        }
        progress.last_step = h;
    }
}
