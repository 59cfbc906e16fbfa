//! Clients of the page that are slow, many, wrong or hostile: neither the render nor other clients
//! notice.

use super::http::{answer, ask, read_answer};
use super::{RENDER, Served};
use crate::support::{BOX, Folder};
use manylight_io::image::read_layered_image;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Longest time of an answer beside strangers.
const PROMPT: Duration = Duration::from_secs(5);

fn interrupt(served: &Served) {
    let id = served.child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &id])
            .status()
            .unwrap()
            .success()
    );
}

/// Sends `bytes`, and reads until the server closes the connection or `time` has passed.
fn exchange(host: &str, bytes: &[u8], time: Duration) -> String {
    let mut stream = TcpStream::connect(host).unwrap();
    stream.set_read_timeout(Some(time)).unwrap();
    // The server may close the connection before it has read everything.
    let _ = stream.write_all(bytes);
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

/// Checks that the page and its picture arrive promptly.
fn check_page(served: &Served) {
    let start = Instant::now();
    assert_eq!(served.get("").status, 200);
    assert_eq!(served.get("live.js").status, 200);
    assert!(start.elapsed() < PROMPT, "{:?}", start.elapsed());
    let path = format!("{}events/image", served.path);
    let mut stream = ask(&served.host, "GET", &path, &served.host);
    stream.set_read_timeout(Some(PROMPT)).unwrap();
    let (mut text, mut buffer) = (String::new(), [0; 4096]);
    while !text.contains("event: picture") {
        let count = stream.read(&mut buffer).unwrap();
        assert_ne!(count, 0, "{text}");
        text.push_str(&String::from_utf8_lossy(&buffer[..count]));
    }
}

/// Peak memory of a process in bytes; `None` if the system does not tell.
fn peak_bytes(id: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? * 1024)
}

#[test]
fn half_sent_requests_block_nobody() {
    let folder = Folder::new(BOX);
    // Fewer files than there are connections: a server that keeps all of them prevents the image,
    // too.
    let mut command = Command::new("sh");
    command
        .args(["-c", "ulimit -n 200; exec \"$0\" \"$@\""])
        .arg(env!("CARGO_BIN_EXE_manylight"))
        .args(RENDER.split(' '))
        .args(["--time", "60s", "-o", "a.exr", "--preview", "browser"])
        .current_dir(folder.path(""))
        .stderr(Stdio::piped())
        .stdout(Stdio::piped());
    let served = Served::of(command);
    let watching = ask(
        &served.host,
        "GET",
        &format!("{}events/image", served.path),
        &served.host,
    );
    check_page(&served);
    let mut silent: Vec<TcpStream> = Vec::new();
    for i in 0..400 {
        let mut stream = TcpStream::connect(&served.host).unwrap();
        if i % 2 == 0 {
            let _ = stream.write_all(b"GET / HTTP/1.1\r\nHost: 127");
        }
        silent.push(stream);
        if i % 100 == 99 {
            check_page(&served);
        }
    }
    interrupt(&served);
    // The one that showed the picture all the time received the last one.
    let events = read_answer(watching).body;
    assert!(events.contains("event: end"));
    let (ended, text) = served.end();
    ended.code(130);
    assert!(!text.contains("warning"), "{text}");
    read_layered_image(&folder.path("a.exr")).unwrap();
}

#[test]
fn half_sent_requests_end_after_seconds() {
    let folder = Folder::new(BOX);
    let served = Served::start(
        &folder,
        &format!("{RENDER} --time 60s -o a.exr --preview browser"),
    );
    let start = Instant::now();
    exchange(
        &served.host,
        b"GET / HTTP/1.1\r\nHost: 127",
        Duration::from_secs(30),
    );
    let waited = start.elapsed().as_secs_f64();
    assert!((5.0..25.0).contains(&waited), "{waited} s");
    interrupt(&served);
    served.end().0.code(130);
}

