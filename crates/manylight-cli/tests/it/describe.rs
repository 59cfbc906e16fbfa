//! `info`, `list`, `completions`, `--version`.

use crate::support::{BOX, Folder};

#[test]
fn info_counts() {
    let folder = Folder::new(BOX);
    let info = folder.run("info scene.xml --json").code(0).json();
    assert_eq!(info["counts"]["triangles"], 6);
    assert_eq!(info["counts"]["triangles_with_instances"], 6);
    assert_eq!(info["counts"]["primitives"], 3);
    assert_eq!(info["counts"]["emitters"], 1);
    assert_eq!(info["sensors"][0]["size"], serde_json::json!([16, 12]));
    assert_eq!(info["sensors"][0]["filter"], "box");
    assert_eq!(info["limits"]["max_depth"], 4);
    let low = info["bounds"]["min"][0].as_f64().unwrap();
    assert!((low + 3.0).abs() < 1e-3, "{low}");
    let text = folder.run("info scene.xml").code(0).stdout();
    assert!(
        text.contains("triangles    6") && text.contains("perspective 16x12"),
        "{text}"
    );
}

#[test]
fn lists() {
    let folder = Folder::new(BOX);
    for (words, name) in [
        ("list methods", "rich-vpl"),
        ("list bsdfs", "roughconductor"),
        ("list emitters", "envmap"),
        ("list shapes", "ply"),
        ("list textures", "bitmap"),
        ("list sensors", "thinlens"),
        ("list filters", "gaussian"),
        ("list integrators", "path"),
    ] {
        assert!(folder.run(words).code(0).stdout().contains(name), "{words}");
    }
}

#[test]
fn completions_and_version() {
    let folder = Folder::new(BOX);
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = folder.run(&format!("completions {shell}")).code(0).stdout();
        assert!(script.contains("placement"), "{shell}");
    }
    let version = folder.run("--version").code(0).stdout();
    let begins = format!("manylight {} (", env!("CARGO_PKG_VERSION"));
    let ends = format!("{})", manylight::instruction_set());
    assert!(version.starts_with(&begins), "{version}");
    assert!(version.trim().ends_with(&ends), "{version}");
}
