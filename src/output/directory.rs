//! The directory of a run's results. Files are written as a whole or not at all, except the log of a
//! checkpoint, whose valid length is in the checkpoint.

use super::plot::PlotError;
use serde::Serialize;
use std::fs::{self, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Why results cannot be written.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
#[non_exhaustive]
pub enum OutputError {
    /// An error of the file system.
    #[error("cannot write {}: {source}", path.display())]
    Write { path: PathBuf, source: io::Error },
    /// The path for results is a file.
    #[error("cannot write results to {}: it is a file, and they take a directory", path.display())]
    File { path: PathBuf },
    /// Another process writes into the directory.
    #[error(
        "cannot write results to {}: process {process} is writing there; wait for it, or give another \
         directory (--out)",
        path.display()
    )]
    Busy {
        path: PathBuf,
        /// Its id.
        process: String,
    },
    /// A figure cannot be drawn.
    #[error("cannot draw {name}: {source}")]
    Draw { name: String, source: PlotError },
    /// A result cannot be serialised.
    #[error("cannot encode {name}: {source}")]
    Encode {
        name: String,
        source: serde_json::Error,
    },
}

/// A directory for results, claimed by one process while this value exists.
#[derive(Debug)]
pub(crate) struct Directory {
    path: PathBuf,
    files: Vec<String>,
    /// Locked, so that the claim ends with the process.
    _claim: fs::File,
}

/// Name of the file with the id of the process that writes into a directory.
const CLAIM: &str = ".lock";

impl Drop for Directory {
    fn drop(&mut self) {
        // Best effort: an old file without a lock is no claim.
        fs::remove_file(self.path.join(CLAIM)).ok();
    }
}

impl Directory {
    /// Opens a directory, creates it if needed, and removes the results of an earlier run
    /// (identified by its `result.json`): steps of two runs must not mix.
    pub fn open(path: &Path) -> Result<Self, OutputError> {
        Self::cleared(path, super::results::NAME, &is_result)
    }

    /// Opens a directory for files of these names, creates it if needed, and removes files of an earlier
    /// run (identified by the first name). Other files stay.
    pub fn open_for(path: &Path, names: &[&str]) -> Result<Self, OutputError> {
        let first = names.first().copied().unwrap_or_default();
        Self::cleared(path, first, &|name| names.contains(&name))
    }

    fn cleared(
        path: &Path,
        known_by: &str,
        ours: &dyn Fn(&str) -> bool,
    ) -> Result<Self, OutputError> {
        if path.is_file() {
            let path = path.to_owned();
            return Err(OutputError::File { path });
        }
        fs::create_dir_all(path).map_err(writing(path))?;
        let directory = Self::claimed(path)?;
        if path.join(known_by).is_file() {
            directory.remove(&|name| ours(name) || is_temporary(name, ours))?;
        }
        Ok(directory)
    }

    /// Opens the directory of a resumed run, and removes the ParaView files written after its checkpoint.
    pub fn reopen(path: &Path, kept: Vec<String>) -> Result<Self, OutputError> {
        let mut directory = Self::claimed(path)?;
        let later = |name: &str| is_grid(name) && kept.iter().all(|kept| kept != name);
        directory.remove(&|name| is_temporary(name, &is_result) || later(name))?;
        directory.files = kept;
        Ok(directory)
    }

    fn claimed(path: &Path) -> Result<Self, OutputError> {
        Ok(Self {
            path: path.to_owned(),
            files: Vec::new(),
            _claim: claim(path)?,
        })
    }

