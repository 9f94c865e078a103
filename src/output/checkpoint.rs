//! `checkpoint.json`: with the rows in the log beside it, everything that a motion needs to go on as if
//! it had never stopped.

use super::directory::{self, OutputError};
use super::history::Row;
use super::log::{self, Extent};
use super::plot::Shapes;
use super::vtu::Frame;
use crate::warnings::Turn;
use pullback_elements::model::Model;
use pullback_integrators::dynamics::Progress;
use pullback_manifold::system::System;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Program and version.
const PROGRAM: &str = concat!("pullback ", env!("CARGO_PKG_VERSION"));

/// What is wrong with a file that was damaged, or changed by hand.
const CHECKSUM: &str = "its checksum is not that of its content";

/// Name of the file.
pub(super) const NAME: &str = "checkpoint.json";

/// What has been recorded so far, besides rows and grids.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Record {
    /// Shapes on the way, thinned out as they grow many.
    pub shapes: Vec<(f64, Shapes)>,
    /// The shape of the last row, where it is not among them.
    pub latest: Option<(f64, Shapes)>,
    /// The grid of the last row, where it has not been written.
    pub pending: Option<(Frame, String)>,
    /// Every how many rows a shape is kept.
    pub stride: usize,
    /// Iterations and changes of chart of steps after the last row.
    pub since: [usize; 2],
    /// Largest rotation angle of any node so far.
    pub largest_rotation: f64,
    /// What looked doubtful at the start.
    pub warnings: Vec<String>,
    /// Largest change of a joint's rate in a step, where steps do not resolve it.
    pub turn: Option<Turn>,
    /// Wall-clock time spent.
    pub seconds: f64,
}

/// A motion that can be taken up again.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Of what stands behind it in the file.
    #[serde(skip_serializing)]
    crc32: u32,
    program: String,
    /// The model file with defaults.
    settings: Value,
    /// Names of the unknowns in their order.
    unknowns: Vec<String>,
    pub(super) progress: Progress,
    pub(super) element_charts: Vec<u32>,
    /// What maps remember of their way.
    pub(super) maps: Vec<Vec<f64>>,
    /// Rotation vectors that the probes have seen last.
    pub(super) memories: Vec<[f64; 3]>,
    pub(super) record: Record,
    /// How much of the log is its own.
    pub(super) log: Extent,
    /// The rows in the log.
    #[serde(skip)]
    pub(super) rows: Vec<Row>,
    /// The grids of rows in the log.
    #[serde(skip)]
    pub(super) frames: Vec<Frame>,
}

/// Why a run cannot be resumed.
#[derive(Debug, thiserror::Error)]
pub enum ResumeError {
    /// Only a motion has checkpoints.
    #[error("only a dynamic analysis can be resumed; run without --resume")]
    Statics,
    /// There is no checkpoint.
    #[error("cannot read {}: {source}; run without --resume first", path.display())]
    None {
        /// Where it should be.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file is no checkpoint of this program.
    #[error("{} is no checkpoint of this version of the program: {source}", path.display())]
    Unusable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// The model file is another one by now.
    #[error(
        "`{part}` has changed in the model file since {} was written; only `output` and \
         `analysis.dynamic` (but not its scheme) may change. Undo that, or run without --resume",
        path.display()
    )]
    Changed {
        /// The checkpoint.
        path: PathBuf,
        /// What has changed.
        part: String,
    },
    /// The file is not as it was written.
    #[error("{} is damaged: {what}; run without --resume", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// The run has passed the end that is asked for.
    #[error(
        "the checkpoint is at time {t}, not before `to` = {to}: there is nothing left to compute"
    )]
    Passed {
        /// Time reached.
        t: f64,
        /// Time asked for.
        to: f64,
    },
}

impl Checkpoint {
    pub(super) fn new(settings: Value, unknowns: Vec<String>, progress: &Progress) -> Self {
        Self {
            crc32: 0,
            program: PROGRAM.to_owned(),
            settings,
            unknowns,
            progress: progress.clone(),
            element_charts: Vec::new(),
            maps: Vec::new(),
            memories: Vec::new(),
            record: Record::default(),
            log: Extent::default(),
            rows: Vec::new(),
            frames: Vec::new(),
        }
    }

    /// Its text: an object of JSON, whose first entry is the checksum of what follows.
    pub(super) fn text(&self) -> Result<String, OutputError> {
        let text = serde_json::to_string(self).map_err(|source| OutputError::Encode {
            name: NAME.to_owned(),
            source,
        })?;
        let content = &text[1..];
        let crc32 = crc32fast::hash(content.as_bytes());
        Ok(format!("{{\"crc32\":{crc32},{content}"))
    }

    /// Reads the checkpoint of a directory, for a model file that now says `settings`.
    ///
    /// # Errors
    /// [`ResumeError`].
    pub fn read(directory: &Path, settings: &Value, model: &Model) -> Result<Self, ResumeError> {
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
        if read.unknowns != names(model) {
            let part = "the order of nodes".to_owned();
            return Err(ResumeError::Changed { path, part });
        }
        let path = directory.join(log::NAME);
        let lines = directory::read(&path).map_err(none(&path))?;
        // What stands behind was written after this checkpoint.
        let Some(lines) = lines.get(..read.log.bytes) else {
            return Err(damaged(path, "it ends before its checkpoint does"));
        };
        if crc32fast::hash(lines) != read.log.crc32 {
            return Err(damaged(path, CHECKSUM));
        }
        (read.rows, read.frames) = log::read(lines).map_err(|source| unusable(path, source))?;
        Ok(read)
    }

    /// Where the motion is.
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// Puts a model into the charts that it was in.
    ///
    /// # Errors
    /// [`ResumeError::Damaged`] where they are not those of this model.
    pub(crate) fn restore(&self, model: &mut Model, directory: &Path) -> Result<(), ResumeError> {
        model.set_element_charts(&self.element_charts);
        if model.restore_maps(&self.maps) {
            return Ok(());
        }
        Err(ResumeError::Damaged {
            path: directory.join(NAME),
            what: "what the joints remember is not of this model".to_owned(),
        })
    }

    /// Names of the ParaView files written by then.
    pub(crate) fn grids(&self) -> Vec<&str> {
        self.frames.iter().map(|f| f.file.as_str()).collect()
    }
}

/// Names of the unknowns of a model.
pub(super) fn names(model: &Model) -> Vec<String> {
    (0..model.pattern().dim()).map(|i| model.name(i)).collect()
}

/// The part of the model file that must not have changed but has.
fn changed(before: &Value, now: &Value) -> Option<String> {
    let scheme = "/analysis/dynamic/scheme";
    if before.pointer(scheme) != now.pointer(scheme) {
        return Some("analysis.dynamic.scheme".to_owned());
    }
    let (before, now) = (before.as_object()?, now.as_object()?);
    let keys = before.keys().chain(now.keys());
    let mut fixed = keys.filter(|key| !["analysis", "output"].contains(&key.as_str()));
    fixed.find(|key| before.get(*key) != now.get(*key)).cloned()
}
