//! The program `pullback`.

use pullback::input::Registry;
use std::process::ExitCode;

fn main() -> ExitCode {
    pullback::cli::main(&Registry::standard())
}
