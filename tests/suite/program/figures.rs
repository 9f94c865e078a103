//! Figures: ticks at round numbers, ranges that are never empty, and round-off that is not drawn.
#![allow(clippy::unwrap_used)]

use crate::support::program::{directory, ran, read};
use pullback::output::plot::{AxisScale, Graph, PlotCurve, graphs};
use roxmltree::{Document, Node};

/// A curve in a graph without descriptions.
fn drawn(scale: [AxisScale; 2], points: &[(f64, f64)]) -> String {
    let graph = Graph {
        description: [String::new(), String::new()],
        scale,
        curves: vec![PlotCurve::new("curve", points.to_vec())],
        marked: true,
        slopes: Vec::new(),
        level: None,
    };
    graphs(None, "", &[graph]).unwrap()
}

fn number(node: &Node<'_, '_>, name: &str) -> f64 {
    node.attribute(name).unwrap().parse().unwrap()
}

/// Tick labels and their positions, along both axes.
fn ticks(svg: &str) -> [Vec<(String, f64)>; 2] {
    let document = Document::parse(svg).unwrap();
    let of = |name: &str, is_tick: fn(&Node<'_, '_>) -> bool| {
        let texts = document.descendants().filter(|n| n.has_tag_name("text"));
        let ticks = texts.filter(is_tick).filter_map(|n| {
            let label = n.text()?.trim();
            (!label.is_empty()).then(|| (label.to_owned(), number(&n, name)))
        });
        ticks.collect()
    };
    [
        of("x", |n| {
            n.attribute("dy") == Some("0.76em") && n.attribute("transform").is_none()
        }),
        of("y", |n| n.attribute("text-anchor") == Some("end")),
    ]
}

/// Labels on a horizontal axis for values between these.
fn labels(scale: AxisScale, [low, high]: [f64; 2]) -> String {
    let svg = drawn([scale, AxisScale::Linear], &[(low, 0.0), (high, 1.0)]);
    let [across, _] = ticks(&svg);
    let labels: Vec<String> = across.into_iter().map(|(label, _)| label).collect();
    labels.join(" ")
}

#[test]
fn ticks_stand_at_round_numbers() {
    for (scale, values, expected) in [
        (AxisScale::Linear, [-0.06, 1.01], "0 0.2 0.4 0.6 0.8 1"),
        (AxisScale::Logarithmic, [1e-3, 0.1], "10⁻³ 10⁻² 10⁻¹"),
        // No two powers of ten.
        (AxisScale::Logarithmic, [0.02, 0.29], "0.02 0.05 0.1 0.2"),
        (
            AxisScale::Logarithmic,
            [1e-12, 1.0],
            "10⁻¹² 10⁻⁹ 10⁻⁶ 10⁻³ 10⁰",
        ),
    ] {
        assert_eq!(labels(scale, values), expected);
    }
}

