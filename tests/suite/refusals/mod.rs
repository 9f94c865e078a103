//! What is refused or hinted at, and in which words.

mod file;
mod hints;
mod model;
mod motion;
mod registry;
mod statics;
