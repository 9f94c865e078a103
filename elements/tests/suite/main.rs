//! All integration tests of elements and models, linked once.
#![allow(non_snake_case, reason = "symbols are those of the equations")]

mod check;
mod leaves;
mod model;
mod support;
