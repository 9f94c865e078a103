//! Mistakes in a model file are refused with their position and with what would be right.

use crate::support::program::{MODEL, assert_says, check_table, directory, refusal, with};
use pullback::input::{assemble_text, load};

#[test]
fn words_of_earlier_versions_are_refused_with_those_of_today() {
    let hinge = "[[joints]]\nname = \"J\"\ntype = \"revolute\"\naxis = [0, 0, 1]\nparent = \"A\"\n";
    check_table(
        &with("[[supports]]", &format!("{hinge}[[supports]]")),
        refusal,
        r#"
parent = "A" => master = "A" | master | | `master` is now `parent`
 => &\ndriven = { constant = 1 } | driven | | `driven` is now `prescribed`
 => &\nmotor = { constant = 1 } | motor | | `motor` is now `actuator`
 => &\nactuator = { hat = { peak = 1, end = 2 } } | hat | | `hat` is now `triangle`
 => &\nprescribed = { run-up = { rate = 1, duration = 2 } } | run-up | | `run-up` is now `spin_up`
type = "revolute"\naxis = [0, 0, 1] => type = "offset"\nplace = [1, 0, 0] | place | | `place` is now `position`
 => type = "on_surface"\nposition = [1, 0, 0]\nsurface = { sphere = { centre = [0, 0, 0] } } | centre | | `centre` is now `center`
 => type = "on-curve" | "on-curve" | | `on-curve` is now `on_curve`
fix = "all" => fix = "place" | "place" | `place` is now `position`
[analysis.static] => [analysis.arc-length] | arc-length | | `arc-length` is now `arc_length`
"#,
    );
}

#[test]
fn mistakes_are_refused_where_they_stand() {
    check_table(
        MODEL,
        refusal,
        r#"
# Unknown keys and words.
section = "main" => Section = "main" | Section | `Section` | did you mean `section`?
elements = 8 => elemnets = 8 | elemnets | unknown key or word `elemnets` | did you mean `elements`?
[nodes] => [nods] | nods | `nods` | did you mean `nodes`?
EA = 1e6 => AE = 1e6 | AE | `AE` | did you mean `EA`?
"displacement" => "displacment" | "displacment" | `displacment` | did you mean `displacement`?
[analysis.static] => [analysis.sttic] | sttic | `sttic` | `static`, `arc_length`
steps = 4 => stepps = 4 | stepps | `stepps` | `steps`
# Wrong forms.
A = [0, 0, 0] => A = [0, 0] | [0, 0] | array of length 3 | [X, Y, Z]
B = [1, 0, 0] => B = [1, 0, 0, 0] | [1, 0, 0, 0] | length 3 | [X, Y, Z]
GA = [1e6, 1e6] => GA = 1e6 | 1e6 | floating point `1000000.0`, expected an array of length 2 | two numbers in brackets are expected, such as GA = [GA2, GA3]
 => GA = [1e6] | [1e6] | length 1, expected an array of length 2 | two numbers in brackets are expected, such as GA = [GA2, GA3]
 => GA = [1e6, 1e6, 1e6] | [1e6, 1e6, 1e6] | length 3, expected an array of length 2 | two numbers in brackets are expected, such as GA = [GA2, GA3]
stiffness = { EA = 1e6, GA = [1e6, 1e6], GJ = 2.0, EI = [2.0, 2.0] } => matrix = [[1, 0, 0, 0, 0, 0], [0, 1, 0]] | [0, 1, 0] | array of length 6 | six rows
elements = 8 => elements = "8" | "8" | expected a whole number | such as 8
 => elements = -8 | -8 | `-8`, expected a whole number that is not negative | such as 8
fix = "all" => fix = "al" | "al" | expected "all", "position", "rotation"
 => fix = ["x", "q"] | ["x", "q"] | expected "all"
title = " => title " | " | expected
B = [1, 0, 0] => A = [1, 0, 0] | A | duplicate key
section = "main"\n => | [[lines]] | missing field `section`
# Numbers that cannot be used.
A = [0, 0, 0] => A = [0, nan, 0] | nan | the number nan | finite
EA = 1e6 => EA = inf | inf | the number inf | finite
 => EA = 1e400 | 1e400 | the number 1e400 | finite
B = [1, 0, 0] => B = [-1e200, 0, 0] | -1e200 | the number -1e200 | 1e100
# Unknown names.
to = "B" => to = "C" | "C" | no node named "C" | `A`, `B`
section = "main" => section = "mian" | "mian" | no section named "mian" | did you mean `main`?
node = "A"\nfix => node = "beam/8"\nfix | "beam/8" | no node named "beam/8" | did you mean `beam/
element = "beam:4" => element = "beam:9" | "beam:9" | no element named "beam:9" | `beam:8`
node = "B"\nmoment => line = "bem"\nforce_per_length | "bem" | no line named "bem" | did you mean `beam`?
# Names that cannot be used, or are there twice.
component = "3" => &\n[[lines]]\nname = "beam"\nfrom = "A"\nto = "B"\nelements = 1\nsection = "main" | "beam" | two lines named "beam" | own name
 => &\n[[probes]]\nname = "tip"\nnode = "B"\nquantity = "position" | "tip" | two probes named "tip" | own name
name = "beam" => name = "be/am" | "be/am" | line name "be/am" | must not contain
[nodes] => &\n"beam/3" = [0, 1, 0] | "beam/3" | node name "beam/3" | inner node
"#,
    );
}

#[test]
fn empty_files_and_files_without_a_structure() {
    for (text, said) in [
        ("", "the model file is empty"),
        ("\n\n", "the model file is empty"),
        ("# nothing but a comment\n", "the model file is empty"),
        ("title = \"a\"", "the model has no nodes"),
        (
            "[nodes]\nA = [0, 0, 0]",
            "the model has no lines, bodies or springs",
        ),
    ] {
        assert_eq!(refusal(text).to_string(), said);
    }
}

#[test]
fn files_that_cannot_be_read() {
    let directory = directory("program_refusals");
    let missing = directory.join("missing.toml");
    let said = load(&missing).err().unwrap().to_string();
    assert_says(&said, &["cannot read", "missing.toml"]);
    assert!(load(&directory).is_err(), "a directory is no model file");
    let latin = directory.join("latin.toml");
    std::fs::write(&latin, b"# one\ntitle = \"\xe4\"\n").unwrap();
    let said = load(&latin).err().unwrap().to_string();
    assert_says(&said, &["not UTF-8", "line 2", "byte 15"]);
}

#[test]
fn what_is_like_no_key_gets_no_suggestion() {
    let refused = refusal(&with("elements = ", "colour = "));
    let help = refused.problem.advice().unwrap();
    let plain = help.starts_with("there are: ") && !help.contains("did you mean");
    assert!(plain, "{help}");
}

#[test]
fn functions_of_t_are_documented_as_they_are() {
    let reference = include_str!("../../../docs/model_file.md");
    let rows = reference.lines().filter_map(|l| l.strip_prefix("| `{ "));
    let functions: Vec<&str> = rows.filter_map(|l| l.split('`').next()).collect();
    assert_eq!(functions.len(), 9);
    let load = "moment = [0, 0, 3.141592653589793]";
    for function in functions {
        let text = with(load, &format!("{load}\ntime = {{ {function}"));
        let job = assemble_text("", &format!("{text}\n[inputs]\ntorque = 0.5\n"));
        assert!(job.is_ok(), "{function}: {:?}", job.err());
    }
}
