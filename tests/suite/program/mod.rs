//! The program: runs, files, resumption, checks.

mod balance;
mod check;
mod dynamic;
mod gallery_command;
mod incomplete;
mod mutations;
mod probes;
mod resume;
mod run;
mod schema;
mod shapes;
mod weight;
