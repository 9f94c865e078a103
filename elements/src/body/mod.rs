//! Bodies: mass attached to a frame node (\[M04\] chapter 3, without the integral).

mod point_mass;
mod rigid;

pub use point_mass::PointMass;
pub use rigid::RigidBody;
