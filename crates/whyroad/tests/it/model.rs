//! `draft`, `judge`, `agreement`, `ask` and `validate --quality` as a user runs them, against a scripted endpoint.
#![allow(clippy::unwrap_used)] // in a test a panic is the report

use crate::scripted::{Reply, Scripted, Seen};
use crate::service::demo;
use crate::session::{Run, whyroad_with};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

const SECRET: &str = "sk-never-shown-4711";

fn run(folder: &Path, line: &str) -> Run {
    let demo = demo().display().to_string();
    let words: Vec<String> = line.split(' ').map(|w| w.replace("DEMO", &demo).replace('~', " ")).collect();
    let run =
        whyroad_with(folder, &words.iter().map(String::as_str).collect::<Vec<_>>(), &[("THE_KEY", SECRET)]);
    assert!(!run.out.contains("never-shown") && !run.err.contains("never-shown"), "{}{}", run.out, run.err);
    run
}

fn lines(path: &Path) -> Vec<Value> {
    fs::read_to_string(path).unwrap().lines().map(|l| serde_json::from_str(l).unwrap()).collect()
}

const SEEN: &str = "左前方的轿车正在切入本车道";
const TRACE: &str = "左前方的轿车正在切入本车道，切入后的车距对当前车速而言过小，继续保持原速很快就会追近，因此自车减速让行，与轿车拉开安全距离。";

/// Stage I and II of a cut-in to which the ego yields; true to every statement; a rule.
fn model() -> Scripted {
    Scripted::new(|_, seen: &Seen| {
        let answer = match seen.form().as_str() {
            "draft_history" => json!({ "components": [{
                "description": SEEN, "category": "critical_objects", "uncertainty": "low", "objects": [],
            }] }),
            "draft_future" => json!({
                "longitudinal": "yield_to_agent", "lateral": null, "lateral_direction": null,
                "causes": {
                    "longitudinal": { "components": ["c1"], "unobserved": "" },
                    "lateral": { "components": [], "unobserved": "" },
                },
                "trace": TRACE, "safe": true, "safety_reason": "",
            }),
            "judge" => {
                let text = seen.text();
                let all: Value = serde_json::from_str(text[text.rfind("\n[").unwrap()..].trim()).unwrap();
                let all = all.as_array().unwrap().iter();
                let answers = all.map(|s| json!({ "id": s["id"], "answer": true, "reason": "seen" }));
                json!({ "answers": answers.collect::<Vec<_>>() })
            }
            _ => json!({ "rule": "ego.speed > 5 m/s for 2 s", "target": "none", "explanation": "fast ego" }),
        };
        Reply::Says(answer.to_string())
    })
}

/// The endpoint, and a folder with one draft of the cut-in.
fn drafted() -> (Scripted, tempfile::TempDir, String) {
    let (endpoint, dir) = (model(), tempfile::tempdir().unwrap());
    let line = format!(
        "draft --lake DEMO/lake --from DEMO/mined --scenario cutin.urgent --limit 1 --texts zh --model {} \
         --model-name vlm --key-env THE_KEY --price-input 2 --price-output 8 --out drafts.jsonl --format json",
        endpoint.url
    );
    (endpoint, dir, line)
}

