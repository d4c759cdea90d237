//! The web server of the page. In: a listener, the files to serve. Out: answers to browsers of this
//! machine, until the process ends.

use std::collections::HashMap;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use axum::Router;
use axum::body::Bytes;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use tower_http::services::ServeFile;

use heliotile::archive::ReadAt;
use heliotile::atlas::PARTS;
use heliotile::{Error, Result};

/// Addresses of the archive, of the one after a change and of the weather, relative to the page.
pub const ARCHIVE: &str = "site.helio";
pub const AFTER: &str = "after.helio";
pub const WEATHER: &str = "weather";

/// Largest answer that is passed on from a remote archive, bytes.
const MAX: u64 = 16 << 20;

/// Contents of the server; every other address is not found.
pub struct Served {
    pub page: String,
    /// The page compressed by gzip, for browsers that accept it.
    pub packed_page: Vec<u8>,
    pub archive: ServedArchive,
    /// Archive after the change, for comparison.
    pub after: Option<ServedArchive>,
    pub weather: Option<Vec<u8>>,
}

/// Source of the archive's bytes.
pub enum ServedArchive {
    /// A local file.
    File(PathBuf),
    /// A remote archive: ranges that the page requests are passed on.
    Held(Arc<dyn ReadAt>),
    /// Files of the parts of an atlas by their addresses, and the list of them.
    Parts { list: String, files: HashMap<String, PathBuf> },
}

impl ServedArchive {
    /// Adds the routes to these bytes at a name relative to the page; parts have names of their
    /// own.
    fn routed(self, router: Router, name: &str) -> Router {
        let at = format!("/{name}");
        match self {
            ServedArchive::File(path) => router.route_service(&at, ServeFile::new(path)),
            ServedArchive::Held(bytes) => router.route(&at, get(async move |headers| passed_on(bytes, headers).await)),
            ServedArchive::Parts { list, files } => {
                let (list, json) = (Bytes::from(list), (header::CONTENT_TYPE, "application/json"));
                let files = Arc::new(files);
                router
                    .route(&format!("/{PARTS}"), get(async move || ([json], list.clone())))
                    .route("/parts/{name}/{file}", get(async move |request| part_of(&files, request).await))
            }
        }
    }
}

/// Serves until the process ends.
pub fn serve(listener: TcpListener, served: Served) -> Result<()> {
    let failed = |error| Error::io(Path::new("the page"), "serve")(error);
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().map_err(failed)?;
    runtime.block_on(async {
        listener.set_nonblocking(true).map_err(failed)?;
        let port = listener.local_addr().map_err(failed)?.port();
        let listener = tokio::net::TcpListener::from_std(listener).map_err(failed)?;
        axum::serve(listener, router(served, port)).await.map_err(failed)
    })
}

fn router(served: Served, port: u16) -> Router {
    let [plain, packed] = [Bytes::from(served.page), Bytes::from(served.packed_page)];
    let html = (header::CONTENT_TYPE, "text/html; charset=utf-8");
    let page = async move |headers: HeaderMap| match takes_gzip(&headers) {
        true => ([html, (header::CONTENT_ENCODING, "gzip")], packed.clone()).into_response(),
        false => ([html], plain.clone()).into_response(),
    };
    let router = served.archive.routed(Router::new().route("/", get(page)), ARCHIVE);
    let router = match served.after {
        Some(after) => after.routed(router, AFTER),
        None => router,
    };
    let router = match served.weather.map(Bytes::from) {
        Some(bytes) => router.route(&format!("/{WEATHER}"), get(async move || bytes.clone())),
        None => router,
    };
    let hosts = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    router.layer(middleware::from_fn_with_state(hosts, guard))
}

/// Serves the file of a known address; no other path is read.
async fn part_of(files: &HashMap<String, PathBuf>, request: Request) -> Response {
    let Some(path) = files.get(request.uri().path()) else { return StatusCode::NOT_FOUND.into_response() };
    match ServeFile::new(path).try_call(request).await {
        Ok(response) => response.into_response(),
        Err(_) => StatusCode::NOT_FOUND.into_response(),
    }
}

/// Serves a range of a remote archive, at most [`MAX`] bytes. Requests without a range are
/// refused.
async fn passed_on(bytes: Arc<dyn ReadAt>, headers: HeaderMap) -> Response {
    let length = bytes.length();
    let asked = headers.get(header::RANGE).and_then(|value| value.to_str().ok());
    let Some((first, last)) = asked.and_then(|range| range.strip_prefix("bytes=")?.split_once('-')) else {
        return (StatusCode::FORBIDDEN, "this archive is served by ranges only\n").into_response();
    };
    let range = first.parse().ok().zip(if last.is_empty() { Some(u64::MAX) } else { last.parse().ok() });
    let range = range.map(|(first, last): (u64, u64)| {
        (first, last.min(length.saturating_sub(1)).min(first.saturating_add(MAX - 1)))
    });
    let Some((first, last)) = range.filter(|(first, last)| first <= last) else {
        return (StatusCode::RANGE_NOT_SATISFIABLE, [(header::CONTENT_RANGE, format!("bytes */{length}"))])
            .into_response();
    };
    let count = usize::try_from(last - first + 1).unwrap_or(0);
    // Reading may wait for the network, so it runs on a blocking thread.
    let read = tokio::task::spawn_blocking(move || bytes.copy_at(first, count)).await;
    match read.map_err(std::io::Error::other).and_then(|read| read) {
        Ok(part) => {
            let range = (header::CONTENT_RANGE, format!("bytes {first}-{last}/{length}"));
            (StatusCode::PARTIAL_CONTENT, [range, (header::ACCEPT_RANGES, "bytes".into())], part).into_response()
        }
        Err(error) => (StatusCode::BAD_GATEWAY, format!("{error}\n")).into_response(),
    }
}

/// Returns true if a browser accepts gzip.
fn takes_gzip(headers: &HeaderMap) -> bool {
    let named = headers.get(header::ACCEPT_ENCODING).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let refused = |weight: &str| weight.trim().strip_prefix("q=").is_some_and(|q| q.parse() == Ok(0.0));
    named.split(',').any(|one| match one.split_once(';') {
        None => one.trim() == "gzip",
        Some((name, weight)) => name.trim() == "gzip" && !refused(weight),
    })
}

/// Answers only requests to the address that was printed, so that a foreign page whose host name
/// leads to this machine gets nothing. Headers keep browsers from guessing types, caching answers
/// and showing them inside other pages.
async fn guard(State(hosts): State<[String; 2]>, request: Request, next: Next) -> Response {
    let host = request.headers().get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or_default();
    if !hosts.iter().any(|own| own.eq_ignore_ascii_case(host)) {
        let said = format!("this page is served at http://{} only\n", hosts[0]);
        return (StatusCode::FORBIDDEN, said).into_response();
    }
    let mut response = next.run(request).await;
    for (name, value) in [
        (header::CACHE_CONTROL, "no-cache"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::X_FRAME_OPTIONS, "DENY"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::VARY, "accept-encoding"),
    ] {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    let same = HeaderValue::from_static("same-origin");
    response.headers_mut().insert("cross-origin-resource-policy", same);
    response
}
