//! Motions: orders, energies, charts, allocation.

mod allocation;
mod contexts;
mod energy_momentum;
mod energy_momentum_limits;
mod kinks;
mod newton;
mod order;
mod tsitouras;
mod twist;
mod waves;
