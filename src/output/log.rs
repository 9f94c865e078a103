//! `checkpoint.log`: the rows up to a checkpoint, one JSON line each. It is only appended to, so that the cost
//! of a checkpoint does not depend on the number of rows.

use super::history::HistoryRow;
use super::vtu::VtuFrame;
use serde::{Deserialize, Serialize};

/// Name of the file.
pub(super) const NAME: &str = "checkpoint.log";

/// The part of the file that belongs to a checkpoint. A killed program may have written more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Extent {
    pub rows: usize,
    /// Those of them that have a grid.
    pub frames: usize,
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

/// The lines of rows, some of which have a grid: `frames` in the same order; `name` is that of the
/// grid that the k-th of the rows would have.
pub(super) fn lines(
    rows: &[HistoryRow],
    frames: &[VtuFrame],
    name: impl Fn(usize) -> String,
) -> Result<String, serde_json::Error> {
    let mut out = String::new();
    let mut frames = frames.iter().map(|f| f.file.as_str()).peekable();
    for (k, row) in rows.iter().enumerate() {
        let grid = frames.next_if_eq(&name(k).as_str());
        out += &serde_json::to_string(&(row, grid))?;
        out += "\n";
    }
    Ok(out)
}

/// Parses lines.
pub(super) fn read(lines: &[u8]) -> Result<(Vec<HistoryRow>, Vec<VtuFrame>), serde_json::Error> {
    let (mut rows, mut frames) = (Vec::new(), Vec::new());
    for line in serde_json::Deserializer::from_slice(lines).into_iter() {
        let (row, grid): (HistoryRow, Option<String>) = line?;
        frames.extend(grid.map(|file| VtuFrame { t: row.t, file }));
        rows.push(row);
    }
    Ok((rows, frames))
}
