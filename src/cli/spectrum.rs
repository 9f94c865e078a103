//! `pullback spectrum`.

use super::{REFUSED, print};
use crate::studies::spectrum::{self, SpectrumError};
use crate::terminal::tell;
use std::path::PathBuf;

/// Ω of the files unless others are named.
const FROM: f64 = 0.01;
const TO: f64 = 1000.0;

/// What a command line asks of spectra.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Schemes by their words, such as newmark, hht:-0.1, ga:0.8; an unknown word is answered by
    /// all there are.
    #[arg(long, value_delimiter = ',', default_value = spectrum::SCHEMES)]
    schemes: Vec<String>,
    /// Smallest Ω of the files that --out asks for; the table has positions of its own.
    #[arg(long, default_value_t = FROM, allow_hyphen_values = true)]
    from: f64,
    /// Largest Ω of the files.
    #[arg(long, default_value_t = TO, allow_hyphen_values = true)]
    to: f64,
    /// Directory of the files.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Prints the table and writes the files; the exit code.
pub(super) fn spectrum(asked: Arguments, command: &str) -> u8 {
    let done = || -> Result<String, SpectrumError> {
        let all = spectrum::all(&asked.schemes, [asked.from, asked.to])?;
        let table = spectrum::table(&all)?;
        if let Some(directory) = &asked.out {
            spectrum::write(&all, Some(command), directory)?;
        }
        if asked.out.is_none() && [asked.from, asked.to] != [FROM, TO] {
            tell(
                "note: --from and --to are for files, which --out asks for; the table has positions of its own",
            );
        }
        Ok(table)
    };
    match done() {
        Ok(table) => print(&table),
        Err(error) => {
            tell(format_args!("error: {error}"));
            REFUSED
        }
    }
}
