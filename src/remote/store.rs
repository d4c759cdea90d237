//! Connections to stores. In: an address, the environment of the process. Out: a client that signs, retries and gives up in time.

use std::sync::{Arc, Once, OnceLock};
use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::without_secrets;
use object_store::aws::AmazonS3Builder;
use object_store::azure::MicrosoftAzureBuilder;
use object_store::gcp::GoogleCloudStorageBuilder;
use object_store::http::HttpBuilder;
use object_store::path::Path as ObjectPath;
use object_store::{BackoffConfig, ClientOptions, HeaderMap, HeaderValue, ObjectStore, RetryConfig};
use percent_encoding::percent_decode_str;
use tokio::runtime::Runtime;
use url::Url;

use crate::address::{Address, Scheme};
use crate::failure::Failure;

/// Times that a request is made again where that can help.
const RETRIES: usize = 5;

/// How stores are spoken to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Connection {
    /// What one request may take, and what asking again may take on top.
    pub timeout: Duration,
}

impl Default for Connection {
    /// 60 s.
    fn default() -> Self {
        Connection { timeout: Duration::from_secs(60) }
    }
}

/// A store, and a name in it.
#[derive(Clone, Debug)]
pub struct Locator {
    /// The client.
    pub store: Arc<dyn ObjectStore>,
    /// The object's name in it; empty where the client knows one object only.
    pub path: ObjectPath,
    /// The address, for messages.
    pub address: Address,
    /// How it is spoken to.
    pub connection: Connection,
}

/// Variables that hold the address of a store of others.
const ENDPOINTS: [&str; 7] = [
    "AWS_ENDPOINT_URL_S3",
    "AWS_ENDPOINT_URL",
    "AWS_ENDPOINT",
    "AZURE_STORAGE_ENDPOINT",
    "AZURE_ENDPOINT",
    "GOOGLE_BASE_URL",
    "AWS_CONTAINER_CREDENTIALS_FULL_URI",
];

/// Variables that become part of a header.
const IN_HEADERS: [&str; 5] =
    ["AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY", "AWS_SESSION_TOKEN", "AWS_REGION", "AZURE_STORAGE_SAS_TOKEN"];

/// Refuses what clients of stores take without a look and cannot use.
fn check_environment() -> Result<()> {
    let told = |name: &str| std::env::var(name).ok();
    for (name, text) in ENDPOINTS.iter().filter_map(|name| Some((name, told(name)?))) {
        if !Url::parse(&text).is_ok_and(|url| url.has_host() && matches!(url.scheme(), "http" | "https")) {
            let what = format!("`{}` is no address of a server", without_secrets(&text));
            return Err(Error::argument(*name, what, "give one such as https://s3.example.org, or unset it"));
        }
    }
    for (name, text) in IN_HEADERS.iter().filter_map(|name| Some((name, told(name)?))) {
        if text.chars().any(|letter| letter.is_control() || !letter.is_ascii()) {
            let what = "holds a line break, or a letter that is not ASCII";
            return Err(Error::argument(*name, what, "set it again, without what stands behind it"));
        }
    }
    Ok(())
}

/// The address of a web server without a name and a password, and the header that says them (Reschke 2015, RFC 7617).
fn with_header(url: &Url) -> (String, HeaderMap) {
    let (mut plain, mut headers) = (url.clone(), HeaderMap::new());
    if !url.username().is_empty() || url.password().is_some() {
        let decoded = |text: &str| percent_decode_str(text).collect::<Vec<u8>>();
        let both = [decoded(url.username()), decoded(url.password().unwrap_or_default())].join(&b':');
        // Neither fails: there is a host, and Base64 is ASCII.
        if plain.set_username("").is_ok()
            && plain.set_password(None).is_ok()
            && let Ok(mut value) = HeaderValue::try_from(format!("Basic {}", STANDARD.encode(both)))
        {
            value.set_sensitive(true);
            headers.insert("authorization", value);
        }
    }
    (plain.into(), headers)
}

