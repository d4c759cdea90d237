//! Failures of requests for objects. In: the answer of a store. Out: the finding and a remedy,
//! without the address, which may hold a signature, and without the text of the answer, which may
//! hold more.

use std::error::Error as _;

use heliotile_core::error::Error;
use heliotile_core::text::Message;

use crate::stores::address::{Address, Scheme};

/// Reason why an object could not be read or written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// Kind of failure, for callers that can react to it.
    pub cause: Cause,
    /// Finding, in words that follow the address in a message.
    pub what: String,
}

/// Kinds of failures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Cause {
    /// No such object or bucket exists.
    Missing,
    /// An object exists where none may be.
    Exists,
    /// The object is another version than before.
    Changed,
    /// Credentials are missing, wrong or not enough.
    Denied,
    /// The store refuses the signature's time: this machine's clock differs from the store's.
    Clock,
    /// The server's certificate is not trusted.
    Untrusted,
    /// The server sends whole objects only.
    NoRanges,
    /// The answer ended too early or came too late; the next one may be good.
    Passing,
    /// The server gave no answer, or an error that stays after retries.
    Unreached,
    /// An environment variable gives the store an invalid setting.
    Settings,
    /// The server redirects again and again.
    Elsewhere,
    /// The server answers anything else.
    Refused,
}

impl Failure {
    /// Returns a failure with its cause and its words.
    pub fn new(cause: Cause, what: impl Into<String>) -> Self {
        Failure { cause, what: what.into() }
    }

    /// Returns the failure that a store's answer means.
    pub fn from_store(error: &object_store::Error) -> Self {
        use object_store::Error as Answer;
        let found = Found::from_store(error);
        let code = found.code.as_ref().map_or(String::new(), |code| format!(", {code}"));
        match error {
            // A wrong clock is answered like denied access, so it is checked first.
            _ if found.clock_is_off => {
                let clock = found.server_time.map_or(String::new(), |time| format!(", the store's clock says {time}"));
                let status = found.status.unwrap_or(403);
                Failure::new(Cause::Clock, format!("this machine's clock is off{clock} ({status}{code})"))
            }
            _ if found.code.as_deref() == Some("NoSuchBucket") => {
                Failure::new(Cause::Missing, "is in a bucket that does not exist (404, NoSuchBucket)")
            }
            Answer::NotFound { .. } => Failure::new(Cause::Missing, "is not there (404)"),
            Answer::AlreadyExists { .. } => Failure::new(Cause::Exists, "is there already"),
            Answer::Precondition { .. } | Answer::NotModified { .. } => {
                Failure::new(Cause::Changed, "the store holds another version (412)")
            }
            Answer::PermissionDenied { .. } => Failure::new(Cause::Denied, format!("access is denied (403{code})")),
            Answer::Unauthenticated { .. } => Failure::new(Cause::Denied, format!("requires credentials (401{code})")),
            Answer::NotSupported { .. } => Failure::new(Cause::NoRanges, "its server does not support byte ranges"),
            Answer::NotImplemented { .. } => {
                Failure::new(Cause::Refused, "its store does not support conditional writes")
            }
            _ => found.failure(),
        }
    }

    /// Returns the failure of a client that cannot be built from its settings.
    pub fn of_settings(error: &object_store::Error) -> Self {
        Failure::new(Cause::Settings, format!("its store has invalid settings: {}", Found::from_store(error).text))
    }

    /// Returns true if the only problem is that no object has this name.
    pub fn is_absence(&self) -> bool {
        self.cause == Cause::Missing && !self.what.contains("bucket")
    }

    /// Returns true if the object is absent or may be: S3 answers "denied" for an absent object to
    /// users who may not list the bucket.
    pub fn may_be_absence(&self) -> bool {
        self.is_absence() || self.cause == Cause::Denied
    }

