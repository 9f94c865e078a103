//! Parts of a model that make no sense are refused with their position and with what would be right.

use crate::support::program::{MODEL, check_table, refusal, with};
use pullback::input::assemble_text;

#[test]
fn parts_must_make_sense() {
    check_table(
        MODEL,
        refusal,
        r#"
# Sections.
EA = 1e6 => EA = 0 | 0 | axial stiffness EA must be positive | number above zero
[1e6, 1e6] => [-3.0, 1e6] | -3.0 | shear stiffness GA2 must be positive | number above zero
 => [1e6, -3.0] | -3.0 | shear stiffness GA3 must be positive | number above zero
GJ = 2.0 => GJ = -2 | -2 | torsional stiffness GJ must be positive | number above zero
EI = [2.0, 2.0] => EI = [0.0, 2.0] | 0.0 | bending stiffness EI2 must be positive | number above zero
 => EI = [2.0, -2.0] | -2.0 | bending stiffness EI3 must be positive | number above zero
stiffness = { EA = 1e6, GA = [1e6, 1e6], GJ = 2.0, EI = [2.0, 2.0] } => | main | needs exactly one definition, but has none | exactly one of
 => &\ncircle = { radius = 1 } | main | stiffness and circle | exactly one of
 => circle = { radius = 1 } | { radius | a circle needs a material | add material
 => &\nmaterial = { E = 1, nu = 0.3 } | material | only a rectangle, circle or tube
 => tube = { inner = 2, outer = 1 }\nmaterial = { E = 1, nu = 0.3 } | { inner | inner radius < outer radius
 => circle = { radius = 1 }\nmaterial = { E = 1, nu = 0.7 } | 0.7 | Poisson's ratio must lie in (-1, 0.5]
 => circle = { radius = 1 }\nmaterial = { E = -4, nu = 0.3 } | -4 | Young's modulus E must be positive | number above zero
 => matrix = [[1,0,0,0,0,0],[0,1,0,0,0,0],[0,0,1,0,0,0],[0,0,0,1,0,0],[0,0,0,0,1,0],[0.5,0,0,0,0,1]] | [[1,0 | must be symmetric, but entries (1, 6) and (6, 1) | make the two entries equal
 => matrix = [[1,0,0,0,0,0],[0,1,0,0,0,0],[0,0,1,0,0,0],[0,0,0,1,0,0],[0,0,0,0,1,0],[0,0,0,0,0,-7]] | -7 | must be positive definite | positive numbers on the diagonal
 => &\nmass = { A_rho = -1 } | -1 | the mass must be zero or positive
 => &\nmass = { A_rho = 1, J = [1, -1, 2] } | [1, -1, 2] | positive semidefinite
# Lines have a length and a direction: half a turn in each of the eight elements has none, and more looks like less.
B = [1, 0, 0] => B = [0, 0, 0] | [[lines]] | line "beam" has zero length | move one
elements = 8 => elements = 0 | 0 | elements = 0 is out of range | from 1
 => &\norder = 4 | 4 | order = 4 | 1, 2 or 3
 => &\nsecond_axis = [2, 0, 0] | [2, 0, 0] | second_axis
 => &\ntwist_deg = -1440 | -1440 | twist_deg = -1440 | take more elements
 => &\narc = { center = [0.5, 0, 0], axis = [0, 0, 1], angle_deg = 90 } | [[lines]] | its end is
 => &\narc = { center = [0.5, 0, 0], axis = [0, 0, 1], angle_deg = 0 } | 0 | angle_deg = 0 | not 0
 => &\narc = { center = [0.5, 0, 0], axis = [0, 0, 1], angle_deg = 180 }\ntwist_deg = 10 | 10 | twist_deg is for straight lines
 => elements = 1\narc = { center = [0.5, 0, 0], axis = [0, 0, 1], angle_deg = 180 } | 180 | angle_deg = 180 | take more elements
 => &\narc = { center = [0.5, 0, 0], axis = [0, 0, 0], angle_deg = 180 } | [0, 0, 0] | axis [0.0, 0.0, 0.0] gives no direction
 => &\narc = { center = [0, 0, 2], axis = [0, 0, 1], angle_deg = 180 } | [0, 0, 2] | center
# Supports hold the structure, and once; the library's message says itself what would be right.
[nodes] => &\nC = [5, 5, 5] | C | node C carries no element (loads do not count); connect it or remove it
 => [[joints]]\nname = "arm"\ntype = "offset"\nparent = "B"\nposition = [2, 0, 0]\n[[joints]]\nname = "arm 2"\ntype = "revolute"\nparent = "B"\naxis = [0, 0, 1]\n[nodes] | "arm 2" | node arm 2 angle carries no element
 => [[joints]]\nname = "pin"\ntype = "cylindrical"\nparent = "B"\naxis = [0, 0, 1]\nvalue = 1\n[nodes] | value | no use for value | `coordinates.displacement.value`
fix = "all" => fix = ["x", "x"] | ["x", "x"] | coordinate x of node "A" is prescribed twice | remove
 => &\nprescribed = { rz = { constant = 1 } } | { constant | coordinate rz of node "A" is prescribed twice | remove
 => | "A" | has neither `fix` nor `prescribed` | fix = "all"
 => fix = [] | "A" | has neither `fix`
# Loads are one thing on the right thing.
node = "B"\nmoment = [0, 0, 3.141592653589793] => node = "B" | [[loads]] | this load has none | exactly one of
 => &\nforce = [1, 0, 0] | [[loads]] | force and moment | exactly one of
 => line = "beam"\nforce = [1, 0, 0] | [1, 0, 0] | force, which acts on a node | force_per_length
 => node = "B"\nforce = -1 | -1 | | [Fx, Fy, Fz]
 => node = "B"\nforce_per_length = [1, 0, 0] | [1, 0, 0] | acts on a line
 => node = "B"\ngravity = [0, 0, 1] | [0, 0, 1] | acts on a line, or on all lines and bodies
 => gravity = [0, 0, -9.81] | [0, 0, -9.81] | section "main" has no mass | A_rho
 => &\ntime = { table = [[1, 0], [1, 2]] } | { table | times must increase strictly
 => &\ntime = { table = [] } | { table | at least one point
 => &\ntime = { linear = 1 } | linear | linear | did you mean `proportional`?
 => &\ntime = { rmp = { end = 1 } } | rmp | `rmp` | did you mean `ramp`?
# Analyses.
steps = 4 => to = 0 | 0 | to = 0 | differs from
 => steps = 0 | 0 | steps = 0 | positive
 => &\nmax_step = 1 | max_step | exclude each other
 => first_step = -0.1 | -0.1 | first_step = -0.1 | positive
 => first_step = 0.5\nmax_step = 0.1 | 0.5 | first_step = 0.5 | not larger
 => newton = { relative = 0 } | 0 | relative = 0 | positive
[analysis.static]\nsteps = 4 => [analysis.arc_length]\nstop = [] | [] | stop = 0 | at least one
 => [analysis.arc_length]\nmax_steps = 0 | 0 | max_steps = 0 | positive
 => [analysis.arc_length]\nstop = [{ coordinate = { node = "A", dof = "x", value = 1 } }] | { coordinate | coordinate x of node "A" is prescribed | free
 => [analysis.arc_length]\nstop = [{ coordinate = { node = "B", dof = "rz", value = 4 } }] | { coordinate | never reached | displacement
 => [analysis.arc_length]\nstop = [{ coordinate = { node = "Z", dof = "x", value = 1 } }] | "Z" | no node named "Z" | `A`
# Probes.
quantity = "displacement" => quantity = "N" | "N" | needs an element
 => quantity = "strain_energy" | "strain_energy" | needs neither
component = "3" => component = "z" | "z" | component "z" does not exist for M | "1", "2", "3"
node = "A"\nquantity => node = "B"\nquantity | "B" | no support, so it has no reaction
"#,
    );
}

#[test]
fn elements_of_a_line_may_turn_by_less_than_half_a_turn() {
    for fine in [
        "twist_deg = 1439",
        "arc = { center = [0.5, 0, 0], axis = [0, 0, 1], angle_deg = 180 }",
    ] {
        let text = with("elements = 8", &format!("elements = 8\n{fine}"));
        assert!(assemble_text("", &text).is_ok(), "{fine}");
    }
}
