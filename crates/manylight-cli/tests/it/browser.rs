//! The pages of `compare --html` and `--preview browser` in a headless browser: Chromium, from
//! `MANYLIGHT_BROWSER` or found by name.

use crate::preview::Served;
use crate::support::{BOX, Folder};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Script of a user: waits for the images, reads a pixel of the right image, and moves the slider
/// beyond it. The values become the title of the page.
const READER: &str = r#"<script>
const seen = [];
addEventListener("error", (event) => seen.push(`error: ${event.message}`));
const wait = (ms) => new Promise((done) => setTimeout(done, ms));
(async () => {
  const handle = document.querySelector(".handle");
  const canvas = document.querySelector("canvas");
  for (let k = 0; k < 100 && !document.querySelector(".tag").textContent; k++) await wait(50);
  const look = () => {
    const [x, y] = [0.6, 0.5];
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", { willReadFrequently: true });
    copy.drawImage(canvas, 0, 0);
    const pixel = copy.getImageData(x * canvas.width, y * canvas.height, 1, 1).data;
    seen.push(`${handle.getAttribute("aria-valuenow")}:${pixel[0]}`);
  };
  look();
  for (let k = 0; k < 10; k++) handle.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight" }));
  look();
  document.title = `seen ${seen.join(" ")} end`;
})();
</script>"#;

fn browser() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("MANYLIGHT_BROWSER") {
        return Some(named.into());
    }
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders)
        .flat_map(|folder| {
            ["chromium", "chromium-browser", "google-chrome"].map(|n| folder.join(n))
        })
        .find(|path| path.is_file())
}

/// The final state of a page in the browser, and the console.
fn open(browser: &Path, folder: &Folder, address: &str) -> (String, String) {
    let profile = format!("--user-data-dir={}", folder.path("profile").display());
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"])
        .args(["--enable-logging=stderr", "--virtual-time-budget=20000"])
        .arg(profile)
        .arg(address)
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&output.stdout), text(&output.stderr))
}

#[test]
fn the_page_works_in_a_browser() {
    let Some(browser) = browser() else {
        println!("skipped: no Chromium here, and MANYLIGHT_BROWSER is not set");
        return;
    };
    let folder = Folder::new(BOX);
    for (name, value) in [("a.exr", 0.05), ("b.exr", 0.1), ("r.exr", 0.5)] {
        crate::compare::write(&folder, name, value, None, false);
    }
    folder
        .run("compare a.exr b.exr r.exr --html page.html")
        .code(0);
    let page = std::fs::read_to_string(folder.path("page.html")).unwrap();
    let read = page.replace("</body>", &format!("{READER}</body>"));
    std::fs::write(folder.path("read.html"), read).unwrap();
    let address = format!("file://{}", folder.path("read.html").display());

    // sRGB of 0.5 and of 0.05 and 0.1: what is on the right of the slider, then on its left.
    for (view, expected) in [
        ("", "seen 50:188 70:63 end"),
        (
            "#left=b.exr&right=r.exr&split=0.45",
            "seen 45:188 65:89 end",
        ),
    ] {
        let (dom, console) = open(&browser, &folder, &format!("{address}{view}"));
        let title = dom.split("<title>").nth(1).unwrap_or(&dom);
        let title = title.split("</title>").next().unwrap_or(title);
        assert_eq!(title, expected, "{view}: {console}");
        assert!(!console.contains("CONSOLE"), "{console}");
    }
}

/// The page follows a render to its end. `docs/measurements/preview/page_in_chromium.py` uses it as
/// a person would.
#[test]
fn the_preview_works_in_a_browser() {
    let Some(browser) = browser() else {
        println!("skipped: no Chromium here, and MANYLIGHT_BROWSER is not set");
        return;
    };
    let folder = Folder::new(BOX);
    let words = "render scene.xml -m path --time 15s -o a.exr --preview browser";
    let served = Served::start(&folder, words);
    // The browser's virtual time stands still until the stream of events ends.
    let address = format!("http://{}{}", served.host, served.path);
    let (dom, console) = open(&browser, &folder, &address);
    served.end().0.code(0);
    let progress = dom.split("id=\"progress\"").nth(1).unwrap_or(&dom);
    let progress = progress.split("</p>").next().unwrap_or(progress);
    for word in [
        "<b class=\"\">done</b>",
        "pass ",
        "of 15 s",
        "error at most ",
    ] {
        assert!(progress.contains(word), "{word}: {progress}, {console}");
    }
    for layer in ["image", "emission", "direct", "albedo", "normal", "depth"] {
        let option = format!("<option value=\"{layer}\">");
        assert!(dom.contains(&option), "{layer}: {console}");
    }
    assert!(!console.contains("CONSOLE"), "{console}");
}
