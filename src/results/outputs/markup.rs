//! Text for XML and HTML. In: a text. Out: the text with its markup characters escaped.

/// Escapes a text for the inside of an element of XML or HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
