//! Equations that elements enforce, and starts that satisfy them.

mod assembly;
pub(super) mod enforced;
pub(super) mod omitted;
pub(super) mod redundant;
pub(super) mod start;
