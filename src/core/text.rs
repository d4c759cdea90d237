//! Words of messages.

/// A number of things: "1 tile", "2 tiles".
pub fn counted(count: u64, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

/// A sentence with a list behind it, a line each: who shows it may stop after the first line.
pub fn with_list(sentence: &str, list: impl IntoIterator<Item = String>) -> String {
    list.into_iter().fold(sentence.to_owned(), |text, item| text + "\n  " + &item)
}

/// What to do about the first line of a table that is not separated by commas, if that is why no column is found.
pub fn separator_hint(header: &str) -> Option<&'static str> {
    match (header.contains(';'), header.contains('\t')) {
        _ if header.contains(',') => None,
        (true, _) => Some(
            "separate the columns by commas in place of semicolons, and write 1.5 in place of 1,5: as spreadsheets save CSV in \
             English",
        ),
        (_, true) => Some("separate the columns by commas in place of tabs"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 5 first lines the 2 with other separators get a hint, the 3 others none.
    #[test]
    fn separators() {
        assert!(separator_hint("receiver;x;y;z").is_some_and(|hint| hint.contains("semicolons")));
        assert!(separator_hint("receiver\tx\ty").is_some_and(|hint| hint.contains("tabs")));
        for header in ["receiver,x,y", "receiver", "a;b,c"] {
            assert_eq!(separator_hint(header), None, "{header}");
        }
    }
}
