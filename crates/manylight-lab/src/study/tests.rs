//! Tests of plans, runs and records.

use super::child::{Ending, FinishedProcess};
use super::plan::StudyPlan;
use super::record::{Machine, Record, RunStatus};
use super::runner::store_report;
use super::runs::{Run, plan_runs, select_runs};
use super::testing::{self, TestProgram};
use crate::error::LabError;
use miette::SourceCode;
use serde_json::json;
use std::path::Path;
use std::time::Duration;

/// Place, message and help of a problem in a plan.
fn displayed(error: &LabError) -> String {
    let LabError::Plan(problem) = error else {
        return error.to_string();
    };
    let source: &dyn SourceCode = &problem.text;
    let place = source.read_span(&problem.place, 0, 0).unwrap();
    let name = problem.text.name();
    let line = place.line() + 1;
    format!("{name}:{line}: {}: {}", problem.message, problem.help)
}

const PLAN: &str = r#"{
    "title": "T",
    "options": "--filter box",
    "scenes": [{"name": "a", "title": "A", "file": "a/s.xml", "reference": "a.exr", "size": "16x9", "max_depth": -1}],
    "methods": [
        {"label": "rich", "method": "rich-vpl", "options": "--photons 1000"},
        {"label": "path", "method": "path"}
    ],
    "tasks": [
        {"name": "work", "title": "W", "options": "-n 20 --passes 1", "methods": ["rich"], "limit": "2m"},
        {"name": "time", "title": "T", "budgets": {"option": "--time", "values": ["8s", "16s"]}}
    ],
    "ratios": [{"of": "rich", "over": "path", "task": "time-16s"}]
}"#;

fn parse(text: &str) -> Result<StudyPlan, LabError> {
    let plan = testing::plan(text, None)?;
    plan_runs(&plan, &TestProgram)?;
    Ok(plan)
}

#[test]
fn runs_are_spelled_out() {
    let plan = parse(PLAN).unwrap();
    let runs = plan_runs(&plan, &TestProgram).unwrap();
    let keys: Vec<String> = runs.iter().map(Run::key).collect();
    assert_eq!(
        keys,
        [
            "a.rich.work",
            "a.rich.time-8s",
            "a.rich.time-16s",
            "a.path.time-8s",
            "a.path.time-16s"
        ]
    );
    assert_eq!(
        runs[0].words.join(" "),
        "-m rich-vpl --photons 1000 -n 20 --passes 1 --filter box --size 16x9 --max-depth -1"
    );
    assert_eq!(runs[2].time_limit(), Some(Duration::from_secs(16)));
    assert_eq!(runs[0].task.limit, Some(Duration::from_secs(120)));
    assert_eq!(plan.page_path(), Path::new("p/methods.md"));
}

#[test]
fn runs_are_selected_by_name() {
    let plan = parse(PLAN).unwrap();
    let runs = plan_runs(&plan, &TestProgram).unwrap();
    let keys = |only: &[&str]| -> Vec<String> {
        let only: Vec<String> = only.iter().map(|text| text.to_string()).collect();
        let selected = select_runs(&runs, &only).unwrap();
        selected.iter().map(|run| run.key()).collect()
    };
    assert_eq!(keys(&[]).len(), 5);
    assert_eq!(keys(&["rich"]).len(), 3);
    assert_eq!(keys(&["a"]).len(), 5, "the scene, not all names with an a");
    assert_eq!(keys(&["time"]).len(), 4);
    assert_eq!(keys(&["path", "8s"]), ["a.path.time-8s"]);
    assert_eq!(
        keys(&["work", "time-8s", "rich"]),
        ["a.rich.work", "a.rich.time-8s"]
    );
    assert_eq!(keys(&["path", "work"]), [""; 0]);
    assert!(select_runs(&runs, &["wrk".into()]).is_err());
}

#[test]
fn another_program_may_be_a_method() {
    let text = PLAN.replace(
        r#""label": "path", "method": "path""#,
        r#""label": "path", "program": ["python3", "./other.py"]"#,
    );
    let plan = parse(&text).unwrap();
    let runs = plan_runs(&plan, &TestProgram).unwrap();
    let other = runs.iter().find(|run| run.method.label == "path").unwrap();
    assert_eq!(
        other.words.join(" "),
        "--time 8s --filter box --size 16x9 --max-depth -1"
    );
    assert!(other.settings().is_empty());
    let call = |run: &Run| {
        let renderer = &run.method.renderer;
        renderer.command(Path::new("b/manylight"), Path::new("p"))
    };
    assert_eq!(call(other), ["python3", "p/other.py"]);
    assert_eq!(call(&runs[0]), ["b/manylight", "render"]);
    let elsewhere_text = text.replace("other.py", "another.py");
    let elsewhere = parse(&elsewhere_text).unwrap();
    let runs_elsewhere = plan_runs(&elsewhere, &TestProgram).unwrap();
    let changed = |k: usize| runs[k].fingerprint() != runs_elsewhere[k].fingerprint();
    assert_eq!([0, 4].map(changed), [false, true]);
}

