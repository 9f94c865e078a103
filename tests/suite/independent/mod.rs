//! Cases of the gallery, and independent computations of them.

mod exact;
mod gallery;
mod misaligned_linear;
mod misaligned_shooting;
