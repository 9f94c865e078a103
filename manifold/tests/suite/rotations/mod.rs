//! Rotation vectors and their tensors.

mod properties;
mod quotients;
mod so3;
mod spin;
