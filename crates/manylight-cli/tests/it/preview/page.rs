//! `--preview browser`: who may see the page, and what it receives.

use super::http::{answer, ask, events, parts, read_answer};
use super::{RENDER, Served, is_of_noise, plain_image, run, warnings};
use crate::support::{BOX, Folder};
use manylight_io::image::read_layered_image;
use manylight_lab::viewer::halves;
use serde_json::Value;
use std::io::{BufRead, Read};
use std::net::TcpListener;
use std::time::{Duration, Instant};

#[test]
fn the_page_receives_the_growing_picture() {
    let folder = Folder::new(BOX);
    let served = Served::start(
        &folder,
        &format!("{RENDER} --time 3s -o a.exr --preview browser:0"),
    );
    let stream = served.get("events/direct");
    assert_eq!(stream.status, 200);
    assert!(stream.head.contains("content-type: text/event-stream"));
    let (ended, _) = served.end();
    ended.code(0);

    let events = events(&stream.body);
    let (end, pictures) = events.split_last().unwrap();
    assert_eq!(end.name, "end");
    assert!(pictures.iter().all(|event| event.name == "picture"));
    let growing = |event: &&super::http::SentEvent| event.data["state"] == "rendering";
    let passes: Vec<u64> = (pictures.iter().filter(growing))
        .map(|event| event.data["passes"].as_u64().unwrap())
        .collect();
    assert!(
        (1..=5).contains(&passes.len()),
        "{passes:?} in three seconds"
    );
    assert!(passes.is_sorted(), "{passes:?}");
    for event in pictures.iter().filter(growing) {
        let layer = event.data["layer"].as_u64().unwrap() as usize;
        assert_eq!(event.data["layers"][layer]["name"], "direct");
    }
    let last: Vec<&Value> = (pictures.iter().filter(|event| !growing(event)))
        .map(|event| &event.data)
        .collect();
    assert!(last[0]["passes"].as_u64() > passes.first().copied());
    check_final(&last, &folder, "a.exr");
}

#[test]
fn a_page_that_weighs_lights_receives_their_groups() {
    let folder = Folder::new(BOX);
    let options = "--light-group lamp=* --time 3s -o a.exr --preview browser:0";
    let served = Served::start(&folder, &format!("{RENDER} {options}"));
    let stream = served.get("events/image?lights");
    served.end().0.code(0);

    let events = events(&stream.body);
    let name = |data: &Value| {
        let layer = data["layer"].as_u64().unwrap() as usize;
        data["layers"][layer]["name"].as_str().unwrap().to_owned()
    };
    let first = events[0].data["passes"].as_u64();
    assert_eq!(events[0].data["state"], "rendering");
    let pictures = events.iter().map(|event| &event.data);
    let names: Vec<String> = pictures
        .filter(|data| data["passes"].as_u64() == first && data["state"] == "rendering")
        .map(name)
        .collect();
    assert_eq!(names, ["image", "Combined_lamp"]);
}

/// Checks that the events hold every layer of the file but those of its noise.
fn check_final(last: &[&Value], folder: &Folder, file: &str) {
    let picture = read_layered_image(&folder.path(file)).unwrap();
    let layers = || (picture.layers.iter()).filter(|layer| !is_of_noise(&layer.name));
    assert_eq!(last.len(), layers().count());
    assert_eq!(last[0]["state"], "done");
    assert!(last[0]["error"].as_f64().unwrap() > 0.0);
    for layer in layers() {
        let name = if layer.name.is_empty() {
            "image"
        } else {
            &layer.name
        };
        let index = (last[0]["layers"].as_array().unwrap().iter())
            .position(|entry| entry["name"] == *name)
            .unwrap();
        let event = last.iter().find(|event| event["layer"] == index);
        let event = event.unwrap_or_else(|| panic!("no layer {name}"));
        // The file sorts channels by name.
        let parts = last[0]["layers"][index]["channels"].as_array().unwrap();
        assert_eq!(parts.len(), layer.channels.len());
        let channel = |part: &Value| {
            let part = part.as_str().unwrap();
            let mut channels = layer.channels.iter();
            let found = channels.find(|channel| channel.0.rsplit('.').next() == Some(part));
            found.unwrap().1.as_slice()
        };
        let channels: Vec<&[f32]> = parts.iter().map(channel).collect();
        let values = (0..picture.width * picture.height)
            .flat_map(|i| channels.iter().map(move |channel| channel[i]));
        assert!(event["values"] == halves(values), "{name}");
    }
}

