//! `pullback compare`: its files, its page, its refusals.

use crate::support::drawings::tagged;
use crate::support::program::*;
use pullback::studies::compare::FILES;
use pullback::studies::gallery::{self, MODELS};
use roxmltree::{Document, Node, ParsingOptions};
use std::path::Path;

/// The files that a comparison writes, sorted.
pub fn written() -> [String; FILES.len()] {
    let mut names = FILES.map(str::to_owned);
    names.sort();
    names
}

/// A page as a document.
fn document(page: &str) -> Document<'_> {
    let options = ParsingOptions {
        allow_dtd: true,
        ..Default::default()
    };
    Document::parse_with_options(page, options).unwrap()
}

const ASKED: &str = "--schemes newmark,ga:0.8 --steps 0.1,0.05,0.025 -q";

#[test]
fn it_writes_tables_figures_and_a_page_that_needs_no_other_file() {
    let directory = directory("program_compare");
    succeeded(&compare(&write(&directory, &example("pendulum")), ASKED));
    let out = directory.join("model.compare");
    assert_eq!(files(&out), written());

    let page = read(out.join("compare.html"));
    let document = document(&page);
    let all = || document.descendants();
    let count = |name: &str| all().filter(|n| n.tag_name().name() == name).count();
    for tag in ["script", "link", "img", "iframe", "object", "image", "use"] {
        assert_eq!(count(tag), 0, "{tag}");
    }
    let refers = |n: Node<'_, '_>| {
        let mut names = n.attributes().map(|a| a.name());
        names.any(|a| ["src", "href", "data", "onload", "onclick"].contains(&a))
    };
    assert!(!all().any(refers));
    assert!(!page.contains("url(") && !page.contains("@import"));
    assert_eq!(count("svg"), 4);
    let command = all().find(|n| n.attribute("class") == Some("command"));
    let texts = command.unwrap().descendants().filter_map(|n| n.text());
    let command: String = texts.collect();
    assert_says(&command, &["pullback compare ", ASKED]);

    for name in FILES.iter().filter(|name| name.ends_with(".svg")) {
        Document::parse(&read(out.join(name))).unwrap();
    }
    let csv = read(out.join("compare.csv"));
    let widths: Vec<usize> = csv.lines().map(|l| l.split(',').count()).collect();
    assert_eq!(widths, vec![widths[0]; 7]);
    let json = json(out.join("compare.json"));
    assert_eq!(json["complete"], true);
    let rows = json["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 6);
    // A line per run and common time, of three step sizes and two schemes, and the head.
    let drift = read(out.join("drift.csv"));
    let times = json["times"].as_u64().unwrap() as usize;
    assert_eq!(drift.lines().count(), 1 + 6 * (times + 1));
    assert!(drift.lines().all(|line| line.split(',').count() == 13));
    // What the tables say is the same.
    let heads: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    let column = heads.iter().position(|h| *h == "error_position").unwrap();
    for (row, line) in rows.iter().zip(csv.lines().skip(1)) {
        let cell: f64 = line.split(',').nth(column).unwrap().parse().unwrap();
        assert_eq!(row["error"]["position"].as_f64().unwrap(), cell);
    }
}

#[test]
fn what_lies_in_its_directory_and_is_not_its_own_stays() {
    let directory = directory("program_compare_again");
    let model = write(&directory, &example("pendulum"));
    let out = directory.join("results");
    std::fs::create_dir(&out).unwrap();
    for name in ["result.json", "history.csv", "compare.json", "drift.svg"] {
        std::fs::write(out.join(name), "{}").unwrap();
    }
    let asked = format!("{ASKED} --out results");
    // A refusal changes nothing.
    let refused = format!("{asked} --reference newmark:0.3025:0.6");
    ended(&compare(&model, &refused), 2);
    assert_eq!(read(out.join("drift.svg")), "{}");
    succeeded(&compare(&model, &asked));
    assert_eq!(read(out.join("result.json")), "{}");
    assert_eq!(read(out.join("history.csv")), "{}");
    assert_ne!(read(out.join("drift.svg")), "{}");
}

#[test]
fn several_models_make_one_page_and_a_directory_each() {
    let directory = directory("program_compare_several");
    for name in ["pendulum", "top"] {
        std::fs::write(directory.join(name).with_extension("toml"), example(name)).unwrap();
    }
    let out = directory.join("results");
    let asked = "--schemes newmark,bathe --steps 4x,2x --long 3 --out results";
    let pendulum = directory.join("pendulum.toml");
    let output = compare(&pendulum, &format!("top.toml {asked}"));
    succeeded(&output);
    // Two steps make no order, and the terminal says so.
    let text = String::from_utf8_lossy(&output.stdout);
    assert_says(&text, &["? (2)", "? no order"]);
    assert_eq!(files(&out), ["compare.html", "pendulum", "top"]);
    let page = read(out.join("compare.html"));
    assert_eq!(tagged(&document(&page), "h1").count(), 3);
    for (model, own_step) in [("pendulum", 0.01), ("top", 0.00025)] {
        assert_eq!(files(&out.join(model)), written(), "{model}");
        let json = json(out.join(model).join("compare.json"));
        let [first, long] = [&json["rows"][0], &json["long"][0]];
        assert_eq!(first["requested_step"], 4.0 * own_step, "{model}");
        let end = |row: &serde_json::Value| {
            row["step"].as_f64().unwrap() * row["counts"]["steps"].as_f64().unwrap()
        };
        assert!(end(long) >= 3.0 * end(first) - 1e-9, "{model}");
        assert!(long["drift"]["trend"].as_f64().is_some(), "{model}");
    }
    let refused = compare(&pendulum, &format!("pendulum.toml {asked}"));
    assert_says(&ended(&refused, 2), &["called `pendulum`"]);
}

#[test]
fn refusals_name_what_is_wrong() {
    let directory = directory("program_compare_refusals");
    write(&directory, &example("pendulum"));
    check_lines(
        &directory,
        "compare model.toml",
        "
--schemes newmark,leapfog --steps 0.1,0.05 | leapfog
--schemes newmark,newmark --steps 0.1,0.05 | `newmark` is given twice
--schemes diffsol-euler --steps 0.1,0.05 | diffsol-bdf and diffsol-esdirk
--schemes hht:-0.5 --steps 0.1,0.05 | alpha of HHT = -0.5
--schemes lie-bathe --steps 0.1,0.05 | newmark, hht, wbz, ga, projected-newmark, central-difference
--schemes newmark --steps 0.05,0.1 | 0.1 comes after 0.05
--schemes newmark --steps 0.1,0.1 | 0.1 comes after 0.1
--schemes newmark --steps 0.1,0.0999999999 | both come to
--schemes newmark --steps -0.1,0.05 | step size -0.1
--schemes newmark --steps 0.1,0 | step size 0 is not usable
--schemes newmark --steps inf,0.05 | step size inf
--schemes newmark --steps 0.1,1e-12 | 1e-12 makes more than 1e8 steps
--schemes newmark --steps NaN,0.05 | step size NaN
--schemes newmark --steps 11,0.05 | 11 is larger than the duration 10
--schemes newmark --steps 0.1 | two step sizes at least, 1 given
--schemes newmark --steps 0.1,x | x
--schemes newmark --steps 0.1,0.05s | '0.05s' | such as 0.01, or a multiple
--schemes newmark --steps 10,0.05 | step size 10 makes one step
--schemes newmark --steps 0.1,0.05 --threads 0 | 1 or more
--schemes newmark --steps 0.1,0.05 --reference lie-ga:0.8 | without the prefix
--schemes newmark --steps 0.1,0.05 --reference diffsol-bdf | `diffsol-bdf`
--schemes newmark --steps 0.1,0.05 --reference newmark:0.3025:0.6 | `newmark:0.3025:0.6` cannot be the reference
--schemes newmark --steps 0.1,0.05 --reference central-difference | `central-difference` cannot be the reference
--schemes newmark --steps 0.1,0.05 --reference gaa | no scheme has this name
--schemes newmark --steps 0.1,0.05 --residual 1e-30 | below the rounding of forces, 2.2e-16
",
    );
    // A name that is neither a file nor a model has the nearest one beside it.
    let said = ended(&compare(&directory.join("pendulm"), ASKED), 2);
    let all = ["no file `pendulm`", "did you mean `pendulum`?", "heavy_top"];
    assert_says(&said, &all);
    let statics = write(&directory, &example("cantilever"));
    let said = ended(&compare(&statics, ASKED), 2);
    let still = "model.toml: the analysis of this model is not dynamic";
    assert_says(&said, &[still]);
    assert_eq!(files(&directory), ["model.toml"]);
}

#[test]
fn models_of_the_gallery_need_no_file() {
    // As `pullback gallery` names its cases, too.
    let [case, model] = ["heavy-top", "heavy_top"].map(|name| gallery::model(Path::new(name)));
    assert!(case.is_some() && case == model);
    let listed = files(&repository("examples/models"));
    let known: Vec<String> = MODELS
        .iter()
        .map(|(name, _)| format!("{name}.toml"))
        .collect();
    assert_eq!(known, listed);
    let directory = directory("program_compare_built_in");
    let asked = "compare pendulum --schemes newmark --steps 0.1,0.05 -q";
    printed(&directory, asked);
    assert_eq!(files(&directory.join("pendulum.compare")), written());
    // A directory of results does not hide the model whose name it has.
    for _ in 0..2 {
        printed(&directory, &format!("{asked} --out pendulum"));
    }
    assert_eq!(files(&directory.join("pendulum")), written());
}

/// A formulation that a model does not take makes rows with the reason, as whatever else fails.
#[test]
fn formulations_that_a_model_does_not_take_are_rows() {
    let directory = directory("program_compare_formulations");
    let model = write(&directory, &example("pendulum"));
    let asked = "--schemes newmark,hht:-0.1,ga:0.8,lie-ga:0.8 --steps 0.1,0.05 --charts";
    let output = compare(&model, asked);
    let said = succeeded(&output);
    let once = "lie-ga:0.8 cannot begin: ";
    assert_eq!(said.matches(once).count(), 1, "{said}");
    let table = read(directory.join("model.compare/compare.csv"));
    let rows: Vec<&str> = table.lines().skip(1).collect();
    let complete = rows[..6].iter().all(|row| row.contains(",complete,"));
    assert!(complete, "{table}");
    for row in &rows[6..8] {
        assert!(row.starts_with("compared,lie-ga:0.8,"), "{row}");
        assert_says(row, &["without the prefix"]);
    }
    // It is said once, and what never began stands in no other table, legend or caption with a time.
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(said.matches("lie-ga:0.8: ").count(), 1, "{said}");
    let page = read(directory.join("model.compare/compare.md"));
    let own = |line: &&str| line.starts_with("| lie-ga:0.8 |");
    let lines: Vec<&str> = page.lines().filter(own).collect();
    assert_eq!(lines.len(), 2, "{lines:?}");
    assert!(lines[1].starts_with("| lie-ga:0.8 | all | "), "{lines:?}");
    let none = "lie-ga:0.8 (no run came to its end)";
    assert_says(&page, &[none, "No run changes a chart"]);
    assert!(!page.contains("after t =") && !page.contains("0.00e0"));
    let legends = read(directory.join("model.compare/drift.svg"));
    assert!(legends.contains("ga:0.8") && !legends.contains("lie-ga:0.8"));
}

#[test]
fn schemes_that_cannot_begin_are_refused_before_anything_runs_if_none_can() {
    let directory = directory("program_compare_undamped");
    let undamped = "name = \"C\" => &\\nclosure = \"multipliers\"\nto = 4 => to = 0.02";
    let model = write(&directory, &changed(&example("four_bar"), undamped));
    let steps = "--steps 0.01,0.005 -q --schemes newmark";
    let said = ended(&compare(&model, &format!("{steps},hht:0")), 2);
    let none = "model.toml: no scheme can begin this motion; newmark: ";
    assert_says(&said, &[none]);
    assert_eq!(files(&directory), ["model.toml"]);
    // Where one can, the others are rows with the reason.
    succeeded(&compare(&model, &format!("{steps},ga:0.8")));
    let table = read(directory.join("model.compare/compare.csv"));
    let failed = |row: &&str| row.starts_with("compared,newmark") && row.contains("multiplier");
    assert_eq!(table.lines().filter(failed).count(), 2, "{table}");
}
