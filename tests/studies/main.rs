//! Computations of minutes that the suite makes small ones of: `cargo test --release --test studies`.

mod arms;
mod formulations;
mod support;
