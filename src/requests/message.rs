//! Texts of messages. In: sentences of the library, which name fields and commands, and texts of
//! users, which name nothing. Out: the words of a face.

use std::borrow::Cow;

/// Text that names fields of requests and commands; each face puts its own words in their place.
///
/// A text that is known when the program is compiled names them in braces, as in `"give {every}
/// month, or run {command:archive verify}"`, and so does [`message!`](crate::message). A text that
/// is made at run time, such as the name of a file, names nothing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Message(Box<[Piece]>);

/// Part of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Piece {
    /// Text, shown as it is.
    Text(Cow<'static, str>),
    /// Name of a field of a request.
    Field(&'static str),
    /// Command of the program as it is typed: `archive verify --deep`.
    Command(&'static str),
}

/// A name in a message, which each face replaces by its own words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Named<'a> {
    /// A field of a request.
    Field(&'a str),
    /// A command of the program as it is typed.
    Command(&'a str),
}

/// Function from a name to the user's word for it; `None` if there is none.
pub type Words<'a> = dyn Fn(Named) -> Option<String> + 'a;

impl Message {
    /// Makes a message of its parts.
    pub fn new(pieces: impl IntoIterator<Item = Piece>) -> Self {
        Message(pieces.into_iter().collect())
    }

    /// Returns true if there is nothing to say.
    pub fn is_empty(&self) -> bool {
        self.0.iter().all(|piece| matches!(piece, Piece::Text(text) if text.is_empty()))
    }

    /// Returns the message with another behind it.
    pub fn and(self, other: impl Into<Message>) -> Self {
        Message(self.0.into_iter().chain(other.into().0).collect())
    }

    /// Returns the message without white space at its end.
    pub fn trim_end(mut self) -> Self {
        if let Some(Piece::Text(text)) = self.0.last_mut() {
            *text = text.trim_end().to_owned().into();
        }
        self
    }

    /// Returns the text with the names of fields as requests have them, and commands as they are
    /// typed. There is no `Display`: names within a message that is put into another are kept by
    /// [`Message::and`].
    pub fn plain(&self) -> String {
        self.0.iter().map(Piece::plain).collect()
    }

    /// Returns true if the plain text contains another.
    pub fn contains(&self, text: &str) -> bool {
        self.plain().contains(text)
    }

    /// Returns true if the message names a field.
    pub fn names(&self, field: &str) -> bool {
        self.0.iter().any(|piece| matches!(piece, Piece::Field(name) if *name == field))
    }

    /// Returns the text with the words of a face.
    pub fn in_words(&self, words: &Words) -> String {
        let word = |piece: &Piece| match piece {
            Piece::Text(text) => text.to_string(),
            Piece::Field(name) => words(Named::Field(name)).unwrap_or_else(|| piece.plain()),
            Piece::Command(name) => words(Named::Command(name)).unwrap_or_else(|| piece.plain()),
        };
        self.0.iter().map(word).collect()
    }

    /// Returns messages one behind another, with a text between them.
    pub fn joined(messages: impl IntoIterator<Item = Message>, between: &'static str) -> Self {
        let mut all = Vec::new();
        for (number, message) in messages.into_iter().enumerate() {
            all.extend((number > 0).then(|| Piece::Text(between.into())));
            all.extend(message.0);
        }
        Message(all.into())
    }
}

impl Piece {
    fn plain(&self) -> String {
        match self {
            Piece::Text(text) => text.to_string(),
            Piece::Field(name) => (*name).to_owned(),
            Piece::Command(words) => format!("heliotile {words}"),
        }
    }
}

/// A sentence of the program: names in braces are those of fields and commands.
impl From<&'static str> for Message {
    fn from(text: &'static str) -> Self {
        let (mut pieces, mut from, mut at) = (Vec::new(), 0, 0);
        while let Some(open) = text[at..].find('{').map(|open| at + open) {
            at = open + 1;
            let Some(close) = text[at..].find('}').map(|close| at + close) else { break };
            let Some(piece) = name_of(&text[at..close]) else { continue };
            pieces.extend((from < open).then(|| Piece::Text(text[from..open].into())));
            pieces.push(piece);
            (from, at) = (close + 1, close + 1);
        }
        pieces.extend((from < text.len()).then(|| Piece::Text(text[from..].into())));
        Message(pieces.into())
    }
}

fn name_of(text: &'static str) -> Option<Piece> {
    let is_of = |text: &str, other: &[u8]| {
        !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_lowercase() || other.contains(&byte))
    };
    match text.strip_prefix("command:") {
        Some(command) => is_of(command, b" -").then_some(Piece::Command(command)),
        None => is_of(text, b"_").then_some(Piece::Field(text)),
    }
}

impl From<String> for Message {
    fn from(text: String) -> Self {
        Message([Piece::Text(text.into())].into())
    }
}

impl From<&String> for Message {
    fn from(text: &String) -> Self {
        text.clone().into()
    }
}

impl From<Cow<'static, str>> for Message {
    fn from(text: Cow<'static, str>) -> Self {
        match text {
            Cow::Borrowed(text) => text.into(),
            Cow::Owned(text) => text.into(),
        }
    }
}

impl From<&Message> for Message {
    fn from(message: &Message) -> Self {
        message.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message;

    fn typed(named: Named) -> Option<String> {
        match named {
            Named::Field("nothing") => None,
            Named::Field(field) => Some(format!("--{}", field.replace('_', "-"))),
            Named::Command(command) => Some(format!("heliotile {command}")),
        }
    }

    /// Names in two sentences of the program become the words of a face; those in a text of a user
    /// stay, as do four braces without a name.
    #[test]
    fn sentences_name_fields_and_texts_of_users_do_not() {
        let words = |message: Message| message.in_words(&typed);
        assert_eq!(words("give {min_area} 0, or {every} month".into()), "give --min-area 0, or --every month");
        assert_eq!(words("run `{command:archive verify} a.helio`".into()), "run `heliotile archive verify a.helio`");
        assert_eq!(words("{weather}.epw".to_owned().into()), "{weather}.epw");
        for text in ["found {\"a\": 1} and {", "{command:} {a:b} {}", "}{", "{A}"] {
            assert_eq!(words(text.into()), text);
        }
        assert_eq!(Message::from("a{nothing}.csv").in_words(&typed), "anothing.csv");
    }

    /// A message of four texts and three names keeps the texts of users as they are, and shows the
    /// names of requests if no face has words.
    #[test]
    fn messages_keep_texts_of_users() {
        let (file, count, share) = ("{every}.csv", 3, 0.456);
        let message = message!(
            "{file}: {} of {count:2} ({{every}} {:.1}): run {{command:archive verify --deep}} {{{{}}}} {file}",
            "{crs}",
            share
        );
        assert_eq!(
            message.in_words(&typed),
            "{every}.csv: {crs} of  3 (--every 0.5): run heliotile archive verify --deep {{}} {every}.csv"
        );
        assert_eq!(
            message.plain(),
            "{every}.csv: {crs} of  3 (every 0.5): run heliotile archive verify --deep {{}} {every}.csv"
        );
        assert!(message.names("every") && !message.names("crs") && !message.is_empty());
        assert_eq!(Message::joined([message!("{{every}}"), "b".into()], "; ").plain(), "every; b");
        assert!(Message::default().is_empty() && Message::from("").is_empty());
    }
}
