//! All integration tests of charts and maps, linked once.
#![allow(non_snake_case, reason = "symbols are those of the equations")]

mod check;
mod implicit;
mod maps;
mod rotations;
mod support;
