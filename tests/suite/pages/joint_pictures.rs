//! Every joint has a picture on its page, and every picture is used.
#![allow(clippy::unwrap_used)]

use std::path::Path;

#[test]
fn the_page_shows_every_picture() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/joints.md")).unwrap();
    let mut pictures = 0;
    for entry in std::fs::read_dir(root.join("elements/images")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "svg") {
            continue;
        }
        pictures += 1;
        let name = path.file_stem().unwrap().to_str().unwrap();
        assert!(
            page.contains(&format!("![](../elements/images/{name}.svg)")),
            "{name}"
        );
        assert!(
            page.contains(&format!("`{name}`")) || name == "offset",
            "{name}"
        );
        let text = std::fs::read_to_string(&path).unwrap();
        // The documentation of the library has it as it is: an HTML block ends at an empty line.
        assert!(!text.contains("\n\n"), "{name}");
        roxmltree::Document::parse(&text).unwrap();
        let source = root.join("elements/src/joint");
        let files = std::fs::read_dir(source).unwrap();
        let mut files = files.map(|file| file.unwrap().path());
        let shown = files.any(|file| {
            let text = std::fs::read_to_string(file).unwrap_or_default();
            text.contains(&format!("images/{name}.svg"))
        });
        assert!(shown, "{name} is not in the documentation of the library");
    }
    assert_eq!(page.matches("![](").count(), pictures);
}
