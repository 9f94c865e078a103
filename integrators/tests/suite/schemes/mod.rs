//! Schemes: tables, spectra, what they claim.

mod conformance;
mod spectrum;
mod tables;
