//! `study` on a scene of the project: results, continuation, exit codes.

use crate::support::{BOX, Ended, Folder};
use serde_json::{Value, json};
use std::path::Path;

/// A plan of one scene and two fast methods, with a reference image.
struct Study {
    folder: Folder,
    plan: Value,
}

impl Study {
    fn new() -> Self {
        let study = Study {
            folder: Folder::new(BOX),
            plan: json!({
                "title": "Trial",
                "options": "--filter box",
                "scenes": [{
                    "name": "room", "title": "Room", "file": "glossy-room/scene.xml", "reference": "room.exr",
                    "size": "16x9", "max_depth": 4,
                }],
                "methods": [{"label": "path", "method": "path"}, {"label": "points", "method": "vpl"}],
                "tasks": [
                    {"name": "one", "title": "One pass", "options": "--passes 1", "methods": ["path"]},
                    {"name": "few", "title": "Few lights", "options": "-n 16 --photons 500 --passes 1", "methods": ["points"]},
                ],
            }),
        };
        let scene = scenes().join("glossy-room/scene.xml");
        let options = "-m path --spp 2 --size 16x9 --max-depth 4 --filter box -q -o room.exr";
        let words = format!("render {} {options}", scene.display());
        study.folder.run(&words).code(0);
        study
    }

    fn run(&self, options: &str) -> Ended {
        self.write_plan();
        self.folder.run(&self.words(options))
    }

    fn words(&self, options: &str) -> String {
        let scenes = scenes();
        let folders = format!("--scenes {} --references .", scenes.display());
        format!("study plan.json {folders} {options}")
    }

    fn write_plan(&self) {
        std::fs::write(self.folder.path("plan.json"), self.plan.to_string()).unwrap();
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.path(name)).unwrap()
    }

    fn result(&self, key: &str) -> Value {
        serde_json::from_str(&self.text(&format!("results/{key}.json"))).unwrap()
    }

    fn files(&self, name: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path(name)).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

fn scenes() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

#[test]
fn every_run_has_a_result_and_the_page_shows_it() {
    let study = Study::new();
    let ended = study.run("--images pictures --html pages");
    ended.code(0).says(&[
        "[1/2] room, path, one",
        "[2/2] room, points, few",
        "relMSE",
        "methods.md",
        "index.html",
    ]);
    assert_eq!(study.files("pages/pixels"), ["0.js", "1.js"]);
    let html = study.text("pages/index.html");
    for words in ["Few lights: ", "pixels/1.js", "Made by `manylight study"] {
        assert!(html.contains(words), "{words}");
    }
    assert_eq!(
        study.files("results"),
        ["room.path.one.json", "room.points.few.json"]
    );
    let result = study.result("room.points.few");
    assert_eq!(result["status"], "done");
    assert!(result["metrics"]["relmse"].as_f64().unwrap() > 0.0);
    assert!(result["render"]["memory"]["peak_bytes"].as_f64().unwrap() > 0.0);
    assert_eq!(result["render"]["settings"]["lights"], 16);
    assert_eq!(
        result["command"],
        "manylight render glossy-room/scene.xml -m vpl -n 16 --photons 500 --passes 1 --filter box --size 16x9 \
         --max-depth 4 --output room.points.few.exr"
    );
    // Results contain no paths of this computer.
    let here = scenes().display().to_string();
    assert!(!study.text("results/room.points.few.json").contains(&here));
    let page = study.text("methods.md");
    assert!(
        page.contains("Made by `manylight study plan.json`: 2 of 2 runs"),
        "{page}"
    );
    assert!(page.contains("### Few lights: Bytes per light"), "{page}");
    assert_eq!(
        study.files("pictures"),
        [
            "room.path.one.exr",
            "room.path.one.png",
            "room.points.few.exr",
            "room.points.few.png"
        ]
    );

    std::fs::remove_file(study.folder.path("methods.md")).unwrap();
    let ended = study
        .folder
        .run("study plan.json --page-only --page other.md");
    assert_eq!(ended.code(0).stdout(), "");
    assert_eq!(study.text("other.md"), page);
}

