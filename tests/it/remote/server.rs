//! A small object store on this machine, with faults: GET and HEAD with ranges and conditions,
//! lists, conditional PUT, uploads in parts, as in S3. It uses one thread and one request a
//! connection.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// Fault of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    None,
    Status(u16),
    /// The store refuses the time of the signature, in S3's words.
    Skewed,
    /// Half of the body is sent, then the connection ends.
    Cut,
    /// Half of the body is sent, then nothing more.
    Stall,
    /// One bit of the body is flipped.
    Flip,
    /// The connection ends before any answer.
    Gone,
    /// The object changes between two requests.
    Replace,
}

/// Fault of the n-th request.
pub type Faults = Arc<dyn Fn(u64) -> Fault + Send + Sync>;

#[derive(Default)]
struct Held {
    objects: BTreeMap<String, (Vec<u8>, u64)>,
    uploads: BTreeMap<String, BTreeMap<u32, Vec<u8>>>,
    written: u64,
    /// Value that the header `Authorization` must have.
    wanted: Option<String>,
}

/// A store that lives as long as this value.
pub struct Store {
    pub address: SocketAddr,
    pub requests: Arc<AtomicU64>,
    pub sent: Arc<AtomicU64>,
    held: Arc<Mutex<Held>>,
    faults: Arc<Mutex<Faults>>,
    ranges: Arc<AtomicBool>,
    ended: Arc<AtomicBool>,
}

impl Store {
    pub fn new() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let faults: Faults = Arc::new(|_| Fault::None);
        let store = Store {
            address: listener.local_addr().expect("an address"),
            requests: Arc::default(),
            sent: Arc::default(),
            held: Arc::default(),
            faults: Arc::new(Mutex::new(faults)),
            ranges: Arc::new(AtomicBool::new(true)),
            ended: Arc::default(),
        };
        let parts = (store.requests.clone(), store.sent.clone(), store.held.clone(), store.faults.clone());
        let (ranges, ended) = (store.ranges.clone(), store.ended.clone());
        thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                if ended.load(Ordering::Relaxed) {
                    break;
                }
                let (requests, sent, held, faults) = parts.clone();
                let with_ranges = ranges.load(Ordering::Relaxed);
                thread::spawn(move || {
                    let number = requests.fetch_add(1, Ordering::Relaxed);
                    let fault = (faults.lock().expect("faults").clone())(number);
                    // The client may have closed the connection.
                    if let Ok(bytes) = answer(stream, &held, fault, with_ranges) {
                        sent.fetch_add(bytes, Ordering::Relaxed);
                    }
                });
            }
        });
        store
    }

    pub fn put(&self, name: &str, bytes: Vec<u8>) {
        let mut held = self.held.lock().expect("held");
        held.written += 1;
        let version = held.written;
        held.objects.insert(name.into(), (bytes, version));
    }

    pub fn get(&self, name: &str) -> Option<Vec<u8>> {
        self.held.lock().expect("held").objects.get(name).map(|object| object.0.clone())
    }

    pub fn remove(&self, name: &str) {
        self.held.lock().expect("held").objects.remove(name);
    }

    /// Returns the name that was written last.
    pub fn newest(&self) -> String {
        let held = self.held.lock().expect("held");
        let newest = held.objects.iter().max_by_key(|(_, (_, version))| *version);
        newest.map(|(name, _)| name.clone()).expect("an object")
    }

    pub fn names(&self) -> Vec<String> {
        self.held.lock().expect("held").objects.keys().cloned().collect()
    }

    pub fn set_faults(&self, faults: impl Fn(u64) -> Fault + Send + Sync + 'static) {
        *self.faults.lock().expect("faults") = Arc::new(faults);
        self.requests.store(0, Ordering::Relaxed);
        self.sent.store(0, Ordering::Relaxed);
    }

    /// Requires this value of the header `Authorization` from now on.
    pub fn want(&self, authorization: &str) {
        self.held.lock().expect("held").wanted = Some(authorization.to_owned());
    }

    pub fn set_ranges(&self, ranges: bool) {
        self.ranges.store(ranges, Ordering::Relaxed);
    }
}

