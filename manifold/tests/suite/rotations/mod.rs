//! Rotation vectors and their tensors.

mod quotients;
mod so3;
mod spin;
