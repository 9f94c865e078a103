//! Records converged steps and writes the results.

mod campbell;
mod finish;
mod modes;

use super::checkpoint::{self, Checkpoint, Record};
use super::directory::{Directory, OutputError, encoding};
use super::grids::{Grids, frames, grid_name};
use super::history::csv;
use super::log::{self, Extent};
use super::plot::Shapes;
use super::recording::Recording;
use super::results::{Ending, FinalState, Statistics, final_state};
use super::vtu::{collection, grid};
use crate::input::{Geometry, ModelFile, Plan};
use crate::probe::{Answers, Probe};
use crate::solve::Advance;
use pullback_elements::model::Context;
use pullback_integrators::dynamics::Progress;
use pullback_manifold::system::{System, SystemError};
use std::time::{Duration, Instant};

/// Time between two savings of history and results.
const SAVED: Duration = Duration::from_secs(5);

/// Most shapes kept for the figures of the deformed structure.
const SHAPES: usize = 128;

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
    /// The history and what else is in memory.
    pub recording: Recording<'a>,
    reference: Shapes,
    record: Record,
    /// The rows in the log of the last checkpoint.
    log: Extent,
    last: Option<FinalState>,
    grids: Grids,
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
            recording: Recording::new(setting.plan, probes, warnings),
            setting,
            directory,
            log: Extent::default(),
            record: Record {
                stride: 1,
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
        let recording = &mut self.recording;
        for (probe, memory) in recording.probes.iter_mut().zip(checkpoint.memories) {
            probe.continued = memory;
        }
        recording.rows = checkpoint.rows;
        self.record = checkpoint.record;
        recording.seen = self.record.seen.clone();
        self.log = checkpoint.log;
        let answers = recording.resume(context, progress)?;
        let t = progress.state.t;
        self.last = Some(final_state(context, &answers, t, None, self.setting.file));
        if self.grids != Grids::None {
            // Grids written after the checkpoint were removed.
            self.write_collection()?;
        }
        Ok(())
    }

    /// Records the initial state of a motion; see [`Recording::start`].
    pub fn start(&mut self, context: &mut Context, progress: &Progress) -> Result<(), RecordError> {
        match self.recording.start(context, progress)? {
            Some(answers) => Ok(self.add(context, &answers)?),
            None => Ok(()),
        }
    }

    /// Records a converged step, with the model in its configuration; in a motion at the interval of the plan.
    pub fn record(&mut self, context: &mut Context, step: &Advance<'_>) -> Result<(), RecordError> {
        let Some(answers) = self.recording.take(context, step)? else {
            return Ok(());
        };
        self.add(context, &answers)?;
        if self.saved.elapsed() > SAVED {
            self.write_history()?;
            self.write_results(&Ending::Running)?;
            self.saved = Instant::now();
        }
        Ok(())
    }

    /// Adds what the files tell of the last row.
    fn add(&mut self, context: &Context, answers: &Answers) -> Result<(), OutputError> {
        let Some((row, earlier)) = self.recording.rows.split_last() else {
            return Ok(());
        };
        let (number, before) = (earlier.len(), earlier.last().map(|row| row.t));
        let (t, unstable) = (row.t, row.unstable);
        let file = self.setting.file;
        self.last = Some(final_state(context, answers, t, unstable, file));
        let scale = self.setting.file.output.deformation_scale;
        let shape = (t, Shapes::of(context, self.setting.geometry, scale));
        if number.is_multiple_of(self.record.stride) {
            self.record.latest = None;
            self.keep(shape);
        } else {
            self.record.latest = Some(shape);
        }
        if self.grids != Grids::None {
            let load = match self.setting.plan {
                Plan::Dynamic(_) => None,
                _ => Some(t),
            };
            let text = grid(context, self.setting.geometry, answers, load);
            self.record.pending = Some((number, text));
            if self.grids.due(number, before, t) {
                self.write_pending()?;
            }
        }
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
        if let Some((number, text)) = self.record.pending.take() {
            let name = grid_name(self.setting.plan, number);
            self.directory.write(&name, &text)?;
            self.recording.rows[number].grid = true;
            self.write_collection()?;
        }
        Ok(())
    }

    fn write_collection(&mut self) -> Result<(), OutputError> {
        let frames = frames(self.setting.plan, &self.recording.rows);
        self.directory.write("steps.pvd", &collection(&frames))
    }

    fn write_history(&mut self) -> Result<(), OutputError> {
        let text = csv(&self.recording.history());
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
        let rows = &self.recording.rows;
        let lines = log::lines(&rows[before.rows..]).map_err(encoding(log::NAME))?;
        self.directory.append(log::NAME, before.bytes, &lines)?;
        self.log = Extent {
            rows: rows.len(),
            bytes: before.bytes + lines.len(),
            crc32: before.crc32_with(&lines),
        };
        let settings =
            serde_json::to_value(self.setting.file).map_err(encoding(checkpoint::NAME))?;
        let mut checkpoint = Checkpoint::new(settings, context, progress);
        let probes = self.recording.probes.iter();
        checkpoint.memories = probes.map(|probe| probe.continued).collect();
        checkpoint.record = self.record.clone();
        checkpoint.record.seen = self.recording.seen.clone();
        checkpoint.record.seconds = self.seconds();
        checkpoint.log = self.log;
        self.directory.write(checkpoint::NAME, &checkpoint.text()?)
    }
}

/// Why a step cannot be recorded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// It cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The model cannot be evaluated there.
    #[error("a converged state cannot be evaluated: {0}")]
    System(#[from] SystemError),
}