impl Drop for Store {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        // Wakes the thread that listens.
        let _ = TcpStream::connect(self.address);
    }
}

struct Request {
    method: String,
    path: String,
    query: String,
    headers: BTreeMap<String, String>,
    body: Vec<u8>,
}

impl Request {
    fn read(stream: &TcpStream) -> std::io::Result<Self> {
        let mut reader = BufReader::new(stream);
        let mut line = String::new();
        reader.read_line(&mut line)?;
        let mut words = line.split_whitespace();
        let (method, target) = (words.next().unwrap_or("").to_owned(), words.next().unwrap_or("").to_owned());
        let (path, query) = target.split_once('?').unwrap_or((&target, ""));
        let mut headers = BTreeMap::new();
        loop {
            let mut line = String::new();
            reader.read_line(&mut line)?;
            let Some((name, value)) = line.trim_end().split_once(": ") else { break };
            headers.insert(name.to_lowercase(), value.to_owned());
        }
        let length = headers.get("content-length").and_then(|length| length.parse().ok()).unwrap_or(0);
        let mut body = vec![0; length];
        reader.read_exact(&mut body)?;
        Ok(Request { method, path: path[1..].to_owned(), query: query.to_owned(), headers, body })
    }

    fn parameter(&self, name: &str) -> Option<&str> {
        self.query.split('&').find_map(|part| part.strip_prefix(name)?.strip_prefix('='))
    }
}

/// Answer of S3 to a signature that is hours old.
const SKEWED: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Error><Code>RequestTimeTooSkewed</Code>\
    <Message>The difference between the request time and the current time is too large.</Message>\
    <RequestTime>20261123T194011Z</RequestTime><ServerTime>2026-11-23T22:40:11Z</ServerTime>\
    <MaxAllowedSkewMilliseconds>900000</MaxAllowedSkewMilliseconds></Error>";

/// Answers a request; returns the bytes of the body that were sent.
fn answer(mut stream: TcpStream, held: &Mutex<Held>, fault: Fault, ranges: bool) -> std::io::Result<u64> {
    let request = Request::read(&stream)?;
    if fault == Fault::Gone {
        return Ok(0);
    }
    if fault == Fault::Replace {
        let mut held = held.lock().expect("held");
        held.written += 1;
        let version = held.written;
        if let Some(object) = held.objects.get_mut(&request.path) {
            object.1 = version;
            object.0.iter_mut().skip(8192).for_each(|byte| *byte ^= 0x55);
        }
    }
    let (status, head, mut body) = match fault {
        Fault::Status(status) => (status, String::new(), b"<Error><Code>Injected</Code></Error>".to_vec()),
        Fault::Skewed => (403, String::new(), SKEWED.as_bytes().to_vec()),
        _ => respond(&request, &mut held.lock().expect("held"), ranges),
    };
    let length = body.len();
    let is_head = request.method == "HEAD";
    if fault == Fault::Flip && length > 0 && request.method == "GET" {
        body[length / 2] ^= 1;
    }
    let stated = if is_head && status == 200 { String::new() } else { format!("Content-Length: {length}\r\n") };
    write!(stream, "HTTP/1.1 {status} x\r\nConnection: close\r\n{stated}{head}\r\n")?;
    if is_head {
        return Ok(0);
    }
    if matches!(fault, Fault::Cut | Fault::Stall) {
        body.truncate(length / 2);
    }
    stream.write_all(&body)?;
    if fault == Fault::Stall {
        stream.flush()?;
        thread::sleep(Duration::from_secs(20));
    }
    Ok(body.len() as u64)
}

