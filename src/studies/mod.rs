//! Studies of methods: cases with known results, schemes side by side, spectra of schemes.

pub mod compare;
pub mod gallery;
pub mod general;
pub mod spectrum;
pub mod sweep;
