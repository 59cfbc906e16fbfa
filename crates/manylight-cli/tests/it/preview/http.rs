//! A client of the page: requests as text, and the events of a stream.

use serde_json::Value;
use std::io::{Read, Write};
use std::net::TcpStream;

/// The answer to a request.
#[derive(Debug)]
pub(super) struct Answer {
    pub(super) status: u16,
    /// Status line and headers.
    pub(super) head: String,
    pub(super) body: String,
}

/// An event of a stream, with its data if these are JSON.
#[derive(Debug, PartialEq)]
pub(super) struct SentEvent {
    pub(super) name: String,
    pub(super) data: Value,
}

/// The parts of `http://HOST:PORT/PATH`.
pub(super) fn parts(address: &str) -> (String, String) {
    let rest = address.strip_prefix("http://").unwrap();
    let (host, path) = rest.split_once('/').unwrap();
    (host.into(), format!("/{path}"))
}

/// Sends a request to `host`, with `name` in its header `Host`; the connection, to read from.
pub(super) fn ask(host: &str, method: &str, path: &str, name: &str) -> TcpStream {
    let mut stream = TcpStream::connect(host).unwrap();
    let request = format!("{method} {path} HTTP/1.1\r\nHost: {name}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    stream
}

/// The whole answer to a request.
pub(super) fn answer(host: &str, method: &str, path: &str, name: &str) -> Answer {
    read_answer(ask(host, method, path, name))
}

/// Reads an answer until the server closes the connection.
pub(super) fn read_answer(mut stream: TcpStream) -> Answer {
    let mut bytes = Vec::new();
    stream.read_to_end(&mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let (head, body) = text.split_once("\r\n\r\n").unwrap();
    let is_chunked = head.to_lowercase().contains("transfer-encoding: chunked");
    Answer {
        status: head.split(' ').nth(1).unwrap().parse().unwrap(),
        head: head.into(),
        body: if is_chunked {
            joined(body)
        } else {
            body.into()
        },
    }
}

/// A body of chunks as one text.
fn joined(mut body: &str) -> String {
    let mut text = String::new();
    while let Some((length, rest)) = body.split_once("\r\n") {
        let length = usize::from_str_radix(length, 16).unwrap();
        text.push_str(&rest[..length]);
        body = &rest[length + 2..];
    }
    text
}

/// The events in the body of a stream.
pub(super) fn events(body: &str) -> Vec<SentEvent> {
    let blocks = body
        .split("\n\n")
        .filter(|block| block.starts_with("event"));
    let field = |block: &str, name: &str| {
        let line = block.lines().find_map(|line| line.strip_prefix(name));
        line.unwrap_or_default().trim().to_owned()
    };
    blocks
        .map(|block| SentEvent {
            name: field(block, "event:"),
            data: serde_json::from_str(&field(block, "data:")).unwrap_or_default(),
        })
        .collect()
}
