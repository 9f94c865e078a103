//! The laws of maps, of charts and of implicit constraints.

mod chart;
mod finite;
mod implicit;
mod kinematics;
mod map;
mod pieces;

pub use chart::chart;
pub use implicit::{implicit, rewriting};
pub use kinematics::{Mapped, kinematics, motion};
pub(crate) use map::{TIME, laws_behind_slices, plain, saved, short_name, within};
pub use map::{map, parametrization};
pub(crate) use pieces::freeze_piece;
pub use pieces::pieces;
