//! `--preview tev`: packets, and viewers that are missing, slow, or go away.

use super::tev_reader::{Received, TevImage, listen, read_all, read_packet};
use super::{RENDER, is_of_noise, plain_image, run, warnings};
use crate::support::{BOX, Folder};
use manylight_io::image::read_layered_image;
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::process::Stdio;
use std::sync::mpsc::channel;
use std::time::Duration;

/// Checks that the image holds the layers of the file but those of its noise and mattes, bit by
/// bit.
fn check_final(image: &TevImage, folder: &Folder, file: &str) {
    let picture = read_layered_image(&folder.path(file)).unwrap();
    assert_eq!((image.width, image.height), (picture.width, picture.height));
    let expected: Vec<&(String, Vec<f32>)> = (picture.layers.iter())
        .filter(|layer| !is_of_noise(&layer.name) && !layer.name.starts_with("Crypto"))
        .flat_map(|layer| &layer.channels)
        .collect();
    assert_eq!(image.channels.len(), expected.len());
    for (name, values) in expected {
        assert!(image.channel(name) == values, "{name}");
    }
}

#[test]
fn tev_shows_all_layers_of_the_final_image() {
    let folder = Folder::new(BOX);
    let expected = plain_image(&folder, "--passes 3");
    let (address, viewer) = listen("127.0.0.1");
    let options = format!("--passes 3 --preview tev:{address} -o layers.exr");
    let (ended, _) = run(&folder, &options, &expected);
    assert_eq!(warnings(&ended), [""; 0]);
    let received = viewer.join().unwrap();
    assert_eq!(received.created, 1);
    let (name, image) = received.images.first_key_value().unwrap();
    assert_eq!(name, "layers.exr");
    assert!(image.updates >= 2, "the picture grows");
    assert_eq!(image.channels[0].0, "R");
    check_final(image, &folder, "layers.exr");
}

#[test]
fn every_method_and_limit_has_a_preview() {
    let folder = Folder::new(BOX);
    let list = folder.run("list methods").code(0).stdout();
    // Lines with settings are indented.
    let names = list.lines().filter(|line| !line.starts_with(' '));
    let mut options: Vec<String> = names
        .map(|line| format!("-m {} --passes 2", line.split(' ').next().unwrap()))
        .collect();
    assert!(options.len() >= 15, "{list}");
    options.push("-m path --time 1s".into());
    options.push("-m path --target-error 0.2".into());
    for options in options {
        let (address, viewer) = listen("127.0.0.1");
        let words = format!("render scene.xml {options} -o a.exr --preview tev:{address}");
        folder.run(&words).code(0);
        let received = viewer.join().unwrap();
        check_final(&received.images["a.exr"], &folder, "a.exr");
    }
}

#[test]
fn hosts_have_names_and_new_addresses() {
    let folder = Folder::new(BOX);
    let (address, viewer) = listen("127.0.0.1");
    let port = address.port();
    let words =
        format!("render scene.xml -m direct --passes 1 -o a.exr --preview tev:localhost:{port}");
    folder.run(&words).code(0);
    assert!(viewer.join().unwrap().images.contains_key("a.exr"));
    if TcpListener::bind("[::1]:0").is_err() {
        println!("skipped: no IPv6 here");
        return;
    }
    let (address, viewer) = listen("::1");
    let words = format!("render scene.xml -m direct --passes 1 -o a.exr --preview tev:{address}");
    folder.run(&words).code(0);
    assert!(viewer.join().unwrap().images.contains_key("a.exr"));
}

#[test]
fn a_missing_viewer_is_one_warning() {
    let folder = Folder::new(BOX);
    let expected = plain_image(&folder, "--passes 3");
    let address = TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap();
    for viewer in [address.to_string(), "no-such-host.invalid:80".into()] {
        let options = format!("--passes 3 --preview tev:{viewer}");
        let (ended, time) = run(&folder, &options, &expected);
        let warnings = warnings(&ended);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(warnings[0].contains(&viewer), "{warnings:?}");
        assert!(warnings[0].contains("does not answer"), "{warnings:?}");
        assert!(time < Duration::from_secs(20), "{time:?}");
        // No picture was made for nobody.
        let (ended, _) = run(&folder, &format!("{options} -q --json"), &expected);
        assert_eq!(ended.stderr(), "");
        assert_eq!(ended.json()["warnings"].as_array().unwrap().len(), 0);
    }
}

#[test]
fn a_viewer_that_reads_nothing_is_one_warning() {
    let folder = Folder::new(BOX);
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    // 23 MB, more than the buffers of the system.
    let options = "--size 640x480 --passes 2";
    let words = |more: &str| format!("render scene.xml -m path {options} {more}");
    folder.run(&words("-o plain.pfm -q")).code(0);
    let start = std::time::Instant::now();
    let ended = folder
        .run(&words(&format!("-o shown.pfm --preview tev:{address}")))
        .code(0);
    let time = start.elapsed();
    let (silent, _) = listener.accept().unwrap();
    drop(silent);
    let read = |name| std::fs::read(folder.path(name)).unwrap();
    assert!(read("plain.pfm") == read("shown.pfm"));
    let warnings = warnings(&ended);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("read"), "{warnings:?}");
    assert!(time < Duration::from_secs(40), "{time:?}");
}

#[test]
fn a_viewer_may_go_away_and_come_back() {
    let folder = Folder::new(BOX);
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let (gone, came) = channel();
    let viewer = std::thread::spawn(move || {
        let (mut first, _) = listener.accept().unwrap();
        let mut received = Received::default();
        received.apply(&read_packet(&mut first).unwrap());
        received.apply(&read_packet(&mut first).unwrap());
        drop(first);
        let (second, _) = listener.accept().unwrap();
        gone.send(()).unwrap();
        read_all(second)
    });
    let words = format!("{RENDER} --time 9s -o a.exr --preview tev:{address}");
    let ended = folder.run(&words).code(0);
    came.recv_timeout(Duration::from_secs(1))
        .expect("the viewer is found again");
    let received = viewer.join().unwrap();
    assert_eq!(received.created, 1, "the image is made anew");
    check_final(&received.images["a.exr"], &folder, "a.exr");
    let warnings = warnings(&ended);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("gone away"), "{warnings:?}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_image_is_shown() {
    let folder = Folder::new(BOX);
    let (address, viewer) = listen("127.0.0.1");
    let words = format!("{RENDER} --time 60s -v --progress plain -o a.exr --preview tev:{address}");
    let mut command = folder.command(&words);
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("loading") {
        line.clear();
        assert_ne!(stderr.read_line(&mut line).unwrap(), 0);
    }
    let id = child.id().to_string();
    let kill = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status();
    assert!(kill.unwrap().success());
    std::io::copy(&mut stderr, &mut std::io::sink()).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    check_final(&viewer.join().unwrap().images["a.exr"], &folder, "a.exr");
}
