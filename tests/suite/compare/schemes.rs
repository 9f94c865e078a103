//! Schemes in model files: words and tables, and what is refused.

use crate::support::program::{assert_says, cells, changed, example, refusal};
use pullback::input::{Plan, assemble_text};
use pullback::integrators::dynamics::Scheme;
use pullback::integrators::dynamics::scheme::SCHEMES;

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
"bath" | scheme `bath`: no scheme has this name
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
