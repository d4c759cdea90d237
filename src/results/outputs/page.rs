//! A page for people. In: a title, words, pictures, a table as text. Out: one HTML file that needs no other.

/// The page; `words` are HTML, pictures SVG by name.
pub fn page(title: &str, words: &str, pictures: &[(&str, String)], table: &str) -> String {
    let drawn: String = pictures.iter().map(|(_, svg)| format!("<figure>{svg}</figure>\n")).collect();
    let (title, table) = (escaped(title), escaped(table));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{title}</title>\n<style>\n\
         body {{ font-family: sans-serif; max-width: 52em; margin: 2em auto; padding: 0 1em; line-height: 1.5 }}\n\
         pre {{ font-size: 85%; overflow-x: auto }} figure {{ margin: 1.5em 0 }} svg {{ max-width: 100%; height: auto }}\n\
         </style>\n</head>\n<body>\n<h1>{title}</h1>\n<p>{words}</p>\n{drawn}<pre>{table}</pre>\n</body>\n</html>\n"
    )
}

/// Text as HTML has it.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
