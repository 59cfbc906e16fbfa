//! Names in any bytes, and texts of files that a terminal would obey.

use super::soon;
use crate::support::{BOX, Ended, Folder};
use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::process::Command;

fn program(folder: &Folder, words: &[&[u8]]) -> Command {
    let mut command = folder.command("");
    command.args(words.iter().map(|word| OsStr::from_bytes(word)));
    command
}

/// Checks that no text for people has a character that a terminal obeys, but line ends. JSON is for
/// programs.
#[track_caller]
fn is_harmless(ended: &Ended) {
    let mut text = ended.stderr();
    if !ended.stdout().starts_with('{') {
        text += &ended.stdout();
    }
    let obeyed = |c: char| c.is_control() && c != '\n' || ('\u{202a}'..='\u{202e}').contains(&c);
    assert!(!text.contains(obeyed), "{text:?}");
}

#[test]
fn names_have_any_bytes() {
    let folder = Folder::new(BOX);
    for name in [
        &b"a b"[..],
        b"\xff\xfe",
        b"a\nb",
        b"\x1b]0;title\x07",
        b"\xc2\x9b31m",
        b"-x",
        b"%s{}",
        b"\xe2\x80\xaegnp",
    ] {
        let place = |extension: &[u8]| [b"./", name, extension].concat();
        let [scene, image, part] = [&b".xml"[..], b".exr", b".part"].map(place);
        let path = |name: &[u8]| folder.path("").join(OsStr::from_bytes(name));
        fs::write(path(&scene), BOX).unwrap();
        let words: [&[u8]; 12] = [
            b"render",
            &scene,
            b"-m",
            b"path",
            b"--passes",
            b"2",
            b"-v",
            b"-o",
            &image,
            b"--checkpoint",
            &part,
            b"--json",
        ];
        let ended = soon(&mut program(&folder, &words)).code(0);
        assert!(path(&image).exists() && path(&part).exists());
        ended.json();
        is_harmless(&ended);
        is_harmless(&soon(&mut program(&folder, &[b"compare", &image, &image])).code(0));
        is_harmless(&soon(&mut program(&folder, &[b"info", &scene])).code(0));
        is_harmless(&soon(&mut program(&folder, &[b"check", &scene])).code(0));
        fs::remove_file(path(&scene)).unwrap();
        let lost = soon(&mut program(&folder, &[b"render", &scene])).code(4);
        is_harmless(&lost);
        assert!(lost.stderr().lines().count() <= 6, "{}", lost.stderr());
        fs::write(path(&scene), "<scene").unwrap();
        is_harmless(&soon(&mut program(&folder, &[b"render", &scene])).code(3));
        let unwritable = [b"nowhere/", name, b".exr"].concat();
        is_harmless(
            &soon(&mut program(
                &folder,
                &[b"render", b"scene.xml", b"-o", &unwritable],
            ))
            .code(4),
        );
    }
}

#[test]
fn excerpts_are_shown_and_not_obeyed() {
    let folder = Folder::new(BOX);
    let evil = "\u{9b}31m\u{202e}\u{7f}";
    for (name, text) in [
        ("a.xml", format!("<scene version=\"3.0.0\">\n<shape type=\"{evil}\" id=\"{evil}\"/>\n<bsdf type=\"{evil}\"/></scene>")),
        ("b.xml", BOX.replace("</scene>", &format!("<shape type=\"ply\"><string name=\"filename\" value=\"{evil}\"/></shape></scene>"))),
        ("a.pbrt", format!("WorldBegin\nShape \"\u{1b}]0;x\u{7}{evil}\"\nTexture \"{evil}\u{1b}[2J\" \"float\" \"{evil}\"\n")),
        ("a.gltf", format!("{{\"asset\": {{\"version\": \"{evil}\\u001b[2J\"}}, \"x{evil}\": 3}}")),
        ("garbage", format!("\u{1b}[2J{evil}\n")),
    ] {
        fs::write(folder.path(name), text).unwrap();
        for command in ["check", "render"] {
            let ended = soon(&mut folder.command(&format!("{command} {name}"))).code(3);
            is_harmless(&ended);
            assert!(ended.stderr().contains('×'));
        }
    }
    // A camera with a name from a file.
    let named = BOX.replace(
        "<sensor type=\"perspective\">",
        &format!("<sensor type=\"perspective\" id=\"{evil}\">"),
    );
    fs::write(folder.path("named.xml"), named).unwrap();
    is_harmless(&soon(&mut folder.command("info named.xml")).code(0));
}
