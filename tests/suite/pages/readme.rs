//! What the README shows is what the repository has.

const README: &str = include_str!("../../../README.md");

/// The fenced block that starts with the given line.
fn block(fence: &str) -> &'static str {
    let start = README.find(fence).unwrap() + fence.len() + 1;
    let end = README[start..].find("\n```").unwrap();
    &README[start..start + end]
}

#[test]
fn the_first_program_is_the_example() {
    let example = include_str!("../../../examples/first_program.rs");
    assert_eq!(block("```rust").trim(), example.trim());
    let code = example.lines().map(str::trim);
    let code = code.filter(|line| !line.is_empty() && !line.starts_with("//"));
    assert!(code.count() <= 30, "a first program is short");
}

#[test]
fn its_model_assembles() {
    assert_eq!(README.matches("```toml\n").count(), 1);
    pullback::input::assemble_text("README.md", block("```toml")).unwrap();
}

#[test]
fn every_path_that_it_names_exists() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    for part in README.split("](").skip(1) {
        let path = &part[..part.find(')').unwrap()];
        assert!(root.join(path).exists(), "{path}");
    }
}
