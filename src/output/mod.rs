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
mod recording;
mod results;
mod vtu;

pub(crate) use checkpoint::Checkpoint;
pub use checkpoint::ResumeError;
pub use directory::OutputError;
pub(crate) use directory::{Directory, drawing};
pub(crate) use history::HistoryRow;
pub use history::{COLUMNS, DYNAMIC_COLUMNS, History, STATIC_COLUMNS};
pub use recorder::RecordError;
pub(crate) use recorder::{Recorder, Setting};
pub(crate) use recording::Recording;
pub use results::Ending;
pub(crate) use results::{PROGRAM, is_complete};
