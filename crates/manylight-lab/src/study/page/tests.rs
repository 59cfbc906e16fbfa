//! A page from fixed results.

use super::super::record::{Machine, Record};
use super::super::runs::plan_runs;
use super::super::testing::{self, TestProgram};
use super::*;
use crate::document::DocumentPart;
use serde_json::json;

fn plan() -> StudyPlan {
    let scene = |name: &str, title: &str| {
        json!({"name": name, "title": title, "file": format!("{name}/scene.xml"), "reference": format!("{name}.exr"),
               "size": "16x9", "max_depth": if name == "a" { -1 } else { 5 }})
    };
    let plan = json!({
        "title": "Trial",
        "notes": "Two scenes.",
        "options": "--filter box",
        "scenes": [scene("a", "Attic"), scene("b", "Barn")],
        "methods": [
            {"label": "rich", "method": "rich-vpl", "options": "--photons 1000", "notes": "Few photons."},
            {"label": "path", "method": "path"},
        ],
        "tasks": [
            {"name": "work", "title": "Equal work", "options": "--passes 1", "notes": "One pass."},
            {"name": "time", "title": "Over time", "figures": ["relmse"],
             "budgets": {"option": "--time", "values": ["1s", "4s"]}},
        ],
        "ratios": [{"of": "rich", "over": "path", "task": "work"}],
    });
    testing::plan(&plan.to_string(), None).unwrap()
}

/// A result with the errors and the time given, and figures made of them.
fn record(run: &Run, mse: f64, shade: f64) -> Record {
    let machine = Machine {
        cpu: "Abacus 3".into(),
        threads: 2,
    };
    let lights = if run.method.label == "rich" { 512 } else { 0 };
    Record {
        status: RunStatus::Done,
        version: "1.2.3".into(),
        date: "2020-02-03T04:05:06Z".into(),
        seconds: 9.0,
        metrics: Some(json!({
            "relmse": mse / 4.0 + 0.0004,
            "mse": mse + 0.0016,
            "reference_noise": {"mse": 0.0016, "relmse": 0.0004},
            "ratio_of_means": [1.0, 1.0 - mse, 1.0 + mse / 2.0],
            "ratio_standard_error": [0.001, if lights > 0 { json!(0.002) } else { json!(null) }, 0.003],
        })),
        render: Some(json!({
            "settings": {"threads": 2},
            "stages": {"load": 1.0, "photons": shade / 4.0, "trifle": 1e-6, "shade": shade, "write": 2.0},
            "counts": {"lights": lights, "passes": 1},
            "memory": {"peak_bytes": 52_300_000, "bytes_per_light": 4210.0},
            "clamped_share": 0.0123,
        })),
        ..Record::new(run, String::new(), &machine)
    }
}

#[test]
fn a_page_of_fixed_results() {
    let plan = plan();
    let runs = plan_runs(&plan, &TestProgram).unwrap();
    let results = runs.iter().filter_map(|run| {
        let found = match run.key().as_str() {
            "a.rich.work" => record(run, 0.01, 2.0),
            "a.path.work" => record(run, 0.04, 1.0),
            "b.rich.work" => Record {
                status: RunStatus::Stopped,
                limit: Some(60.0),
                ..record(run, 0.02, 48.0)
            },
            "b.path.work" => Record {
                status: RunStatus::Failed,
                message: Some("  × unknown plugin `x`".into()),
                metrics: None,
                render: None,
                ..record(run, 0.0, 0.0)
            },
            "a.rich.time-1s" => record(run, 0.04, 0.8),
            "a.rich.time-4s" => record(run, 0.01, 3.2),
            "b.rich.time-1s" => record(run, 0.09, 4.0),
            "b.rich.time-4s" => record(run, 0.09, 4.1),
            "b.path.time-1s" => Record {
                status: RunStatus::Unavailable,
                message: Some("no module named x".into()),
                metrics: None,
                render: None,
                ..record(run, 0.0, 0.0)
            },
            "a.path.time-4s" => Record {
                date: "2020-02-05T00:00:00Z".into(),
                fingerprint: "another".into(),
                ..record(run, 0.03, 3.2)
            },
            _ => return None,
        };
        Some((run.key(), found))
    });
    let results = Results::of(results);
    let document = page(&plan, &runs, &results, "manylight study plan.json");
    let plots = document
        .parts
        .iter()
        .filter(|part| matches!(part, DocumentPart::Plot(_)));
    assert_eq!(plots.count(), 2);
    let text = document.markdown();
    // The section of methods depends on the program.
    let (before, rest) = text.split_once("## Methods").unwrap();
    let (methods, after) = rest.split_once("## Equal work").unwrap();
    let page = format!("{before}## Equal work{after}");
    assert_eq!(page, include_str!("golden.md"));
    assert!(
        methods.contains("* **rich** (`-m rich-vpl --photons 1000`): Rich"),
        "{methods}"
    );
    assert!(
        methods.contains("Few photons.\n* **path** (`-m path`): "),
        "{methods}"
    );
    assert!(
        methods.contains("\n| settings | lights | photons |"),
        "{methods}"
    );
    assert!(methods.contains("\n| rich | 512 | 1000 |"), "{methods}");
}
