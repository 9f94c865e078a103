//! Pages of the documentation against the sources they show.

mod adding_an_integrator;
mod included;
mod joint_pictures;
mod modes;
mod readme;
mod theory;
mod tutorial;