fn respond(request: &Request, held: &mut Held, ranges: bool) -> (u16, String, Vec<u8>) {
    let known = held.objects.get(&request.path);
    let etag = known.map(|object| format!("\"{}\"", object.1));
    let condition = |name: &str| request.headers.get(name).cloned();
    let none = |status: u16| (status, String::new(), Vec::new());
    if held.wanted.as_ref().is_some_and(|wanted| request.headers.get("authorization") != Some(wanted)) {
        return none(401);
    }
    // Google counts versions; 0 is no object.
    let generation = known.map_or(0, |object| object.1).to_string();
    if condition("x-goog-if-generation-match").is_some_and(|wanted| wanted != generation) {
        return none(412);
    }
    if condition("if-match").is_some_and(|wanted| Some(wanted) != etag)
        || condition("if-none-match").is_some_and(|wanted| wanted == "*" && etag.is_some())
    {
        return none(412);
    }
    let upload = request.parameter("uploadId").map(str::to_owned);
    match (request.method.as_str(), upload) {
        ("GET", _) if request.parameter("list-type").is_some() => {
            let prefix = request.parameter("prefix").unwrap_or_default().replace("%2F", "/");
            let within = format!("{}/{prefix}", request.path);
            let names = held.objects.keys().filter_map(|name| {
                let name = name.strip_prefix(&request.path)?.strip_prefix('/').filter(|_| name.starts_with(&within))?;
                Some(format!(
                    "<Contents><Key>{}</Key><Size>1</Size><LastModified>2026-11-02T10:00:00.000Z</LastModified></Contents>",
                    name
                ))
            });
            let names = names.collect::<String>();
            (200, String::new(), format!("<ListBucketResult>{names}</ListBucketResult>").into_bytes())
        }
        ("GET" | "HEAD", _) => {
            let (Some((bytes, _)), Some(etag)) = (known, etag) else { return none(404) };
            let about = format!(
                "ETag: {etag}\r\nx-goog-generation: {generation}\r\nLast-Modified: Mon, 02 Nov 2026 10:00:00 GMT\r\n"
            );
            if request.method == "HEAD" {
                return (200, format!("{about}Content-Length: {}\r\n", bytes.len()), Vec::new());
            }
            let range = condition("range").filter(|_| ranges);
            let Some(range) = range.as_deref().and_then(|range| range.strip_prefix("bytes=")) else {
                return (200, about, bytes.clone());
            };
            let (first, last) = range.split_once('-').expect("a range");
            let (start, end) = match first.is_empty() {
                true => (bytes.len().saturating_sub(last.parse().expect("a number")), bytes.len()),
                false => {
                    (first.parse().expect("a number"), bytes.len().min(last.parse::<usize>().expect("a number") + 1))
                }
            };
            if start >= end {
                return none(416);
            }
            let head = format!("{about}Content-Range: bytes {start}-{}/{}\r\n", end - 1, bytes.len());
            (206, head, bytes[start..end].to_vec())
        }
        ("PUT", None) => {
            held.written += 1;
            let version = held.written;
            held.objects.insert(request.path.clone(), (request.body.clone(), version));
            (200, format!("ETag: \"{version}\"\r\nx-goog-generation: {version}\r\n"), Vec::new())
        }
        ("PUT", Some(id)) => {
            let part = request.parameter("partNumber").and_then(|part| part.parse().ok()).expect("a part");
            held.uploads.entry(id).or_default().insert(part, request.body.clone());
            (200, format!("ETag: \"part{part}\"\r\n"), Vec::new())
        }
        ("POST", None) => {
            held.written += 1;
            let id = held.written;
            held.uploads.insert(id.to_string(), BTreeMap::new());
            let text =
                format!("<InitiateMultipartUploadResult><UploadId>{id}</UploadId></InitiateMultipartUploadResult>");
            (200, String::new(), text.into_bytes())
        }
        ("POST", Some(id)) => {
            let Some(parts) = held.uploads.remove(&id) else { return none(404) };
            held.written += 1;
            let version = held.written;
            held.objects.insert(request.path.clone(), (parts.into_values().flatten().collect(), version));
            let text =
                format!("<CompleteMultipartUploadResult><ETag>\"{version}\"</ETag></CompleteMultipartUploadResult>");
            (200, String::new(), text.into_bytes())
        }
        ("DELETE", Some(id)) => {
            held.uploads.remove(&id);
            none(204)
        }
        _ => none(405),
    }
}
