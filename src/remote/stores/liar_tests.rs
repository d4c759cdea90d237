//! Web servers that lie: answers of another length than they state or than was requested, and
//! redirects to other hosts.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use object_store::GetRange;

use crate::stores::address::Address;
use crate::stores::failure::Cause;
use crate::stores::object::Object;
use crate::stores::store::{Connection, Locator, runtime};

/// Starts a server that answers each request with the same head and bytes without end, up to 64
/// MiB. Returns its port and the requests that it got.
fn server(head: String, is_endless: bool) -> (u16, Receiver<String>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("an address").port();
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        for mut stream in listener.incoming().flatten() {
            let lines = BufReader::new(stream.try_clone().expect("a stream")).lines().map_while(Result::ok);
            let _ = sender.send(lines.take_while(|line| !line.is_empty()).collect::<Vec<_>>().join("\n"));
            // The client ends the connection of an endless answer.
            let mut done = stream.write_all(head.as_bytes());
            for _ in 0..if is_endless { 64 } else { 0 } {
                done = done.and_then(|()| stream.write_all(&vec![0; 1 << 20]));
            }
        }
    });
    (port, receiver)
}

fn locator(port: u16, name: &str) -> Locator {
    let text = format!("http://127.0.0.1:{port}/{name}");
    let address = Address::parse(Path::new(&text)).expect("an address");
    Locator::connect(&address, Connection { timeout: Duration::from_secs(5) }).expect("a client")
}

/// A server states 1 TiB in its length, or a range of 1 TiB, or sends 64 MiB without a length,
/// where 100 bytes were requested: 3 of 3 fail after at most 4 MiB.
#[test]
fn answers_longer_than_requested_are_refused() {
    for fields in [
        format!("Content-Range: bytes 0-99/1000\r\nContent-Length: {}", 1_u64 << 40),
        format!("Content-Range: bytes 0-{}/{}", (1_u64 << 40) - 1, 1_u64 << 40),
        "Content-Range: bytes 0-99/1000\r\nConnection: close".to_owned(),
    ] {
        let (port, _) = server(format!("HTTP/1.1 206 Partial Content\r\nETag: \"x\"\r\n{fields}\r\n\r\n"), true);
        let before = crate::stores::traffic::so_far().received;
        let place = locator(port, "a.helio");
        let opened = runtime().expect("a runtime").block_on(Object::open(&place, GetRange::Bounded(0..100)));
        assert!(opened.is_err(), "{fields}");
        let came = crate::stores::traffic::so_far().received - before;
        assert!(came < 4 << 20, "{fields}: {came}");
    }
}

/// A request that is redirected to another server does not tell it the signed address: 0 headers
/// `Referer`.
#[test]
fn redirects_do_not_pass_signed_addresses_on() {
    let (other, seen) =
        server("HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n".into(), false);
    let head = format!(
        "HTTP/1.1 302 Found\r\nLocation: http://localhost:{other}/b\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
    );
    let (port, _) = server(head, false);
    let place = locator(port, "a.helio?signature=secret");
    let opened = runtime().expect("a runtime").block_on(Object::open(&place, GetRange::Bounded(0..100)));
    assert_eq!(opened.expect_err("nothing there").cause, Cause::Missing);
    let request = seen.recv_timeout(Duration::from_secs(5)).expect("a second request").to_lowercase();
    assert!(request.starts_with("get /b") && !request.contains("referer") && !request.contains("secret"), "{request}");
}