    /// Returns the error for a user, with the address and a hint.
    pub fn at(self, address: &Address) -> Error {
        let path = address.shown();
        let variables = match address.scheme() {
            Scheme::S3 => {
                "AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and AWS_REGION (profiles are not read: `aws configure \
                 export-credentials --format env`), or AWS_SKIP_SIGNATURE=true for a public bucket"
            }
            Scheme::Google => "GOOGLE_APPLICATION_CREDENTIALS, or GOOGLE_SKIP_SIGNATURE=true for a public bucket",
            Scheme::Azure => "AZURE_STORAGE_ACCOUNT_NAME and AZURE_STORAGE_ACCOUNT_KEY or AZURE_STORAGE_SAS_TOKEN",
            Scheme::Web => "a signed address that is still valid, or https://USER:PASSWORD@HOST/NAME",
        };
        let hint: Message = match self.cause {
            Cause::Changed => return Error::SourceChanged { path: path.to_path_buf(), what: self.what },
            Cause::Missing if address.name().contains('.') => "is the address right? capitals count".into(),
            Cause::Missing => {
                "is the address right? capitals count; the address of an atlas is the folder of its atlas.json".into()
            }
            Cause::Exists => "give it another name, or replace it with {replace}".into(),
            Cause::Denied | Cause::Settings => format!("check the settings and credentials: {variables}").into(),
            Cause::Elsewhere if address.scheme() == Scheme::S3 => "is AWS_REGION the region of the bucket?".into(),
            Cause::Elsewhere => "open the address in a browser: it may have moved, or require a login".into(),
            Cause::Clock => "set the clock of this machine: stores accept signatures of the last 15 minutes only".into(),
            Cause::Untrusted => {
                "is the host's name right, and this machine's date? for a certificate authority of your own, set SSL_CERT_FILE to the \
                 file of its certificates"
                    .into()
            }
            Cause::NoRanges => "use a server with byte ranges, or fetch the file and open it from disk".into(),
            Cause::Passing | Cause::Unreached => {
                "is the network there? try again; HELIOTILE_TIMEOUT=300 waits 300 s for each answer".into()
            }
            Cause::Refused => "try again later, or ask who runs the server".into(),
        };
        Error::input(path, None, self.what, hint)
    }
}

/// Phrases with which S3, Azure and Google's token servers report that a signature's time is too
/// far from the server's clock.
const OF_CLOCKS: [&str; 3] = ["RequestTimeTooSkewed", "Request date header too old", "in a reasonable timeframe"];

/// Details in the chain of causes of an error.
struct Found {
    /// The innermost cause, in one line.
    text: String,
    /// HTTP status.
    status: Option<u16>,
    /// `<Code>` that S3, Azure and Google send.
    code: Option<String>,
    /// True if a signature was refused for its time.
    clock_is_off: bool,
    /// `<ServerTime>` that S3 sends.
    server_time: Option<String>,
    /// True if the error arose while credentials were fetched.
    of_credentials: bool,
}

impl Found {
    fn from_store(error: &object_store::Error) -> Self {
        let (mut inner, mut of_credentials) = (error.source(), false);
        let mut text = String::new();
        while let Some(cause) = inner {
            text = cause.to_string();
            let own = |word: &&str| {
                !word.contains("://") || word.contains("169.254.169.254") || word.contains("metadata.google")
            };
            let lower = text.split_whitespace().filter(own).collect::<Vec<_>>().join(" ").to_lowercase();
            of_credentials |= ["169.254.169.254", "metadata.google", "credential", "msi/token"]
                .iter()
                .any(|word| lower.contains(word));
            inner = cause.source();
        }
        let after = |mark: &str| text.split_once(mark).map(|(_, rest)| rest);
        let status = after("status code: ").and_then(|rest| rest.get(..3)?.parse().ok());
        let within = |mark: &str| after(mark).and_then(|rest| rest.split('<').next()).map(plain);
        let [code, server_time] = ["<Code>", "<ServerTime>"].map(|mark| within(mark).filter(|value| !value.is_empty()));
        let clock_is_off = OF_CLOCKS.iter().any(|words| text.contains(words));
        Found {
            status,
            code,
            clock_is_off,
            server_time,
            of_credentials,
            text: plain(text.lines().next().unwrap_or_default()),
        }
    }