#[test]
fn a_draft_by_a_model_is_marked_resumed_for_nothing_and_taken_as_a_task() {
    let (endpoint, dir, line) = drafted();
    let first = run(dir.path(), &line);
    assert_eq!(first.code, 0, "{}{}", first.out, first.err);
    let report: Value = serde_json::from_str(&first.out).unwrap();
    assert_eq!((&report["written"], &report["by"]), (&json!(1), &json!("vlm")));
    assert_eq!((&report["spent"]["requests"], &report["spent"]["input_tokens"]), (&json!(2), &json!(200)));
    // 200 x 2 + 40 x 8 millionths.
    assert!((report["spent"]["cost"].as_f64().unwrap() - 720e-6).abs() < 1e-12);
    let drafts = lines(&dir.path().join("drafts.jsonl"));
    assert_eq!(drafts[0]["provenance"]["source"], "model");
    assert_eq!((&drafts[0]["provenance"]["by"], &drafts[0]["coc_trace"]), (&json!("vlm"), &json!(TRACE)));
    assert!(endpoint.seen()[0].head.contains(SECRET), "the key is sent");
    for file in fs::read_dir(dir.path().join("drafts.answers")).unwrap() {
        assert!(!fs::read_to_string(file.unwrap().path()).unwrap().contains("never-shown"));
    }

    let again = run(dir.path(), &format!("{line} --max-requests 0"));
    let report: Value = serde_json::from_str(&again.out).unwrap();
    assert_eq!(
        (&report["spent"]["requests"], &report["spent"]["cached"]),
        (&json!(0), &json!(2)),
        "{}",
        again.err
    );
    assert_eq!(endpoint.seen().len(), 2);
    assert_eq!(lines(&dir.path().join("drafts.jsonl")), drafts);

    let tasks = run(dir.path(), "tasks import drafts.jsonl --project p --lake DEMO/lake --data store");
    assert_eq!(
        (tasks.code, tasks.out.starts_with("1 tasks created")),
        (0, true),
        "{}{}",
        tasks.out,
        tasks.err
    );
}