#[test]
fn what_is_done_is_not_done_again() {
    let mut study = Study::new();
    study
        .run("--only points")
        .code(0)
        .says(&["1 run, 0 of them"]);
    assert_eq!(study.files("results"), ["room.points.few.json"]);
    let first = study.text("results/room.points.few.json");
    study
        .run("")
        .code(0)
        .says(&["2 runs, 1 of them", "[1/1] room, path, one"]);
    let path = study.text("results/room.path.one.json");
    study.run("").code(0).says(&["2 runs, 2 of them"]);
    assert_eq!(study.text("results/room.points.few.json"), first);

    study.plan["tasks"][1]["options"] = "-n 17 --photons 500 --passes 1".into();
    study.run("").code(0).says(&["[1/1] room, points, few"]);
    assert_eq!(
        study.result("room.points.few")["render"]["settings"]["lights"],
        17
    );
    assert_eq!(study.text("results/room.path.one.json"), path);

    study
        .run("--again --only one")
        .code(0)
        .says(&["[1/1] room, path, one"]);
    assert_ne!(
        study.text("results/room.path.one.json"),
        path,
        "times differ"
    );
}

#[test]
fn a_run_that_fails_is_recorded_and_the_others_go_on() {
    let mut study = Study::new();
    let mut broken = study.plan["scenes"][0].clone();
    broken["name"] = "broken".into();
    broken["file"] = "./scene.xml".into();
    study.plan["scenes"] = json!([broken, study.plan["scenes"][0]]);
    let misspelled = BOX.replace("\"reflectance\"", "\"reflectence\"");
    std::fs::write(study.folder.path("scene.xml"), misspelled).unwrap();
    study
        .run("--only path")
        .code(1)
        .says(&["[2/2] room, path, one", "1 run failed"]);
    let result = study.result("broken.path.one");
    assert_eq!(
        (&result["status"], &result["exit_code"]),
        (&json!("failed"), &json!(3))
    );
    let message = result["message"].as_str().unwrap();
    assert!(
        message.contains("scene.xml:12:") && message.contains("reflectence"),
        "{message}"
    );
    assert_eq!(study.result("room.path.one")["status"], "done");
    assert!(study.text("methods.md").contains("| path | failed |"));

    // Repeated without the error. A reference of another size is an error too.
    std::fs::write(study.folder.path("scene.xml"), BOX).unwrap();
    study
        .run("--only path")
        .code(0)
        .says(&["[1/1] broken, path, one"]);
    study.plan["scenes"][0]["size"] = "8x8".into();
    study.run("--only path").code(1).says(&["8x8", "16x9"]);
    study.plan["scenes"][0]["reference"] = "none.exr".into();
    study
        .run("--only path")
        .code(1)
        .says(&["none.exr", "does not exist"]);
}

#[test]
fn a_run_is_stopped_at_its_limit() {
    let mut study = Study::new();
    study.plan["tasks"][0]["options"] = "--passes 100000000".into();
    study.plan["tasks"][0]["limit"] = "1s".into();
    study
        .run("--only path")
        .code(0)
        .says(&["stopped at its limit"]);
    let result = study.result("room.path.one");
    assert_eq!(result["status"], "stopped");
    assert!(result["seconds"].as_f64().unwrap() < 20.0);
    assert!(
        study
            .text("methods.md")
            .contains("* room, path, one: † stopped after 1.00 s")
    );
    study.run("--only path").code(0).says(&["1 run, 1 of them"]);
    study.plan["tasks"][0]["limit"] = "1200ms".into();
    study.run("--only path").code(0).says(&["1 run, 0 of them"]);
}

#[cfg(unix)]
#[test]
fn an_interrupt_keeps_what_is_done() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};
    let mut study = Study::new();
    study.plan["tasks"][1]["options"] = "-n 16 --time 300s".into();
    study.write_plan();
    let mut command = study.folder.command(&study.words(""));
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let second = lines.find(|line| line.as_ref().unwrap().contains("[2/2]"));
    // The time of the second run is known, and it is the last one.
    assert!(
        second
            .unwrap()
            .unwrap()
            .ends_with("(about 5 min 00 s left)")
    );
    let kill = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(kill.unwrap().success());
    let rest: Vec<String> = lines.map(Result::unwrap).collect();
    assert!(
        rest.iter().any(|line| line.contains("interrupted")),
        "{rest:?}"
    );
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(study.files("results"), ["room.path.one.json"]);
    assert!(study.text("methods.md").contains("1 of 2 runs"));
}