#[test]
fn wrong_requests_are_refused_and_cost_no_memory() {
    let folder = Folder::new(BOX);
    let served = Served::start(
        &folder,
        &format!("{RENDER} --time 60s -o a.exr -q --preview browser"),
    );
    let (host, path) = (served.host.as_str(), served.path.as_str());
    check_page(&served);
    let before = peak_bytes(served.child.id());

    for method in ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "BREW"] {
        assert_eq!(answer(host, method, path, host).status, 405, "{method}");
        assert_eq!(answer(host, method, "/", host).status, 404, "{method}");
    }
    for hidden in [
        "../../etc/passwd",
        "%2e%2e/%2e%2e/etc/passwd",
        "..%2f..%2fetc/passwd",
        "live.js/../../../etc/passwd",
        "events",
        "events/",
        "events/a/b",
        "events//etc/passwd",
    ] {
        let found = answer(host, "GET", &format!("{path}{hidden}"), host);
        assert_eq!((found.status, found.body.as_str()), (404, ""), "{hidden}");
    }
    let from = |origin: &str| {
        let request = format!(
            "GET {path} HTTP/1.1\r\nHost: {host}\r\nOrigin: {origin}\r\nConnection: close\r\n\r\n"
        );
        exchange(host, request.as_bytes(), PROMPT)
    };
    assert!(from(&format!("http://{host}")).starts_with("HTTP/1.1 200"));
    for foreign in [
        "http://example.org",
        "null",
        "https://127.0.0.1.example.org:80",
        "file://",
    ] {
        let answer = from(foreign);
        assert!(answer.starts_with("HTTP/1.1 403"), "{foreign}: {answer}");
        assert!(!answer.contains("access-control"));
    }

    let long = "x".repeat(4 << 20);
    for (request, codes) in [
        (
            format!("GET /{long} HTTP/1.1\r\nHost: {host}\r\n\r\n"),
            ["414", "431"],
        ),
        (
            format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nX: {long}\r\n\r\n"),
            ["431", "431"],
        ),
        (
            format!(
                "GET {path} HTTP/1.1\r\nHost: {host}\r\n{}\r\n",
                "A: b\r\n".repeat(5000)
            ),
            ["431", "400"],
        ),
        (
            format!(
                "POST {path} HTTP/1.1\r\nHost: {host}\r\nContent-Length: 99999999999\r\n\r\n{long}"
            ),
            ["405", "405"],
        ),
        (
            "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n".to_owned(),
            ["400", "505"],
        ),
        ("\u{1}\u{2}\0\r\n\r\n".to_owned(), ["400", "400"]),
        (
            format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nHost: evil\r\n\r\n"),
            ["403", "400"],
        ),
        (format!("GET {path} HTTP/1.1\r\n\r\n"), ["403", "400"]),
    ] {
        let answer = exchange(host, request.as_bytes(), Duration::from_secs(1));
        let shown = &request[..request.len().min(60)];
        // A connection that is closed while it still sends may lose the answer.
        let refused = answer.is_empty()
            || codes
                .iter()
                .any(|code| answer.starts_with(&format!("HTTP/1.1 {code}")));
        assert!(refused, "{shown}: {}", &answer[..answer.len().min(300)]);
    }
    // The render itself takes tens of megabytes meanwhile.
    if let (Some(before), Some(after)) = (before, peak_bytes(served.child.id())) {
        assert!(
            after < before + (200 << 20),
            "from {before} to {after} bytes"
        );
    }
    check_page(&served);
    interrupt(&served);
    served.end().0.code(130);
}

#[test]
fn many_pages_and_pages_that_vanish() {
    let folder = Folder::new(BOX);
    let served = Served::start(
        &folder,
        &format!("{RENDER} --time 60s -o a.exr --preview browser"),
    );
    let path = format!("{}events/image", served.path);
    check_page(&served);
    for _ in 0..3 {
        let pages: Vec<TcpStream> = (0..60)
            .map(|_| ask(&served.host, "GET", &path, &served.host))
            .collect();
        let status = |mut stream: TcpStream| {
            stream.set_read_timeout(Some(PROMPT)).unwrap();
            let mut line = [0; 12];
            stream.read_exact(&mut line).unwrap();
            (line[9..] == *b"503", stream)
        };
        let answers: Vec<(bool, TcpStream)> = pages.into_iter().map(status).collect();
        let refused = answers.iter().filter(|(refused, _)| *refused).count();
        assert!((28..=33).contains(&refused), "{refused} of 60 refused");
        drop(answers);
        // Pages that are gone are noticed with the next picture.
        let start = Instant::now();
        while answer(&served.host, "GET", &served.path, &served.host).status != 200 {}
        std::thread::sleep(Duration::from_millis(2500));
        check_page(&served);
        assert!(start.elapsed() < 2 * PROMPT);
    }
    interrupt(&served);
    let (ended, text) = served.end();
    ended.code(130);
    assert!(!text.contains("warning"), "{text}");
}