    fn failure(self) -> Failure {
        let Found { status, code, text, of_credentials, .. } = self;
        let code = code.map_or(String::new(), |code| format!(" ({code})"));
        match status {
            _ if of_credentials => {
                Failure::new(Cause::Denied, "no credentials were found, but the store requires them")
            }
            Some(416) => Failure::new(Cause::Refused, "is empty, or shorter than its stated length (416)"),
            Some(status @ (408 | 429 | 500..)) => {
                Failure::new(Cause::Unreached, format!("the server answers {status}{code}, also after retries"))
            }
            Some(status) => Failure::new(Cause::Refused, format!("the server answers {status}{code}")),
            None if text.contains("redirect") => {
                Failure::new(Cause::Elsewhere, "the server redirects to another address")
            }
            None if text.contains("timed out") => Failure::new(Cause::Passing, "gave no complete answer in time"),
            None => {
                let lower = text.to_lowercase();
                let gone = ["refused", "dns", "resolve", "unreachable"].iter().any(|word| lower.contains(word));
                let cause = match gone {
                    _ if lower.contains("invalidcontenttype") => {
                        return Failure::new(
                            Cause::Unreached,
                            "is on a server that does not speak TLS: is it http://?",
                        );
                    }
                    _ if lower.contains("certificate") => Cause::Untrusted,
                    true => Cause::Unreached,
                    false => Cause::Passing,
                };
                Failure::new(cause, format!("request failed: {text}"))
            }
        }
    }
}

/// Shortens text of a server for a message: one line of at most 120 characters, without addresses
/// and control characters.
fn plain(text: &str) -> String {
    let words = text.split_whitespace().map(|word| if word.contains("://") { "..." } else { word });
    let line = words.collect::<Vec<_>>().join(" ");
    line.chars().filter(|c| !c.is_control()).take(120).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// 10 answers become messages that name the address, what was found and what to do, and none of
    /// the 3 secrets in them.
    #[test]
    fn messages_hold_a_remedy_and_no_secret() {
        let generic = |text: &str| object_store::Error::Generic { store: "S3", source: text.to_string().into() };
        let source = || {
            "GET https://h/a?X-Amz-Signature=5ecret status code: 403: <Code>AccessDenied</Code> <Key>k3y</Key>".into()
        };
        let path = String::new();
        let cases = [
            (
                object_store::Error::PermissionDenied { path: path.clone(), source: source() },
                "access is denied (403, AccessDenied)",
            ),
            (object_store::Error::NotFound { path: path.clone(), source: source() }, "is not there (404)"),
            (object_store::Error::Precondition { path, source: source() }, "has changed while it was read"),
            (generic("status code: 503 Slow: <Code>SlowDown</Code>"), "answers 503 (SlowDown), also after retries"),
            (
                generic(
                    "status code: 403 Forbidden: <Error>\n<Code>RequestTimeTooSkewed</Code><ServerTime>2026-11-23T22:40:11Z</ServerTime>",
                ),
                "this machine's clock is off, the store's clock says 2026-11-23T22:40:11Z (403, RequestTimeTooSkewed)",
            ),
            (
                generic(
                    "status code: 403: <Code>AuthenticationFailed</Code>\n<AuthenticationErrorDetail>Request date header too old: 'Mon'",
                ),
                "this machine's clock is off (403, AuthenticationFailed)",
            ),
            (
                generic(
                    "status code: 400 Bad Request: {\"error\":\"invalid_grant\",\"error_description\":\"Invalid JWT: Token must be a short-lived token (60 minutes) and in a reasonable timeframe.\"}",
                ),
                "this machine's clock is off (400)",
            ),
            (generic("invalid peer certificate: UnknownIssuer"), "SSL_CERT_FILE"),
            (generic("operation timed out"), "gave no complete answer in time"),
            (generic("tcp connect to https://h/?sig=5ecret: refused"), "request failed: tcp connect to ... refused"),
        ];
        let address =
            Address::parse(Path::new("https://me:pa55@h/a.helio?X-Amz-Signature=5ecret")).expect("an address");
        for (answer, part) in cases {
            let text = Failure::from_store(&answer).at(&address).to_string();
            assert!(
                text.starts_with("https://h/a.helio: ") && text.contains(part) && text.contains("to fix: "),
                "{text}"
            );
            assert!(!["5ecret", "pa55", "k3y"].iter().any(|secret| text.contains(secret)), "{text}");
        }
    }
}
