//! Pages that include blocks of code from source files.
//!
//! The first line of a block says where in the source it begins; it goes on to where the next one
//! begins, the last one to the end. With `UPDATE_PAGES` in the environment a test writes its page
//! anew.

use super::program::{read, repository};
use std::ops::Range;

/// The blocks of a page that begin with the fence.
pub fn blocks<'a>(page: &'a str, fence: &str) -> Vec<&'a str> {
    let parts = page.split(fence).skip(1);
    parts
        .map(|part| part.split_once("\n```").expect("a block ends").0)
        .collect()
}

/// The page with other texts in its blocks.
fn replaced(page: &str, fence: &str, texts: &[&str]) -> String {
    let mut parts = page.split(fence);
    let mut out = parts.next().unwrap_or_default().to_owned();
    for (part, text) in parts.zip(texts) {
        let (_, rest) = part.split_once("\n```").expect("a block ends");
        out += &[fence, text, "\n```", rest].concat();
    }
    out
}

/// Where lines stand in a source after a position.
fn find(source: &str, from: usize, lines: &str) -> usize {
    let at = format!("\n{source}\n")[from..].find(&format!("\n{lines}\n"));
    from + at.unwrap_or_else(|| panic!("`{lines}` is not in the source after byte {from}"))
}

/// The page with the text of the source in the blocks of this range that begin with the fence.
fn include(page: &str, fence: &str, range: Range<usize>, source: &str) -> String {
    let mut texts = blocks(page, fence);
    let mut ends = Vec::new();
    for block in &texts[range.clone()] {
        let from = ends.last().map_or(0, |at| at + 1);
        ends.push(find(source, from, block.lines().next().unwrap_or_default()));
    }
    ends.push(source.len());
    for (text, ends) in texts[range].iter_mut().zip(ends.windows(2)) {
        *text = source[ends[0]..ends[1]].trim_end();
    }
    replaced(page, fence, &texts)
}

/// Fails where the text of a page is not what it has to be, or writes it.
pub fn update(page: &str, before: &str, after: &str) {
    if before == after {
        return;
    }
    let update = std::env::var_os("UPDATE_PAGES").is_some();
    assert!(
        update,
        "{page} is not up to date: UPDATE_PAGES=1 cargo test writes it anew"
    );
    std::fs::write(repository(page), after).expect("the page can be written");
}

/// The page with pieces of the source in the blocks of this range that begin with the fence. The first
/// two and the last two lines of a block say where in the source its piece begins and ends.
fn include_pieces(page: &str, fence: &str, range: Range<usize>, source: &str) -> String {
    let mut texts = blocks(page, fence);
    for text in &mut texts[range] {
        let lines: Vec<&str> = text.lines().collect();
        let [first, last] = [&lines[..2], &lines[lines.len() - 2..]].map(|l| l.join("\n"));
        let at = find(source, 0, &first);
        *text = &source[at..find(source, at, &last) + last.len()];
    }
    replaced(page, fence, &texts)
}

/// Holds blocks of a page to the pieces of the source that they include, or writes them.
pub fn hold_pieces(page: &str, fence: &str, range: Range<usize>, source: &str) {
    let before = read(repository(page));
    let after = include_pieces(&before, fence, range, &read(repository(source)));
    update(page, &before, &after);
}

/// Holds blocks of a page to the source that they include, or writes them. All of the source has to
/// be in them where `whole` says so.
pub fn hold(page: &str, fence: &str, range: Range<usize>, source: &str, whole: bool) {
    let [before, text] = [page, source].map(|path| read(repository(path)));
    let first = range.start;
    let after = include(&before, fence, range, &text);
    update(page, &before, &after);
    let line = blocks(&after, fence)[first].lines().next();
    let from_start = text.starts_with(line.unwrap_or_default());
    assert!(!whole || from_start, "{page} begins after {source}");
}

#[test]
fn blocks_take_their_text_from_the_source() {
    let page = "# A\n```rust\none\nold\n```\nwords\n```rust\ntwo\n```\n```rust\nother\n```\n";
    let source = "one\nnew\n\ntwo\nmore\n";
    let made = include(page, "```rust\n", 0..2, source);
    let right =
        "# A\n```rust\none\nnew\n```\nwords\n```rust\ntwo\nmore\n```\n```rust\nother\n```\n";
    assert_eq!(made, right);
}

#[test]
fn pieces_end_where_their_last_lines_say() {
    let page = "```rust\none\ntwo\nold\nfour\n}\n```\nwords\n";
    let source = "zero\none\ntwo\nnew\nfour\n}\nsix\n}\n";
    let made = include_pieces(page, "```rust\n", 0..1, source);
    assert_eq!(made, "```rust\none\ntwo\nnew\nfour\n}\n```\nwords\n");
}
