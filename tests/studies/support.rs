//! Set-up that the suite has too.

#[path = "../suite/support/formulations.rs"]
pub mod formulations;
#[path = "../suite/support/independent.rs"]
pub mod independent;
#[path = "../suite/support/program.rs"]
pub mod program;
