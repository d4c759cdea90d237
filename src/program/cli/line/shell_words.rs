//! Quoting for shells. In: words of a command line. Out: the words quoted so that a shell takes
//! them when they are pasted.

/// Quotes a word for a shell, if it needs quotes.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,+%@".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 plain words stay, 3 others get quotes that a shell removes again.
    #[test]
    fn words_with_spaces_are_quoted() {
        for word in ["--output=a/b.helio", "5%"] {
            assert_eq!(quoted(word), word);
        }
        for (word, expected) in [("", "''"), ("my town.obj", "'my town.obj'"), ("it's", r"'it'\''s'")] {
            assert_eq!(quoted(word), expected);
        }
    }
}
