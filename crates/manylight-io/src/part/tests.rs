//! Part files read back, and headers that lie.

use super::*;
use manylight::color::Rgb;
use manylight::film::arrays::arrays_of_sums;
use manylight::film::blocks::DEFAULT_BLOCK;
use manylight::film::{Film, FilmDesc, Filter, Half, IdLayer, Layer};
use manylight::math::UVec2;
use serde_json::{Map, Value, json};
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64};

fn film() -> Film {
    let desc = FilmDesc {
        size: UVec2::new(40, 30),
        crop_offset: UVec2::new(5, 2),
        crop_size: UVec2::new(19, 11),
        filter: Filter::Box,
    };
    let layers = [Layer::Beauty, Layer::Direct, Layer::Depth];
    let mut film = Film::with_blocks(desc, &layers, &[IdLayer::Material], DEFAULT_BLOCK, 0);
    for pass in 0..3 {
        film.begin_batch();
        film.set_half(Half::of_set(pass));
        film.add_pass(&AtomicBool::new(false), &AtomicU64::new(0), |samples| {
            for (i, pixel) in samples.tile().pixels().enumerate() {
                samples.add(
                    i,
                    Layer::Direct,
                    Rgb::new(pixel.x as f32, pixel.y as f32, 1.0 / (pass + 1) as f32),
                );
                samples.add_id(i, IdLayer::Material, (pixel.x * pass) % 4, 0.5);
            }
        });
    }
    film
}

fn write(path: &Path, film: &Film) {
    let render = Map::from_iter([("seed".to_owned(), json!(7))]);
    let header = PartHeader::new(film, render, json!({ "seconds": 1.5 }), Value::Null);
    write_part(
        path,
        &header,
        &[("block.0.".into(), arrays_of_sums(film, film.current()))],
    )
    .unwrap();
}

#[test]
fn the_same_part_has_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let film = film();
    let bytes = |k: u32| {
        let path = folder.path().join(format!("{k}.part"));
        write(&path, &film);
        fs::read(path).unwrap()
    };
    let first = bytes(0);
    assert!((1..16).all(|k| bytes(k) == first));
}

#[test]
fn a_part_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.part");
    let film = film();
    write(&path, &film);
    let part = PartFile::open(&path).unwrap();
    part.verify().unwrap();
    assert_eq!(part.header().render["seed"], 7);
    assert_eq!(part.groups(), ["block.0."]);
    let read = part.film("block.0.").unwrap();
    assert_eq!(
        (read.desc(), read.layers(), read.id_layers()),
        (film.desc(), film.layers(), film.id_layers())
    );
    assert_eq!(&part.sums("block.0.", &read).unwrap(), film.current());
    assert!(
        part.sums("block.1.", &read)
            .unwrap_err()
            .message
            .contains("block.1.passes is missing")
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// A part is read in several steps.
#[test]
fn a_part_that_is_replaced_while_it_is_read_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.part");
    let film = film();
    write(&path, &film);
    let part = PartFile::open(&path).unwrap();
    let header = PartHeader::new(&film, Map::new(), Value::Null, Value::Null);
    let groups = [("block.0.".into(), arrays_of_sums(&film, film.current()))];
    write_part(&path, &header, &groups).unwrap();
    for message in [
        part.verify().unwrap_err().message,
        part.sums("block.0.", &film).unwrap_err().message,
    ] {
        assert!(message.contains("replaced"), "{message}");
    }
}

/// The numbers of a header are compared with the size of the file before memory is taken.
#[test]
fn a_header_with_a_huge_film_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.part");
    write(&path, &film());
    let bytes = fs::read(&path).unwrap();
    let replaced = |from: &str, to: &str| {
        assert_eq!(from.len(), to.len());
        let place = bytes
            .windows(from.len())
            .position(|window| window == from.as_bytes())
            .unwrap();
        let mut bytes = bytes.clone();
        bytes[place..place + to.len()].copy_from_slice(to.as_bytes());
        fs::write(&path, bytes).unwrap();
        PartFile::open(&path)
    };
    let mut part = replaced(r#"[19,11]"#, r#"[9e9,9]"#);
    assert!(part.is_err());
    part = replaced(r#"[19,11]"#, r#"[99,99]"#);
    assert!(
        part.unwrap()
            .film("block.0.")
            .unwrap_err()
            .message
            .contains("99 x 99")
    );
    part = replaced(r#"[11,19,3]"#, r#"[99,99,3]"#);
    assert!(part.is_err());
    part = replaced(r#"\"layers\":[\"beauty\""#, r#"\"layers\":[\"direct\""#);
    assert!(
        part.unwrap()
            .film("block.0.")
            .unwrap_err()
            .message
            .contains("beauty first")
    );
    part = replaced(r#"\"block\":16"#, r#"\"block\":12"#);
    assert!(
        part.unwrap()
            .film("block.0.")
            .unwrap_err()
            .message
            .contains("multiple of 8")
    );
}

#[test]
fn another_safetensors_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("weights.safetensors");
    let json = br#"{"w":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}}  "#;
    let bytes = [&(json.len() as u64).to_le_bytes(), json.as_slice(), &[0; 4]].concat();
    fs::write(&path, bytes).unwrap();
    assert!(
        PartFile::open(&path)
            .unwrap_err()
            .message
            .contains("expected a part of a render")
    );
}

#[test]
fn lights_are_no_part_and_a_part_is_no_lights() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.part");
    write(&path, &film());
    let refused = LightsFile::open(&path).unwrap_err().message;
    assert!(
        refused.contains("expected a file of virtual lights"),
        "{refused}"
    );
}
