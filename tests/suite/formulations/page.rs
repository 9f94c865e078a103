//! The page of docs/formulations.md on smaller models: what theory says of orders and of energies. And
//! whether the page is a copy of docs/formulations. Whether that is up to date is a gate of its own
//! (tests/studies/formulations.rs), and says nothing of whether it is right.

use crate::support::formulations::{PAGE, commands, results, table};
use crate::support::included;
use crate::support::prelude::*;
use crate::support::program::{changed, directory, example};
use pullback::studies::compare::{
    Comparison, ComparisonOptions, ErrorQuantity, Hooks, Slope, Subject, run_several,
};

const METHODS: [&str; 4] = ["newmark", "ul-newmark", "lie-newmark", "spin-newmark"];

const ARM: &str = include_str!("../../../docs/formulations/smooth_arm.toml");

/// A model with [other words](changed).
fn subject(name: &str, text: &str, changes: &str, steps: &[f64]) -> Subject<'static> {
    let file = input::parse(name, &changed(text, changes)).unwrap();
    Subject {
        name: name.to_owned(),
        model: name.to_owned(),
        make: Box::new(move |formulation| input::job("model.toml", &file, Some(formulation))),
        options: ComparisonOptions {
            long: Some(20.0),
            residual: Some(1e-10),
            ..ComparisonOptions::new(METHODS.map(|m| m.parse().unwrap()).to_vec(), steps.to_vec())
        },
    }
}

/// How much of the change of energy over the long run is a trend.
fn trend(comparison: &Comparison, method: &str) -> f64 {
    let row = comparison.long.iter().find(|row| row.scheme == method);
    let drift = row.unwrap().drift;
    (drift.trend.unwrap() / drift.energy.unwrap()).abs()
}

#[test]
fn all_keep_their_order_and_sums_of_spins_keep_the_energy_of_the_top() {
    let [top, elbow] = ["top", "elbow"].map(example);
    let few = "elements = 10 => elements = 2\nelements = 10 => elements = 2\nto = 30 => to = 6";
    let subjects = [
        subject("top", &top, "to = 1.5 => to = 0.5", &[1e-3, 5e-4, 2.5e-4]),
        subject("elbow", &elbow, few, &[0.1, 0.05, 0.025]),
        subject("arm", ARM, "to = 3 => to = 0.6", &[5e-3, 2.5e-3, 1.25e-3]),
    ];
    let out = directory("formulations_page");
    let all = run_several(&subjects, None, &out, &Hooks::NONE).unwrap();
    for comparison in &all {
        let model = &comparison.model;
        for scheme in &comparison.orders {
            let order = scheme.of(ErrorQuantity::Rotation);
            // No sum of these loses the order of Newmark's scheme: the local errors are of third order.
            assert_eq!(
                scheme.slope(ErrorQuantity::Rotation),
                Some(Slope::Theory),
                "{model}, {}: {order:?}",
                scheme.scheme
            );
        }
        let equal = comparison.equal_cost.as_ref().unwrap();
        assert_eq!(equal.schemes.len(), METHODS.len(), "{model}");
    }
    // Steps of sums of spins can be run backwards: energy comes and goes. Those of a chart that is
    // centred anew, or changed, cannot.
    let top = &all[0];
    for method in ["lie-newmark", "spin-newmark"] {
        assert!(trend(top, method) < 0.1, "{method}: {}", trend(top, method));
    }
    for method in ["newmark", "ul-newmark"] {
        assert!(trend(top, method) > 0.3, "{method}: {}", trend(top, method));
    }
    // On the top local errors are (h³/12)(Ω̈ + c Ω×Ω̇) with c = ½ for the updated Lagrangian, −1 and 2
    // for sums of spins (tests/suite/formulations/spin_vectors.rs).
    let error = |method: &str| {
        let row = top.of(method).last().unwrap();
        row.error.unwrap().of(ErrorQuantity::Rotation)
    };
    for method in ["lie-newmark", "spin-newmark"] {
        assert!(error(method) > 2.0 * error("ul-newmark"), "{method}");
    }
}

/// The page with its tables copied from the results.
fn with_tables(page: &str) -> String {
    let mut out = String::new();
    let mut copied = false;
    for line in page.lines() {
        if line == "<!-- end -->" {
            copied = false;
        }
        if !copied {
            out += &format!("{line}\n");
        }
        let mark = line
            .strip_prefix("<!-- ")
            .and_then(|l| l.strip_suffix(" -->"));
        if let Some((name, heading)) = mark.and_then(|mark| mark.split_once(": ")) {
            for line in table(&results(name), heading) {
                out += &format!("{line}\n");
            }
            copied = true;
        }
    }
    out
}

#[test]
fn the_tables_of_the_page_are_those_of_the_commands_on_it() {
    included::update("docs/formulations.md", PAGE, &with_tables(PAGE));
    assert!(PAGE.matches("\n<!-- end -->\n").count() >= 10);
    for command in commands() {
        let (_, name) = command.rsplit_once("--out ").unwrap();
        let shown = format!("```sh\n{command}\n```");
        assert!(results(name).contains(&shown), "{command}");
    }
}
