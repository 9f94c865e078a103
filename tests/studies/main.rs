//! Computations of minutes that the suite makes small ones of: `cargo test --release --test studies`.

mod arms;
mod formulations;

mod support {
    #[path = "../../suite/support/formulations.rs"]
    pub mod formulations;
    #[path = "../../suite/support/independent.rs"]
    pub mod independent;
    #[path = "../../suite/support/program.rs"]
    pub mod program;
}
