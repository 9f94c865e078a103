//! `checkpoint.log`: the rows up to a checkpoint, one JSON line each. It is only appended to, so that the cost
//! of a checkpoint does not depend on the number of rows.

use super::history::HistoryRow;
use serde::{Deserialize, Serialize};

/// Name of the file.
pub(super) const NAME: &str = "checkpoint.log";

/// The part of the file that belongs to a checkpoint. A killed program may have written more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Extent {
    pub rows: usize,
    pub bytes: usize,
    /// Checksum of these bytes.
    pub crc32: u32,
}

impl Extent {
    /// The checksum with `lines` appended.
    pub(super) fn crc32_with(&self, lines: &str) -> u32 {
        let mut hasher = crc32fast::Hasher::new_with_initial(self.crc32);
        hasher.update(lines.as_bytes());
        hasher.finalize()
    }
}

/// The lines of rows.
pub(super) fn lines(rows: &[HistoryRow]) -> Result<String, serde_json::Error> {
    let lines = rows.iter().map(serde_json::to_string);
    lines.map(|line| Ok(line? + "\n")).collect()
}

/// Parses lines.
pub(super) fn read(lines: &[u8]) -> Result<Vec<HistoryRow>, serde_json::Error> {
    let rows = serde_json::Deserializer::from_slice(lines).into_iter();
    rows.collect()
}