#[test]
fn a_plan_has_scales() {
    let scaled = PLAN.replace("16x9", "{size}").replace(
        "\"ratios\"",
        "\"scales\": [{\"name\": \"quick\", \"values\": {\"size\": \"32x18\"}}, {\"name\": \"full\", \"values\": {\"size\": \"64x36\"}}],\n\"page\": \"{scale}.md\", \"ratios\"",
    );
    let at = |scale| testing::plan(&scaled, scale);
    for (asked, name, size) in [
        (None, "quick", "32x18"),
        (Some("quick"), "quick", "32x18"),
        (Some("full"), "full", "64x36"),
    ] {
        let plan = at(asked).unwrap();
        assert_eq!(plan.scale(), Some(name));
        assert_eq!(plan.scenes[0].size, size);
        assert_eq!(plan.page_path(), Path::new("p").join(format!("{name}.md")));
        assert_eq!(plan.results_folder(), Path::new("p/results").join(name));
    }
    let said = |scale, text: &str| displayed(&testing::plan(text, scale).unwrap_err());
    assert!(said(Some("ful"), &scaled).contains("expected one of full, quick"));
    assert!(said(Some("full"), PLAN).contains("the plan has no scales"));
    let outside = scaled.replace("\"full\"", "\"../full\"");
    assert!(said(Some("../full"), &outside).contains("cannot be part of a file's name"));
    let quoted = scaled.replace("64x36", "64\\\"x36");
    assert!(said(Some("full"), &quoted).contains("no quotation marks"));
    assert_eq!(
        parse(PLAN).unwrap().results_folder(),
        Path::new("p/results/")
    );
}

/// Changes of [`PLAN`] from one text to another, with the line and words of the resulting message.
const MISTAKES: &[(&str, &str, &str, &str)] = &[
    (
        "\"title\": \"T\",\n    \"opt",
        "\"titel\": \"T\",\n    \"opt",
        ":2:",
        "unknown field `titel`, expected one of `title`",
    ),
    (
        "\"limit\": \"2m\"",
        "\"limit\": \"soon\"",
        ":10:",
        "found `soon`, expected a length of time",
    ),
    (
        "\"method\": \"path\"",
        "\"method\": \"pth\"",
        ":7:",
        "unknown method `pth`; expected one of path",
    ),
    (
        "\"methods\": [\"rich\"]",
        "\"methods\": [\"rch\"]",
        ":10:",
        "the plan has no method `rch`",
    ),
    (
        "\"methods\": [\"rich\"], ",
        "",
        ":10:",
        "task work, method path: --lights has no meaning",
    ),
    (
        "\"method\": \"path\"",
        "\"method\": \"path\", \"program\": [\"python3\"]",
        ":8:",
        "not clear what renders `path`",
    ),
    (
        ", \"method\": \"path\"",
        "",
        ":8:",
        "not clear what renders `path`",
    ),
    (
        "--passes 1",
        "--pases 1",
        ":10:",
        "unexpected argument `--pases`",
    ),
    (
        "time-16s",
        "time-32s",
        ":13:",
        "the plan has no task `time-32s`",
    ),
    (
        "\"label\": \"path\"",
        "\"label\": \"rich\"",
        ":13:",
        "`rich` is there twice",
    ),
    (
        "\"label\": \"path\"",
        "\"label\": \"a.b\"",
        ":7:",
        "`a.b` cannot be part of a file's name",
    ),
    ("[\"8s\", \"16s\"]", "[]", ":11:", "have no values"),
    (
        "\"task\": \"time-16s\"",
        "\"task\": \"time-16s\", \"figure\": \"stages\"",
        ":13:",
        "is not one number",
    ),
    (
        "\"task\": \"time-16s\"}]",
        "\"task\": \"time-16s\"",
        ":14:",
        "EOF while parsing a list",
    ),
];

