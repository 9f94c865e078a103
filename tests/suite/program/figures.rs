//! Figures: ticks at round numbers, ranges that are never empty, and round-off that is not drawn.

use crate::support::drawings::{self, TICKS, assert_labelled, polylines, tagged};
use crate::support::*;
use pullback::output::plot::{AxisScale, PlotCurve};
use roxmltree::Document;
use serde_json::Value;

/// A curve in a graph.
fn drawn(scale: [AxisScale; 2], points: &[(f64, f64)]) -> String {
    let curve = PlotCurve::new("curve", points.to_vec());
    drawings::graph(scale, vec![curve], true)
}

/// Tick labels and their positions, along both axes.
fn ticks(svg: &str) -> [Vec<(String, f64)>; 2] {
    let document = Document::parse(svg).unwrap();
    [0, 1].map(|k| drawings::ticks(&document, ["x", "y"][k], TICKS[k]).collect())
}

/// Labels on a horizontal axis for values between these.
fn labels(scale: AxisScale, [low, high]: [f64; 2]) -> String {
    let svg = drawn([scale, AxisScale::Linear], &[(low, 0.0), (high, 1.0)]);
    let [across, _] = ticks(&svg);
    let labels: Vec<String> = across.into_iter().map(|(label, _)| label).collect();
    labels.join(" ")
}

#[test]
fn ticks_stand_at_round_numbers_with_short_labels() {
    let logarithms = "10⁻¹² 10⁻⁹ 10⁻⁶ 10⁻³ 10⁰";
    for (values, expected) in [
        ([1e-3, 0.1], "10⁻³ 10⁻² 10⁻¹"),
        // No two powers of ten.
        ([0.02, 0.29], "0.02 0.05 0.1 0.2"),
        ([1e-12, 1.0], logarithms),
    ] {
        assert_eq!(labels(AxisScale::Logarithmic, values), expected);
    }
    for (values, expected) in [
        ([-0.06, 1.01], "0 0.2 0.4 0.6 0.8 1"),
        // 3 · 0.1 is 0.30000000000000004.
        ([0.0, 0.5], "0 0.1 0.2 0.3 0.4 0.5"),
        ([-20.0, 40.0], "−20 0 20 40"),
        ([0.0, 1e7], "0 2e6 4e6 6e6 8e6 1e7"),
        ([2.2e6, 2.6e6], "2.2e6 2.3e6 2.4e6 2.5e6 2.6e6"),
        ([-4e-5, 6e-5], "−4e−5 −2e−5 0 2e−5 4e−5 6e−5"),
        ([12000.0, 14000.0], "12000 12500 13000 13500 14000"),
    ] {
        assert_eq!(labels(AxisScale::Linear, values), expected);
    }
}

#[test]
fn what_has_no_logarithm_has_no_position() {
    let values = [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-3, 1e-1];
    let points: Vec<(f64, f64)> = (1..).map(f64::from).zip(values).collect();
    let svg = drawn([AxisScale::Linear, AxisScale::Logarithmic], &points);
    let document = Document::parse(&svg).unwrap();
    let marks = tagged(&document, "circle").map(|n| n.attribute("cy").unwrap());
    // One is in the legend.
    let heights: Vec<f64> = marks.skip(1).map(|y| y.parse().unwrap()).collect();
    let [_, up] = ticks(&svg);
    let tick = |label: &str| up.iter().find(|(text, _)| text == label).unwrap().1;
    assert_eq!(heights, [tick("10⁻³"), tick("10⁻¹")]);
}

#[test]
fn ranges_are_never_empty() {
    for values in [&[][..], &[0.0], &[3.0, 3.0], &[f64::NAN], &[1.0, 2.0]] {
        let points: Vec<(f64, f64)> = (0..).map(f64::from).zip(values.iter().copied()).collect();
        let [_, up] = ticks(&drawn([AxisScale::Linear; 2], &points));
        assert!(up.len() > 1, "{values:?}: {up:?}");
        for pair in up.windows(2) {
            // Upwards.
            assert!(pair[1].1 < pair[0].1, "{values:?}: {up:?}");
        }
    }
}

/// The figure of the history of a model.
fn history(name: &str, text: &str) -> String {
    let text = format!("{text}[output]\nparaview_every = 0\n");
    read(ran(&directory(name), &text).join("history.svg"))
}