#[test]
fn only_those_who_know_the_address_see_the_page() {
    let folder = Folder::new(BOX);
    let words = format!("{RENDER} --time 20s -o a.exr -q --preview browser");
    let served = Served::start(&folder, &words);
    let (host, path) = (served.host.as_str(), served.path.as_str());
    assert!(host.starts_with("127.0.0.1:"));
    assert_eq!(path.len(), 34, "128 random bits: {path}");
    let status = |method, path: &str, name: &str| answer(host, method, path, name).status;

    let page = served.get("");
    assert_eq!(page.status, 200);
    assert!(page.body.contains("scene.xml, path"));
    for header in [
        "content-security-policy: default-src 'none'",
        "referrer-policy: no-referrer",
        "cache-control: no-store",
    ] {
        assert!(page.head.contains(header), "{}", page.head);
    }
    assert!(!page.head.contains("access-control"), "{}", page.head);
    for part in ["page.css", "shared.js", "live.js"] {
        assert_eq!(served.get(part).status, 200);
    }
    assert_eq!(status("GET", path.trim_end_matches('/'), host), 308);
    assert_eq!(status("HEAD", path, host), 200);
    for tunneled in ["localhost:9", "127.0.0.1", "LOCALHOST", "[::1]:80"] {
        assert_eq!(status("GET", path, tunneled), 200, "{tunneled}");
    }

    for foreign in ["example.org", "127.0.0.1.example.org", "10.1.2.3:80", ""] {
        assert_eq!(status("GET", path, foreign), 403, "{foreign}");
        assert_eq!(status("GET", &format!("{path}events/image"), foreign), 403);
        assert_eq!(status("GET", "/", foreign), 403);
    }
    let wrong = format!("/{}/", "0".repeat(32));
    let longer = format!("{path}../{}", &path[1..]);
    for unknown in [
        "/",
        "/index.html",
        "/favicon.ico",
        "/events/image",
        &wrong,
        &longer,
        &path[..30],
        "//",
    ] {
        let found = status("GET", unknown, host);
        assert_eq!(found, 404, "{unknown}");
    }
    assert_eq!(status("POST", path, host), 405);

    let id = served.child.id().to_string();
    let kill = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status();
    assert!(kill.unwrap().success());
    let (ended, text) = served.end();
    ended.code(130);
    assert_eq!(text, "", "--quiet prints the address alone");
}

#[test]
fn a_page_that_opens_late_or_leaves_changes_nothing() {
    let folder = Folder::new(BOX);
    let expected = plain_image(&folder, "--passes 2");
    let start = Instant::now();
    let (ended, _) = run(&folder, "--passes 2 --preview browser", &expected);
    assert_eq!(warnings(&ended), [""; 0]);
    assert!(start.elapsed() < Duration::from_secs(20));

    let served = Served::start(
        &folder,
        &format!("{RENDER} --time 4s -o a.exr --preview browser"),
    );
    let events_path = format!("{}events/image", served.path);
    drop(ask(&served.host, "GET", &events_path, &served.host));
    std::thread::sleep(Duration::from_secs(2));
    // The latest picture is there at once.
    let mut stream = ask(&served.host, "GET", &events_path, &served.host);
    stream
        .set_read_timeout(Some(Duration::from_millis(900)))
        .unwrap();
    let mut first = [0; 4096];
    let mut text = String::new();
    while !text.contains("event: picture") {
        let count = stream.read(&mut first).expect("a picture within a second");
        text.push_str(std::str::from_utf8(&first[..count]).unwrap());
    }
    drop(stream);
    served.end().0.code(0);
}

#[test]
fn a_page_that_reads_nothing_delays_the_end_by_seconds_only() {
    let folder = Folder::new(BOX);
    // 24 MB of events, more than the buffers of the system.
    let words = "render scene.xml -m path --size 800x600 --passes 2 -o a.exr --preview browser";
    let mut served = Served::start(&folder, words);
    let path = format!("{}events/image", served.path);
    let _silent = ask(&served.host, "GET", &path, &served.host);
    let mut line = String::new();
    while !line.starts_with("wrote a.exr") {
        line.clear();
        assert_ne!(served.stderr.read_line(&mut line).unwrap(), 0);
    }
    let start = Instant::now();
    let (ended, text) = served.end();
    ended.code(0);
    assert!(
        text.contains("did not receive the whole last picture"),
        "{text}"
    );
    assert_eq!(text.matches("warning").count(), 1, "{text}");
    let delay = start.elapsed();
    assert!((4.0..20.0).contains(&delay.as_secs_f64()), "{delay:?}");
}

#[test]
fn a_busy_port_is_one_warning() {
    let folder = Folder::new(BOX);
    let busy = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = busy.local_addr().unwrap().port();
    let ended = folder
        .run(&format!(
            "render scene.xml -m direct --passes 1 -o a.exr --preview browser:{port}"
        ))
        .code(0);
    let warnings = warnings(&ended);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains(&format!("browser:{port}: the port is not available")));
    let text = ended.stderr();
    let address = text.lines().find_map(|line| line.strip_prefix("preview: "));
    let (host, _) = parts(address.unwrap());
    assert_ne!(host, format!("127.0.0.1:{port}"));
    assert!(folder.path("a.exr").exists());

    drop(busy);
    let ended = folder
        .run(&format!(
            "render scene.xml -m direct --passes 1 -o a.exr --preview browser:{port}"
        ))
        .code(0);
    ended.says(&[&format!("preview: http://127.0.0.1:{port}/")]);
}

#[test]
fn the_last_picture_of_an_interrupted_render_arrives() {
    let folder = Folder::new(BOX);
    let served = Served::start(
        &folder,
        &format!("{RENDER} --time 60s -o a.exr --preview browser"),
    );
    let path = format!("{}events/image", served.path);
    let stream = ask(&served.host, "GET", &path, &served.host);
    std::thread::sleep(Duration::from_millis(500));
    let id = served.child.id().to_string();
    let kill = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status();
    assert!(kill.unwrap().success());
    let events = events(&read_answer(stream).body);
    served.end().0.code(130);
    let (end, pictures) = events.split_last().unwrap();
    assert_eq!(end.name, "end");
    assert_eq!(pictures.last().unwrap().data["state"], "interrupted");
}