#[test]
fn without_an_answer_or_a_key_nothing_is_written_and_the_reason_is_said_in_both_languages() {
    let dir = tempfile::tempdir().unwrap();
    let away = Scripted::new(|_, _| Reply::Status(429, None, r#"{"error":{"message":"busy"}}"#.into()));
    let line = format!(
        "draft --lake DEMO/lake --from DEMO/mined --scenario cutin.urgent --limit 1 --model {} --retries 0 --out d.jsonl",
        away.url
    );
    let gone = run(dir.path(), &line);
    assert_eq!(gone.code, 1);
    assert!(gone.err.contains("chat.unavailable") && gone.err.contains("busy"), "{}", gone.err);
    let zh = run(dir.path(), &format!("{line} --lang zh"));
    assert!(zh.err.contains("仍无回答"), "{}", zh.err);
    let no_key = run(dir.path(), &format!("{line} --key-env NO_SUCH_KEY"));
    assert!(no_key.code == 1 && no_key.err.contains("NO_SUCH_KEY"), "{}", no_key.err);
}

#[test]
fn drafts_by_rule_differ_by_seed_and_are_repeatable() {
    let dir = tempfile::tempdir().unwrap();
    let traces = |seed: u32| {
        let line =
            format!("draft --lake DEMO/lake --from DEMO/mined --texts zh --seed {seed} --out r{seed}.jsonl");
        let made = run(dir.path(), &line);
        assert_eq!(made.code, 0, "{}", made.err);
        let drafts = lines(&dir.path().join(format!("r{seed}.jsonl")));
        assert!(drafts.len() >= 8 && drafts.iter().all(|d| d["provenance"]["source"] == "rule"));
        drafts.iter().map(|d| d["coc_trace"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let (first, again, other) = (traces(1), traces(1), traces(2));
    let line = "draft --lake DEMO/lake --from DEMO/mined --scenario cutin.urgent --limit 1 --out one.jsonl";
    let one = run(dir.path(), line).out;
    assert!(one.starts_with("1 episode: 1 draft written (by rule"), "{one}");
    assert_eq!(first, again);
    assert!(first.iter().zip(&other).filter(|(a, b)| a != b).count() * 2 > first.len());
    for trace in first.iter().chain(&other) {
        let n = trace.chars().count();
        assert!((50..=100).contains(&n), "{n}: {trace}");
        assert!(!trace.chars().any(|c| c.is_ascii_alphabetic()), "{trace}");
    }
}

#[test]
fn a_judge_answers_people_get_their_share_and_agreement_compares() {
    let (endpoint, dir, line) = drafted();
    assert_eq!(run(dir.path(), &line).code, 0);
    let judge = format!(
        "judge drafts.jsonl --lake DEMO/lake --model {} --model-name judge --texts zh --people people.jsonl \
         --people-share 1 --out judged.jsonl --format json",
        endpoint.url
    );
    let judged = run(dir.path(), &judge);
    assert_eq!(judged.code, 0, "{}", judged.err);
    let report: Value = serde_json::from_str(&judged.out).unwrap();
    assert_eq!((&report["judged"], &report["for_people"]), (&json!(1), &json!(1)));
    assert_eq!(report["kinds"]["decision"]["questions"], 2);
    let mut people = lines(&dir.path().join("people.jsonl"));
    let questions = people[0]["questions"].as_array_mut().unwrap();
    assert!(questions.iter().all(|q| q["answer"].is_null() && q.get("reason").is_none()));
    questions.iter_mut().for_each(|q| q["answer"] = true.into());
    questions[0]["answer"] = false.into();
    let n = questions.len();
    fs::write(dir.path().join("people.jsonl"), people[0].to_string()).unwrap();
    let compared = run(dir.path(), "agreement judged.jsonl people.jsonl --format json");
    assert_eq!(compared.code, 0, "{}", compared.err);
    let of: Value = serde_json::from_str(&compared.out).unwrap();
    let all = of["kinds"].as_array().unwrap().last().unwrap().clone();
    assert_eq!((&all["kind"], &all["answers"]), (&json!("all"), &json!(n)));
    let same = all["same"]["value"].as_f64().unwrap();
    assert!((same - (n - 1) as f64 / n as f64).abs() < 1e-12, "{all}");
    assert!(run(dir.path(), "agreement judged.jsonl people.jsonl --lang zh").out.contains("模型和人"));
}

#[test]
fn two_annotators_are_compared_part_by_part() {
    let dir = tempfile::tempdir().unwrap();
    let label: Value =
        serde_json::from_str(include_str!("../../../../examples/cutin_urgent_example.json")).unwrap();
    let file = |name: &str, decisions: [&str; 4]| {
        let text: Vec<String> = decisions
            .iter()
            .enumerate()
            .map(|(i, d)| {
                let mut l = label.clone();
                l["clip_id"] = format!("clip_{i}").into();
                l["driving_decision"]["longitudinal"] = (*d).into();
                l.to_string()
            })
            .collect();
        fs::write(dir.path().join(name), text.join("\n")).unwrap();
    };
    file("ada.jsonl", ["yield_to_agent", "yield_to_agent", "lead_following", "lead_following"]);
    file("ben.jsonl", ["yield_to_agent", "lead_following", "lead_following", "lead_following"]);
    let run = run(dir.path(), "agreement ada.jsonl ben.jsonl --format json");
    assert_eq!(run.code, 0, "{}", run.err);
    let of: Value = serde_json::from_str(&run.out).unwrap();
    let of = &of["agreement"];
    assert_eq!((&of["episodes"], &of["raters"]), (&json!(4), &json!(["ada", "ben"])));
    // By hand: observed 3/4, chance 2/4 x 1/4 + 2/4 x 3/4 = 1/2; kappa 1/2.
    let longitudinal = of["parts"].as_array().unwrap().iter().find(|p| p["part"] == "longitudinal").unwrap();
    assert!((longitudinal["kappa"]["value"].as_f64().unwrap() - 0.5).abs() < 1e-12);
    assert_eq!(
        (&of["keyframe"]["median_s"]["value"], &of["components"]["f1"]["value"]),
        (&json!(0.0), &json!(1.0))
    );
}

#[test]
fn a_question_becomes_a_rule_that_is_shown_and_run() {
    let (endpoint, dir) = (model(), tempfile::tempdir().unwrap());
    let line =
        format!("ask when~is~the~ego~fast --lake DEMO/lake --model {} --name fast --out asked", endpoint.url);
    let asked = run(dir.path(), &line);
    assert_eq!(asked.code, 0, "{}", asked.err);
    for said in ["rule: ego.speed > 5 m/s for 2 s", "fast ego", "custom.fast"] {
        assert!(asked.out.contains(said), "{said}: {}", asked.out);
    }
    assert!(dir.path().join("asked/episodes.jsonl").is_file());
    let json = run(dir.path(), &format!("{line} --format json"));
    let report: Value = serde_json::from_str(&json.out).unwrap();
    assert_eq!(report["conditions"].as_array().unwrap().len(), 1, "{report}");
    assert!(report["results"].is_object() && report["spent"]["cached"] == 1, "{report}");
    let broken = Scripted::new(|_, _| {
        Reply::Says(json!({ "rule": "ego.speed > 5 m", "target": "none", "explanation": "" }).to_string())
    });
    let failed = run(dir.path(), &format!("ask fast --model {} --corrections 1 --cache c", broken.url));
    assert!(failed.code == 1 && failed.err.contains("ask.rule") && failed.err.contains("rule.unit.mismatch"));
}

#[test]
fn the_quality_of_imported_texts_is_one_report_by_kind() {
    let dir = tempfile::tempdir().unwrap();
    // The ego of this drive yields to a car that cuts in at 17 s.
    let text =
        |words: &str| json!({ "clip_id": "multilane-ego", "t0_us": 17_000_000, "chain_of_causation": words });
    let texts = [
        text(
            "The car on the left is cutting into the ego lane and the gap becomes too small, so the ego slows down and yields.",
        ),
        text(
            "The road ahead is free and nothing restrains the ego, so the ego turns right at the junction onto the side road.",
        ),
        text(
            "The car that later nearly collided with the ego is cutting in from the left, so the ego slows down and yields to it.",
        ),
    ];
    fs::write(dir.path().join("a2.jsonl"), texts.map(|t| t.to_string()).join("\n")).unwrap();
    let read = run(dir.path(), "labels import alpamayo2 a2.jsonl --lake DEMO/lake --out drafts.jsonl");
    assert_eq!(read.code, 0, "{}", read.err);
    let report = run(dir.path(), "validate drafts.jsonl --lake DEMO/lake --quality --format json");
    let of: Value = serde_json::from_str(&report.out).unwrap();
    assert_eq!((&of["texts"], &of["not_in_lake"]), (&json!(3), &json!(0)), "{of:#}");
    let kind =
        |id: &str| of["kinds"].as_array().unwrap().iter().find(|k| k["kind"] == id).unwrap()["texts"].clone();
    assert_eq!(kind("route"), 1, "{of:#}");
    assert_eq!(kind("late_evidence"), 1, "{of:#}");
    assert_eq!(report.code, 1);
    let zh = run(dir.path(), "validate drafts.jsonl --lake DEMO/lake --quality --lang zh");
    assert!(zh.out.contains("3 条因果文本") && zh.out.contains("与路线矛盾"), "{}", zh.out);
}

#[test]
fn options_of_the_model_ask_for_the_model() {
    let dir = tempfile::tempdir().unwrap();
    for option in [
        "--timeout 5",
        "--retries 1",
        "--jobs 2",
        "--cache c",
        "--key-env THE_KEY",
        "--model-name m",
        "--requests-per-minute 9",
        "--max-requests 9",
        "--max-tokens 9",
        "--max-answer-tokens 9",
        "--price-input 1 --price-output 1",
    ] {
        let line = format!("draft --lake DEMO/lake --from DEMO/mined --out d.jsonl {option}");
        let refused = run(dir.path(), &line);
        assert!(refused.code == 2 && refused.err.contains("--model <URL>"), "{option}: {}", refused.err);
        let refused = run(dir.path(), &format!("{line} --lang zh"));
        assert!(refused.err.contains("缺少必需的参数：\n  --model <URL>"), "{option}: {}", refused.err);
    }
    // The variable with the name of the model may be set for other commands.
    let line = ["draft", "--lake", &format!("{}/lake", demo().display()), "--from"];
    let mined = format!("{}/mined", demo().display());
    let line: Vec<&str> = line.into_iter().chain([mined.as_str(), "--out", "d.jsonl"]).collect();
    let drafted = whyroad_with(dir.path(), &line, &[("WHYROAD_MODEL", "m")]);
    assert_eq!(drafted.code, 0, "{}", drafted.err);
    let served = run(dir.path(), "serve --people-share 0.5");
    assert!(served.code == 2 && served.err.contains("--model <URL>"), "{}", served.err);
}

#[test]
fn agreement_of_nothing_has_no_empty_brackets() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("a.jsonl"), "").unwrap();
    fs::write(dir.path().join("b.jsonl"), "").unwrap();
    for lang in ["en", "zh"] {
        let none = run(dir.path(), &format!("agreement a.jsonl b.jsonl --lang {lang}"));
        for empty in ["()", "（）", "[]", "brackets", "方括号"] {
            assert!(!none.out.contains(empty), "{}", none.out);
        }
    }
}