/// Whether each curve of a figure is flat.
fn flat(svg: &str) -> Vec<bool> {
    let document = Document::parse(svg).unwrap();
    let curves = polylines(&document);
    curves
        .map(|points| points.chunks(2).all(|p| p[1] == points[1]))
        .collect()
}

/// Two displacements in a structure of length 10, there and back again.
#[test]
fn round_off_is_drawn_as_zero_and_small_values_are_not() {
    let after = |name: &str, sizes: [f64; 2]| {
        let mut text = "[nodes]\nground = [0, 0, 0]\nwall = [10, 0, 0]\nelsewhere = [5, 0, 0]\n\
                        [analysis.dynamic]\nto = 2\nstep = 0.1\n"
            .to_owned();
        text += &body_of("elsewhere", 1.0, "inertia = [1, 1, 1]");
        for node in ["ground", "wall"] {
            text += &(body_of(node, 1.0, "") + &fixed(node));
        }
        for (k, size) in sizes.into_iter().enumerate() {
            let (name, back) = (format!("J{k}"), -size);
            let drive = format!("table = [[0, 0], [1, {size:e}], [2, {back:e}]]");
            let drive = format!("axis = [0, 1, 0]\nprescribed = {{ {drive} }}");
            text += &joint(&name, "prismatic", "ground", &drive);
            text += &(probe(&format!("y{k}"), "displacement", &name) + "component = \"y\"\n");
        }
        let svg = history(name, &text);
        let [_, up] = ticks(&svg);
        (flat(&svg), up.iter().any(|(label, _)| label.contains("e−")))
    };
    let zero = after("figures_round_off", [3e-13, 9e-12]);
    assert_eq!(zero, (vec![true; 2], false));
    // Beside a larger curve round-off is recognised as such.
    let small = after("figures_small", [3e-13, 2e-11]);
    assert_eq!(small, (vec![false; 2], true));
}

/// A body at O, and a motion of it.
fn point(inertia: &str, more: &str) -> String {
    let body = body_of("O", 1.0, inertia);
    format!("[nodes]\nO = [0, 0, 0]\n[analysis.dynamic]\nto = 1\nstep = 0.1\n{body}{more}")
}

#[test]
fn round_off_of_energies_is_known_without_an_extent() {
    let spinning = "[[initial]]\nnode = \"O\"\nangular_velocity = [0.3, 0.2, 0.1]\n\
                    [[probes]]\nname = \"defect\"\nquantity = \"energy_defect\"\n";
    let svg = history("figures_point", &point("inertia = [1, 1, 1]", spinning));
    assert_eq!(flat(&svg), [true]);
}

/// A point without extent, free along one axis and held along the others, under a load of 1e-20.
#[test]
fn nothing_is_round_off_where_no_size_is_known() {
    let mut text = "[[supports]]\nnode = \"O\"\nfix = [\"x\", \"y\", \"rx\", \"ry\", \"rz\"]\n\
                    [[loads]]\nnode = \"O\"\nforce = [1e-20, 0, 1e-20]\n"
        .to_owned();
    let quantities = [
        ("displacement", "node = \"O\"\ncomponent = \"z\""),
        ("acceleration", "node = \"O\"\ncomponent = \"z\""),
        ("reaction_force", "node = \"O\"\ncomponent = \"x\""),
        ("momentum", "component = \"z\""),
        ("kinetic_energy", ""),
    ];
    for (quantity, of) in quantities {
        text += &probe_of(&format!("its {quantity}"), quantity, of);
    }
    let [_, up] = ticks(&history("figures_no_size", &point("", &text)));
    assert!(up.len() >= quantities.len(), "{up:?}");
    for (label, _) in up.iter().filter(|(label, _)| label != "0") {
        assert!(label.contains("e−"), "{up:?}");
    }
}

/// A cart that slides along a rail and carries a pendulum, a length and an angle; more of the file.
fn cart(more: &str) -> String {
    [
        "title = \"Cart & <pole>\"\n[nodes]\nrail = [0, 0, 0]\n",
        &fixed("rail"),
        &joint("cart", "prismatic", "rail", "axis = [1, 0, 0]"),
        &joint("pole", "revolute", "cart", "axis = [0, 1, 0]\nvalue = 0.5"),
        &body_of("pole", 1.0, "center = [0, 0, -1]"),
        GRAVITY,
        "[analysis.dynamic]\nto = 0.1\nstep = 0.01\n",
        more,
    ]
    .concat()
}

