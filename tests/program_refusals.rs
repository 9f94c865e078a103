//! Every mistake in a model file is refused with its place and with what would be right.
#![allow(clippy::unwrap_used)]

mod program_support;

use program_support::{MODEL, directory, with};
use pullback::input::{InputError, assemble_text, load};

/// The refusal of a text.
fn refusal(text: &str) -> InputError {
    match assemble_text("model.toml", text) {
        Ok(_) => panic!("this was accepted:\n{text}"),
        Err(error) => error,
    }
}

/// Refuses `text` with a message, advice, and a place whose text begins with `place`.
#[track_caller]
fn check(text: &str, place: &str, message: &str, advice: &str) {
    let error = refusal(text);
    let said = error.to_string();
    assert!(said.contains(message), "message {said:?} lacks {message:?}");
    let help = error.problem.advice().unwrap_or_default();
    assert!(help.contains(advice), "advice {help:?} lacks {advice:?}");
    let span = error.span.clone().expect("a place");
    assert!(
        text[span.clone()].starts_with(place),
        "{said}: place {:?} instead of {place:?}",
        &text[span.start..(span.end + 20).min(text.len())]
    );
    let (line, column) = error.line_column().unwrap();
    let before = &text[..span.start];
    assert_eq!(line, before.lines().count().max(1) + usize::from(before.ends_with('\n')));
    let start = before.rfind('\n').map_or(0, |k| k + 1);
    assert_eq!(column, before[start..].chars().count() + 1);
}

#[test]
fn the_model_itself_is_accepted() {
    assert!(assemble_text("model.toml", MODEL).is_ok());
}

#[test]
fn unknown_keys_and_words_get_a_suggestion() {
    check(
        &with("elements = 8", "elemnets = 8"),
        "elemnets",
        "unknown key or word `elemnets`",
        "did you mean `elements`?",
    );
    check(&with("[nodes]", "[nods]"), "nods", "`nods`", "did you mean `nodes`?");
    check(&with("EA = 1e6", "AE = 1e6"), "AE", "`AE`", "did you mean `EA`?");
    check(&with("\"displacement\"", "\"displacment\""), "\"displacment\"", "`displacment`", "did you mean `displacement`?");
    check(&with("[analysis.static]", "[analysis.sttic]"), "sttic", "`sttic`", "`static`, `arc-length`");
    check(&with("steps = 4", "stepps = 4"), "stepps", "`stepps`", "`steps`");
}

#[test]
fn wrong_forms_are_refused_where_they_stand() {
    check(&with("A = [0, 0, 0]", "A = [0, 0]"), "[0, 0]", "array of length 3", "");
    check(&with("B = [1, 0, 0]", "B = [1, 0, 0, 0]"), "[1, 0, 0, 0]", "length 3", "");
    check(&with("GA = [1e6, 1e6]", "GA = 1e6"), "1e6", "array of length 2", "");
    check(&with("elements = 8", "elements = \"8\""), "\"8\"", "expected usize", "");
    check(&with("elements = 8", "elements = -8"), "-8", "-8", "");
    check(&with("fix = \"all\"", "fix = \"al\""), "\"al\"", "expected \"all\", \"place\", \"rotation\"", "");
    check(&with("fix = \"all\"", "fix = [\"x\", \"q\"]"), "[\"x\", \"q\"]", "expected \"all\"", "");
    check(&with("title = ", "title "), "\"Quarter", "expected", "");
    check(&with("B = [1, 0, 0]", "A = [1, 0, 0]"), "A", "duplicate key", "");
    check(&with("section = \"main\"\n", ""), "[[lines]]", "missing field `section`", "");
}

#[test]
fn unusable_numbers_are_refused() {
    check(&with("A = [0, 0, 0]", "A = [0, nan, 0]"), "nan", "the number nan", "finite");
    check(&with("EA = 1e6", "EA = inf"), "inf", "the number inf", "finite");
    check(&with("EA = 1e6", "EA = 1e400"), "1e400", "the number 1e400", "finite");
    check(&with("B = [1, 0, 0]", "B = [-1e200, 0, 0]"), "-1e200", "the number -1e200", "1e100");
}

