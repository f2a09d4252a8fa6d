//! `whyroad robustness` as a person runs it, on a simulated drive of the repository.

use std::process::{Command, Output};

fn whyroad(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_whyroad"))
        .args(args)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .env_remove("WHYROAD_FRAMEWORK")
        .env_remove("WHYROAD_LANG")
        .output()
        .unwrap()
}

#[test]
fn agreement_is_reported_and_a_floor_decides_the_exit_code() {
    let dir = tempfile::tempdir().unwrap();
    let (lake, page) = (dir.path().join("lake"), dir.path().join("page.html"));
    let (lake, page) = (lake.to_str().unwrap(), page.to_str().unwrap());
    let drive = "examples/truth/agents/seen/seen_lane_01";
    assert!(matches!(whyroad(&["ingest", "sumo", "--lake", lake, drive]).status.code(), Some(0 | 1)));
    let asked = ["robustness", "--lake", lake, "--perturbation", "id_breaks", "--perturbation", "correlated"];
    let o = whyroad(&[&asked[..], &["--format", "json", "--page", page]].concat());
    assert_eq!(o.status.code(), Some(0), "{}", String::from_utf8_lossy(&o.stderr));
    let json: serde_json::Value = serde_json::from_slice(&o.stdout).unwrap();
    let names: Vec<&str> =
        json["perturbations"].as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["correlated", "id_breaks"], "in a fixed order");
    for p in json["perturbations"].as_array().unwrap() {
        // The drive has episodes, and most of them are found in the perturbed drive too.
        assert!(p["all"]["before"].as_u64().unwrap() > 0);
        assert!(p["all"]["agreement"].as_f64().unwrap() > 0.5, "{p:#}");
    }
    let text = std::fs::read_to_string(page).unwrap();
    assert!(text.contains("id_breaks") && text.contains("<table>"));
    // Names of the taxonomy, in both languages; ids only in tooltips.
    let without_tooltips: String =
        text.split(" title=\"").map(|part| part.split_once("\">").map_or(part, |p| p.1)).collect();
    assert!(
        !without_tooltips.contains("reactive_") && !without_tooltips.contains("proactive."),
        "{without_tooltips}"
    );
    let again = whyroad(&[&asked[..], &["--format", "json"]].concat());
    assert_eq!(again.stdout, o.stdout, "seeded");

    let least = json["perturbations"]
        .as_array()
        .unwrap()
        .iter()
        .map(|p| p["all"]["agreement"].as_f64().unwrap())
        .fold(1.0, f64::min);
    let floor = |f: f64| whyroad(&[&asked[..], &["--floor", &f.to_string()]].concat()).status.code();
    assert_eq!(floor(least), Some(0));
    if least < 1.0 {
        assert_eq!(floor(1.0), Some(1));
    }
    assert_eq!(whyroad(&["robustness", "--lake", lake, "--perturbation", "fog"]).status.code(), Some(2));
    assert_eq!(whyroad(&["robustness", "--lake", lake, "--floor", "1.5"]).status.code(), Some(2));
}
