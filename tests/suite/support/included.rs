//! Pages that include blocks of code from source files.
//!
//! The first line of a block says where in the source it begins; it goes on to where the next one
//! begins, the last one to the end. With `UPDATE_PAGES` in the environment a test writes its page
//! anew.

use std::fs;
use std::ops::Range;
use std::path::Path;

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The page with the text of the source in the blocks of this range that begin with the fence.
fn include(page: &str, fence: &str, blocks: Range<usize>, source: &str) -> String {
    let mut parts = page.split(fence);
    let mut out = parts.next().unwrap_or_default().to_owned();
    let parts: Vec<(&str, &str)> = parts
        .map(|part| part.split_once("\n```").expect("a block ends"))
        .collect();
    let mut from = 0;
    let starts: Vec<usize> = parts[blocks.clone()]
        .iter()
        .map(|(block, _)| {
            let first = block.lines().next().unwrap_or_default();
            let line = format!("\n{first}\n");
            let at = format!("\n{source}")[from..].find(&line);
            let at =
                at.unwrap_or_else(|| panic!("a block begins with `{first}`, which is no line of the source after byte {from}"));
            from += at + 1;
            from - 1
        })
        .collect();
    for (k, (block, rest)) in parts.iter().enumerate() {
        let text = match k.checked_sub(blocks.start) {
            Some(i) if i < starts.len() => {
                let end = starts.get(i + 1).copied().unwrap_or(source.len());
                source[starts[i]..end].trim_end()
            }
            _ => block,
        };
        out += &[fence, text, "\n```", rest].concat();
    }
    out
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
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(page);
    fs::write(path, after).expect("the page can be written");
}

/// The page with pieces of the source in the blocks of this range that begin with the fence. The first
/// two and the last two lines of a block say where in the source its piece begins and ends.
fn include_pieces(page: &str, fence: &str, blocks: Range<usize>, source: &str) -> String {
    let mut parts = page.split(fence);
    let mut out = parts.next().unwrap_or_default().to_owned();
    let text = format!("\n{source}");
    for (k, part) in parts.enumerate() {
        if !blocks.contains(&k) {
            out += &[fence, part].concat();
            continue;
        }
        let (block, rest) = part.split_once("\n```").expect("a block ends");
        let lines: Vec<&str> = block.lines().collect();
        let [first, last] = [&lines[..2], &lines[lines.len() - 2..]].map(|l| l.join("\n"));
        let missing = |what: &str| format!("`{what}` is not in the source of a piece");
        let at = text.find(&format!("\n{first}\n"));
        let at = at.unwrap_or_else(|| panic!("{}", missing(&first))) + 1;
        let end = text[at..].find(&format!("\n{last}\n"));
        let end = at + end.unwrap_or_else(|| panic!("{}", missing(&last))) + 1 + last.len();
        out += &[fence, &text[at..end], "\n```", rest].concat();
    }
    out
}

/// Holds blocks of a page to the pieces of the source that they include, or writes them.
pub fn hold_pieces(page: &str, fence: &str, blocks: Range<usize>, source: &str) {
    let (before, text) = (read(page), read(source));
    let found = before.matches(fence).count();
    assert!(found >= blocks.end, "{page} has {found} blocks");
    update(
        page,
        &before,
        &include_pieces(&before, fence, blocks, &text),
    );
}

/// Holds blocks of a page to the source that they include, or writes them. All of the source has to
/// be in them where `whole` says so.
pub fn hold(page: &str, fence: &str, blocks: Range<usize>, source: &str, whole: bool) {
    let (before, text) = (read(page), read(source));
    let found = before.matches(fence).count();
    assert!(found >= blocks.end, "{page} has {found} blocks");
    let after = include(&before, fence, blocks.clone(), &text);
    update(page, &before, &after);
    let first = after.split(fence).nth(blocks.start + 1);
    let line = first.and_then(|b| b.lines().next()).unwrap_or_default();
    assert!(
        !whole || text.starts_with(line),
        "{page} begins after {source}"
    );
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
