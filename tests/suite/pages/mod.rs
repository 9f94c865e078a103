//! Pages of the documentation against the sources they show.

mod adding_a_joint;
mod adding_an_element;
mod adding_an_integrator;
mod included;
mod joint_pictures;
mod modes;
mod readme;
mod theory;
mod tutorial;
