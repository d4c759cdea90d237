//! Texts of messages. In: numbers, names and places. Out: the words of a message, without secrets.

pub use heliotile_requests::{Message, Named, Words, message};

/// Returns a number of things in words: "1 tile", "2 tiles".
pub fn counted(count: u64, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

/// Returns the first `most` characters of a text on one line, followed by `...` if the text is
/// longer: for messages.
pub fn excerpt(text: &str, most: usize) -> String {
    let shown: String = text.chars().take(most).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(most).is_some() { shown + "..." } else { shown }
}

/// Returns names with commas between them, followed by `...` if they are fewer than `count`.
pub fn listed(names: impl IntoIterator<Item: AsRef<str>>, count: usize) -> String {
    let names: Vec<_> = names.into_iter().collect();
    let texts: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    texts.join(", ") + if count > texts.len() { ", ..." } else { "" }
}

/// Number of items, the first `MOST` of them by name.
#[derive(Clone, Debug, Default)]
pub struct FirstNames<const MOST: usize> {
    /// Number of items.
    pub count: u64,
    /// Names of the first few.
    pub first: Vec<String>,
}

impl<const MOST: usize> FirstNames<MOST> {
    /// Counts an item.
    pub fn add(&mut self, name: impl FnOnce() -> String) {
        self.count += 1;
        if self.first.len() < MOST {
            self.first.push(name());
        }
    }

    /// Returns the first names, followed by `...` if there are more items.
    pub fn listed(&self) -> String {
        listed(&self.first, self.count as usize)
    }
}

/// Returns true if a place is an address, such as `s3://bucket/site.helio`, and not a path.
pub fn is_address(place: &str) -> bool {
    place.split_once("://").is_some_and(|(scheme, _)| {
        // A drive of Windows has one letter.
        scheme.len() > 1 && scheme.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte))
    })
}

/// Returns a place as messages, tables and pages name it. An address loses its user and password,
/// and everything behind `?` or `#`, which may be a signature.
pub fn without_secrets(place: &str) -> String {
    let Some((scheme, rest)) = place.split_once("://").filter(|_| is_address(place)) else { return place.to_owned() };
    let rest = rest.split(['?', '#']).next().unwrap_or_default();
    // Some parsers of addresses skip slashes where a host is missing.
    let slashes = rest.len() - rest.trim_start_matches('/').len();
    let host_at = if scheme.eq_ignore_ascii_case("file") { 0 } else { slashes };
    let (host, path) =
        rest[host_at..].find('/').map_or((&rest[host_at..], ""), |slash| rest[host_at..].split_at(slash));
    // Azure puts the container where other addresses have the user: `az://container@account`.
    let is_container = scheme.eq_ignore_ascii_case("az") && !host.contains(':');
    let user_and_host = host.rsplit_once('@').filter(|_| !is_container);
    let host = user_and_host.map_or(host, |(_, host)| host);
    format!("{scheme}://{host}{path}")
}

/// Returns a sentence followed by a list, one item a line. A program may show the first line only.
pub fn with_list(sentence: impl Into<Message>, list: impl IntoIterator<Item = String>) -> Message {
    list.into_iter().fold(sentence.into(), |text, item| text.and(format!("\n  {item}")))
}

/// Returns advice for the header of a table that is not separated by commas; `None` if it is.
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

    /// A text of 5 characters is shown whole at 5 and cut at 4; a line break becomes a blank.
    #[test]
    fn long_texts_are_cut_and_lines_joined() {
        assert_eq!((excerpt("ab\u{e9}\nd", 5), excerpt("abcde", 4)), ("ab\u{e9} d".into(), "abcd...".into()));
    }

    /// Five addresses and 4 paths are told apart. Nine places lose user, password and signature.
    #[test]
    fn addresses_lose_their_secrets() {
        for address in ["s3://b/a.helio", "gs://b/a", "az://c@account/a", "https://h/a", "abfs+x://c/a"] {
            assert!(is_address(address), "{address}");
        }
        for path in ["a.helio", "c://a.helio", "a b://c", "folder/s3:/a"] {
            assert!(!is_address(path), "{path}");
        }
        for (place, named) in [
            ("https://me:secret@host:80/a.helio?X-Amz-Signature=ab#c", "https://host:80/a.helio"),
            ("https://host?sig=ab", "https://host"),
            ("http://a@b@host/x@y", "http://host/x@y"),
            ("HTTPS://me:secret@host/a", "HTTPS://host/a"),
            ("https:///me:secret@host/a", "https://host/a"),
            ("s3://KEY:SECRET@bucket/a", "s3://bucket/a"),
            ("s3://bucket/a.helio?versionId=1", "s3://bucket/a.helio"),
            ("az://container@account/a", "az://container@account/a"),
            ("what?.helio", "what?.helio"),
        ] {
            assert_eq!(without_secrets(place), named);
        }
    }

    /// Two of 5 header lines, those with other separators, get a hint, the 3 others none.
    #[test]
    fn headers_with_other_separators_get_a_hint() {
        assert!(separator_hint("receiver;x;y;z").is_some_and(|hint| hint.contains("semicolons")));
        assert!(separator_hint("receiver\tx\ty").is_some_and(|hint| hint.contains("tabs")));
        for header in ["receiver,x,y", "receiver", "a;b,c"] {
            assert_eq!(separator_hint(header), None, "{header}");
        }
    }
}
