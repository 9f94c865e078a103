//! The program: runs, files, resumption, checks.

mod balance;
mod check;
mod checkpoints;
mod dynamic;
mod figures;
mod gallery_command;
mod incomplete;
mod modes;
mod motion;
mod mutations;
mod probes;
mod progress;
mod resume;
mod run;
mod schema;
mod shapes;
mod shell;
mod sweep;
mod weight;
