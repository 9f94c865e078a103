//! `checkpoint.json`: with the rows in the log beside it, everything needed to resume a motion with bitwise the
//! same results.

use super::directory::{self, OutputError};
use super::grids::frames;
use super::history::HistoryRow;
use super::log::{self, Extent};
use super::plot::Shapes;
use super::recording::Seen;
use super::results::PROGRAM;
use crate::input::Plan;
use nalgebra::Vector3;
use pullback_elements::model::{Context, SavedState};
use pullback_integrators::dynamics::Progress;
use pullback_manifold::system::System;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Message for a file that was damaged or edited.
const CHECKSUM: &str = "its checksum is not that of its content";

/// Name of the file.
pub(super) const NAME: &str = "checkpoint.json";

/// Recorded data other than rows and grids.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Record {
    /// Intermediate shapes, thinned out as their number grows.
    pub shapes: Vec<(f64, Shapes)>,
    /// The shape of the last row, if it is not among them.
    pub latest: Option<(f64, Shapes)>,
    /// The number of the last row and its grid, if it has not been written.
    pub pending: Option<(usize, String)>,
    /// Number of rows per shape.
    pub stride: usize,
    /// What is known of all steps.
    pub seen: Seen,
    /// Wall-clock time spent.
    pub seconds: f64,
}

/// A motion that can be resumed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Checksum of the rest of the file.
    #[serde(skip_serializing)]
    crc32: u32,
    program: String,
    /// The model file with defaults.
    settings: Value,
    /// Names of the unknowns in their order.
    unknowns: Vec<String>,
    pub(crate) progress: Progress,
    /// State of the model besides the coordinates.
    state: SavedState,
    /// Last rotation vectors of the probes.
    pub(super) memories: Vec<Vector3<f64>>,
    pub(super) record: Record,
    /// The part of the log that belongs to it.
    pub(super) log: Extent,
    /// The rows in the log.
    #[serde(skip)]
    pub(super) rows: Vec<HistoryRow>,
}

/// Why a run cannot be resumed.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
#[non_exhaustive]
pub enum ResumeError {
    /// Only dynamic analyses have checkpoints.
    #[error("only a dynamic analysis can be resumed; run without --resume")]
    Statics,
    /// There is no checkpoint.
    #[error("cannot read {}: {source}; run without --resume first", path.display())]
    None {
        path: PathBuf,
        source: std::io::Error,
    },
    /// The file is not a checkpoint of this program.
    #[error("{} is not a checkpoint of this version of the program: {source}", path.display())]
    Unusable {
        path: PathBuf,
        source: serde_json::Error,
    },
    /// The model file has changed.
    #[error(
        "`{part}` has changed in the model file since {} was written; only `output` and \
         `analysis.dynamic` (but not its scheme or its start in equilibrium) may change. Undo that, or run without --resume",
        path.display()
    )]
    Changed {
        /// The checkpoint.
        path: PathBuf,
        part: String,
    },
    /// The file is damaged or was edited.
    #[error("{} is damaged: {what}; run without --resume", path.display())]
    Damaged { path: PathBuf, what: String },
    /// The run has passed the requested end.
    #[error(
        "the checkpoint is at time {t}, not before `to` = {to}: there is nothing left to compute"
    )]
    Passed {
        t: f64,
        /// Requested end time.
        to: f64,
    },
}

impl Checkpoint {
    pub(super) fn new(settings: Value, context: &Context, progress: &Progress) -> Self {
        Self {
            crc32: 0,
            program: PROGRAM.to_owned(),
            settings,
            unknowns: names(context),
            progress: progress.clone(),
            state: context.save(),
            memories: Vec::new(),
            record: Record::default(),
            log: Extent::default(),
            rows: Vec::new(),
        }
    }

    /// Its text: a JSON object, whose first entry is the checksum of the rest.
    pub(super) fn text(&self) -> Result<String, OutputError> {
        let text = serde_json::to_string(self).map_err(directory::encoding(NAME))?;
        let content = &text[1..];
        let crc32 = crc32fast::hash(content.as_bytes());
        Ok(format!("{{\"crc32\":{crc32},{content}"))
    }

    /// Reads the checkpoint of a directory, for a model file with the present `settings`, and restores the state of its
    /// model besides the coordinates.
    ///
    /// # Errors
    /// [`ResumeError`].
    pub fn read(
        directory: &Path,
        settings: &Value,
        context: &mut Context,
    ) -> Result<Self, ResumeError> {
        let path = directory.join(NAME);
        let none = |path: &Path| {
            let path = path.to_owned();
            |source| ResumeError::None { path, source }
        };
        let text = directory::read(&path).map_err(none(&path))?;
        let unusable = |path, source| ResumeError::Unusable { path, source };
        let damaged = |path, what: &str| {
            let what = what.to_owned();
            ResumeError::Damaged { path, what }
        };
        let mut read: Self =
            serde_json::from_slice(&text).map_err(|source| unusable(path.clone(), source))?;
        if read.program != PROGRAM {
            return Err(damaged(path, "it is of another version"));
        }
        let content = text.splitn(2, |&byte| byte == b',').last();
        if crc32fast::hash(content.unwrap_or_default()) != read.crc32 {
            return Err(damaged(path, CHECKSUM));
        }
        if let Some(part) = changed(&read.settings, settings) {
            return Err(ResumeError::Changed { path, part });
        }
        if read.unknowns != names(context) {
            let part = "the order of nodes".to_owned();
            return Err(ResumeError::Changed { path, part });
        }
        if !context.restore(&read.state) {
            let what = "its state of charts and joints is not of this model";
            return Err(damaged(path, what));
        }
        let path = directory.join(log::NAME);
        let lines = directory::read(&path).map_err(none(&path))?;
        // The rest was written after this checkpoint.
        let Some(lines) = lines.get(..read.log.bytes) else {
            return Err(damaged(path, "it ends before its checkpoint does"));
        };
        if crc32fast::hash(lines) != read.log.crc32 {
            return Err(damaged(path, CHECKSUM));
        }
        read.rows = log::read(lines).map_err(|source| unusable(path, source))?;
        Ok(read)
    }

    /// Names of the ParaView files of the rows so far.
    pub(crate) fn grids(&self, plan: &Plan) -> Vec<String> {
        let frames = frames(plan, &self.rows).into_iter();
        frames.map(|frame| frame.file).collect()
    }
}

/// Names of the unknowns of a model.
fn names(context: &Context) -> Vec<String> {
    (0..context.pattern().dim())
        .map(|i| context.name(i))
        .collect()
}

/// The first changed part of the model file that must not change.
fn changed(before: &Value, now: &Value) -> Option<String> {
    for key in ["scheme", "from_equilibrium"] {
        let path = format!("/analysis/dynamic/{key}");
        if before.pointer(&path) != now.pointer(&path) {
            return Some(format!("analysis.dynamic.{key}"));
        }
    }
    let (before, now) = (before.as_object()?, now.as_object()?);
    let keys = before.keys().chain(now.keys());
    let mut fixed = keys.filter(|key| !["analysis", "output"].contains(&key.as_str()));
    fixed.find(|key| before.get(*key) != now.get(*key)).cloned()
}
