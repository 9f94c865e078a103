//! Model files with one mistake, drawn at random from those of the examples: each loads or is refused with
//! a position in the file (or for something that the file lacks), and none panics.

use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::RngSeed;
use pullback::input::{InputProblem, assemble_text};
use pullback::studies::gallery::MODELS;
use std::ops::Range;

/// A mistake; positions are counted among those of its kind in the file.
#[derive(Clone, Debug)]
enum Mistake {
    NoLine(Index),
    TwoLines(Index),
    Cut(Index),
    Number(Index, String),
    Key(Index),
}

fn mistakes() -> impl Strategy<Value = Mistake> {
    let huge = format!("\"{}\"", "long ".repeat(20_000));
    let extremes = "nan inf 0 -1 1e-300 1e100 -1e100 1e400 9223372036854775807".split(' ');
    let numbers: Vec<String> = extremes.chain([&*huge]).map(str::to_owned).collect();
    prop_oneof![
        any::<Index>().prop_map(Mistake::NoLine),
        any::<Index>().prop_map(Mistake::TwoLines),
        any::<Index>().prop_map(Mistake::Cut),
        (any::<Index>(), prop::sample::select(numbers))
            .prop_map(|(position, number)| Mistake::Number(position, number)),
        any::<Index>().prop_map(Mistake::Key),
    ]
}

/// The keys of a text, words before an equals sign, or its numbers.
fn words(text: &str, keys: bool) -> Vec<Range<usize>> {
    let part = |c: char| c.is_ascii_alphanumeric() || "+-._".contains(c);
    let mut start = 0;
    let words = text.split_inclusive(|c| !part(c)).map(|word| {
        let from = start;
        start += word.len();
        from..from + word.trim_end_matches(|c| !part(c)).len()
    });
    let is = |word: &Range<usize>| match keys {
        true => text[word.end..].trim_start_matches(' ').starts_with('='),
        false => text[word.clone()].parse::<f64>().is_ok(),
    };
    words.filter(|word| !word.is_empty() && is(word)).collect()
}

impl Mistake {
    /// The text with the mistake in it.
    fn make(&self, text: &str) -> String {
        let pick = |position: &Index, keys: bool| {
            let words = words(text, keys);
            words[position.index(words.len())].clone()
        };
        let line = |position: &Index| {
            let lines: Vec<&str> = text.split_inclusive('\n').collect();
            let k = position.index(lines.len());
            let from = lines[..k].concat().len();
            (from..from + lines[k].len(), lines[k])
        };
        let (position, new) = match self {
            Self::NoLine(position) => (line(position).0, ""),
            Self::TwoLines(position) => {
                let (Range { start, .. }, line) = line(position);
                (start..start, line)
            }
            Self::Cut(position) => {
                let mut starts = text.char_indices().map(|(k, _)| k);
                let start = starts.nth(position.index(text.chars().count()));
                (start.unwrap()..text.len(), "")
            }
            Self::Number(position, number) => (pick(position, false), number.as_str()),
            Self::Key(position) => (pick(position, true), "renamed"),
        };
        [&text[..position.start], new, &text[position.end..]].concat()
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 1500,
        rng_seed: RngSeed::Fixed(2004),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn one_mistake_never_panics_and_has_a_place(model in any::<Index>(), mistake in mistakes()) {
        let (name, text) = model.get(MODELS);
        let text = mistake.make(text);
        let Err(error) = assemble_text(name, &text) else {
            return Ok(());
        };
        // What a file lacks altogether has no position in it.
        if !matches!(*error.problem, InputProblem::Missing { .. } | InputProblem::Empty) {
            let position = error.span.clone();
            let stands = position.is_some_and(|position| text.get(position).is_some());
            prop_assert!(stands && error.line_column().is_some(), "{name}: no position for {error}");
        }
    }
}
