//! `sweep.csv`, the rows of a sweep; one that was stopped goes on with the rows that it has.

use super::{Sweep, SweepRow};
use crate::output::{Directory, OutputError};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The sweep itself, by which its rows are recognised.
const SWEEP: &str = "sweep.json";
const ROWS: &str = "sweep.csv";
/// Time between two savings.
const SAVED: Duration = Duration::from_millis(500);

/// Why there is no table.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// It cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A row cannot be encoded.
    #[error("cannot encode a row of {ROWS}: {0}")]
    Row(#[from] csv::Error),
    /// The directory holds the rows of something else.
    #[error(
        "{} holds another sweep, of another model or other values: give another directory (--out), or \
         remove it",
        .0.display()
    )]
    Other(PathBuf),
}

/// The table of a sweep.
pub struct SweepTable {
    directory: Directory,
    names: Vec<String>,
    rows: Vec<SweepRow>,
    /// Length of the file, and rows in it.
    saved: (usize, usize),
    at: Instant,
}

impl SweepTable {
    /// Opens the table of a sweep with these columns of values in a directory, with the rows that it has already.
    ///
    /// # Errors
    /// [`TableError`].
    pub fn open(sweep: &Sweep, columns: &[String], path: &Path) -> Result<Self, TableError> {
        let parameters = sweep.axes.iter().map(|axis| axis.path.clone());
        let general = ["outcome", "t", "seconds"].map(str::to_owned);
        let names = ["run".to_owned()].into_iter().chain(parameters);
        let names = names.chain(general).chain(columns.to_vec());
        let names: Vec<String> = names.chain(["warnings".to_owned()]).collect();
        let own = serde_json::to_value(sweep).unwrap_or_default();
        let there = std::fs::read(path.join(SWEEP)).ok();
        let there = there.map(|text| serde_json::from_slice::<serde_json::Value>(&text).ok());
        let mut table = Self {
            directory: match there {
                None => Directory::open_for(path, &[SWEEP, ROWS])?,
                Some(there) if there.as_ref() == Some(&own) => Directory::reopen(path, Vec::new())?,
                Some(_) => return Err(TableError::Other(path.to_owned())),
            },
            names,
            rows: Vec::new(),
            saved: (0, 0),
            at: Instant::now(),
        };
        table.rows = table.read(sweep, &path.join(ROWS));
        table.directory.write_json(SWEEP, &own)?;
        table.write_all()?;
        Ok(table)
    }

    /// The complete rows of a file.
    fn read(&self, sweep: &Sweep, path: &Path) -> Vec<SweepRow> {
        let Ok(text) = std::fs::read(path) else {
            return Vec::new();
        };
        // The program may have been killed within a line.
        let whole = text.iter().rposition(|b| *b == b'\n').map_or(0, |k| k + 1);
        let mut reader = csv::Reader::from_reader(&text[..whole]);
        let named = reader.headers().is_ok_and(|names| names == self.names);
        let records = reader.into_records().filter(|_| named).flatten();
        let row = |record: csv::StringRecord| {
            let run = record
                .get(0)?
                .parse()
                .ok()
                .filter(|run| *run < sweep.runs())?;
            let (first, last) = (1 + sweep.axes.len(), record.len() - 1);
            let number = |k: usize| match record.get(k)? {
                "" => Some(f64::NAN),
                text => text.parse().ok(),
            };
            Some(SweepRow {
                run,
                parameters: sweep.parameters(run),
                outcome: record.get(first)?.to_owned(),
                t: number(first + 1)?,
                seconds: number(first + 2)?,
                values: (first + 3..last).map(number).collect::<Option<_>>()?,
                warnings: record.get(last)?.to_owned(),
            })
        };
        records.filter_map(row).collect()
    }

    /// The rows so far.
    pub fn rows(&self) -> &[SweepRow] {
        &self.rows
    }

    /// Adds a row.
    ///
    /// # Errors
    /// [`TableError`]; rows that have been saved stay.
    pub fn add(&mut self, row: SweepRow) -> Result<(), TableError> {
        self.rows.push(row);
        match self.at.elapsed() > SAVED {
            true => self.save(),
            false => Ok(()),
        }
    }

    /// Saves the rows.
    fn save(&mut self) -> Result<(), TableError> {
        let (bytes, count) = self.saved;
        let text = lines(None, &self.rows[count..])?;
        self.directory.append(ROWS, bytes, &text)?;
        self.saved = (bytes + text.len(), self.rows.len());
        self.at = Instant::now();
        Ok(())
    }

    /// Writes all rows in the order of the runs.
    ///
    /// # Errors
    /// [`TableError`]; rows that have been saved stay.
    pub fn finish(mut self) -> Result<Vec<SweepRow>, TableError> {
        self.save()?;
        self.rows.sort_by_key(|row| row.run);
        self.write_all()?;
        Ok(self.rows)
    }

    fn write_all(&mut self) -> Result<(), TableError> {
        let text = lines(Some(&self.names), &self.rows)?;
        self.directory.write(ROWS, &text)?;
        self.saved = (text.len(), self.rows.len());
        Ok(())
    }
}

/// Names of columns, if given, and rows as lines; numbers that are none are empty.
fn lines(names: Option<&Vec<String>>, rows: &[SweepRow]) -> Result<String, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    if let Some(names) = names {
        writer.write_record(names)?;
    }
    for row in rows {
        let number = |x: f64| match x.is_nan() {
            true => String::new(),
            false => format!("{x:?}"),
        };
        let own = [row.outcome.clone(), number(row.t), number(row.seconds)];
        let cells = [row.run.to_string()]
            .into_iter()
            .chain(row.parameters.iter().cloned());
        writer.write_record(
            cells
                .chain(own)
                .chain(row.values.iter().map(|x| number(*x)))
                .chain([row.warnings.clone()]),
        )?;
    }
    let text = writer
        .into_inner()
        .map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}