#[test]
fn unknown_names_get_a_suggestion() {
    check(&with("to = \"B\"", "to = \"C\""), "\"C\"", "no node named \"C\"", "`A`, `B`");
    check(&with("section = \"main\"", "section = \"mian\""), "\"mian\"", "no section named \"mian\"", "did you mean `main`?");
    check(&with("node = \"A\"\nfix", "node = \"beam/8\"\nfix"), "\"beam/8\"", "no node named \"beam/8\"", "did you mean `beam/");
    check(&with("element = \"beam:4\"", "element = \"beam:9\""), "\"beam:9\"", "no element named \"beam:9\"", "`beam:8`");
    let loaded = with("node = \"B\"\nmoment", "line = \"bem\"\nforce_per_length");
    check(&loaded, "\"bem\"", "no line named \"bem\"", "did you mean `beam`?");
}

#[test]
fn names_must_be_usable_and_distinct() {
    let twice = MODEL.to_owned() + "\n[[lines]]\nname = \"beam\"\nfrom = \"A\"\nto = \"B\"\nelements = 1\nsection = \"main\"\n";
    check(&twice, "\"beam\"", "two lines named \"beam\"", "own name");
    let probe = MODEL.to_owned() + "\n[[probes]]\nname = \"tip\"\nnode = \"B\"\nquantity = \"position\"\n";
    check(&probe, "\"tip\"", "two probes named \"tip\"", "own name");
    check(&with("name = \"beam\"", "name = \"be/am\""), "\"be/am\"", "line name \"be/am\"", "must not contain");
    check(&with("[nodes]\n", "[nodes]\n\"beam/3\" = [0, 1, 0]\n"), "\"beam/3\"", "node name \"beam/3\"", "inner node");
}

#[test]
fn sections_must_make_sense() {
    check(&with("EA = 1e6", "EA = 0"), "{ EA = 0", "axial stiffness EA must be positive", "");
    check(&with("EI = [2.0, 2.0]", "EI = [2.0, -2.0]"), "{ EA", "bending stiffness EI3 must be positive", "");
    let main = "stiffness = { EA = 1e6, GA = [1e6, 1e6], GJ = 2.0, EI = [2.0, 2.0] }";
    check(&with(main, ""), "main", "must be given in one way, but has none", "exactly one of");
    check(&with(main, &format!("{main}\ncircle = {{ radius = 1 }}")), "main", "stiffness and circle", "exactly one of");
    check(&with(main, "circle = { radius = 1 }"), "{ radius", "a circle needs a material", "add material");
    let material = "material = { E = 1, nu = 0.3 }";
    check(&with(main, &format!("{main}\n{material}")), "material", "only a rectangle, circle or tube", "");
    check(&with(main, &format!("tube = {{ inner = 2, outer = 1 }}\n{material}")), "{ inner", "inner radius < outer radius", "");
    check(&with(main, "circle = { radius = 1 }\nmaterial = { E = 1, nu = 0.7 }"), "{ radius", "Poisson's ratio", "");
    let rows = |last: f64| format!("matrix = [[1,0,0,0,0,0],[0,1,0,0,0,0],[0,0,1,0,0,0],[0,0,0,1,0,0],[0,0,0,0,1,0],[{last:?},0,0,0,0,1]]");
    check(&with(main, &rows(0.5)), "[[1,0", "must be symmetric", "");
    check(&with(main, &format!("{main}\nmass = {{ A_rho = -1 }}")), "{ A_rho", "A_rho must not be negative", "");
}

