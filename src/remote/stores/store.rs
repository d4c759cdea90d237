//! Connections to stores. In: an address, the environment of the process. Out: a client that signs,
//! retries and gives up in time.

use std::str::FromStr;
use std::sync::{Arc, Once, OnceLock};
use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use heliotile_core::error::{Error, Result};
use object_store::aws::AmazonS3Builder;
use object_store::azure::MicrosoftAzureBuilder;
use object_store::client::{HttpClient, HttpConnector};
use object_store::gcp::GoogleCloudStorageBuilder;
use object_store::http::HttpBuilder;
use object_store::path::Path as ObjectPath;
use object_store::{BackoffConfig, ClientOptions, HeaderMap, HeaderValue, ObjectStore, RetryConfig};
use percent_encoding::percent_decode_str;
use tokio::runtime::Runtime;
use url::Url;

use crate::stores::address::{Address, Scheme};
use crate::stores::failure::Failure;

/// Times that a request is made again where that can help.
const RETRIES: usize = 5;

/// Settings of the requests to stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Connection {
    /// Time limit of one request, and further time limit of its retries.
    pub timeout: Duration,
}

impl Default for Connection {
    /// Returns a time limit of 60 s.
    fn default() -> Self {
        Connection { timeout: Duration::from_secs(60) }
    }
}

/// A store, and a name in it.
#[derive(Clone, Debug)]
pub struct Locator {
    /// Client of the store.
    pub store: Arc<dyn ObjectStore>,
    /// Name of the object in the store; empty where the client knows one object only.
    pub path: ObjectPath,
    /// Address of the object, for messages.
    pub address: Address,
    /// Settings of the requests.
    pub connection: Connection,
}

/// Returns the environment variables of a store, those whose names begin with `prefix`. Empty ones
/// are left out, as clients do not expect them. An error: a value that the client would take
/// unchecked and cannot use.
fn variables(prefix: &str) -> Result<Vec<(String, String)>> {
    let said =
        std::env::vars_os().filter_map(|(name, value)| Some((name.into_string().ok()?, value.into_string().ok()?)));
    let said: Vec<_> = said.filter(|(name, value)| name.starts_with(prefix) && !value.is_empty()).collect();
    for (name, value) in &said {
        // The message leaves the value out: it may be a secret.
        let is_url = || Url::parse(value).is_ok_and(|url| url.has_host() && matches!(url.scheme(), "http" | "https"));
        if ENDPOINTS.contains(&name.as_str()) && !is_url() {
            let hint = "give one such as https://s3.example.org, or unset it";
            return Err(Error::argument(name, "is no address of a server", hint));
        }
        let is_odd = |letter: char| letter.is_control() || letter.is_whitespace() || !letter.is_ascii();
        if IN_HEADERS.contains(&name.as_str()) && value.contains(is_odd) {
            let what = "holds a space, a line break or a letter that is not ASCII";
            return Err(Error::argument(name, what, "set it again, without that character"));
        }
    }
    Ok(said)
}

/// Environment variables that hold the address of a server.
const ENDPOINTS: [&str; 7] = [
    "AWS_ENDPOINT_URL_S3",
    "AWS_ENDPOINT_URL",
    "AWS_ENDPOINT",
    "AWS_CONTAINER_CREDENTIALS_FULL_URI",
    "AZURE_STORAGE_ENDPOINT",
    "AZURE_ENDPOINT",
    "GOOGLE_BASE_URL",
];

/// Environment variables that become part of a header.
const IN_HEADERS: [&str; 6] = [
    "AWS_ACCESS_KEY_ID",
    "AWS_SECRET_ACCESS_KEY",
    "AWS_SESSION_TOKEN",
    "AWS_REGION",
    "AWS_DEFAULT_REGION",
    "AZURE_STORAGE_ACCOUNT_NAME",
];

/// Keeps the environment variables that a client knows.
fn known<K: FromStr>(said: Vec<(String, String)>) -> impl Iterator<Item = (K, String)> {
    said.into_iter().filter_map(|(name, value)| Some((name.to_ascii_lowercase().parse().ok()?, value)))
}

