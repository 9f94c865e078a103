//! Set-up that several tests share.

pub mod dynamics;
pub mod linear_solver;
pub mod statics;
