//! All integration tests of the program and its library, linked once.
#![allow(non_snake_case, reason = "symbols are those of the equations")]

mod closures;
mod compare;
mod dynamics;
mod formulations;
mod independent;
mod joints;
mod linearization;
mod loops;
mod pages;
mod program;
mod refusals;
mod slides;
mod statics;
mod support;
