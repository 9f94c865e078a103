//! Parts of a model that make no sense are refused with their position and with what would be right.
#![allow(clippy::unwrap_used)]

use crate::support::program::{check, with};
use pullback::input::assemble_text;

#[test]
fn sections_must_make_sense() {
    let main = "stiffness = { EA = 1e6, GA = [1e6, 1e6], GJ = 2.0, EI = [2.0, 2.0] }";
    for (old, new, position, message) in [
        ("EA = 1e6", "EA = 0", "0", "axial stiffness EA"),
        ("[1e6, 1e6]", "[-3.0, 1e6]", "-3.0", "shear stiffness GA2"),
        ("[1e6, 1e6]", "[1e6, -3.0]", "-3.0", "shear stiffness GA3"),
        ("GJ = 2.0", "GJ = -2", "-2", "torsional stiffness GJ"),
        (
            "EI = [2.0, 2.0]",
            "EI = [0.0, 2.0]",
            "0.0",
            "bending stiffness EI2",
        ),
        (
            "EI = [2.0, 2.0]",
            "EI = [2.0, -2.0]",
            "-2.0",
            "bending stiffness EI3",
        ),
    ] {
        let message = format!("{message} must be positive");
        check(&with(old, new), position, &message, "number above zero");
    }
    check(
        &with(main, ""),
        "main",
        "needs exactly one definition, but has none",
        "exactly one of",
    );
    check(
        &with(main, &format!("{main}\ncircle = {{ radius = 1 }}")),
        "main",
        "stiffness and circle",
        "exactly one of",
    );
    check(
        &with(main, "circle = { radius = 1 }"),
        "{ radius",
        "a circle needs a material",
        "add material",
    );
    let material = "material = { E = 1, nu = 0.3 }";
    check(
        &with(main, &format!("{main}\n{material}")),
        "material",
        "only a rectangle, circle or tube",
        "",
    );
    check(
        &with(
            main,
            &format!("tube = {{ inner = 2, outer = 1 }}\n{material}"),
        ),
        "{ inner",
        "inner radius < outer radius",
        "",
    );
    check(
        &with(
            main,
            "circle = { radius = 1 }\nmaterial = { E = 1, nu = 0.7 }",
        ),
        "0.7",
        "Poisson's ratio must lie in (-1, 0.5]",
        "",
    );
    let weak = "circle = { radius = 1 }\nmaterial = { E = -4, nu = 0.3 }";
    check(
        &with(main, weak),
        "-4",
        "Young's modulus E must be positive",
        "number above zero",
    );
    let rows = |last: &str| {
        let first = "[1,0,0,0,0,0],[0,1,0,0,0,0],[0,0,1,0,0,0],[0,0,0,1,0,0],[0,0,0,0,1,0]";
        with(main, &format!("matrix = [{first},{last}]"))
    };
    check(
        &rows("[0.5,0,0,0,0,1]"),
        "[[1,0",
        "must be symmetric, but entries (1, 6) and (6, 1)",
        "make the two entries equal",
    );
    check(
        &rows("[0,0,0,0,0,-7]"),
        "-7",
        "must be positive definite",
        "positive numbers on the diagonal",
    );
    check(
        &with(main, &format!("{main}\nmass = {{ A_rho = -1 }}")),
        "{ A_rho",
        "A_rho must not be negative",
        "",
    );
}

#[test]
fn lines_must_have_length_and_direction() {
    check(
        &with("B = [1, 0, 0]", "B = [0, 0, 0]"),
        "[[lines]]",
        "line \"beam\" has zero length",
        "move one",
    );
    check(
        &with("elements = 8", "elements = 0"),
        "0",
        "elements = 0 is out of range",
        "from 1",
    );
    check(
        &with("elements = 8", "elements = 8\norder = 4"),
        "4",
        "order = 4",
        "1, 2 or 3",
    );
    check(
        &with("elements = 8", "elements = 8\nsecond_axis = [2, 0, 0]"),
        "[2, 0, 0]",
        "second_axis",
        "",
    );
    let arc = |text: &str| with("elements = 8", &format!("elements = 8\n{text}"));
    let turned = "arc = { center = [0.5, 0, 0], axis = [0, 0, 1], angle_deg = ";
    check(
        &arc(&format!("{turned}90 }}")),
        "[[lines]]",
        "its end is",
        "",
    );
    check(
        &arc(&format!("{turned}0 }}")),
        "0",
        "angle_deg = 0",
        "not 0",
    );
    check(
        &arc(&format!("{turned}180 }}\ntwist_deg = 10")),
        "10",
        "twist_deg is for straight lines",
        "",
    );
    // Half a turn in each of the eight elements has no direction, and more looks like less.
    check(
        &arc("twist_deg = -1440"),
        "-1440",
        "twist_deg = -1440",
        "take more elements",
    );
    assert!(assemble_text("", &arc("twist_deg = 1439")).is_ok());
    check(
        &with("elements = 8", &format!("elements = 1\n{turned}180 }}")),
        "180",
        "angle_deg = 180",
        "take more elements",
    );
    check(
        &arc("arc = { center = [0.5, 0, 0], axis = [0, 0, 0], angle_deg = 180 }"),
        "[0, 0, 0]",
        "axis [0.0, 0.0, 0.0] gives no direction",
        "",
    );
    check(
        &arc("arc = { center = [0, 0, 2], axis = [0, 0, 1], angle_deg = 180 }"),
        "[0, 0, 2]",
        "center",
        "",
    );
    assert!(assemble_text("", &arc(&format!("{turned}180 }}"))).is_ok());
}