#[test]
fn lines_must_have_length_and_direction() {
    check(&with("B = [1, 0, 0]", "B = [0, 0, 0]"), "[[lines]]", "line \"beam\" has zero length", "move one");
    check(&with("elements = 8", "elements = 0"), "0", "elements = 0 is out of range", "from 1");
    check(&with("elements = 8", "elements = 8\norder = 4"), "4", "order = 4", "1, 2 or 3");
    check(&with("elements = 8", "elements = 8\nsecond_axis = [2, 0, 0]"), "[2, 0, 0]", "second_axis", "");
    let arc = |text: &str| with("elements = 8", &format!("elements = 8\n{text}"));
    let turned = "arc = { center = [0.5, 0, 0], axis = [0, 0, 1], angle_deg = ";
    check(&arc(&format!("{turned}90 }}")), "[[lines]]", "its end is", "");
    check(&arc(&format!("{turned}0 }}")), "0", "angle_deg = 0", "not 0");
    check(&arc(&format!("{turned}180 }}\ntwist_deg = 10")), "10", "twist_deg is for straight lines", "");
    check(&arc("arc = { center = [0.5, 0, 0], axis = [0, 0, 0], angle_deg = 180 }"), "[0, 0, 0]", "axis [0.0, 0.0, 0.0] gives no direction", "");
    check(&arc("arc = { center = [0, 0, 2], axis = [0, 0, 1], angle_deg = 180 }"), "[0, 0, 2]", "center", "");
    assert!(assemble_text("", &arc(&format!("{turned}180 }}"))).is_ok());
}

#[test]
fn supports_must_hold_the_structure_once() {
    check(&with("[nodes]\n", "[nodes]\nC = [5, 5, 5]\n"), "C", "node C carries no element", "");
    check(&with("fix = \"all\"", "fix = \"place\""), "A", "rotation about", "");
    check(&with("fix = \"all\"", "fix = [\"y\", \"z\", \"rx\", \"ry\", \"rz\"]"), "A", "translation along (1", "");
    let free = with("[[supports]]\nnode = \"A\"\nfix = \"all\"\n", "");
    check(&free, "A", "is not supported", "");
    check(&with("fix = \"all\"", "fix = [\"x\", \"x\"]"), "[\"x\", \"x\"]", "coordinate x of node \"A\" is prescribed twice", "remove");
    let driven = with("fix = \"all\"", "fix = \"all\"\ndriven = { rz = { constant = 1 } }");
    check(&driven, "{ constant", "coordinate rz of node \"A\" is prescribed twice", "remove");
    check(&with("fix = \"all\"\n", ""), "\"A\"", "neither what to fix nor what to drive", "fix = \"all\"");
    check(&with("fix = \"all\"", "fix = []"), "\"A\"", "neither what to fix", "");
}

#[test]
fn loads_must_be_one_thing_on_the_right_thing() {
    let load = "node = \"B\"\nmoment = [0, 0, 3.141592653589793]";
    check(&with(load, "node = \"B\""), "[[loads]]", "this load has none", "exactly one of");
    check(&with(load, &format!("{load}\nforce = [1, 0, 0]")), "[[loads]]", "force and moment", "exactly one of");
    check(&with(load, "line = \"beam\"\nforce = [1, 0, 0]"), "[1, 0, 0]", "force, which acts on a node", "");
    check(&with(load, "node = \"B\"\nforce_per_length = [1, 0, 0]"), "[1, 0, 0]", "acts on a line", "");
    check(&with(load, "gravity = [0, 0, -9.81]"), "[0, 0, -9.81]", "section \"main\" has no mass", "A_rho");
    check(&with(load, &format!("{load}\ntime = {{ table = [[1, 0], [1, 2]] }}")), "{ table", "times must increase strictly", "");
    check(&with(load, &format!("{load}\ntime = {{ table = [] }}")), "{ table", "at least one point", "");
    check(&with(load, &format!("{load}\ntime = {{ rmp = {{ end = 1 }} }}")), "rmp", "`rmp`", "did you mean `ramp`?");
}