    /// Removes the files with unwanted names.
    fn remove(&self, unwanted: &dyn Fn(&str) -> bool) -> Result<(), OutputError> {
        let fail = || writing(&self.path);
        for entry in fs::read_dir(&self.path).map_err(fail())? {
            let entry = entry.map_err(fail())?;
            if entry.file_name().to_str().is_some_and(unwanted) {
                fs::remove_file(entry.path()).map_err(fail())?;
            }
        }
        Ok(())
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names of the files written so far, without repetitions.
    pub fn files(&self) -> &[String] {
        &self.files
    }

    /// Writes or replaces a file as a whole; after an error it is unchanged.
    pub fn write(
        &mut self,
        name: &str,
        content: &(impl AsRef<[u8]> + ?Sized),
    ) -> Result<(), OutputError> {
        let path = self.path.join(name);
        let temporary = self.path.join(format!(".{name}.{}", std::process::id()));
        let outcome = fs::File::create(&temporary)
            .and_then(|mut file| {
                file.write_all(content.as_ref())?;
                // Grids are numerous, and not needed to resume a run.
                if is_grid(name) {
                    Ok(())
                } else {
                    file.sync_data()
                }
            })
            .and_then(|()| fs::rename(&temporary, &path));
        if let Err(source) = outcome {
            // Best effort: the first failure is reported.
            fs::remove_file(&temporary).ok();
            return Err(OutputError::Write { path, source });
        }
        self.add(name);
        Ok(())
    }

    /// Writes or replaces a file of JSON.
    pub fn write_json(&mut self, name: &str, value: &impl Serialize) -> Result<(), OutputError> {
        let text = serde_json::to_string_pretty(value).map_err(encoding(name))?;
        self.write(name, &(text + "\n"))
    }

    /// Truncates a file after its first bytes and appends to it; after an error the first bytes are unchanged.
    /// Without first bytes the file is created or replaced.
    pub fn append(&mut self, name: &str, bytes: usize, content: &str) -> Result<(), OutputError> {
        let path = self.path.join(name);
        if bytes == 0 {
            // A link would be followed, and a pipe would block.
            fs::remove_file(&path).ok();
        }
        let mut options = fs::OpenOptions::new();
        options
            .write(true)
            .create_new(bytes == 0)
            .open(&path)
            .and_then(|mut file| {
                file.set_len(bytes as u64)?;
                file.seek(SeekFrom::End(0))?;
                file.write_all(content.as_bytes())?;
                file.sync_data()
            })
            .map_err(writing(&path))?;
        self.add(name);
        Ok(())
    }

    fn add(&mut self, name: &str) {
        if !self.files.iter().any(|f| f == name) {
            self.files.push(name.to_owned());
        }
    }
}

/// The error of a path that cannot be written.
fn writing(path: &Path) -> impl FnOnce(io::Error) -> OutputError {
    let path = path.to_owned();
    |source| OutputError::Write { path, source }
}

/// The error of a file that cannot be encoded.
pub(super) fn encoding(name: &str) -> impl FnOnce(serde_json::Error) -> OutputError {
    let name = name.to_owned();
    |source| OutputError::Encode { name, source }
}

/// The error of a figure that cannot be drawn.
pub(crate) fn drawing(name: &str) -> impl FnOnce(PlotError) -> OutputError {
    let name = name.to_owned();
    |source| OutputError::Draw { name, source }
}

/// Reads a file of results; links and pipes are refused.
pub(super) fn read(path: &Path) -> io::Result<Vec<u8>> {
    regular(path)?;
    fs::read(path)
}

/// Refuses a path that exists but is no regular file.
fn regular(path: &Path) -> io::Result<()> {
    match fs::symlink_metadata(path) {
        Ok(found) if !found.is_file() => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "it is a link, a pipe or a directory, where a file is needed",
        )),
        _ => Ok(()),
    }
}

/// Claims a directory for this process, until the file is closed.
fn claim(directory: &Path) -> Result<fs::File, OutputError> {
    let path = directory.join(CLAIM);
    let own = std::process::id().to_string();
    let fail = || writing(&path);
    loop {
        regular(&path).map_err(fail())?;
        let mut options = fs::OpenOptions::new();
        let options = options.write(true).create(true).truncate(false);
        let mut file = options.open(&path).map_err(fail())?;
        // The file system has no locks.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(OutputError::Busy {
                path: directory.to_owned(),
                process: fs::read_to_string(&path).unwrap_or_default(),
            });
        }
        file.set_len(0).map_err(fail())?;
        file.write_all(own.as_bytes()).map_err(fail())?;
        // The previous owner may have removed the file after it was opened here.
        if fs::read_to_string(&path).is_ok_and(|owner| owner == own) {
            return Ok(file);
        }
    }
}

/// Whether a file name is that of a grid.
pub(super) fn is_grid(name: &str) -> bool {
    let step = name
        .strip_prefix("step_")
        .and_then(|rest| rest.strip_suffix(".vtu"));
    step.is_some_and(|digits| digits.len() >= 4 && digits.bytes().all(|b| b.is_ascii_digit()))
}

/// Whether a file name is that of an unfinished file of a killed program.
fn is_temporary(name: &str, ours: &dyn Fn(&str) -> bool) -> bool {
    let inner = name.strip_prefix('.').and_then(|n| n.rsplit_once('.'));
    inner.is_some_and(|(name, id)| ours(name) && id.bytes().all(|b| b.is_ascii_digit()))
}

/// Whether a file name belongs to a run's results.
fn is_result(name: &str) -> bool {
    let (stem, kind) = name.rsplit_once('.').unwrap_or((name, ""));
    let figure = ["svg", "png", "pdf"].contains(&kind);
    let numbers = |text: &str| text.bytes().all(|b| b.is_ascii_digit() || b == b'_');
    let mode = stem.strip_prefix("mode_").is_some_and(numbers);
    is_grid(name)
        || mode && (figure || ["pvd", "vtu"].contains(&kind))
        || figure && ["campbell", "deformed", "history"].contains(&stem)
        || [
            super::results::NAME,
            super::checkpoint::NAME,
            super::log::NAME,
            "history.csv",
            "buckling.csv",
            "buckling.json",
            "campbell.csv",
            "campbell.json",
            "modes.csv",
            "modes.json",
            "steps.pvd",
            "deformed.html",
        ]
        .contains(&name)
}
