//! Output of a run: history, results, figures, ParaView files.
//!
//! Files are written under temporary names and renamed when they are complete. The log of a checkpoint
//! is appended to instead; its valid length is in the checkpoint.

mod checkpoint;
mod directory;
mod grids;
mod history;
mod log;
mod panels;
pub mod plot;
mod recorder;
mod results;
mod vtu;

pub use checkpoint::{Checkpoint, ResumeError};
pub(crate) use directory::drawing;
pub use directory::{Directory, OutputError};
pub use history::{COLUMNS, DYNAMIC_COLUMNS, HistoryRow, STATIC_COLUMNS, csv};
pub use recorder::{RecordError, Recorder, Setting};
pub(crate) use results::is_complete;
pub use results::{
    Ending, FinalState, MotionResult, NodeResult, ReactionResult, Results, Statistics,
};
pub use vtu::{VtuFrame, collection, grid};
