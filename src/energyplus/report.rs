//! The report on a model. In: sections of text, tables and pictures. Out: the report as Markdown
//! and as an HTML page.

use heliotile_results::outputs::markup::escaped;

/// A part of a report.
pub enum Block {
    Text(String),
    List(Vec<String>),
    /// A table: head and rows; the first column is text, others are numbers.
    Table(Vec<String>, Vec<Vec<String>>),
    /// A picture: name of the file, and its SVG.
    Picture(String, String),
}

/// A report.
pub struct Report {
    pub title: String,
    pub sections: Vec<(String, Vec<Block>)>,
}

impl Report {
    /// Returns the report as Markdown.
    pub fn markdown(&self) -> String {
        let mut out = format!("# {}\n", self.title);
        for (heading, blocks) in &self.sections {
            out += &format!("\n## {heading}\n");
            for block in blocks {
                out.push('\n');
                match block {
                    Block::Text(text) => out += &format!("{text}\n"),
                    Block::List(items) => items.iter().for_each(|item| out += &format!("- {item}\n")),
                    Block::Picture(name, _) => out += &format!("![{name}]({name})\n"),
                    Block::Table(head, rows) => {
                        let line = |cells: &[String]| {
                            let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
                            format!("| {} |\n", cells.join(" | "))
                        };
                        out += &line(head);
                        out += &format!("| --- |{}\n", " ---: |".repeat(head.len().saturating_sub(1)));
                        rows.iter().for_each(|row| out += &line(row));
                    }
                }
            }
        }
        out
    }

    /// Returns the report as one HTML page that contains its pictures.
    pub fn html(&self) -> String {
        let mut out = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{title}</title>\n<style>\n\
             body {{ font-family: sans-serif; max-width: 64em; margin: 2em auto; padding: 0 1em; line-height: 1.5 }}\n\
             table {{ border-collapse: collapse; font-size: 85% }} th, td {{ padding: 0.15em 0.6em; border-bottom: 1px solid #ccc; \
             text-align: right }} th:first-child, td:first-child {{ text-align: left }}\n\
             figure {{ margin: 1.5em 0 }} svg {{ max-width: 100%; height: auto }}\n</style>\n</head>\n<body>\n<h1>{title}</h1>\n",
            title = escaped(&self.title)
        );
        for (heading, blocks) in &self.sections {
            out += &format!("<h2>{}</h2>\n", escaped(heading));
            for block in blocks {
                match block {
                    Block::Text(text) => out += &format!("<p>{}</p>\n", escaped(text)),
                    Block::List(items) => {
                        let items: String = items.iter().map(|item| format!("<li>{}</li>\n", escaped(item))).collect();
                        out += &format!("<ul>\n{items}</ul>\n");
                    }
                    Block::Picture(_, svg) => out += &format!("<figure>{svg}</figure>\n"),
                    Block::Table(head, rows) => {
                        let line = |cells: &[String], tag: &str| {
                            let cells: String =
                                cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell))).collect();
                            format!("<tr>{cells}</tr>\n")
                        };
                        let rows: String = rows.iter().map(|row| line(row, "td")).collect();
                        out += &format!("<table>\n{}{rows}</table>\n", line(head, "th"));
                    }
                }
            }
        }
        out + "</body>\n</html>\n"
    }

    /// Returns the pictures of the report: name and SVG.
    pub fn pictures(&self) -> impl Iterator<Item = (&str, &str)> {
        let blocks = self.sections.iter().flat_map(|(_, blocks)| blocks);
        blocks.filter_map(|block| match block {
            Block::Picture(name, svg) => Some((name.as_str(), svg.as_str())),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A name with `|` and `<` stays in 1 cell of both forms.
    #[test]
    fn cells_hold_any_name() {
        let table = Block::Table(vec!["surface".into(), "m2".into()], vec![vec!["a|b <c>".into(), "1".into()]]);
        let report = Report { title: "T".into(), sections: vec![("S".into(), vec![table])] };
        assert!(report.markdown().contains("| a\\|b <c> | 1 |\n"), "{}", report.markdown());
        assert!(report.html().contains("<tr><td>a|b &lt;c&gt;</td><td>1</td></tr>"), "{}", report.html());
    }
}