/// Says which cryptography TLS uses, once; what a program around this one has said stays.
fn provide_tls() {
    static SAID: Once = Once::new();
    SAID.call_once(|| drop(rustls::crypto::ring::default_provider().install_default()));
}

impl Locator {
    /// Makes a client; asks nobody. An error: an environment that says something that cannot be.
    pub fn connect(address: &Address, connection: Connection) -> Result<Self> {
        provide_tls();
        check_environment()?;
        let failed = |error: object_store::Error| Failure::of_settings(&error).at(address);
        let timeout = connection.timeout;
        let options =
            ClientOptions::new().with_timeout(timeout).with_connect_timeout(timeout.min(Duration::from_secs(10)));
        let backoff = BackoffConfig {
            init_backoff: Duration::from_millis(100),
            max_backoff: Duration::from_secs(5),
            ..BackoffConfig::default()
        };
        let retry = RetryConfig { backoff, max_retries: RETRIES, retry_timeout: timeout };
        let url = address.url();
        let path = || {
            let hint = "name an object without empty parts, `//`, and without parts that are only dots";
            let wrong = |_| Error::input(address.shown(), None, "has a name that is not taken", hint);
            ObjectPath::from_url_path(url.path()).map_err(wrong)
        };
        let (store, path): (Arc<dyn ObjectStore>, _) = match address.scheme() {
            Scheme::S3 => {
                // An endpoint without TLS is somebody's wish.
                let plain = ["AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL", "AWS_ENDPOINT"]
                    .iter()
                    .find_map(|name| std::env::var(name).ok())
                    .is_some_and(|endpoint| endpoint.starts_with("http://"));
                let builder = AmazonS3Builder::from_env().with_url(url.as_str());
                let builder = builder.with_client_options(options.with_allow_http(plain)).with_retry(retry);
                (Arc::new(builder.build().map_err(failed)?), path()?)
            }
            Scheme::Google => {
                let plain = std::env::var("GOOGLE_BASE_URL").is_ok_and(|endpoint| endpoint.starts_with("http://"));
                let builder = GoogleCloudStorageBuilder::from_env().with_url(url.as_str());
                let builder = builder.with_client_options(options.with_allow_http(plain)).with_retry(retry);
                (Arc::new(builder.build().map_err(failed)?), path()?)
            }
            Scheme::Azure => {
                let plain = std::env::var("AZURE_STORAGE_USE_EMULATOR").is_ok_and(|value| value == "true");
                let builder = MicrosoftAzureBuilder::from_env().with_url(url.as_str());
                let builder = builder.with_client_options(options.with_allow_http(plain)).with_retry(retry);
                (Arc::new(builder.build().map_err(failed)?), path()?)
            }
            Scheme::Web => {
                let (url, headers) = with_header(url);
                let builder = HttpBuilder::new().with_url(url).with_retry(retry);
                let builder = builder.with_client_options(options.with_allow_http(true).with_default_headers(headers));
                // The address is whole: its spelling and its query stay as they are.
                (Arc::new(builder.build().map_err(failed)?), ObjectPath::default())
            }
        };
        Ok(Locator { store, path, address: address.clone(), connection })
    }

    /// Whether the last bytes of an object can be asked for before its length is known.
    pub fn has_suffixes(&self) -> bool {
        self.address.scheme() != Scheme::Azure
    }
}

/// What requests run on: two threads of the process, begun when they are first needed.
pub fn runtime() -> Result<&'static Runtime> {
    static RUNTIME: OnceLock<std::result::Result<Runtime, String>> = OnceLock::new();
    let begun = RUNTIME.get_or_init(|| {
        let mut builder = tokio::runtime::Builder::new_multi_thread();
        builder
            .worker_threads(2)
            .thread_name("heliotile-remote")
            .enable_all()
            .build()
            .map_err(|error| error.to_string())
    });
    begun.as_ref().map_err(|error| {
        Error::argument("--threads", format!("no thread can be started: {error}"), "end other programs")
    })
}
