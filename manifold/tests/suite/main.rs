//! All integration tests of charts and maps, linked once.

mod check;
mod implicit;
mod maps;
mod rotations;
mod support;