#[test]
fn what_cannot_be_done_is_said_before_anything_is_rendered() {
    let study = Study::new();
    let before = study.folder.files();
    study
        .folder
        .run("study plan.json")
        .code(4)
        .says(&["plan.json", "does not exist"]);
    study.write_plan();
    for (words, code, message) in [
        ("", 2, "--scenes DIR, or set the variable MANYLIGHT_SCENES"),
        ("--scenes .", 2, "MANYLIGHT_REFERENCES"),
        ("--scenes none --references .", 4, "none"),
        ("--only pats", 2, "expected one of path"),
        ("--page none/page.md", 4, "the folder does not exist"),
        ("--page-only --again", 2, "cannot be used with"),
    ] {
        let words = format!("study plan.json {words}");
        study.folder.run(&words).code(code).says(&[message]);
    }
    std::fs::write(study.folder.path("plan.json"), "{\n  \"titel\": 1\n}").unwrap();
    let ended = study.folder.run("study plan.json --page-only");
    ended
        .code(2)
        .says(&["plan.json:2:", "unknown field `titel`", "`title`"]);
    std::fs::remove_file(study.folder.path("plan.json")).unwrap();
    assert_eq!(study.folder.files(), before);
}

#[test]
fn another_program_renders_too() {
    let mut study = Study::new();
    // It copies the reference, and reports its arguments.
    let script = r#"for word in "$@"; do
    if [ "$before" = --output ]; then cp "$FOLDER/room.exr" "$word"; fi
    before=$word
done
echo "{\"version\": \"Copier 1\", \"called\": \"$*\", \"stages\": {\"copy\": 0.5}, \"counts\": {\"passes\": 7}}""#;
    let folder = study.folder.path("").display().to_string();
    let script = script.replace("$FOLDER", folder.trim_end_matches('/'));
    std::fs::write(study.folder.path("copy.sh"), script).unwrap();
    let of = |label: &str, program: &[&str]| json!({"label": label, "program": program, "notes": "It copies."});
    let methods = study.plan["methods"].as_array_mut().unwrap();
    methods.push(of("copier", &["sh", "./copy.sh", "well"]));
    methods.push(of("absent", &["./no-such-program"]));
    methods.push(of(
        "elsewhere",
        &["sh", "-c", "echo it is not installed >&2; exit 5"],
    ));
    study.plan["tasks"][0]["methods"] = json!(["path", "copier", "absent", "elsewhere"]);
    study.plan["tasks"][0]["figures"] = json!(["rmse", "passes", "seconds"]);
    let ended = study.run("");
    ended.code(1).says(&[
        "absent, one",
        "cannot be run",
        "1 run failed",
        "unavailable: it is",
    ]);
    let result = study.result("room.copier.one");
    assert_eq!(result["status"], "done");
    assert_eq!(result["metrics"]["mse"], 0.0);
    let called = result["render"]["called"].as_str().unwrap();
    assert!(
        called.starts_with(
            "well glossy-room/scene.xml --passes 1 --filter box --size 16x9 --max-depth 4 --json"
        ),
        "{called}"
    );
    assert_eq!(
        result["command"],
        "sh copy.sh well glossy-room/scene.xml --passes 1 --filter box --size 16x9 --max-depth 4 --output room.copier.one.exr"
    );
    assert_eq!(study.result("room.elsewhere.one")["status"], "unavailable");
    let page = study.text("methods.md");
    assert!(page.contains("unavailable: it is not installed"), "{page}");
    assert!(page.contains("**copier** (`sh ./copy.sh well`): Another program. It copies."));
    study
        .run("--only copier")
        .code(0)
        .says(&["1 of them done already"]);
}
