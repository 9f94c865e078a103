//! Every case of the gallery meets every published or exact value.

use pullback::gallery;

#[test]
fn every_case_meets_its_tolerances() {
    let rows = gallery::run(&[], None, &mut |_| {}).unwrap();
    let missed: Vec<String> = rows
        .iter()
        .filter(|row| !row.passed())
        .map(|row| format!("{row:?}"))
        .collect();
    assert!(missed.is_empty(), "{}", missed.join("\n"));
    // Every case has rows, and none compares with a tolerance that lets everything pass.
    for case in gallery::CASES {
        assert!(
            rows.iter().any(|row| row.case == case.name),
            "{}",
            case.name
        );
    }
    for row in &rows {
        let scale = row.published.abs().max(1.0);
        assert!(row.tolerance <= 0.5 * scale, "{row:?}");
    }
}

/// What each case of statics must compare: its name, how the quantity or the source begins, the
/// least number of such rows and the largest tolerance, relative to the published value or to 1.
/// The tolerances are those to which the outside values are known or to which a published mesh
/// reaches them, 0.05 to 0.15 for orders of convergence and what is read from figures.
const STATICS: &[(&str, &str, usize, f64)] = &[
    ("bend45", "most iterations", 1, 0.2),
    // Each component to 1e-3, whatever its size: see below.
    ("bend45", "tip displacement, 8 elements", 3, 1e-3),
    ("bend45-convergence", "order, 2-node", 3, 0.05),
    ("bend45-convergence", "order, 3-node", 3, 0.075),
    ("bend45-convergence", "order, geodesic", 2, 0.15),
    ("bend45-convergence", "tip, 64 3-node", 3, 1e-6),
    ("bend45-convergence", "tip, 32 4-node", 3, 1e-8),
    ("bend45-convergence", "tip, 32 geodesic 4-node", 3, 1e-8),
    ("helix", "first maximum", 3, 0.016),
    ("helix", "load factor of the first maximum", 3, 0.002),
    ("helix", "load factor reached", 3, 0.0),
    ("helix", "height of the tip at full load", 1, 0.2),
    ("helix", "order of the mean distance", 1, 0.05),
    ("helix", "mean distance", 1, 0.5),
    ("rollup", "tip displacement after 1", 3, 1e-9),
    ("rollup", "tip displacement after 2", 3, 1e-9),
    ("rollup", "rotation left over", 2, 1e-9),
    ("rollup", "strain energy after 1", 1, 1e-9),
    ("rollup", "strain energy after 2", 1, 1e-9),
    ("rollup", "rotation of a single element", 1, 1e-10),
    ("elastica", "w/L", 11, 1e-8),
    ("elastica", "u/L", 11, 1e-8),
    ("elastica", "rotation", 11, 1e-8),
    ("cantilever", "exact curve", 3, 1e-9),
    ("cantilever", "published", 3, 1e-3),
    ("twisted", "published: kynema-fmb", 3, 1e-9),
    ("twisted", "published: ANSYS solid", 3, 0.032),
    // 0.5 % of the largest displacements, 0.0107 and 0.146.
    ("princeton", "uy", 7, 5.36e-5),
    ("princeton", "uz", 7, 7.32e-4),
    ("shear-flexible", "large load", 4, 1e-6),
    ("shear-flexible", "exact curve", 5, 1e-9),
    ("shear-flexible", "small load", 2, 1e-12),
    ("shear-flexible", "order", 3, 0.05),
    ("lee-frame", "exact curve", 9, 1e-5),
    ("lee-frame", "published: Lee et al.", 1, 2e-3),
    (
        "lee-frame",
        "published: Simo & Vu-Quoc 1986, 10 quadratic",
        1,
        2e-3,
    ),
    ("lee-frame", "turning points", 1, 0.0),
    (
        "deep-arch",
        "exact curve: independent shooting, S12",
        3,
        2e-5,
    ),
    ("deep-arch", "crown deflection at load 500 beyond", 1, 1e-7),
    ("deep-arch", "crown deflection at load 0 beyond", 1, 1e-7),
    ("deep-arch", "crown displacement along e1 at load", 2, 2e-7),
    ("deep-arch", "turning points", 1, 0.0),
    ("deep-arch", "published", 3, 6e-4),
    ("bending-torsion", "rotation matrix of the tip", 8, 1e-9),
    (
        "bending-torsion",
        "place of the tip over length at load 0.9",
        4,
        1e-7,
    ),
    (
        "bending-torsion",
        "place of the tip over length at load 1,",
        4,
        1e-9,
    ),
    ("follower", "ux", 8, 1e-7),
    ("follower", "uy", 8, 1e-7),
    ("follower", "rotation", 8, 1e-7),
    ("objectivity", "tip after loading and unloading", 1, 1e-9),
    ("objectivity", "tip for two orders of two loads", 1, 1e-9),
    ("objectivity", "strain energy of the unloaded", 2, 1e-12),
    (
        "objectivity",
        "relative change of strain energy when the loaded geodesic",
        5,
        1e-10,
    ),
    (
        "objectivity",
        "relative change of strain energy when the loaded bend",
        1,
        1e-3,
    ),
    ("objectivity", "order", 1, 0.1),
];

#[test]
fn no_case_of_statics_is_lost_or_loosened() {
    let mut names: Vec<String> = STATICS.iter().map(|row| row.0.to_owned()).collect();
    names.dedup();
    let rows = gallery::run(&names, None, &mut |_| {}).unwrap();
    let mut bounded = vec![false; rows.len()];
    for &(case, start, least, largest) in STATICS {
        let mut count = 0;
        for (row, bounded) in rows.iter().zip(&mut bounded) {
            if row.case == case
                && (row.quantity.starts_with(start) || row.source.starts_with(start))
            {
                let scale = row.published.abs().max(1.0);
                // The last digit of a product may be rounded.
                assert!(row.tolerance <= largest * scale * (1.0 + 1e-9), "{row:?}");
                *bounded = true;
                count += 1;
            }
        }
        assert!(count >= least, "{case} has {count} rows {start:?}");
    }
    for (row, bounded) in rows.iter().zip(bounded) {
        assert!(row.passed(), "{row:?}");
        assert!(bounded, "nothing bounds the tolerance of {row:?}");
        if row.case == "bend45" && row.quantity.starts_with("tip") {
            assert!(row.tolerance <= 1e-3, "{row:?}");
        }
    }
}

#[test]
fn a_miss_is_seen() {
    let rows = gallery::run(&["bend45".to_owned()], None, &mut |_| {}).unwrap();
    let mut row = rows[0].clone();
    assert!(row.passed());
    row.difference = 2.0 * row.tolerance;
    assert!(!row.passed());
    row.difference = f64::NAN;
    assert!(!row.passed());
}

#[test]
fn an_unknown_case_is_refused_with_the_known_ones() {
    let error = gallery::run(&["bend46".to_owned()], None, &mut |_| {}).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("bend46") && text.contains("bend45"), "{text}");
}
