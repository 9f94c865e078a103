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
