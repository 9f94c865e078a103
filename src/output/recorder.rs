//! Records converged steps and writes the results.

mod campbell;
mod finish;
mod modes;

use super::checkpoint::{self, Checkpoint, Record};
use super::directory::{Directory, OutputError, encoding};
use super::grids::{Grids, grid_name};
use super::history::{HistoryRow, csv};
use super::log::{self, Extent};
use super::plot::Shapes;
use super::results::{Ending, FinalState, Statistics, final_state};
use super::vtu::{VtuFrame, collection, grid};
use crate::input::{DynamicPlan, Geometry, ModelFile, Plan};
use crate::probe::{Answers, Probe};
use crate::solve::{Advance, Counts};
use crate::warnings::{Diagnostics, JointRates};
use pullback_elements::model::Context;
use pullback_integrators::dynamics::Progress;
use pullback_manifold::system::{Evaluation, Point, System, SystemError};
use std::time::{Duration, Instant};

/// Time between two savings of history and results.
const SAVED: Duration = Duration::from_secs(5);

/// Shapes kept for the figure of the deformed structure.
const SHAPES: usize = 64;

/// The constant data of an analysis.
pub(crate) struct Setting<'a> {
    /// Path of the model file, as displayed.
    pub source: &'a str,
    /// The file with defaults.
    pub file: &'a ModelFile,
    /// The analysis.
    pub plan: &'a Plan,
    /// Geometry of the lines.
    pub geometry: &'a Geometry,
    /// Notes on the model.
    pub notes: &'a [String],
}

/// Collects steps and writes files.
pub(crate) struct Recorder<'a> {
    setting: Setting<'a>,
    directory: Directory,
    probes: Vec<Probe>,
    reference: Shapes,
    /// Rows so far.
    pub rows: Vec<HistoryRow>,
    frames: Vec<VtuFrame>,
    record: Record,
    /// The rows and frames in the log of the last checkpoint.
    log: Extent,
    last: Option<FinalState>,
    grids: Grids,
    diagnostics: Diagnostics,
    joint_rates: JointRates,
    statistics: Statistics,
    started: Instant,
    saved: Instant,
}

impl<'a> Recorder<'a> {
    /// Writes a first `result.json`, marked as incomplete. `warnings` are those of the model.
    pub fn new(
        setting: Setting<'a>,
        directory: Directory,
        probes: Vec<Probe>,
        context: &Context,
        warnings: Vec<String>,
    ) -> Result<Self, OutputError> {
        let lines = setting.geometry.lines.iter();
        let elements = lines.map(|l| l.elements.len()).sum::<usize>();
        let bodies = setting.geometry.bodies.len();
        let statistics = Statistics {
            nodes: context.frames().count(),
            elements: elements + bodies + setting.file.springs.len(),
            unknowns: context.pattern().dim(),
            symmetric: context.is_symmetric(),
            ..Statistics::default()
        };
        let now = Instant::now();
        let mut recorder = Self {
            reference: Shapes::of(context, setting.geometry, 0.0),
            grids: Grids::of(setting.file.output.paraview_every, setting.plan),
            diagnostics: Diagnostics::new(setting.plan.start(), setting.plan.relative()),
            joint_rates: JointRates::default(),
            setting,
            directory,
            probes,
            rows: Vec::new(),
            frames: Vec::new(),
            log: Extent::default(),
            record: Record {
                stride: 1,
                warnings,
                ..Record::default()
            },
            last: None,
            statistics,
            started: now,
            saved: now,
        };
        recorder.write_results(&Ending::Running)?;
        Ok(recorder)
    }

    /// Resumes from a checkpoint, whose state has its row already.
    pub fn resume(
        &mut self,
        context: &mut Context,
        checkpoint: Checkpoint,
        progress: &Progress,
    ) -> Result<(), RecordError> {
        for (probe, memory) in self.probes.iter_mut().zip(checkpoint.memories) {
            probe.restore(memory);
        }
        self.record = checkpoint.record;
        self.rows = checkpoint.rows;
        self.frames = checkpoint.frames;
        self.log = checkpoint.log;
        self.statistics.counts = Counts::of_motion(&progress.summary);
        self.joint_rates = JointRates::new(context, &progress.state);
        let (t, answers) = (progress.state.t, moving(context, progress)?);
        self.last = Some(final_state(context, &answers, t, None, self.setting.file));
        if self.grids != Grids::None {
            // Grids written after the checkpoint were removed.
            self.write_collection()?;
        }
        Ok(())
    }

