//! Joints, what drives them and what they drive.

mod curves;
mod driven;
mod drives;
mod gears;
mod limits;
mod motions;
