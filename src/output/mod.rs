//! What a run writes: history, results, figures, ParaView files.
//!
//! Files are written under temporary names and renamed when they are whole; the log of a checkpoint
//! grows instead, and what of it counts stands in the checkpoint.

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
pub use directory::{Directory, OutputError};
pub use history::{COLUMNS, DYNAMIC_COLUMNS, Row, STATIC_COLUMNS, csv};
pub use recorder::{RecordError, Recorder, Setting};
pub(crate) use results::is_complete;
pub use results::{
    Ending, FinalState, MotionResult, NodeResult, ReactionResult, Results, Statistics,
};
pub use vtu::{Frame, collection, grid};
