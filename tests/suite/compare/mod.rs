//! Comparisons and spectra of schemes.

mod cells;
mod charts;
mod laboratory;
mod library;
mod loops;
mod program;
mod program_more;
mod schemes;
mod spectrum;