#[test]
fn what_is_wrong_is_shown_at_its_place() {
    for &(from, to, place, words) in MISTAKES {
        assert!(PLAN.contains(from), "{from}");
        let failure = parse(&PLAN.replacen(from, to, 1)).unwrap_err();
        assert!(matches!(failure, LabError::Plan(_)), "{failure}");
        let text = displayed(&failure);
        assert!(text.contains(words), "{words}:\n{text}");
        assert!(
            text.contains(&format!("p/plan.json{place}")),
            "{place}:\n{text}"
        );
    }
}

fn plan_with(options: &str, limit: &str) -> StudyPlan {
    let plan = json!({
        "title": "T",
        "scenes": [{"name": "s", "title": "S", "file": "s.xml", "reference": "s.exr", "size": "8x8", "max_depth": 4}],
        "methods": [{"label": "m", "method": "vpl"}],
        "tasks": [{"name": "t", "title": "T", "options": options, "limit": limit}],
    });
    testing::plan(&plan.to_string(), None).unwrap()
}

#[test]
fn a_result_settles_the_run_that_it_is_of() {
    let plan_now = plan_with("-n 20", "10s");
    let run = &plan_runs(&plan_now, &TestProgram).unwrap()[0];
    let mut record = Record::new(run, String::new(), &Machine::this());
    assert!(!record.settles(run), "what failed is tried again");
    record.status = RunStatus::Done;
    record.render = Some(json!({"settings": {"lights": 20, "clamp": "auto"}}));
    assert!(record.settles(run));
    let other = plan_with("-n 21", "10s");
    assert!(!record.settles(&plan_runs(&other, &TestProgram).unwrap()[0]));
    // The same words, but the program's defaults have changed since.
    let mut older = record.clone();
    older.render = Some(json!({"settings": {"lights": 20, "clamp": "none"}}));
    assert!(!older.settles(run));
    let longer = plan_with("-n 20", "20s");
    let longer_run = &plan_runs(&longer, &TestProgram).unwrap()[0];
    assert!(record.settles(longer_run));
    record.status = RunStatus::Stopped;
    assert!(record.settles(run) && !record.settles(longer_run));
    record.status = RunStatus::Unavailable;
    assert!(!record.settles(run), "the program may be there next time");
}

#[test]
fn the_headline_of_a_message() {
    let plan = plan_with("", "1s");
    let mut record = Record::new(
        &plan_runs(&plan, &TestProgram).unwrap()[0],
        String::new(),
        &Machine::this(),
    );
    assert_eq!(record.headline(), "no message");
    record.message = Some("manylight::scene\n\n  × unknown plugin `x`\n   ╭─[s.xml:3:5]".into());
    assert_eq!(record.headline(), "unknown plugin `x`");
    record.message = Some("\n  killed\nmore".into());
    assert_eq!(record.headline(), "killed");
}

#[test]
fn exit_code_5_is_unavailable() {
    let plan = plan_with("", "1s");
    let run = &plan_runs(&plan, &TestProgram).unwrap()[0];
    let ended = |code| FinishedProcess {
        ending: Ending::Exited(Some(code)),
        stdout: String::new(),
        stderr: "it is not installed\n".into(),
        seconds: 0.1,
    };
    let mut record = Record::new(run, String::new(), &Machine::this());
    store_report(&mut record, &ended(5)).unwrap();
    assert_eq!(record.status, RunStatus::Unavailable);
    assert_eq!(record.headline(), "it is not installed");
    let mut record = Record::new(run, String::new(), &Machine::this());
    let message = store_report(&mut record, &ended(1)).unwrap_err();
    assert_eq!(message, "it is not installed");
    assert_eq!(record.status, RunStatus::Failed);
}

#[test]
fn a_method_may_have_references_of_its_own() {
    let plan = json!({
        "title": "T",
        "scenes": [{"name": "s", "title": "S", "file": "s.xml", "reference": "s.exr", "size": "8x8", "max_depth": 4}],
        "methods": [{"label": "a", "method": "vpl"}, {"label": "b", "program": ["b"], "reference": "./own/*.b.exr"}],
        "tasks": [{"name": "t", "title": "T"}],
    });
    let plan = testing::plan(&plan.to_string(), None).unwrap();
    let runs = plan_runs(&plan, &TestProgram).unwrap();
    assert_eq!(runs[0].reference(), "s.exr");
    assert_eq!(runs[1].reference(), "./own/s.b.exr");
}
