//! Elements, joints and loads on their own.

mod bodies;
mod elements;
mod energy;
mod energy_wrong;
mod integration;
mod interpolation;
mod joint_library;
mod line_loads;
mod reference;
mod refusals;
mod springs;
mod time_functions;
