//! Every scheme of the list has its stated properties, and the kit tells where one does not.

use super::WORDS;
use crate::support::dynamics::*;
use crate::support::*;
use pullback_conformance as check;
use pullback_integrators::dynamics::scheme::SCHEMES;

#[test]
fn every_scheme_of_the_list_does_what_it_claims() {
    let more = [
        "newmark:0.5:0.5",
        "projected-newmark",
        "projected-newmark:0.8",
        "projected-newmark:0",
        "tsitouras",
    ];
    let words = || WORDS.into_iter().chain(more);
    for word in words() {
        check::scheme(&word.parse().unwrap()).assert();
    }
    for family in SCHEMES {
        let shown = words().any(|word| word.split(':').next() == Some(family.word));
        assert!(shown, "{}", family.word);
    }
}

const MULTIPLIERS: &str = "orders with multipliers";

/// Laws that a table fails with these claims.
fn failures(stages: &[Stage], properties: SchemeProperties) -> Vec<String> {
    check::scheme(&Scheme::new("trial", stages, properties).unwrap()).failing_laws()
}

fn symmetric(limit: Option<f64>) -> SchemeProperties {
    SchemeProperties {
        limit,
        symmetric: true,
        ..stable(2)
    }
}

fn newmark(beta: f64, gamma: f64) -> Stage {
    Stage::new(1.0, [0.5 - beta, beta], [1.0 - gamma, gamma])
}

/// TR-BDF2 with γ = 1/2, its last row (1/3, 1/3, 1/3).
fn composite(second: f64, c: f64) -> [Stage; 2] {
    let third = 1.0 / 3.0;
    let rows = [[0.25, 0.25, 0.0], [third, second, third]];
    Stage::runge_kutta([c, 1.0], rows)
}

#[test]
fn a_right_table_by_hand_passes() {
    assert!(failures(&composite(1.0 / 3.0, 0.5), stable(2)).is_empty());
    assert!(failures(&[newmark(0.25, 0.5)], symmetric(None)).is_empty());
}

#[test]
fn wrong_schemes_are_caught_by_the_law_they_break() {
    // A weight that is off by one per cent.
    let off = failures(&composite(1.01 / 3.0, 0.5), stable(2));
    for law in ["order", "exactness"] {
        assert!(off.contains(&law.to_owned()), "{off:?}");
    }
    // Loads are asked at the wrong time; nothing that does not depend on time sees it.
    let late = failures(&composite(1.0 / 3.0, 0.6), stable(2));
    assert!(late.contains(&"order".to_owned()), "{late:?}");
    assert!(!late.contains(&"stability".to_owned()), "{late:?}");
    // Damping of the first order that claims the second.
    let damped = failures(&[newmark(0.3025, 0.6)], stable(2));
    let first = [
        "exactness",
        "order",
        "order under changes of chart",
        MULTIPLIERS,
    ];
    assert_eq!(damped, first);
    // Explicit, but claimed to be stable.
    let explicit = failures(&[newmark(0.0, 0.5)], symmetric(None));
    assert_eq!(explicit, ["stability"]);
    // A limit that is too large, and one that is too small.
    let bold = failures(&[newmark(0.0, 0.5)], symmetric(Some(2.1)));
    assert_eq!(bold, ["stability"]);
    let timid = failures(&[newmark(0.0, 0.5)], symmetric(Some(1.9)));
    assert_eq!(timid, ["limit of stability"]);
    // Dissipative, but claimed to be reversible.
    let reversed = failures(&composite(1.0 / 3.0, 0.5), symmetric(None));
    assert_eq!(reversed, ["time reversal"]);
    // A third order that is none.
    let bold = failures(&[newmark(0.25, 0.5)], stable(3));
    assert_eq!(bold, ["exactness", "order", "order under changes of chart"]);
}

/// What index 3 costs is claimed, and measured: neither more nor less.
#[test]
fn wrong_orders_with_multipliers_are_caught() {
    let right = |word: &str| word.parse::<Scheme>().unwrap();
    // Radau's velocities are of order 2; generalised-α and Bathe's scheme keep theirs.
    for (word, held) in [
        ("radau", [3, 3]),
        ("radau", [2, 2]),
        ("bathe", [2, 1]),
        ("ga:0.8", [2, 1]),
        ("ga:0.8", [3, 2]),
    ] {
        let wrong = right(word).under_multipliers(held);
        let found = check::scheme(&wrong).failing_laws();
        assert_eq!(found, [MULTIPLIERS], "{word} {held:?}");
        let claimed = right(word).orders_with_multipliers();
        check::scheme(&wrong.under_multipliers(claimed)).assert();
    }
}

#[test]
fn embedded_rows_have_one_order_less() {
    let tsitouras: Scheme = "tsitouras".parse().unwrap();
    let row = *tsitouras.embedded().unwrap();
    let mut wrong = [row; 3];
    wrong[0].v[2] += 1e-3;
    wrong[1].q[1] = f64::NAN;
    wrong[2].c = 0.3;
    for row in wrong {
        let laws = check::scheme(&tsitouras.with_embedded(row)).failing_laws();
        assert_eq!(laws, ["order of the embedded method"]);
    }
}
