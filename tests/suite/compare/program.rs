//! `pullback compare`: its files, its page, its refusals.
#![allow(clippy::unwrap_used)]

use crate::support::program::{
    assert_says, check_lines, compare, directory, ended, files, program_in, read, succeeded,
};
use pullback::studies::compare::FILES;
use pullback::studies::gallery::{self, MODELS};
use std::path::{Path, PathBuf};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// The files that a comparison writes, sorted.
fn written() -> [String; FILES.len()] {
    let mut names = FILES.map(str::to_owned);
    names.sort();
    names
}

/// A page as a document.
fn document(page: &str) -> roxmltree::Document<'_> {
    let options = roxmltree::ParsingOptions {
        allow_dtd: true,
        ..Default::default()
    };
    roxmltree::Document::parse_with_options(page, options).unwrap()
}

/// A model of the examples, copied into a directory of this test.
fn example(directory: &Path, name: &str) -> PathBuf {
    let path = directory.join("model.toml");
    std::fs::copy(Path::new(ROOT).join("examples/models").join(name), &path).unwrap();
    path
}

const ASKED: &str = "--schemes newmark,ga:0.8 --steps 0.1,0.05,0.025 -q";

#[test]
fn it_writes_tables_figures_and_a_page_that_needs_no_other_file() {
    let directory = directory("program_compare");
    let model = example(&directory, "pendulum.toml");
    let output = compare(&model, ASKED);
    succeeded(&output);
    let out = directory.join("model.compare");
    let names = written();
    assert_eq!(files(&out), names);

    let page = read(out.join("compare.html"));
    let document = document(&page);
    let count = |name: &str| {
        let tags = document
            .descendants()
            .filter(|n| n.tag_name().name() == name);
        tags.count()
    };
    for tag in ["script", "link", "img", "iframe", "object", "image", "use"] {
        assert_eq!(count(tag), 0, "{tag}");
    }
    let refers = |n: roxmltree::Node<'_, '_>| {
        let mut names = n.attributes().map(|a| a.name());
        names.any(|a| ["src", "href", "data", "onload", "onclick"].contains(&a))
    };
    assert!(!document.descendants().any(refers));
    assert!(!page.contains("url(") && !page.contains("@import"));
    assert_eq!(count("svg"), 4);
    let command = document
        .descendants()
        .find(|n| n.attribute("class") == Some("command"));
    let command: String = command
        .unwrap()
        .descendants()
        .filter_map(|n| n.text())
        .collect();
    assert!(command.starts_with("pullback compare ") && command.contains(ASKED));

    // The same tables in Markdown, column by column.
    let text = read(out.join("compare.md"));
    let heads: Vec<usize> = (text.lines())
        .filter(|line| line.starts_with("| :--"))
        .map(|line| line.matches("--").count())
        .collect();
    let tables = document.descendants().filter(|n| n.has_tag_name("table"));
    let widths: Vec<usize> = tables
        .map(|table| table.descendants().filter(|n| n.has_tag_name("th")).count())
        .collect();
    assert_eq!(heads, widths);
    let rows = document.descendants().filter(|n| n.has_tag_name("tr"));
    let lines = text.lines().filter(|line| line.starts_with('|'));
    assert_eq!(lines.count(), rows.count() + widths.len());

    for name in FILES.iter().filter(|name| name.ends_with(".svg")) {
        roxmltree::Document::parse(&read(out.join(name))).unwrap();
    }
    let csv = read(out.join("compare.csv"));
    let widths: Vec<usize> = csv.lines().map(|l| l.split(',').count()).collect();
    assert_eq!(widths, vec![widths[0]; 7]);
    let json: serde_json::Value = serde_json::from_str(&read(out.join("compare.json"))).unwrap();
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
    let model = example(&directory, "pendulum.toml");
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
    for name in ["pendulum.toml", "top.toml"] {
        let example = Path::new(ROOT).join("examples/models").join(name);
        std::fs::copy(example, directory.join(name)).unwrap();
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
    let document = document(&page);
    let heads = document.descendants().filter(|n| n.has_tag_name("h1"));
    assert_eq!(heads.count(), 3);
    let names = written();
    for (model, own_step) in [("pendulum", 0.01), ("top", 0.00025)] {
        assert_eq!(files(&out.join(model)), names, "{model}");
        let json = read(out.join(model).join("compare.json"));
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
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
    example(&directory, "pendulum.toml");
    check_lines(
        &directory,
        "compare model.toml",
        "
--schemes newmark,leapfog --steps 0.1,0.05 | leapfog
--schemes hht:-0.5 --steps 0.1,0.05 | alpha of HHT = -0.5
--schemes lie-bathe --steps 0.1,0.05 | newmark, hht, wbz, ga, projected-newmark, central-difference
--schemes newmark --steps 0.05,0.1 | 0.1 comes after 0.05
--schemes newmark --steps -0.1,0.05 | step size -0.1
--schemes newmark --steps NaN,0.05 | step size NaN
--schemes newmark --steps 11,0.05 | 11 is larger than the duration 10
--schemes newmark --steps 0.1 | two step sizes
--schemes newmark --steps 0.1,x | x
--schemes newmark --steps 0.1,0.05s | '0.05s' | such as 0.01, or a multiple
--schemes newmark --steps 10,0.05 | step size 10 makes one step
--schemes newmark --steps 0.1,0.05 --threads 0 | 1 or more
--schemes newmark --steps 0.1,0.05 --reference lie-ga:0.8 | without the prefix
--schemes newmark --steps 0.1,0.05 --reference diffsol-bdf | `diffsol-bdf`
--schemes newmark --steps 0.1,0.05 --reference gaa | no scheme is called so
--schemes newmark --steps 0.1,0.05 --residual 1e-30 | below the rounding of forces, 2.2e-16
",
    );
    // A name that is neither a file nor a model has the nearest one beside it.
    let said = ended(&compare(&directory.join("pendulm"), ASKED), 2);
    let all = ["no file `pendulm`", "did you mean `pendulum`?", "heavy_top"];
    assert!(all.iter().all(|word| said.contains(word)), "{said}");
    let statics = example(&directory, "cantilever.toml");
    let said = ended(&compare(&statics, ASKED), 2);
    assert_says(
        &said,
        &["model.toml: the analysis of this model is not dynamic"],
    );
    assert_eq!(files(&directory), ["model.toml"]);
}

#[test]
fn models_of_the_gallery_need_no_file() {
    // As `pullback gallery` names its cases, too.
    let [case, model] = ["heavy-top", "heavy_top"].map(|name| gallery::model(Path::new(name)));
    assert!(case.is_some() && case == model);
    let listed = files(&Path::new(ROOT).join("examples/models"));
    let listed: Vec<&str> = listed
        .iter()
        .map(|file| file.trim_end_matches(".toml"))
        .collect();
    let known: Vec<&str> = MODELS.iter().map(|(name, _)| *name).collect();
    assert_eq!(known, listed);
    let directory = directory("program_compare_built_in");
    let asked = "compare pendulum --schemes newmark --steps 0.1,0.05 -q";
    succeeded(&program_in(&directory, asked));
    let names = written();
    assert_eq!(files(&directory.join("pendulum.compare")), names);
    // A directory of results does not hide the model whose name it has.
    let asked = "compare pendulum --schemes newmark --steps 0.1,0.05 -q --out pendulum";
    for _ in 0..2 {
        succeeded(&program_in(&directory, asked));
    }
    assert_eq!(files(&directory.join("pendulum")), names);
}

/// A formulation that a model does not take makes rows with the reason, as whatever else fails.
#[test]
fn formulations_that_a_model_does_not_take_are_rows() {
    let directory = directory("program_compare_formulations");
    let model = example(&directory, "pendulum.toml");
    let asked = "--schemes newmark,hht:-0.1,ga:0.8,lie-ga:0.8 --steps 0.1,0.05 --charts";
    let output = compare(&model, asked);
    let said = succeeded(&output);
    assert_eq!(
        said.matches("lie-ga:0.8 cannot begin: ").count(),
        1,
        "{said}"
    );
    let table = read(directory.join("model.compare/compare.csv"));
    let mut rows = table.lines().skip(1);
    assert!(
        rows.by_ref().take(6).all(|row| row.contains(",complete,")),
        "{table}"
    );
    let without =
        |row: &str| row.starts_with("compared,lie-ga:0.8,") && row.contains("without the prefix");
    assert!(rows.by_ref().take(2).all(without), "{table}");
    // It is said once, and what never began stands in no other table, legend or caption with a time.
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(said.matches("lie-ga:0.8: ").count(), 1, "{said}");
    let page = read(directory.join("model.compare/compare.md"));
    let lines = page
        .lines()
        .filter(|line| line.starts_with("| lie-ga:0.8 |"));
    let lines: Vec<&str> = lines.collect();
    assert_eq!(lines.len(), 2, "{lines:?}");
    assert!(lines[1].starts_with("| lie-ga:0.8 | all | "), "{lines:?}");
    assert!(page.contains("lie-ga:0.8 (no run came to its end)"));
    assert!(!page.contains("after t =") && !page.contains("0.00e0"));
    let legends = read(directory.join("model.compare/drift.svg"));
    assert!(legends.contains("ga:0.8") && !legends.contains("lie-ga:0.8"));
    assert!(page.contains("No run changes a chart"));
}

#[test]
fn schemes_that_cannot_begin_are_refused_before_anything_runs_if_none_can() {
    let directory = directory("program_compare_undamped");
    let model = example(&directory, "four_bar.toml");
    let text = read(&model);
    let joint = "name = \"C\"\n";
    assert_eq!(text.matches(joint).count(), 1);
    let text = text
        .replace(joint, &format!("{joint}closure = \"multipliers\"\n"))
        .replace("to = 4\n", "to = 0.02\n");
    std::fs::write(&model, text).unwrap();
    let steps = "--steps 0.01,0.005 -q --schemes newmark";
    let said = ended(&compare(&model, &format!("{steps},hht:0")), 2);
    assert_says(
        &said,
        &["model.toml: no scheme can begin this motion; newmark: "],
    );
    assert_eq!(files(&directory), ["model.toml"]);
    // Where one can, the others are rows with the reason.
    succeeded(&compare(&model, &format!("{steps},ga:0.8")));
    let table = read(directory.join("model.compare/compare.csv"));
    let failed = table
        .lines()
        .filter(|row| row.starts_with("compared,newmark"));
    assert_eq!(
        failed.filter(|row| row.contains("multiplier")).count(),
        2,
        "{table}"
    );
}
