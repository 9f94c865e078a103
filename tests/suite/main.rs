//! All integration tests of the program and its library, linked once.

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