#[test]
fn supports_must_hold_the_structure_once() {
    check(
        &with("[nodes]\n", "[nodes]\nC = [5, 5, 5]\n"),
        "C",
        "node C carries no element (loads do not count); connect it or remove it",
        "",
    );
    // The library's message says itself what would be right.
    let fixed = "fix = \"all\"";
    for (text, motion) in [
        (with(fixed, "fix = \"position\""), "rotation about"),
        (
            with(fixed, "fix = [\"y\", \"z\", \"rx\", \"ry\", \"rz\"]"),
            "translation along (1",
        ),
        (
            with("[[supports]]\nnode = \"A\"\nfix = \"all\"\n", ""),
            "contains node A is not supported",
        ),
    ] {
        check(&text, "A", motion, "");
        check(&text, "A", "add supports that prevent this", "");
    }
    check(
        &with("fix = \"all\"", "fix = [\"x\", \"x\"]"),
        "[\"x\", \"x\"]",
        "coordinate x of node \"A\" is prescribed twice",
        "remove",
    );
    let driven = with(
        "fix = \"all\"",
        "fix = \"all\"\nprescribed = { rz = { constant = 1 } }",
    );
    check(
        &driven,
        "{ constant",
        "coordinate rz of node \"A\" is prescribed twice",
        "remove",
    );
    check(
        &with("fix = \"all\"\n", ""),
        "\"A\"",
        "has neither `fix` nor `prescribed`",
        "fix = \"all\"",
    );
    check(
        &with("fix = \"all\"", "fix = []"),
        "\"A\"",
        "has neither `fix`",
        "",
    );
}

#[test]
fn loads_must_be_one_thing_on_the_right_thing() {
    let load = "node = \"B\"\nmoment = [0, 0, 3.141592653589793]";
    check(
        &with(load, "node = \"B\""),
        "[[loads]]",
        "this load has none",
        "exactly one of",
    );
    check(
        &with(load, &format!("{load}\nforce = [1, 0, 0]")),
        "[[loads]]",
        "force and moment",
        "exactly one of",
    );
    check(
        &with(load, "line = \"beam\"\nforce = [1, 0, 0]"),
        "[1, 0, 0]",
        "force, which acts on a node",
        "",
    );
    check(
        &with(load, "node = \"B\"\nforce_per_length = [1, 0, 0]"),
        "[1, 0, 0]",
        "acts on a line",
        "",
    );
    check(
        &with(load, "gravity = [0, 0, -9.81]"),
        "[0, 0, -9.81]",
        "section \"main\" has no mass",
        "A_rho",
    );
    check(
        &with(
            load,
            &format!("{load}\ntime = {{ table = [[1, 0], [1, 2]] }}"),
        ),
        "{ table",
        "times must increase strictly",
        "",
    );
    check(
        &with(load, &format!("{load}\ntime = {{ table = [] }}")),
        "{ table",
        "at least one point",
        "",
    );
    check(
        &with(load, &format!("{load}\ntime = {{ rmp = {{ end = 1 }} }}")),
        "rmp",
        "`rmp`",
        "did you mean `ramp`?",
    );
}

#[test]
fn analyses_must_be_possible() {
    check(&with("steps = 4", "to = 0"), "0", "to = 0", "differs from");
    check(
        &with("steps = 4", "steps = 0"),
        "0",
        "steps = 0",
        "positive",
    );
    check(
        &with("steps = 4", "steps = 4\nmax_step = 1"),
        "max_step",
        "contradicts",
        "",
    );
    check(
        &with("steps = 4", "first_step = -0.1"),
        "-0.1",
        "first_step = -0.1",
        "positive",
    );
    check(
        &with("steps = 4", "first_step = 0.5\nmax_step = 0.1"),
        "0.5",
        "first_step = 0.5",
        "not larger",
    );
    check(
        &with("steps = 4", "newton = { relative = 0 }"),
        "0",
        "relative = 0",
        "positive",
    );
    let path = |text: &str| {
        with(
            "[analysis.static]\nsteps = 4",
            &format!("[analysis.arc_length]\n{text}"),
        )
    };
    check(&path("stop = []"), "[]", "stop = 0", "at least one");
    check(&path("max_steps = 0"), "0", "max_steps = 0", "positive");
    let stop = |node: &str| {
        path(&format!(
            "stop = [{{ coordinate = {{ node = \"{node}\", dof = \"x\", value = 1 }} }}]"
        ))
    };
    check(
        &stop("A"),
        "{ coordinate",
        "coordinate x of node \"A\" is prescribed",
        "free",
    );
    check(&stop("Z"), "\"Z\"", "no node named \"Z\"", "`A`");
}

#[test]
fn probes_must_be_answerable() {
    check(
        &with("quantity = \"displacement\"", "quantity = \"N\""),
        "\"N\"",
        "needs an element",
        "",
    );
    check(
        &with(
            "quantity = \"displacement\"",
            "quantity = \"strain_energy\"",
        ),
        "\"strain_energy\"",
        "needs neither",
        "",
    );
    check(
        &with("component = \"3\"", "component = \"z\""),
        "\"z\"",
        "component \"z\" does not exist for M",
        "\"1\", \"2\", \"3\"",
    );
    check(
        &with("node = \"A\"\nquantity", "node = \"B\"\nquantity"),
        "\"B\"",
        "no support, so it has no reaction",
        "",
    );
}
