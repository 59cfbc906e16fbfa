//! Files that are no files, and files that change while they are read.

use super::{make_pipe, soon, succeeds};
use crate::support::{BOX, Folder};
use std::fs;
use std::os::unix::fs::symlink;
use std::time::{Duration, Instant};

/// [`BOX`] with one more element.
fn box_with(element: &str) -> String {
    BOX.replace("</scene>", &format!("{element}\n</scene>"))
}

const TEXTURED: &str = r#"<shape type="sphere"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">
    <string name="filename" value="$file"/></texture></bsdf></shape>"#;
const MESH: &str = r#"<shape type="ply"><string name="filename" value="$file"/></shape>"#;

#[test]
fn only_regular_files_are_read() {
    let folder = Folder::new(BOX);
    let write = |name: &str, text: &str| fs::write(folder.path(name), text).unwrap();
    make_pipe(&folder, "pipe");
    write("textured.xml", &box_with(TEXTURED));
    write("mesh.xml", &box_with(MESH));
    write("including.xml", &box_with(r#"<include filename="$file"/>"#));
    write(
        "s.pbrt",
        "Camera \"perspective\"\nWorldBegin\nInclude \"pipe\"\n",
    );
    write(
        "mesh.pbrt",
        "Camera \"perspective\"\nWorldBegin\nShape \"plymesh\" \"string filename\" \"pipe\"\n",
    );
    write(
        "s.gltf",
        r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "accessors": [{"bufferView": 0,
            "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": "pipe", "byteLength": 36}]}"#,
    );
    let before = folder.files();
    for (words, found) in [
        ("render pipe -o a.exr", "a pipe"),
        ("render /dev/zero -o a.exr", "a device"),
        ("render . -o a.exr", "a folder"),
        ("info pipe", "a pipe"),
        ("check /dev/zero", "a device"),
        ("maps pipe -o maps", "a pipe"),
        ("render textured.xml -D file=pipe -o a.exr", "a pipe"),
        ("render textured.xml -D file=/dev/zero -o a.exr", "a device"),
        ("render mesh.xml -D file=pipe -o a.exr", "a pipe"),
        ("render mesh.xml -D file=/dev/zero -o a.exr", "a device"),
        ("render including.xml -D file=pipe -o a.exr", "a pipe"),
        ("render s.pbrt -o a.exr", "a pipe"),
        ("render mesh.pbrt -o a.exr", "a pipe"),
        ("render s.gltf -o a.exr", "a pipe"),
        ("render scene.xml --resume pipe -o a.exr", "a pipe"),
        ("merge pipe -o a.exr", "a pipe"),
        ("merge /dev/zero -o a.exr", "a device"),
        ("compare pipe pipe", "a pipe"),
        ("study pipe", "a pipe"),
    ] {
        let ended = soon(&mut folder.command(words));
        let ended = ended.code(4);
        ended.says(&[&format!("found {found}, expected a regular file")]);
    }
    assert_eq!(folder.files(), before);
}

#[test]
fn a_file_larger_than_the_memory_is_refused() {
    let folder = Folder::new(BOX);
    let file = fs::File::create(folder.path("huge.xml")).unwrap();
    // A file of zeros that takes no room on the disk.
    if file.set_len(15 << 40).is_err() {
        println!("skipped: no sparse files here");
        return;
    }
    let ended = soon(&mut folder.command("render huge.xml -o a.exr"));
    ended.code(4).says(&["more than the memory has"]);
}

#[test]
fn links_are_followed_and_loops_are_one_message() {
    let folder = Folder::new(BOX);
    symlink("scene.xml", folder.path("link.xml")).unwrap();
    symlink("loop2.xml", folder.path("loop1.xml")).unwrap();
    symlink("loop1.xml", folder.path("loop2.xml")).unwrap();
    symlink("nowhere.xml", folder.path("lost.xml")).unwrap();
    let words = "-m direct --passes 1 -q -o a.pfm";
    soon(&mut folder.command(&format!("render link.xml {words}"))).code(0);
    for name in ["loop1.xml", "lost.xml"] {
        let ended = soon(&mut folder.command(&format!("render {name} {words}"))).code(4);
        let text = ended.stderr();
        assert!(!text.contains(&format!("did you mean `{name}`")), "{text}");
    }
}

#[test]
fn files_that_change_while_they_are_read_are_one_message() {
    let folder = Folder::new(&box_with(MESH));
    // A grid of 200 x 200 vertices, 2.5 MB.
    let mut mesh = String::from(
        "ply\nformat ascii 1.0\nelement vertex 40000\nproperty float x\nproperty float y\nproperty float z\n\
         element face 39601\nproperty list uchar int vertex_indices\nend_header\n",
    );
    let grid = |n: usize| (0..n).flat_map(move |y| (0..n).map(move |x| (x, y)));
    mesh.extend(grid(200).map(|(x, y)| format!("{x}.000000001 {y}.000000001 0\n")));
    mesh.extend(grid(199).map(|(x, y)| {
        let v = y * 200 + x;
        format!("4 {v} {} {} {}\n", v + 1, v + 201, v + 200)
    }));
    let path = folder.path("m.ply");
    fs::write(&path, &mesh).unwrap();
    let begun = Instant::now();
    let time = Duration::from_secs(3);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            for i in 0.. {
                if begun.elapsed() > time {
                    return;
                }
                // It shrinks, grows, vanishes, and comes back.
                match i % 4 {
                    0 => drop(fs::write(&path, &mesh[..mesh.len() / 3])),
                    1 => drop(fs::remove_file(&path)),
                    _ => drop(fs::write(&path, &mesh)),
                }
                std::thread::sleep(Duration::from_millis(i % 7));
            }
        });
        let mut codes = Vec::new();
        while begun.elapsed() < time {
            let words = "render scene.xml -D file=m.ply -m direct --passes 1 -q -o a.pfm";
            let ended = soon(&mut folder.command(words));
            let (text, code) = (ended.stderr(), ended.exit_code());
            assert!(matches!(code, Some(0 | 3 | 4)), "{code:?}: {text}");
            assert!(
                text.len() < 2000 && text.matches(" × ").count() <= 1,
                "{text}"
            );
            codes.push(code);
        }
        println!("exit codes: {codes:?}");
    });
    assert!(folder.files().iter().all(|name| !name.starts_with('.')));
}

