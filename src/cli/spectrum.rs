//! `pullback spectrum`.

use super::{Exit, print, refuse};
use crate::studies::spectrum;
use crate::terminal::tell;
use std::path::PathBuf;

/// Ω of the files unless others are named.
const FROM: f64 = 0.01;
const TO: f64 = 1000.0;

/// Arguments of `pullback spectrum`.
#[derive(clap::Args)]
pub(super) struct SpectrumArguments {
    /// Schemes, such as newmark, hht:-0.1, ga:0.8; an unknown name lists all of them.
    #[arg(long, value_delimiter = ',', default_value = spectrum::SCHEMES)]
    schemes: Vec<String>,
    /// Smallest Ω of the files written with --out; the table has fixed values of Ω.
    #[arg(long, default_value_t = FROM, allow_hyphen_values = true)]
    from: f64,
    /// Largest Ω of the files.
    #[arg(long, default_value_t = TO, allow_hyphen_values = true)]
    to: f64,
    /// Directory of the files.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Prints the table and writes the files; returns the exit code.
pub(super) fn spectrum(args: SpectrumArguments, command: &str) -> Exit {
    let range = [args.from, args.to];
    let all = spectrum::all(&args.schemes, range).map_err(refuse)?;
    let table = spectrum::table(&all).map_err(refuse)?;
    if let Some(directory) = &args.out {
        spectrum::write(&all, Some(command), directory).map_err(refuse)?;
    } else if range != [FROM, TO] {
        tell(
            "note: --from and --to apply to the files written with --out; the table has fixed values of Ω",
        );
    }
    Ok(print(&table))
}
