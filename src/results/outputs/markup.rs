//! Words in XML and HTML. In: a text. Out: the same where it cannot be taken for markup.

/// Text inside an element of XML or HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