#[test]
fn tick_labels_are_short() {
    for (values, expected) in [
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
    let marks = document.descendants().filter(|n| n.has_tag_name("circle"));
    // One is in the legend.
    let heights: Vec<f64> = marks.map(|n| number(&n, "cy")).skip(1).collect();
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
    let directory = directory(name);
    ran(&directory, text);
    read(directory.join("model.out/history.svg"))
}

/// Whether each curve of a figure is flat; frames, ticks and legends have five points at most.
fn flat(svg: &str) -> Vec<bool> {
    let document = Document::parse(svg).unwrap();
    let lines = document
        .descendants()
        .filter(|n| n.has_tag_name("polyline"));
    let heights = lines.map(|n| {
        let points = n.attribute("points").unwrap().split_whitespace();
        let heights = points.map(|p| p.split_once(',').unwrap().1.to_owned());
        heights.collect::<Vec<_>>()
    });
    let curves = heights.filter(|heights| heights.len() > 5);
    curves
        .map(|heights| heights.iter().all(|y| *y == heights[0]))
        .collect()
}

/// Two displacements in a structure of length 10, there and back again.
#[test]
fn round_off_is_drawn_as_zero_and_small_values_are_not() {
    let after = |name: &str, sizes: [f64; 2]| {
        let mut text = "[nodes]\nground = [0, 0, 0]\nwall = [10, 0, 0]\nelsewhere = [5, 0, 0]\n\
                        [[bodies]]\nname = \"free\"\nnode = \"elsewhere\"\nmass = 1\n\
                        inertia = [1, 1, 1]\n"
            .to_owned();
        for node in ["ground", "wall"] {
            text += &format!(
                "[[bodies]]\nname = \"{node}\"\nnode = \"{node}\"\nmass = 1\n\
                 [[supports]]\nnode = \"{node}\"\nfix = \"all\"\n"
            );
        }
        for (k, size) in sizes.into_iter().enumerate() {
            text += &format!(
                "[[joints]]\nname = \"J{k}\"\ntype = \"prismatic\"\nparent = \"ground\"\n\
                 axis = [0, 1, 0]\nprescribed = {{ table = [[0, 0], [1, {size:e}], [2, {:e}]] }}\n\
                 [[probes]]\nname = \"y{k}\"\nquantity = \"displacement\"\nnode = \"J{k}\"\n\
                 component = \"y\"\n",
                -size
            );
        }
        text += "[analysis.dynamic]\nto = 2\nstep = 0.1\n[output]\nparaview_every = 0\n";
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

#[test]
fn round_off_of_energies_is_known_without_an_extent() {
    let svg = history(
        "figures_point",
        "[nodes]\nO = [0, 0, 0]\n[[bodies]]\nname = \"ball\"\nnode = \"O\"\nmass = 1\ninertia = [1, 1, 1]\n\
         [[initial]]\nnode = \"O\"\nangular_velocity = [0.3, 0.2, 0.1]\n\
         [[probes]]\nname = \"defect\"\nquantity = \"energy_defect\"\n\
         [analysis.dynamic]\nto = 2\nstep = 0.1\n[output]\nparaview_every = 0\n",
    );
    assert_eq!(flat(&svg), [true]);
}

/// A point without extent, free along one axis and held along the others, under a load of 1e-20.
#[test]
fn nothing_is_round_off_where_no_size_is_known() {
    let mut text = "[nodes]\nO = [0, 0, 0]\n[[bodies]]\nname = \"point\"\nnode = \"O\"\nmass = 1\n\
                    [[supports]]\nnode = \"O\"\nfix = [\"x\", \"y\", \"rx\", \"ry\", \"rz\"]\n\
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
        text +=
            &format!("[[probes]]\nname = \"its {quantity}\"\nquantity = \"{quantity}\"\n{of}\n");
    }
    text += "[analysis.dynamic]\nto = 1\nstep = 0.1\n[output]\nparaview_every = 0\n";
    let [_, up] = ticks(&history("figures_no_size", &text));
    assert!(up.len() >= quantities.len(), "{up:?}");
    for (label, _) in up.iter().filter(|(label, _)| label != "0") {
        assert!(label.contains("e−"), "{up:?}");
    }
}

/// A cart that slides along a rail and carries a pendulum: a length and an angle.
const CART: &str = r#"
title = "Cart & <pole>"
[nodes]
rail = [0, 0, 0]
[[supports]]
node = "rail"
fix = "all"
[[joints]]
name = "cart"
type = "prismatic"
parent = "rail"
axis = [1, 0, 0]
[[joints]]
name = "pole"
type = "revolute"
parent = "cart"
axis = [0, 1, 0]
value = 0.5
[[bodies]]
name = "bob"
node = "pole"
mass = 1
center = [0, 0, -1]
[[loads]]
gravity = [0, 0, -9.81]
[analysis.dynamic]
to = 0.1
step = 0.01
"#;

/// All texts of a figure.
fn texts(svg: &str) -> Vec<String> {
    let document = Document::parse(svg).unwrap();
    let texts = document.descendants().filter(|n| n.has_tag_name("text"));
    texts
        .filter_map(|n| Some(n.text()?.trim().to_owned()))
        .collect()
}

#[test]
fn axes_have_units_and_lengths_and_angles_panels_of_their_own() {
    let probe = |name: &str, quantity: &str, of: &str| {
        format!("[[probes]]\nname = \"{name}\"\nquantity = \"{quantity}\"\n{of}\n")
    };
    let probes = [
        probe("x", "joint_coordinate", "joint = \"cart\""),
        probe("angle", "joint_coordinate", "joint = \"pole\""),
        probe("speed", "joint_rate", "joint = \"pole\""),
        probe("moment", "joint_moment", "joint = \"pole\""),
        probe("momentum", "angular_momentum", ""),
        probe("fall", "acceleration", "node = \"pole\""),
    ];
    let units = "[units]\nlength = \"m\"\nforce = \"N\"\ntime = \"s\"\n";
    let out = ran(
        &directory("program_units"),
        &format!("{CART}{units}{}", probes.concat()),
    );
    let labels = texts(&read(out.join("history.svg")));
    let known = "time t [s] | joint coordinate [m] | joint coordinate [rad] | rate of joint coordinate [rad/s] | \
                 moment in joint [N m] | angular momentum [N m s] | acceleration [m/s²]";
    for label in known.split(" | ") {
        assert!(labels.iter().any(|l| l == label), "{label}: {labels:?}");
    }
    let labels = texts(&read(out.join("deformed.svg")));
    assert!(labels.iter().any(|l| l == "x [m]"), "{labels:?}");
    // Without their names only angles have a unit.
    let out = ran(
        &directory("program_without_units"),
        &format!("{CART}{}", probes.concat()),
    );
    let labels = texts(&read(out.join("history.svg")));
    let known = "time t | joint coordinate | joint coordinate [rad] | rate of joint coordinate";
    for label in known.split(" | ") {
        assert!(labels.iter().any(|l| l == label), "{label}: {labels:?}");
    }
}

#[test]
fn the_page_of_a_run_has_its_motion() {
    let out = ran(&directory("program_page"), CART);
    let page = read(out.join("deformed.html"));
    assert!(
        page.contains("<title>Cart &amp; &lt;pole&gt;</title>"),
        "no text of a model is markup"
    );
    let (_, rest) = page.split_once("id=\"data\">").unwrap();
    let (data, _) = rest.split_once("</script>").unwrap();
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    let frames = data["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 11);
    assert_eq!(frames[10]["t"], 0.1);
    assert_eq!(data["lines"].as_array().unwrap().len(), 0);
    // At the start the pole leans by 0.5 rad, and the centre of mass, 1 below the cart, is behind it.
    let numbers = |value: &serde_json::Value| -> Vec<f64> {
        let all = value.as_array().unwrap().iter();
        all.map(|x| x.as_f64().unwrap()).collect()
    };
    let body = data["bodies"][0].as_u64().unwrap() as usize;
    let points = numbers(&frames[0]["points"]);
    let (sine, cosine) = 0.5_f64.sin_cos();
    for (found, expected) in points[3 * body..3 * body + 3]
        .iter()
        .zip([-sine, 0.0, -cosine])
    {
        assert!((found - expected).abs() < 1e-7, "{points:?}");
    }
    let axes = numbers(&frames[0]["axes"]);
    let expected = [cosine, 0.0, -sine, 0.0, 1.0, 0.0, sine, 0.0, cosine];
    for (found, expected) in axes.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-7, "{axes:?}");
    }
}

#[test]
fn figures_are_written_in_the_formats_of_the_file() {
    let output = "[output]\nparaview_every = 0\nfigures = [\"png\", \"pdf\"]\n";
    let out = ran(&directory("program_formats"), &format!("{CART}{output}"));
    for name in ["deformed", "history"] {
        for (kind, there) in [
            ("svg", false),
            ("html", false),
            ("png", true),
            ("pdf", true),
        ] {
            assert_eq!(
                out.join(format!("{name}.{kind}")).exists(),
                there,
                "{name}.{kind}"
            );
        }
        let png = std::fs::read(out.join(format!("{name}.png"))).unwrap();
        assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
        // A width of 640 units, in the first chunk.
        assert_eq!(png[16..20], 1280_u32.to_be_bytes());
        let pdf = std::fs::read(out.join(format!("{name}.pdf"))).unwrap();
        assert!(pdf.starts_with(b"%PDF-") && pdf.trim_ascii_end().ends_with(b"%%EOF"));
        let font = b"DejaVuSans";
        assert!(
            pdf.windows(font.len()).any(|part| part == font),
            "texts are texts"
        );
    }
}
