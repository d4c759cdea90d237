//! Words of messages.

/// A number of things: "1 tile", "2 tiles".
pub fn counted(count: u64, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}
