//! What a run leaves in memory: its history, counts and warnings.

use super::history::{History, HistoryRow};
use super::results::Ending;
use crate::input::{DynamicPlan, Plan};
use crate::probe::{Answers, Probe};
use crate::solve::{Advance, Counts};
use crate::warnings::{Diagnostics, JointRates, RateChange, unbalanced};
use pullback_elements::model::Context;
use pullback_integrators::dynamics::Progress;
use pullback_manifold::system::SystemError;
use serde::{Deserialize, Serialize};

/// Takes the converged steps of a run.
pub(crate) struct Recording<'a> {
    plan: &'a Plan,
    /// The quantities recorded.
    pub probes: Vec<Probe>,
    /// Rows so far.
    pub rows: Vec<HistoryRow>,
    /// Counts so far.
    pub counts: Counts,
    /// What is known of all steps.
    pub seen: Seen,
    diagnostics: Diagnostics,
    joint_rates: JointRates,
}

/// What is known of all steps, those without a row included.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Seen {
    /// Iterations and chart changes since the last row.
    pub since: [usize; 2],
    /// Largest rotation angle of any node so far.
    pub largest_rotation: f64,
    /// Warnings of the model, and of what was found at its end.
    pub warnings: Vec<String>,
    /// Largest change of a joint's rate in a step, if steps do not resolve it.
    pub turn: Option<RateChange>,
}

impl<'a> Recording<'a> {
    /// A recording before the first row; `warnings` are those of the model.
    pub fn new(plan: &'a Plan, probes: Vec<Probe>, warnings: Vec<String>) -> Self {
        Self {
            diagnostics: Diagnostics::new(plan.start(), plan.relative()),
            joint_rates: JointRates::default(),
            plan,
            probes,
            rows: Vec::new(),
            counts: Counts::default(),
            seen: Seen {
                warnings,
                ..Seen::default()
            },
        }
    }

    /// Continues a motion whose state has its row already.
    pub fn resume(
        &mut self,
        context: &mut Context,
        progress: &Progress,
    ) -> Result<Answers, SystemError> {
        self.counts = Counts::of_motion(&progress.summary);
        self.joint_rates = JointRates::new(context, &progress.state);
        Answers::of_motion(context, progress)
    }

    /// Records the initial state of a motion; nothing in statics, where the start is a step of its own, number 0.
    pub fn start(
        &mut self,
        context: &mut Context,
        progress: &Progress,
    ) -> Result<Option<Answers>, SystemError> {
        let Plan::Dynamic(_) = self.plan else {
            return Ok(None);
        };
        let answers = self.resume(context, progress)?;
        self.seen.largest_rotation = context.largest_rotation();
        let row = HistoryRow {
            t: progress.state.t,
            chart_changes: progress.summary.chart_changes,
            ..HistoryRow::default()
        };
        self.add(context, row, &answers);
        Ok(Some(answers))
    }

    /// Records a converged step, with the model in its configuration; returns its answers if it has a row: in a
    /// motion at the interval of the plan.
    pub fn take(
        &mut self,
        context: &mut Context,
        step: &Advance<'_>,
    ) -> Result<Option<Answers>, SystemError> {
        self.count(context, step);
        if !self.due(step) {
            return Ok(None);
        }
        let row = self.row(step);
        let answers = match step.progress {
            Some(progress) => Answers::of_motion(context, progress)?,
            None => {
                let answers = Answers::of(context, step.t);
                self.diagnostics.record(context, &answers, &row);
                answers
            }
        };
        self.add(context, row, &answers);
        Ok(Some(answers))
    }

    /// Updates what is known of all steps, recorded as rows or not.
    fn count(&mut self, context: &Context, step: &Advance<'_>) {
        let rotation = context.largest_rotation();
        self.seen.largest_rotation = self.seen.largest_rotation.max(rotation);
        self.counts.add(step);
        if let Some(progress) = step.progress {
            let furthest = &mut self.seen.turn;
            self.joint_rates
                .record(context, &progress.state, step.step_size, furthest);
        }
        self.seen.since[0] += step.iterations;
        self.seen.since[1] += step.chart_changes;
    }

    /// The row of a step, without the quantities of the model.
    fn row(&mut self, step: &Advance<'_>) -> HistoryRow {
        let [iterations, chart_changes] = std::mem::take(&mut self.seen.since);
        let event = match (self.plan, step.event) {
            (Plan::Path(_, names), Some(k)) => names.get(k).cloned(),
            _ => None,
        };
        let end = step.residuals.last();
        let before = step.residuals.iter().nth_back(1);
        let [force, moment, _] = end.map_or([0.0; 3], |i| i.residual);
        HistoryRow {
            step: step.number,
            t: step.t,
            step_size: step.step_size,
            iterations,
            residual: [force, moment],
            ratio: end.map_or(0.0, |i| i.ratio),
            correction: before.map_or(0.0, |i| i.correction * i.damping),
            chart_changes,
            event,
            unstable: step.unstable,
            ..HistoryRow::default()
        }
    }

    /// Whether a step is recorded as a row.
    fn due(&self, step: &Advance<'_>) -> bool {
        match self.plan {
            Plan::Dynamic(DynamicPlan {
                options,
                record_every,
                ..
            }) => {
                let due = match options.intervals(step.t) {
                    Some(passed) => Some(passed) > options.intervals(step.t - step.step_size),
                    None => step.number.is_multiple_of(*record_every),
                };
                due || step.t >= options.to
            }
            _ => true,
        }
    }

    fn add(&mut self, context: &Context, mut row: HistoryRow, answers: &Answers) {
        row.largest_rotation = context.largest_rotation();
        row.strain_energy = answers.strain_energy;
        row.motion = (answers.motion).map(|(balance, defect)| [balance.energies.kinetic, defect]);
        for probe in &mut self.probes {
            probe.record(context, answers, &mut row.probes);
        }
        self.rows.push(row);
    }

    /// The history so far.
    pub fn history(&self) -> History {
        let probes = self.probes.iter().flat_map(Probe::columns);
        History::new(probes.collect(), &self.rows)
    }

    /// The warnings so far, of a complete run or not.
    pub fn warnings(&self, ending: &Ending) -> Vec<String> {
        let found = self.diagnostics.warnings(*ending == Ending::Complete);
        let turn = self.seen.turn.as_ref().map(RateChange::warning);
        let balance = unbalanced(&self.counts).map(str::to_owned);
        let warnings = self.seen.warnings.iter().cloned();
        warnings.chain(found).chain(turn).chain(balance).collect()
    }
}
