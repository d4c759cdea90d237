//! In: words of a command line. Out: the same as a shell takes them, to be pasted.

/// A word as a shell takes it.
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

    /// 2 plain words stay, 3 others get quotes that a shell takes off again.
    #[test]
    fn words_of_a_shell() {
        for word in ["--output=a/b.helio", "5%"] {
            assert_eq!(quoted(word), word);
        }
        for (word, expected) in [("", "''"), ("my town.obj", "'my town.obj'"), ("it's", r"'it'\''s'")] {
            assert_eq!(quoted(word), expected);
        }
    }
}
