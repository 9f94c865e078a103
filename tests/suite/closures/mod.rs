//! Loops closed by multipliers and penalties.

mod alike;
mod allocation;
mod forces;
mod gallery;
mod program;
mod runs;
mod start;
mod units;