    /// Records the reference configuration if nothing acts on it at the first load; otherwise the
    /// equilibrium there is a step of its own, number 0.
    pub fn start(&mut self, context: &mut Context) -> Result<(), OutputError> {
        let n = context.pattern().dim();
        let (q, t) = (vec![0.0; n], self.setting.plan.start());
        let mut r = vec![0.0; n];
        let at = Point::statics(t, &q);
        let evaluated = context.evaluate(at, Evaluation::residual(&mut r));
        if evaluated.is_err() || r.iter().any(|r| *r != 0.0) {
            return Ok(());
        }
        let row = HistoryRow {
            t,
            ..HistoryRow::default()
        };
        self.add(context, row, &Answers::of(context, t))
    }

    /// Records the initial state of a motion.
    pub fn start_motion(
        &mut self,
        context: &mut Context,
        progress: &Progress,
    ) -> Result<(), RecordError> {
        self.statistics.counts = Counts::of_motion(&progress.summary);
        self.record.largest_rotation = context.largest_rotation();
        self.joint_rates = JointRates::new(context, &progress.state);
        let row = HistoryRow {
            t: progress.state.t,
            chart_changes: progress.summary.chart_changes,
            ..HistoryRow::default()
        };
        let answers = moving(context, progress)?;
        Ok(self.add(context, row, &answers)?)
    }

    /// Records a converged step, with the model in its configuration; in a motion at the interval of the plan.
    pub fn record(&mut self, context: &mut Context, step: &Advance<'_>) -> Result<(), RecordError> {
        self.count(context, step);
        if !self.due(step) {
            return Ok(());
        }
        let row = self.row(step);
        let answers = match step.progress {
            Some(progress) => moving(context, progress)?,
            None => {
                let answers = Answers::of(context, step.t);
                let first = step.residuals.first().filter(|_| step.number == 0);
                let released = first.map_or([0.0; 3], |i| i.residual);
                self.diagnostics.record(context, &answers, &row, released);
                answers
            }
        };
        self.add(context, row, &answers)?;
        if self.saved.elapsed() > SAVED {
            self.write_history()?;
            self.write_results(&Ending::Running)?;
            self.saved = Instant::now();
        }
        Ok(())
    }

    /// Updates what is known of all steps, recorded as rows or not.
    fn count(&mut self, context: &Context, step: &Advance<'_>) {
        let rotation = context.largest_rotation();
        self.record.largest_rotation = self.record.largest_rotation.max(rotation);
        self.statistics.counts.add(step);
        if let Some(progress) = step.progress {
            let furthest = &mut self.record.turn;
            self.joint_rates
                .record(context, &progress.state, step.step_size, furthest);
        }
        self.record.since[0] += step.iterations;
        self.record.since[1] += step.chart_changes;
    }

