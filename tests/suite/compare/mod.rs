//! Comparisons and spectra of schemes.

mod cells;
mod charts;
mod error_curves;
mod figures;
mod library;
mod loops;
mod program;
mod program_more;
mod runs;
mod schemes;
mod spectrum;