#[test]
fn inputs_are_not_replaced_by_outputs() {
    let folder = Folder::new(&box_with(TEXTURED));
    let quick = "-m direct --passes 1 -q";
    let plain = Folder::new(BOX);
    for name in ["wood.png", "other.exr"] {
        let made = plain.run(&format!("render scene.xml {quick} -o {name}"));
        made.code(0);
        fs::copy(plain.path(name), folder.path(name)).unwrap();
    }
    fs::create_dir(folder.path("d")).unwrap();
    symlink("../wood.png", folder.path("d/link.png")).unwrap();
    let before = fs::read(folder.path("wood.png")).unwrap();
    for output in [
        "-o wood.png",
        "-o ./d/../wood.png",
        "-o d/link.png",
        "-o a.exr -o wood.png",
    ] {
        let words = format!("render scene.xml -D file=wood.png {quick} {output}");
        let ended = soon(&mut folder.command(&words)).code(2);
        ended.says(&["is a file of the scene, which the render would replace"]);
    }
    fs::write(folder.path("scene-of-this-name"), BOX).unwrap();
    let words = format!("render scene-of-this-name {quick} --checkpoint scene-of-this-name");
    soon(&mut folder.command(&words))
        .code(2)
        .says(&["is a file of the scene"]);
    let words = "compare other.exr other.exr --html other.exr";
    soon(&mut folder.command(words))
        .code(2)
        .says(&["is an image, which the page would replace"]);
    let part = format!("render scene.xml -D file=wood.png {quick} --shard 1/1 -o a.part");
    soon(&mut folder.command(&part)).code(0);
    fs::rename(folder.path("a.part"), folder.path("a.exr")).unwrap();
    let merged = soon(&mut folder.command("merge a.exr -o a.exr"));
    merged
        .code(2)
        .says(&["is a part, which the image would replace"]);
    assert!(fs::read(folder.path("wood.png")).unwrap() == before);
    // A hard link is another name: the file of the scene stays.
    fs::hard_link(folder.path("wood.png"), folder.path("hard.png")).unwrap();
    let words = format!("render scene.xml -D file=wood.png {quick} -o hard.png");
    soon(&mut folder.command(&words)).code(0);
    assert!(fs::read(folder.path("wood.png")).unwrap() == before);
    assert!(succeeds(&[
        "cmp",
        "-s",
        folder.path("wood.png").to_str().unwrap(),
        plain.path("wood.png").to_str().unwrap()
    ]));
}
