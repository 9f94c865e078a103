//! Slides along chains, and their landings.

mod landings;
mod landings_flexible;
mod landings_many;
mod program;
