//! A render never waits for a viewer, and a missing viewer gets no pictures.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on shall fail")]

use manylight_io::image::ImageLayer;
use manylight_preview::{
    Picture, Preview, PreviewTarget, Progress, RenderInfo, RenderState, TevAddress,
};
use std::io::Read;
use std::net::TcpListener;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// A picture of 8 MB.
fn picture(passes: u32, state: RenderState) -> Picture {
    let (width, height) = (1000, 500);
    let channel = |name: &str| (name.to_owned(), vec![passes as f32; width * height]);
    Picture {
        width,
        height,
        layers: vec![ImageLayer {
            name: String::new(),
            channels: ["R", "G", "B", "A"].map(channel).into(),
        }],
        progress: Progress {
            passes,
            seconds: 1.0,
            error: None,
            state,
        },
    }
}

fn start(address: TevAddress) -> (Preview, Arc<Mutex<Vec<String>>>) {
    let warnings = Arc::new(Mutex::new(Vec::new()));
    let told = warnings.clone();
    let warn = Arc::new(move |warning| told.lock().unwrap().push(warning));
    let target = PreviewTarget::Tev(address);
    let preview = Preview::start(&target, RenderInfo::default(), warn).unwrap();
    (preview, warnings)
}

fn local(port: u16) -> TevAddress {
    TevAddress {
        host: "127.0.0.1".into(),
        port,
    }
}

#[test]
fn a_slow_viewer_costs_no_time_and_gets_the_last_picture() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let (mut preview, warnings) = start(local(listener.local_addr().unwrap().port()));
    let (mut viewer, _) = listener.accept().unwrap();
    let mut longest = Duration::ZERO;
    for passes in 1..=30 {
        let picture = picture(passes, RenderState::Rendering);
        let start = Instant::now();
        preview.finish(|| picture);
        longest = longest.max(start.elapsed());
    }
    assert!(longest < Duration::from_millis(500), "{longest:?}");
    preview.finish(|| picture(31, RenderState::Done));

    let reader = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        viewer.read_to_end(&mut bytes).unwrap();
        bytes
    });
    preview.close();
    let bytes = reader.join().unwrap();
    // At least one picture was dropped, and the last value is that of the last picture.
    assert!(bytes.len() < 30 * 8_000_000, "{} bytes", bytes.len());
    assert_eq!(bytes[bytes.len() - 4..], 31_f32.to_le_bytes());
    assert!(warnings.lock().unwrap().is_empty());
}

#[test]
fn nobody_gets_no_pictures() {
    let free = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = free.local_addr().unwrap().port();
    drop(free);
    let (mut preview, warnings) = start(local(port));
    let begun = Instant::now();
    while warnings.lock().unwrap().is_empty() {
        assert!(begun.elapsed() < Duration::from_secs(10));
        std::thread::sleep(Duration::from_millis(5));
    }
    preview.update(|| unreachable!("nobody wants a picture"));
    preview.finish(|| unreachable!("nobody wants a picture"));
    let end = Instant::now();
    preview.close();
    assert!(end.elapsed() < Duration::from_millis(500));
    let warnings = warnings.lock().unwrap();
    assert_eq!(warnings.len(), 1);
    assert!(
        warnings[0].contains(&format!("127.0.0.1:{port} does not answer")),
        "{warnings:?}"
    );
}

#[test]
fn pictures_have_a_pace() {
    let info = RenderInfo::default();
    let warn = Arc::new(|warning| panic!("{warning}"));
    let target = PreviewTarget::Browser { port: 0 };
    let mut preview = Preview::start(&target, info, warn).unwrap();
    let mut made = 0;
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_millis(1500) {
        preview.update(|| {
            made += 1;
            picture(made, RenderState::Rendering)
        });
    }
    assert!((1..=2).contains(&made), "{made} pictures in 1.5 s");
    preview.close();
}
