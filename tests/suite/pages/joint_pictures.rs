//! Every joint has a picture on its page, and every picture is used.

use super::theory::text;
use crate::support::program::{assert_says, read, repository};

#[test]
fn the_page_shows_every_picture() {
    let page = read(repository("docs/joints.md"));
    let sources = text(&repository("elements/src/joint"));
    let mut pictures = 0;
    for entry in std::fs::read_dir(repository("elements/images")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "svg") {
            continue;
        }
        pictures += 1;
        let name = path.file_stem().unwrap().to_str().unwrap();
        assert_says(&page, &[&format!("![](../elements/images/{name}.svg)")]);
        let named = page.contains(&format!("`{name}`"));
        assert!(named || name == "offset", "{name}");
        let text = read(&path);
        // The documentation of the library has it as it is: an HTML block ends at an empty line.
        assert!(!text.contains("\n\n"), "{name}");
        roxmltree::Document::parse(&text).unwrap();
        let shown = sources.contains(&format!("images/{name}.svg"));
        assert!(shown, "{name} is not in the documentation of the library");
    }
    assert_eq!(page.matches("![](").count(), pictures);
}
