//! Addresses of objects. In: the text that a user typed. Out: a scheme that is known, a bucket or
//! host, an object name, and the name for messages.

use std::path::{Path, PathBuf};

use heliotile_core::error::{Error, Result};
use heliotile_core::text::without_secrets;
use url::Url;

/// Kind of store behind an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Scheme {
    /// `s3://bucket/name`
    S3,
    /// `gs://bucket/name`
    Google,
    /// `az://container/name`
    Azure,
    /// `https://host/name` and `http://host/name`
    Web,
}

/// The address of an object.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    scheme: Scheme,
    url: Url,
    shown: PathBuf,
}

impl Address {
    /// Parses the address of an object. Errors: another scheme, no bucket, no name.
    pub fn parse(place: &Path) -> Result<Self> {
        let address = Address::parse_folder(place)?;
        if address.url.path().ends_with('/') || address.url.path().is_empty() {
            let hint = "add the name of an archive, such as /site.helio";
            return Err(Error::input(&address.shown, None, "names no object in the bucket or on the host", hint));
        }
        Ok(address)
    }

    /// Parses the address of a folder, which may be a whole bucket. Errors: another scheme, no
    /// bucket, a query or a fragment outside web addresses.
    pub fn parse_folder(place: &Path) -> Result<Self> {
        let text = place.to_string_lossy();
        let shown = PathBuf::from(without_secrets(&text));
        let refuse = |what: String, hint: &'static str| Err(Error::input(&shown, None, what, hint));
        let usual =
            "give s3://BUCKET/NAME, gs://BUCKET/NAME, az://CONTAINER/NAME, https://HOST/NAME or http://HOST/NAME";
        let url = match Url::parse(&text) {
            Ok(url) => url,
            Err(error) => return refuse(format!("is no address: {error}"), usual),
        };
        let scheme = match url.scheme() {
            "s3" => Scheme::S3,
            "gs" => Scheme::Google,
            "az" => Scheme::Azure,
            "http" | "https" => Scheme::Web,
            other => return refuse(format!("`{other}://` is not supported"), usual),
        };
        if url.host_str().is_none_or(str::is_empty) {
            return refuse("names no bucket and no host".into(), usual);
        }
        if scheme != Scheme::Web && (url.query().is_some() || url.fragment().is_some()) {
            return refuse("holds a `?` or a `#`".into(), "write them as %3F and %23 if they are part of the name");
        }
        Ok(Address { scheme, url, shown })
    }

    /// Returns the kind of store.
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// Returns the whole address, with its password and signature.
    pub fn url(&self) -> &Url {
        &self.url
    }

    /// Returns the name of the address for messages, without password and signature.
    pub fn shown(&self) -> &Path {
        &self.shown
    }

    /// Returns the last part of the object's path.
    pub fn name(&self) -> &str {
        self.url.path_segments().and_then(|mut parts| parts.next_back()).unwrap_or_default()
    }

    /// Returns the address of another object in the same folder.
    pub fn beside(&self, name: &str) -> Self {
        let mut url = self.url.clone();
        if let Ok(mut parts) = url.path_segments_mut() {
            parts.pop().push(name);
        }
        let shown = PathBuf::from(without_secrets(url.as_str()));
        Address { scheme: self.scheme, url, shown }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 5 addresses are parsed with their kinds and names and shown without a signature; 7 others
    /// are refused with a hint what to write, of which 3 are folders.
    #[test]
    fn five_addresses_parse_and_seven_are_refused() {
        for (text, scheme, name) in [
            ("s3://bucket/a/site.helio", Scheme::S3, "site.helio"),
            ("gs://bucket/site.helio", Scheme::Google, "site.helio"),
            ("az://container/site.helio", Scheme::Azure, "site.helio"),
            ("https://host:8/site.helio?sig=secret", Scheme::Web, "site.helio"),
            ("http://me:word@host/x", Scheme::Web, "x"),
        ] {
            let address = Address::parse(Path::new(text)).expect(text);
            assert_eq!((address.scheme(), address.name()), (scheme, name));
            let shown = address.shown().display().to_string();
            assert!(!shown.contains("secret") && !shown.contains("word"), "{shown}");
        }
        for text in ["ftp://host/a", "s3://", "s3:///a", "s3://bucket", "s3://bucket/a/", "s3://b/a?x", "http://[/a"] {
            let error = Address::parse(Path::new(text)).expect_err(text).to_string();
            assert!(error.contains("to fix: "), "{error}");
        }
        assert!(
            ["s3://bucket", "s3://bucket/", "s3://bucket/a/"]
                .iter()
                .all(|text| Address::parse_folder(Path::new(text)).is_ok())
        );
        let beside = Address::parse(Path::new("s3://b/f/site.helio")).expect("an address").beside("other.helio");
        assert_eq!(beside.shown(), Path::new("s3://b/f/other.helio"));
    }
}
