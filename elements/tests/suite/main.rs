//! All integration tests of elements and models, linked once.

mod check;
mod leaves;
mod model;
mod support;
