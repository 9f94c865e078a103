//! Writer of a page: the same headings, paragraphs, tables and figures in HTML and in Markdown.

use super::super::figures::Figure;
use super::escaped;

/// Format of a page. Text inside paragraphs and cells is that of HTML in both, which
/// Markdown accepts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::studies::compare) enum Format {
    /// One file with embedded figures.
    Html,
    /// Tables with bars; figures by file name.
    Markdown,
}

/// A page.
pub(super) struct Page {
    format: Format,
    text: String,
}

impl Page {
    pub(super) fn new(format: Format) -> Self {
        Self {
            format,
            text: String::new(),
        }
    }

    pub(super) fn is_html(&self) -> bool {
        self.format == Format::Html
    }

    pub(super) fn into_text(self) -> String {
        match self.format {
            Format::Html => self.text,
            // Ends with a single line break.
            Format::Markdown => self.text.trim_end().to_owned() + "\n",
        }
    }

    /// Appends a line as it is.
    pub(super) fn put(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    pub(super) fn heading(&mut self, level: usize, class: &str, text: &str) {
        match self.format {
            Format::Html => self.put(&format!("<h{level}{}>{text}</h{level}>", of(class))),
            Format::Markdown => self.put(&format!("{} {text}\n", "#".repeat(level))),
        }
    }

    pub(super) fn paragraph(&mut self, class: &str, text: &str) {
        match self.format {
            Format::Html => self.put(&format!("<p{}>{text}</p>", of(class))),
            Format::Markdown => self.put(&format!("{}\n", text.trim())),
        }
    }

    /// A command line.
    pub(super) fn command(&mut self, command: &str) {
        match self.format {
            Format::Html => {
                let code = format!("<code>{}</code>", escaped(command));
                self.paragraph("command", &code);
            }
            Format::Markdown => self.put(&format!("```sh\n{command}\n```\n")),
        }
    }

    pub(super) fn list(&mut self, items: &[String]) {
        match self.format {
            Format::Html => {
                let items = items.iter().map(|item| format!("<li>{item}</li>\n"));
                self.put(&format!("<ul>\n{}</ul>", items.collect::<String>()));
            }
            Format::Markdown => self.put(&format!("- {}\n", items.join("\n- "))),
        }
    }

    pub(super) fn figure(&mut self, figure: &Figure) {
        let Figure {
            name, caption, svg, ..
        } = figure;
        match self.format {
            Format::Html => {
                let svg = inline(svg);
                let caption = format!("<figcaption>{caption}</figcaption>");
                self.put(&format!("<figure>\n{svg}\n{caption}\n</figure>"));
            }
            Format::Markdown => {
                let alternative = name.trim_end_matches(".svg");
                self.put(&format!("![{alternative}]({name})\n\n{caption}\n"));
            }
        }
    }

    /// The head of a table: a caption and names of columns, the first `words` of them text.
    pub(super) fn table(&mut self, caption: &str, columns: &[&str], words: usize) {
        if !caption.is_empty() {
            self.paragraph("caption", caption);
        }
        match self.format {
            Format::Html => {
                let head = cells("th", words, columns);
                self.put(&format!("<table>\n<thead><tr>{head}</tr></thead>\n<tbody>"));
            }
            Format::Markdown => {
                self.row(false, words, columns);
                let sides = (0..columns.len()).map(|k| if k < words { " :-- |" } else { " --: |" });
                self.put(&format!("|{}", sides.collect::<String>()));
            }
        }
    }

    /// A row of a table, the first cells text; `next` at the start of a group.
    pub(super) fn row(&mut self, next: bool, words: usize, row: &[impl AsRef<str>]) {
        match self.format {
            Format::Html => {
                let class = of(if next { "next" } else { "" });
                self.put(&format!("<tr{class}>{}</tr>", cells("td", words, row)));
            }
            Format::Markdown => {
                let cell = |cell: &_| {
                    let line = AsRef::<str>::as_ref(cell)
                        .replace('|', "\\|")
                        .replace('\n', "<br/>");
                    format!(" {line} |")
                };
                self.put(&format!("|{}", row.iter().map(cell).collect::<String>()));
            }
        }
    }

    pub(super) fn end_table(&mut self) {
        let end = if self.is_html() {
            "</tbody>\n</table>"
        } else {
            ""
        };
        self.put(end);
    }
}

/// A class as an attribute.
fn of(class: &str) -> String {
    match class.is_empty() {
        true => String::new(),
        false => format!(" class=\"{class}\""),
    }
}

fn cells(tag: &str, words: usize, cells: &[impl AsRef<str>]) -> String {
    let cells = cells.iter().enumerate().map(|(k, cell)| {
        let class = of(if k < words { "l" } else { "" });
        format!("<{tag}{class}>{}</{tag}>", cell.as_ref())
    });
    cells.collect()
}

/// A figure to embed in a page: without its declaration.
fn inline(svg: &str) -> &str {
    let start = svg.find("<svg");
    start.map_or(svg, |start| svg[start..].trim_end())
}