#[test]
fn analyses_must_be_possible() {
    check(&with("steps = 4", "to = 0"), "0", "to = 0", "differs from");
    check(&with("steps = 4", "steps = 0"), "0", "steps = 0", "positive");
    check(&with("steps = 4", "steps = 4\nmax_step = 1"), "max_step", "contradicts", "");
    check(&with("steps = 4", "first_step = -0.1"), "-0.1", "first_step = -0.1", "positive");
    check(&with("steps = 4", "first_step = 0.5\nmax_step = 0.1"), "0.5", "first_step = 0.5", "not larger");
    check(&with("steps = 4", "newton = { relative = 0 }"), "0", "relative = 0", "positive");
    let path = |text: &str| with("[analysis.static]\nsteps = 4", &format!("[analysis.arc-length]\n{text}"));
    check(&path("stop = []"), "[]", "stop = 0", "at least one");
    check(&path("max_steps = 0"), "0", "max_steps = 0", "positive");
    let stop = |node: &str| path(&format!("stop = [{{ coordinate = {{ node = \"{node}\", dof = \"x\", value = 1 }} }}]"));
    check(&stop("A"), "{ coordinate", "coordinate x of node \"A\" is prescribed", "free");
    check(&stop("Z"), "\"Z\"", "no node named \"Z\"", "`A`");
}

#[test]
fn probes_must_be_answerable() {
    check(&with("quantity = \"displacement\"", "quantity = \"N\""), "\"N\"", "needs an element", "");
    check(&with("quantity = \"displacement\"", "quantity = \"strain_energy\""), "\"strain_energy\"", "needs neither", "");
    check(&with("component = \"3\"", "component = \"z\""), "\"z\"", "component \"z\" does not exist for M", "\"1\", \"2\", \"3\"");
    check(&with("node = \"A\"\nquantity", "node = \"B\"\nquantity"), "\"B\"", "no support, so it has no reaction", "");
}

#[test]
fn empty_files_and_files_without_a_structure() {
    for text in ["", "\n\n", "# nothing but a comment\n"] {
        assert_eq!(refusal(text).to_string(), "the model file is empty");
    }
    assert_eq!(refusal("title = \"a\"").to_string(), "the model has no nodes");
    assert_eq!(refusal("[nodes]\nA = [0, 0, 0]").to_string(), "the model has no lines");
}

#[test]
fn files_that_cannot_be_read() {
    let directory = directory("program_refusals");
    let missing = directory.join("missing.toml");
    let said = load(&missing).err().unwrap().to_string();
    assert!(said.contains("cannot read") && said.contains("missing.toml"), "{said}");
    assert!(load(&directory).is_err(), "a directory is no model file");
    let latin = directory.join("latin.toml");
    std::fs::write(&latin, b"# one\ntitle = \"\xe4\"\n").unwrap();
    let said = load(&latin).err().unwrap().to_string();
    assert!(said.contains("not UTF-8") && said.contains("line 2") && said.contains("byte 15"), "{said}");
}

#[test]
fn mutilated_files_never_panic() {
    // Every prefix, and every line left out or repeated: refused or accepted, but answered.
    for end in (0..MODEL.len()).filter(|&k| MODEL.is_char_boundary(k)) {
        let _ = assemble_text("", &MODEL[..end]);
    }
    let lines: Vec<&str> = MODEL.lines().collect();
    for k in 0..lines.len() {
        let without = [&lines[..k], &lines[k + 1..]].concat().join("\n");
        let _ = assemble_text("", &without);
        let twice = [&lines[..=k], &lines[k..]].concat().join("\n");
        let _ = assemble_text("", &twice);
    }
    // Every number replaced by an extreme one.
    for extreme in ["1e100", "-1e100", "1e-300", "0", "-1", "9223372036854775807"] {
        for (k, _) in MODEL.match_indices(|c: char| c.is_ascii_digit()) {
            let text = format!("{}{extreme}{}", &MODEL[..k], &MODEL[k + 1..]);
            let _ = assemble_text("", &text);
        }
    }
}