/// Splits the address of a web server into the address without user name and password, and the
/// header that carries them (Reschke 2015, RFC 7617).
fn with_header(url: &Url) -> (String, HeaderMap) {
    let (mut plain, mut headers) = (url.clone(), HeaderMap::new());
    if !url.username().is_empty() || url.password().is_some() {
        let decoded = |text: &str| percent_decode_str(text).collect::<Vec<u8>>();
        let both = [decoded(url.username()), decoded(url.password().unwrap_or_default())].join(&b':');
        // Neither step fails: the address has a host, and Base64 is ASCII.
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

/// Installs the cryptography that TLS uses, once; a provider that the calling program installed
/// stays.
fn provide_tls() {
    static SAID: Once = Once::new();
    SAID.call_once(|| drop(rustls::crypto::ring::default_provider().install_default()));
}

/// Returns the time limit of a connection, for requests that may take `timeout`.
fn connect_limit(timeout: Duration) -> Duration {
    timeout.min(Duration::from_secs(10))
}

/// Maker of clients of web servers, which send no `Referer`: a signed address is a password, and a
/// server that redirects would hand it to another host.
#[derive(Debug)]
struct WebConnector {
    headers: HeaderMap,
    timeout: Duration,
}

impl HttpConnector for WebConnector {
    fn connect(&self, _: &ClientOptions) -> object_store::Result<HttpClient> {
        let client = reqwest::ClientBuilder::new()
            .user_agent(concat!("heliotile/", env!("CARGO_PKG_VERSION")))
            .default_headers(self.headers.clone())
            .referer(false)
            .timeout(self.timeout)
            .connect_timeout(connect_limit(self.timeout))
            // A packed answer would have another length than the range.
            .no_gzip()
            .no_brotli()
            .no_zstd()
            .no_deflate();
        let failed = |source| object_store::Error::Generic { store: "HTTP", source: Box::new(source) };
        client.build().map(HttpClient::new).map_err(failed)
    }
}

impl Locator {
    /// Makes a client; sends no request. An error: an invalid setting in the environment.
    pub fn connect(address: &Address, connection: Connection) -> Result<Self> {
        provide_tls();
        let failed = |error: object_store::Error| Failure::of_settings(&error).at(address);
        let timeout = connection.timeout;
        let options = ClientOptions::new().with_timeout(timeout).with_connect_timeout(connect_limit(timeout));
        let backoff = BackoffConfig {
            init_backoff: Duration::from_millis(100),
            max_backoff: Duration::from_secs(5),
            ..BackoffConfig::default()
        };
        let retry = RetryConfig { backoff, max_retries: RETRIES, retry_timeout: timeout };
        let url = address.url();
        let path = || {
            let hint = "give a name without empty parts (`//`) and without parts that are only dots";
            let wrong = |_| Error::input(address.shown(), None, "has a name that stores do not accept", hint);
            ObjectPath::from_url_path(url.path()).map_err(wrong)
        };
        let (store, path): (Arc<dyn ObjectStore>, _) = match address.scheme() {
            Scheme::S3 => {
                let said = variables("AWS_")?;
                // The user asked for plain HTTP by naming such an endpoint.
                let plain = ["AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL", "AWS_ENDPOINT"]
                    .iter()
                    .find_map(|name| said.iter().find(|(known, _)| known == name))
                    .is_some_and(|(_, endpoint)| endpoint.starts_with("http://"));
                let builder = AmazonS3Builder::new().with_url(url.as_str());
                let builder = known(said).fold(builder, |builder, (key, value)| builder.with_config(key, value));
                let builder = builder.with_client_options(options.with_allow_http(plain)).with_retry(retry);
                (Arc::new(builder.build().map_err(failed)?), path()?)
            }
            Scheme::Google => {
                let said = variables("GOOGLE_")?;
                let plain = said.iter().any(|(name, value)| name == "GOOGLE_BASE_URL" && value.starts_with("http://"));
                let builder = GoogleCloudStorageBuilder::new().with_url(url.as_str());
                let file = std::env::var("SERVICE_ACCOUNT").ok();
                let builder = file.into_iter().fold(builder, |builder, file| builder.with_service_account_path(file));
                let builder = known(said).fold(builder, |builder, (key, value)| builder.with_config(key, value));
                let builder = builder.with_client_options(options.with_allow_http(plain)).with_retry(retry);
                (Arc::new(builder.build().map_err(failed)?), path()?)
            }
            Scheme::Azure => {
                let plain = std::env::var("AZURE_STORAGE_USE_EMULATOR").is_ok_and(|value| value == "true");
                variables("AZURE_")?;
                let builder = MicrosoftAzureBuilder::from_env().with_url(url.as_str());
                let builder = builder.with_client_options(options.with_allow_http(plain)).with_retry(retry);
                (Arc::new(builder.build().map_err(failed)?), path()?)
            }
            Scheme::Web => {
                let (url, headers) = with_header(url);
                let builder = HttpBuilder::new().with_url(url).with_retry(retry);
                let builder = builder.with_http_connector(WebConnector { headers, timeout });
                // The address is whole: its spelling and its query stay as they are.
                (Arc::new(builder.build().map_err(failed)?), ObjectPath::default())
            }
        };
        Ok(Locator { store, path, address: address.clone(), connection })
    }

    /// Returns true if the last bytes of an object can be requested before its length is known.
    pub fn has_suffixes(&self) -> bool {
        self.address.scheme() != Scheme::Azure
    }
}

/// Returns the runtime of the requests: two threads of the process, started when they are first
/// needed.
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
    begun
        .as_ref()
        .map_err(|error| Error::argument("threads", format!("no thread can be started: {error}"), "end other programs"))
}
