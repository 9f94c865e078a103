//! Cases of the gallery, and independent computations of them.

mod andrews;
mod gallery;
mod misaligned_linear;
mod misaligned_shooting;
