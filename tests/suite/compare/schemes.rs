//! Schemes in model files: words and tables, what is refused, and a run with each.

use crate::support::dynamics::observed;
use crate::support::program::{assert_close, assert_says, cells, changed, example, refusal};
use pullback::input::{Plan, assemble_text};
use pullback::integrators::dynamics::scheme::SCHEMES;
use pullback::integrators::dynamics::{DynamicOptions, Scheme};

/// The pendulum with another scheme.
fn with(scheme: &str) -> String {
    let changes = format!("{{ newmark = [0.25, 0.5] }} => {scheme}");
    changed(&example("pendulum"), &changes)
}

fn scheme(text: &str) -> Scheme {
    match assemble_text("pendulum.toml", &with(text)).unwrap().plan {
        Plan::Dynamic(plan) => plan.options.scheme,
        other => panic!("{other:?}"),
    }
}

#[test]
fn words_and_tables_say_the_same() {
    for (table, word) in [
        ("{ newmark = [0.3025, 0.6] }", "newmark:0.3025:0.6"),
        ("{ hht = -0.1 }", "hht:-0.1"),
        ("{ hht = 0 }", "hht:0"),
        ("{ wbz = 0.8 }", "wbz:0.8"),
        ("{ generalised-alpha = 1 }", "ga:1"),
        ("{ ga = 0.8 }", "generalised-alpha:0.8"),
        ("{ bathe = 0.5 }", "bathe:0.5"),
    ] {
        let quoted = format!("{word:?}");
        assert_eq!(scheme(table), word.parse().unwrap());
        assert_eq!(scheme(table), scheme(&quoted));
    }
    for family in SCHEMES {
        if (family.make)(&[]).is_some() {
            let word = format!("{:?}", family.word);
            assert_eq!(scheme(&word), family.word.parse().unwrap());
        }
    }
}

#[test]
fn what_is_no_scheme_is_refused_at_its_place() {
    for [scheme, words] in cells(
        r#"
"bath" | scheme `bath`: no scheme is called so
{ bath = 1 } | scheme `bath`: no scheme is called so
"em" | scheme `em`: it is now called projected-newmark
"svq-newmark" | scheme `svq-newmark`: it is now called lie-newmark
"lie-radau" | one stage
"lie-tsitouras" | schemes with one stage
"spin-ga:0.8" | newmark
"ul-nothing" | ul-nothing
"lie-" | there are
{ hht = 0.3 } | rho of HHT (or alpha, which is not positive) = 0.3 is outside its range
{ wbz = [0.1, 0.2] } | 2 numbers are given
{ wbz = 0.1, hht = 0 } | one scheme is enough
{ wbz = true } |
{ } | no scheme is named
3 | a scheme, such as
"radau"\nadaptive = { tolerance = 1e-4 } | no estimate of the local error
"#,
    ) {
        println!("{scheme}");
        let error = refusal(&with(scheme));
        assert_says(&format!("{error:?} {error}"), &[words]);
    }
}

#[test]
fn every_scheme_of_the_list_runs_the_pendulum_of_a_model_file() {
    // published.json, R04 (IFToMM A01): cos and sin of the angle from the lowest position at t = 1.
    let (x, y) = (0.986_291_751_131_875_f64, -0.165_010_853_125_541_f64);
    for family in SCHEMES {
        // Some take no numbers, some one: a spectral radius.
        let words = [family.word.to_owned(), format!("{}:0.8", family.word)];
        let word = words.into_iter().find(|w| w.parse::<Scheme>().is_ok());
        let word = word.expect("a scheme without numbers, or with one");
        let mut job = assemble_text("pendulum.toml", &with(&format!("{word:?}"))).unwrap();
        let options = DynamicOptions {
            scheme: word.parse().unwrap(),
            ..DynamicOptions::new(1.0, 0.005)
        };
        let from = [&job.start.q[..], &job.start.v];
        let end = observed(&mut job.context, from, &options, &mut |_, _| ()).state;
        // The model's angle is that from (−1, 0), and grows downwards.
        let angle = end.q[0].abs();
        assert_close(-angle.cos(), x, 2e-4, &word);
        assert_close(-angle.sin(), y, 2e-4, &word);
    }
}
