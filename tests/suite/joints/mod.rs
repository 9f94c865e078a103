//! Joints, what drives them and what they drive.

mod driven;
mod gears;
mod limits;
mod motions;
