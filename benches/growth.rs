//! The program from the model file to its results: seconds for each element and iteration, in statics
//! and in motion, of 1,000, 10,000 and 100,000 elements.
//!
//! `cargo bench --bench growth` prints the table; a column that stays the same is a program that is
//! linear in the size of its models.

#![allow(missing_docs)]

use std::error::Error;
use std::process::Command;
use std::time::Instant;

/// Analyses, and the steps that they take.
const ANALYSES: [(&str, &str); 2] = [
    ("statics", "static = { steps = 5 }"),
    ("dynamics", "dynamic = { to = 5e-4, step = 1e-4 }"),
];

/// A rod that is attached to a hinge, under its weight.
fn model(elements: usize, analysis: &str) -> String {
    format!(
        r#"
        [sections]
        s = {{ stiffness = {{ EA = 1e4, GA = [5e3, 4e3], GJ = 700, EI = [800, 900] }}, mass = {{ A_rho = 1, J = [0.02, 0.01, 0.01] }} }}
        [nodes]
        g = [0, 0, 0]
        t = [1, 0, 0]
        [[joints]]
        name = "j"
        type = "revolute"
        parent = "g"
        axis = [0, 1, 0]
        spring = {{ k = 100 }}
        [[lines]]
        name = "rod"
        from = "j"
        to = "t"
        elements = {elements}
        section = "s"
        [[supports]]
        node = "g"
        fix = "all"
        [[loads]]
        gravity = [0, 0, -9.81]
        [analysis]
        {analysis}
        "#
    )
}

/// Seconds of a run, and its iterations.
fn run(elements: usize, analysis: &str) -> Result<(f64, f64), Box<dyn Error>> {
    let directory = std::env::temp_dir().join(format!("pullback-growth-{}", std::process::id()));
    std::fs::create_dir_all(&directory)?;
    let file = directory.join("model.toml");
    std::fs::write(&file, model(elements, analysis))?;
    let start = Instant::now();
    let output = Command::new(env!("CARGO_BIN_EXE_pullback"))
        .arg("run")
        .arg(&file)
        .output()?;
    let seconds = start.elapsed().as_secs_f64();
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into());
    }
    let text = std::fs::read_to_string(directory.join("model.out/result.json"))?;
    let result: serde_json::Value = serde_json::from_str(&text)?;
    std::fs::remove_dir_all(&directory)?;
    let iterations = result["statistics"]["iterations"].as_f64();
    Ok((seconds, iterations.ok_or("a run has iterations")?))
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("analysis   elements   seconds   iterations   us per element and iteration");
    for (name, analysis) in ANALYSES {
        for elements in [1_000, 10_000, 100_000] {
            let (seconds, iterations) = run(elements, analysis)?;
            let each = 1e6 * seconds / (elements as f64 * iterations);
            println!("{name:9}  {elements:8}  {seconds:8.2}  {iterations:11}  {each:8.2}");
        }
    }
    Ok(())
}