    /// The row of a step, without the quantities of the model.
    fn row(&mut self, step: &Advance<'_>) -> HistoryRow {
        let [iterations, chart_changes] = std::mem::take(&mut self.record.since);
        let event = match (self.setting.plan, step.event) {
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
        match self.setting.plan {
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

    fn add(
        &mut self,
        context: &Context,
        mut row: HistoryRow,
        answers: &Answers,
    ) -> Result<(), OutputError> {
        row.largest_rotation = context.largest_rotation();
        row.strain_energy = answers.strain_energy;
        row.motion = (answers.motion).map(|(balance, defect)| [balance.energies.kinetic, defect]);
        for probe in &mut self.probes {
            probe.record(context, answers, &mut row.probes);
        }
        self.last = Some(final_state(
            context,
            answers,
            row.t,
            row.unstable,
            self.setting.file,
        ));
        let number = self.rows.len();
        let scale = self.setting.file.output.deformation_scale;
        let shape = (row.t, Shapes::of(context, self.setting.geometry, scale));
        if number.is_multiple_of(self.record.stride) {
            self.record.latest = None;
            self.keep(shape);
        } else {
            self.record.latest = Some(shape);
        }
        if self.grids != Grids::None {
            // A path may turn back in the load; ParaView needs ascending times.
            let (at, load) = match self.setting.plan {
                Plan::Dynamic(_) => (row.t, None),
                Plan::Static(_) => (row.t, Some(row.t)),
                Plan::Path(..) => (number as f64, Some(row.t)),
            };
            let frame = VtuFrame {
                t: at,
                file: grid_name(self.setting.plan, number),
            };
            let text = grid(context, self.setting.geometry, answers, load);
            self.record.pending = Some((frame, text));
            let before = self.rows.last().map(|row| row.t);
            if self.grids.due(number, before, row.t) {
                self.write_pending()?;
            }
        }
        self.rows.push(row);
        Ok(())
    }

    /// Keeps a shape; if there are too many, every second one is dropped. The limit is even, so the last one stays.
    fn keep(&mut self, shape: (f64, Shapes)) {
        let record = &mut self.record;
        record.shapes.push(shape);
        if record.shapes.len() > SHAPES {
            let all = std::mem::take(&mut record.shapes);
            record.shapes = all.into_iter().step_by(2).collect();
            record.stride *= 2;
        }
    }

    fn write_pending(&mut self) -> Result<(), OutputError> {
        if let Some((frame, text)) = self.record.pending.take() {
            self.directory.write(&frame.file, &text)?;
            self.frames.push(frame);
            self.write_collection()?;
        }
        Ok(())
    }

    fn write_collection(&mut self) -> Result<(), OutputError> {
        self.directory.write("steps.pvd", &collection(&self.frames))
    }

    fn write_history(&mut self) -> Result<(), OutputError> {
        let columns: Vec<String> = self.probes.iter().flat_map(Probe::columns).collect();
        let text = csv(&columns, &self.rows);
        self.directory.write("history.csv", &text)
    }

    fn seconds(&self) -> f64 {
        self.record.seconds + self.started.elapsed().as_secs_f64()
    }

    /// Writes a checkpoint: first appends the rows since the last one to the log, then writes the state with the
    /// new length of the log.
    pub fn checkpoint(
        &mut self,
        context: &Context,
        progress: &Progress,
    ) -> Result<(), OutputError> {
        let before = self.log;
        let name = |k| grid_name(self.setting.plan, before.rows + k);
        let (rows, frames) = (&self.rows[before.rows..], &self.frames[before.frames..]);
        let lines = log::lines(rows, frames, name).map_err(encoding(log::NAME))?;
        self.directory.append(log::NAME, before.bytes, &lines)?;
        self.log = Extent {
            rows: self.rows.len(),
            frames: self.frames.len(),
            bytes: before.bytes + lines.len(),
            crc32: before.crc32_with(&lines),
        };
        let settings =
            serde_json::to_value(self.setting.file).map_err(encoding(checkpoint::NAME))?;
        let mut checkpoint = Checkpoint::new(settings, context, progress);
        checkpoint.memories = self.probes.iter().map(Probe::save).collect();
        checkpoint.record = self.record.clone();
        checkpoint.record.seconds = self.seconds();
        checkpoint.log = self.log;
        self.directory.write(checkpoint::NAME, &checkpoint.text()?)
    }
}

/// The answers of a model at the present state of a motion.
fn moving(context: &mut Context, progress: &Progress) -> Result<Answers, RecordError> {
    let t = progress.state.t;
    let balance = context
        .energies_and_momentum(progress.state.point())
        .map_err(RecordError::System)?;
    let defect = progress.summary.energy.map_or(0.0, |e| e.defect());
    Ok(Answers {
        motion: Some((balance, defect)),
        ..Answers::of(context, t)
    })
}

/// Why a step cannot be recorded.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// It cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The model cannot be evaluated there.
    #[error("a converged state cannot be evaluated: {0}")]
    System(SystemError),
}
