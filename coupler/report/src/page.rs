//! The page: sections of words, tables and pictures in one self-contained file.

use std::fmt::Write as _;

use draw::colour;
use draw::picture::Picture;
use draw::svg::escape;

/// A part of the page.
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// Its title.
    pub title: String,
    /// HTML below the title: paragraphs and tables, already escaped.
    pub text: String,
    /// Pictures of full width.
    pub maps: Vec<Picture>,
    /// Pictures in two columns.
    pub plots: Vec<Picture>,
}

impl Section {
    /// A section of text.
    pub fn of_text(title: &str, text: String) -> Section {
        Section {
            title: title.into(),
            text,
            ..Section::default()
        }
    }

    /// A section of pictures.
    pub fn of_pictures(title: &str, maps: Vec<Picture>, plots: Vec<Picture>) -> Section {
        Section {
            maps,
            plots,
            ..Section::of_text(title, String::new())
        }
    }

    /// True if there is nothing to show.
    pub(super) fn is_empty(&self) -> bool {
        self.text.is_empty() && self.maps.is_empty() && self.plots.is_empty()
    }

    pub(super) fn pictures(&self) -> impl Iterator<Item = &Picture> {
        self.maps.iter().chain(&self.plots)
    }

    /// HTML of the section; its pictures are numbered from `figures` + 1 on.
    fn html(&self, number: usize, figures: &mut usize) -> String {
        let mut figure = |picture: &Picture| {
            *figures += 1;
            figure(*figures, picture)
        };
        let title = escape(&self.title);
        let mut html = format!("<section id=\"s{number}\"><h2>{title}</h2>{}", self.text);
        html.extend(self.maps.iter().map(&mut figure));
        if !self.plots.is_empty() {
            let plots = self.plots.iter().map(&mut figure).collect::<String>();
            html += &format!("<div class=\"plots\">{plots}</div>");
        }
        html + "</section>"
    }
}

/// Style of the page on a screen and on paper.
const STYLE: &str = "
body{font:15px/1.45 sans-serif;color:#222;max-width:1100px;margin:24px auto;padding:0 24px;background:#fff}
h1{margin:0 0 4px;font-size:26px}
h2{margin:34px 0 8px;font-size:19px;border-bottom:1px solid #bbb;padding-bottom:3px}
h3{margin:18px 0 4px;font-size:15px}
nav{margin:10px 0}nav a{margin-right:14px;color:#12355b}
.verdict{border:2px solid;border-left-width:10px;padding:8px 14px;margin:12px 0}
.verdict p{margin:4px 0}
.completed{border-color:#3c8c6e}.suspect{border-color:#e27d1e}.failed{border-color:#a42645}
table{border-collapse:collapse;margin:6px 0}
th,td{text-align:left;vertical-align:top;padding:3px 18px 3px 0;border-bottom:1px solid #e4e4e4}
td.n{text-align:right;white-space:nowrap;font-variant-numeric:tabular-nums}
th{font-weight:600;border-bottom-color:#999}
code{font:13px monospace;overflow-wrap:anywhere}
td:last-child>code:only-child{white-space:nowrap}
pre{background:#f4f4f4;padding:8px 10px;overflow-x:auto;white-space:pre-wrap}
figure{margin:14px 0}figcaption{font-size:13.5px;margin-top:2px}
svg{max-width:100%;height:auto}
.plots{display:grid;grid-template-columns:1fr 1fr;gap:4px 20px}
@media screen and (max-width:800px){.plots{display:block}}
@page{size:A4;margin:14mm}
@media print{body{margin:0;max-width:none;padding:0;font-size:10pt}h3{font-size:10pt}h2{margin-top:22px}code,figcaption{font-size:8.5pt}nav{display:none}figure,tr,.verdict{break-inside:avoid}h2,h3{break-after:avoid}}
";

/// The whole page.
pub fn page(title: &str, head: &str, sections: &[Section]) -> String {
    let (mut links, mut body, mut figures) = (String::new(), String::new(), 0);
    for (number, section) in sections.iter().enumerate() {
        let title = escape(&section.title);
        let _ = write!(links, "<a href=\"#s{number}\">{title}</a>");
        body += &section.html(number, &mut figures);
    }
    let title = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\"><link rel=\"icon\" href=\"data:,\"><title>{title}</title><style>{STYLE}</style></head><body><main><h1>{title}</h1>{head}<nav aria-label=\"sections\">{links}</nav>{body}</main></body></html>\n"
    )
}

/// A picture with its caption; the drawing contains the text alternative.
fn figure(number: usize, picture: &Picture) -> String {
    let (svg, caption) = (accessible(picture), names(&escape(&picture.caption)));
    format!("<figure>{svg}<figcaption>Figure {number}: {caption}</figcaption></figure>")
}

/// Escaped text with names between backticks set as code.
pub fn names(text: &str) -> String {
    let parts = text.split('`').enumerate();
    let parts = parts.map(|(number, part)| match number % 2 {
        0 => part.to_string(),
        _ => format!("<code>{part}</code>"),
    });
    parts.collect()
}

/// The drawing with its name and description for screen readers.
pub(super) fn accessible(picture: &Picture) -> String {
    let (caption, alternative) = (escape(&picture.caption), escape(&picture.alternative));
    let described = format!("<svg role=\"img\" aria-label=\"{caption} {alternative}\" ");
    let svg = colour::owned(&picture.svg, &picture.file);
    let parts = svg
        .split_once("<svg ")
        .and_then(|(_, rest)| rest.split_once('>'));
    let Some((attributes, inside)) = parts else {
        return svg;
    };
    format!("{described}{attributes}><title>{caption}</title><desc>{alternative}</desc>{inside}")
}

/// A table: its head, and rows of cells that are escaped already. Columns in `numbers` are right-aligned. Empty without rows.
pub fn table<'a>(
    head: impl AsRef<[&'a str]>,
    numbers: &[usize],
    rows: impl IntoIterator<Item: AsRef<[String]>>,
) -> String {
    let cell = |(column, text): (usize, &String)| {
        if numbers.contains(&column) {
            format!("<td class=\"n\">{text}</td>")
        } else {
            format!("<td>{text}</td>")
        }
    };
    let row = |row: &[String]| {
        let cells: String = row.iter().enumerate().map(cell).collect();
        format!("<tr>{cells}</tr>")
    };
    let head = head.as_ref().iter();
    let head: String = head.map(|text| format!("<th>{text}</th>")).collect();
    let rows: String = rows.into_iter().map(|of| row(of.as_ref())).collect();
    if rows.is_empty() {
        String::new()
    } else {
        format!("<table><tr>{head}</tr>{rows}</table>")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_picture_has_a_text_alternative_and_no_name_is_markup() {
        let picture = Picture {
            file: "a.svg".into(),
            caption: "Force on `<b>`".into(),
            alternative: "from 1 to \"2\"".into(),
            svg: "<svg width=\"3\"><path/></svg>".into(),
        };
        let section = Section {
            plots: vec![picture],
            ..Section::of_text("<script>alert(1)</script>", String::new())
        };
        let html = page("</title><script>", "", &[section]);
        assert!(
            !html.contains("<script>") && !html.contains("<b>"),
            "{html}"
        );
        assert!(html.contains("<figcaption>Figure 1: Force on"), "{html}");
        assert!(html.contains("<svg role=\"img\" aria-label=\"Force on `&lt;b&gt;` from 1 to &quot;2&quot;\" width=\"3\"><title>"));
    }
}