#[test]
fn axes_have_units_and_lengths_and_angles_panels_of_their_own() {
    let probes = [
        ("x", "joint_coordinate", "joint = \"cart\""),
        ("angle", "joint_coordinate", "joint = \"pole\""),
        ("speed", "joint_rate", "joint = \"pole\""),
        ("moment", "joint_moment", "joint = \"pole\""),
        ("momentum", "angular_momentum", ""),
        ("fall", "acceleration", "node = \"pole\""),
    ];
    let probes = probes.map(|(name, quantity, of)| probe_of(name, quantity, of));
    let labelled = |name: &str, more: &str, figure: &str, labels: &str| {
        let out = ran(&directory(name), &cart(&[more, &probes.concat()].concat()));
        assert_labelled(&Document::parse(&read(out.join(figure))).unwrap(), labels);
    };
    let units = "[units]\nlength = \"m\"\nforce = \"N\"\ntime = \"s\"\n";
    let known = "time t [s] | joint coordinate [m] | joint coordinate [rad] | rate of joint coordinate [rad/s] | \
                 moment in joint [N m] | angular momentum [N m s] | acceleration [m/s²]";
    labelled("program_units", units, "history.svg", known);
    labelled("program_units", units, "deformed.svg", "x [m]");
    // Without their names only angles have a unit.
    let known = "time t | joint coordinate | joint coordinate [rad] | rate of joint coordinate";
    labelled("program_without_units", "", "history.svg", known);
}

#[test]
fn the_page_of_a_run_has_its_motion() {
    let page = read(ran(&directory("program_page"), &cart("")).join("deformed.html"));
    // No text of a model is markup.
    assert_says(&page, &["<title>Cart &amp; &lt;pole&gt;</title>"]);
    let (_, rest) = page.split_once("id=\"data\">").unwrap();
    let (data, _) = rest.split_once("</script>").unwrap();
    let data: Value = serde_json::from_str(data).unwrap();
    let frames = data["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 11);
    assert_eq!(frames[10]["t"], 0.1);
    assert_eq!(data["lines"].as_array().unwrap().len(), 0);
    // At the start the pole leans by 0.5 rad, and the centre of mass, 1 below the cart, is behind it.
    let numbers = |value: &Value| -> Vec<f64> {
        let all = value.as_array().unwrap().iter();
        all.map(|x| x.as_f64().unwrap()).collect()
    };
    let body = 3 * data["bodies"][0].as_u64().unwrap() as usize;
    let (s, c) = 0.5_f64.sin_cos();
    let center = &numbers(&frames[0]["points"])[body..body + 3];
    let found = [center, &numbers(&frames[0]["axes"])[..9]].concat();
    let center = [-s, 0.0, -c];
    let axes = [c, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, c];
    for (k, exact) in center.into_iter().chain(axes).enumerate() {
        assert_close(found[k], exact, 1e-7, k);
    }
}

#[test]
fn figures_are_written_in_the_formats_of_the_file() {
    let output = "[output]\nparaview_every = 0\nfigures = [\"png\", \"pdf\"]\n";
    let out = ran(&directory("program_formats"), &cart(output));
    let written = "checkpoint.json checkpoint.log deformed.pdf deformed.png \
                   history.csv history.pdf history.png result.json";
    assert!(files(&out).iter().eq(written.split(' ')));
    for name in ["deformed", "history"] {
        let png = std::fs::read(out.join(format!("{name}.png"))).unwrap();
        assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
        // A width of 640 units, in the first chunk.
        assert_eq!(png[16..20], 1280_u32.to_be_bytes());
        let pdf = std::fs::read(out.join(format!("{name}.pdf"))).unwrap();
        assert!(pdf.starts_with(b"%PDF-") && pdf.trim_ascii_end().ends_with(b"%%EOF"));
        let font = b"DejaVuSans";
        let texts = pdf.windows(font.len()).any(|part| part == font);
        assert!(texts, "texts are texts");
    }
}
