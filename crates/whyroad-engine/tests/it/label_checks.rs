//! Labels against the drives that they speak of: labels drafted from the bundled simulated drives (and the recorded
//! ones, where they are at hand) are true as far as motion goes; each is then made false in one way, and the check that
//! names the fault must find it. What the ego did is the simulator's, not ours.
#![allow(clippy::print_stdout, reason = "the table is what a reader wants to see")]

use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use whyroad_engine::label_drives::LabelDrives;
use whyroad_engine::mine::{MineOptions, mine_lake_with};
use whyroad_framework::Framework;
use whyroad_ingest::{Options as Ingest, find_sources, read};
use whyroad_label::check::{Checker, Recorded, Recordings};
use whyroad_label::draft::draft;
use whyroad_lake::Lake;
use whyroad_mining::RuleSet;
use whyroad_model::{Lang, TrackId};
use whyroad_signals::Catalog;

/// Codes of the checks against the recording.
const AGAINST_RECORDING: [&str; 5] =
    ["label.motion.", "label.object.", "label.keyframe.moment", "label.class.rule", "label.cause.no_effect"];

struct Fault {
    kind: &'static str,
    codes: &'static [&'static str],
    label: Value,
}

pub(crate) fn lake(dir: &Path, folders: &[PathBuf]) -> Lake {
    let lake = Lake::create_or_open(dir.join("lake")).unwrap();
    for source in find_sources(None, folders).0 {
        // All of a simulation, not what a sensor sees of it.
        let all = Ingest::default().with(&whyroad_ingest::sumo::SENSOR_RANGE, f64::INFINITY);
        if let Some(drive) = read(&source, &all).0 {
            lake.write_drive(&drive).unwrap();
        }
    }
    lake
}

/// Drafts of all primary episodes, in both languages, written as a person would hand them in.
fn labels(lake: &Lake) -> Vec<Value> {
    let framework = Framework::bundled();
    let rules = RuleSet::of_framework(framework, Catalog::bundled()).0;
    let mined = mine_lake_with(lake, &rules, &MineOptions::default(), |_| ());
    let mut out = Vec::new();
    for found in &mined.drives {
        let drive = lake.read_drive(&found.drive_id).unwrap();
        let signals = whyroad_engine::mine::signals_of(lake, &found.drive_id).unwrap();
        for episode in found.episodes.iter().filter(|e| e.record.is_primary) {
            for lang in [Lang::Zh, Lang::En] {
                let made = draft(framework, &drive, &signals, &episode.record, lang);
                out.push(serde_json::to_value(made.label).unwrap());
            }
        }
    }
    out
}

/// What the ego does in the 6 s after the keyframe, from the drive itself.
struct Motion {
    speeds: Vec<f64>,
    turned_deg: f64,
}

fn motion(drives: &LabelDrives, label: &Value) -> Motion {
    let recorded = drives.of_clip(label["clip_id"].as_str().unwrap()).unwrap();
    let times = &recorded.drive.times;
    let at = whyroad_model::Nanos::parse_iso(label["keyframe"]["timestamp"].as_str().unwrap()).unwrap();
    let from = whyroad_model::time::frame_at(times, at).min(times.len() - 1);
    let to = (from + 61).min(times.len());
    let ego = recorded.drive.ego.as_ref().unwrap();
    let speed = recorded.signals.frame_columns.get("ego.speed").unwrap();
    let heading = |f: usize| ego.motion.heading[f];
    let mut turned = 0.0;
    for f in from + 1..to {
        let d: f64 = heading(f) - heading(f - 1);
        turned += (d + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
    }
    Motion { speeds: (from..to).filter_map(|f| speed.number(f)).collect(), turned_deg: turned.to_degrees() }
}

fn faults(label: &Value, m: &Motion) -> Vec<Fault> {
    let mut out = Vec::new();
    let mut add = |kind, codes, change: &dyn Fn(&mut Value)| {
        let mut label = label.clone();
        change(&mut label);
        out.push(Fault { kind, codes, label });
    };
    let decide = |along: Value, across: Value, side: Value| {
        move |l: &mut Value| {
            l["driving_decision"] =
                json!({ "longitudinal": along, "lateral": across, "lateral_direction": side });
        }
    };
    let (first, whole) = (m.speeds[0], m.speeds.len() > 60);
    let least = m.speeds.iter().copied().fold(f64::INFINITY, f64::min);
    let most = m.speeds.iter().copied().fold(0.0, f64::max);
    let contradicts: &[&str] = &["label.motion.contradicts"];
    if whole && least > 3.0 && m.speeds[60] > 0.7 * first {
        add(
            "a stop that did not happen",
            contradicts,
            &decide(json!("stop_for_regulation"), json!(null), json!(null)),
        );
    }
    if whole && least > 2.0 {
        add("start of a moving car", contradicts, &decide(json!("resume"), json!(null), json!(null)));
    }
    if least > first - 0.3 && most > first + 2.5 {
        add(
            "yield while speeding up",
            contradicts,
            &decide(json!("yield_to_agent"), json!(null), json!(null)),
        );
    }
    if whole && first > 5.0 && least < 0.1 {
        add(
            "speed kept while stopping",
            contradicts,
            &decide(json!("set_speed_tracking"), json!(null), json!(null)),
        );
    }
    if least < first - 3.0 && most < first + 0.3 {
        add(
            "passing while slowing",
            contradicts,
            &decide(json!("acceleration_for_passing"), json!("lane_change"), json!("left")),
        );
    }
    if m.turned_deg.abs() > 60.0 {
        let other = if m.turned_deg > 0.0 { "right" } else { "left" };
        add("turn to the other side", contradicts, &decide(json!(null), json!("turn"), json!(other)));
    }
    if whole && m.turned_deg.abs() < 5.0 && least > 3.0 {
        add("a turn that did not happen", contradicts, &decide(json!(null), json!("turn"), json!("left")));
    }
    add("keyframe in another year", &["label.motion.outside"], &|l| {
        l["keyframe"]["timestamp"] = json!("2031-01-01T00:00:00.000Z");
    });
    add("keyframe moved", &["label.keyframe.moment"], &|l| {
        let at = whyroad_model::Nanos::parse_iso(l["keyframe"]["timestamp"].as_str().unwrap()).unwrap();
        l["keyframe"]["timestamp"] = json!(at.plus_secs(3.6).to_string());
    });
    let linked = label["critical_components"][0]["linked_objects"][0].as_str().map(str::to_owned);
    if linked.is_some() {
        add("object of no drive", &["label.object.unknown"], &|l| {
            l["critical_components"][0]["linked_objects"] = json!(["no such object"]);
        });
        let text = label["critical_components"][0]["description"].as_str().unwrap();
        let swapped = swap_sides(text);
        if swapped != text {
            add("object on the other side", &["label.object.position"], &|l| {
                l["critical_components"][0]["description"] = json!(swapped);
            });
        }
        let other = if text.contains("行人") || text.contains("pedestrian") {
            "前方的货车正在减速"
        } else {
            "前方的行人正在横穿道路"
        };
        add("object of another class", &["label.object.class"], &|l| {
            l["critical_components"][0]["description"] = json!(other);
        });
    }
    let parts = label["critical_components"].as_array().unwrap();
    let light = parts.iter().position(|c| c["category"] == "traffic_lights");
    if let Some(i) = light {
        let text = parts[i]["description"].as_str().unwrap().to_owned();
        let other = if text.contains("红") || text.contains("red") {
            "本车道信号灯为绿灯"
        } else {
            "本车道信号灯为红灯"
        };
        add("light of another color", &["label.object.light"], &|l| {
            l["critical_components"][i]["description"] = json!(other);
        });
    }
    out
}

fn swap_sides(text: &str) -> String {
    let pairs =
        [("左前方", "右前方"), ("左后方", "右后方"), ("左侧", "右侧"), ("on the left", "on the right")];
    for (a, b) in pairs {
        if text.contains(a) {
            return text.replace(a, b);
        }
        if text.contains(b) {
            return text.replace(b, a);
        }
    }
    text.to_owned()
}

fn of_recording(checker: &Checker<'_>, label: &Value) -> Vec<String> {
    let found = checker.check_text(&label.to_string());
    let ours = |c: &&str| AGAINST_RECORDING.iter().any(|p| c.starts_with(p));
    found.iter().map(|d| d.code).filter(ours).map(str::to_owned).collect()
}

fn run(lake: &Lake) -> (usize, usize, usize, usize) {
    let drives = LabelDrives::new(lake.clone(), Framework::bundled());
    let labels = labels(lake);
    let motions: Vec<Motion> = labels.iter().map(|l| motion(&drives, l)).collect();
    let checker = Checker::new(Framework::bundled()).with_recordings(Arc::new(drives));
    let mut kinds: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    let mut flagged = 0;
    for (label, motion) in labels.iter().zip(&motions) {
        // A draft leaves a decision null where its class explains no such motion, which is not the same as no change.
        let mut found = of_recording(&checker, label);
        found.retain(|c| c != "label.motion.unlabelled");
        if !found.is_empty() {
            flagged += 1;
            println!("FALSE ALARM {found:?} {} {}", label["scenario"]["full_id"], label["driving_decision"]);
        }
        for fault in faults(label, motion) {
            let found = of_recording(&checker, &fault.label);
            let hit = found.iter().any(|c| fault.codes.contains(&c.as_str()));
            let tally = kinds.entry(fault.kind).or_default();
            tally.0 += usize::from(hit);
            tally.1 += 1;
            if !hit {
                println!(
                    "MISSED {}: {found:?} {} {}",
                    fault.kind, label["scenario"]["full_id"], label["keyframe"]["timestamp"]
                );
            }
        }
    }
    for (kind, (hit, all)) in &kinds {
        println!("{kind:<28} {hit:>4} of {all}");
    }
    let (hit, all) = kinds.values().fold((0, 0), |(h, a), (hit, all)| (h + hit, a + all));
    println!("found {hit} of {all}; false alarms {flagged} of {}", labels.len());
    (hit, all, flagged, labels.len())
}

#[test]
fn on_simulated_drives() {
    let dir = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drives");
    let folders: Vec<PathBuf> =
        ["back_street", "multilane", "signal_junction"].map(|n| root.join(n)).to_vec();
    let (hit, all, flagged, labels) = run(&lake(dir.path(), &folders));
    assert!(all >= 150 && hit as f64 >= 0.95 * all as f64, "{hit} of {all}");
    assert!(flagged as f64 <= 0.05 * labels as f64, "{flagged} of {labels}");
}

#[test]
fn on_recorded_drives() {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let data = std::env::var_os("WHYROAD_DATA").map_or(beside, PathBuf::from);
    let logs = data.join("av2/sensor_logs");
    if !logs.is_dir() {
        println!("skipped: no recorded data");
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let (hit, all, flagged, labels) = run(&lake(dir.path(), &[logs]));
    assert!(hit as f64 >= 0.9 * all as f64, "{hit} of {all}");
    assert!(flagged as f64 <= 0.1 * labels as f64, "{flagged} of {labels}");
}

/// One change that makes `label` false for a check, where the recording offers it.
fn change_for(code: &str, label: &Value, recorded: &Recorded) -> Option<Value> {
    let mut out = label.clone();
    let times = &recorded.drive.times;
    let at = whyroad_model::Nanos::parse_iso(label["keyframe"]["timestamp"].as_str()?).ok()?;
    let keyframe = whyroad_model::time::frame_at(times, at).min(times.len() - 1);
    let linked = || label["critical_components"][0]["linked_objects"][0].as_str();
    let number = |id: &str, name: &str| {
        let row = recorded.signals.target(&TrackId::from(id))?.row(keyframe)?;
        recorded.signals.target_columns.get(name)?.number(row)
    };
    let speeds: Vec<f64> = (keyframe..(keyframe + 61).min(times.len()))
        .filter_map(|f| recorded.signals.frame_columns.get("ego.speed")?.number(f))
        .collect();
    let (least, most) = speeds.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(*v), b.max(*v)));
    match code {
        "label.motion.no_change" if speeds.len() > 60 && most - least < 0.3 && least > 1.0 => {
            out["driving_decision"] = json!({ "longitudinal": "road_speed_adaptation", "lateral": null });
        }
        "label.motion.side" if number(linked()?, "target.path_lateral")? > 1.5 => {
            out["driving_decision"] =
                json!({ "longitudinal": null, "lateral": "in_lane_nudge", "lateral_direction": "left" });
        }
        "label.object.unseen" => {
            let first = *recorded.drive.track(&TrackId::from(linked()?))?.frames.first()? as usize;
            let before = first.checked_sub(20)?;
            out["critical_components"][0]["evidence_times"] = json!([times[before].to_string()]);
        }
        "label.object.state" if number(linked()?, "target.speed")? > 3.0 => {
            let text = label["critical_components"][0]["description"].as_str()?;
            let (before, _) = text.split_once("轿车")?;
            out["critical_components"][0]["description"] = json!(format!("{before}轿车停着不动"));
        }
        "label.class.rule" => {
            out["scenario"] = json!({ "l1": "reactive_road", "l2": "weather_adaptation", "l3": "fog" });
        }
        "label.cause.no_effect" => {
            let own = linked()?;
            let (_, other) = recorded
                .signals
                .targets
                .iter()
                .filter(|t| t.id.as_str() != own)
                .filter_map(|t| Some((number(t.id.as_str(), "target.longitudinal")?, &t.id)))
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .filter(|(behind_m, _)| *behind_m < -5.0)?;
            out["critical_components"][0]["linked_objects"] = json!([other.as_str()]);
        }
        _ => return None,
    }
    Some(out)
}

/// Checks that the mutations above do not ask: each speaks of a label that is false for it, and of none of the true.
#[test]
fn each_check_against_the_recording_speaks() {
    let dir = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drives");
    let folders: Vec<PathBuf> =
        ["back_street", "multilane", "signal_junction"].map(|n| root.join(n)).to_vec();
    let lake = lake(dir.path(), &folders);
    let drives = Arc::new(LabelDrives::new(lake.clone(), Framework::bundled()));
    let checker = Checker::new(Framework::bundled()).with_recordings(drives.clone());
    let labels = labels(&lake);
    let says = |label: &Value, code: &str| of_recording(&checker, label).iter().any(|c| c == code);
    for code in [
        "label.motion.no_change",
        "label.motion.side",
        "label.object.unseen",
        "label.object.state",
        "label.class.rule",
        "label.cause.no_effect",
    ] {
        let (mut made, mut found) = (0, 0);
        for label in &labels {
            assert!(!says(label, code), "{code}: {label:#}");
            let recorded = drives.of_clip(label["clip_id"].as_str().unwrap()).unwrap();
            let Some(changed) = change_for(code, label, &recorded) else { continue };
            made += 1;
            found += usize::from(says(&changed, code));
        }
        println!("{code:<28} {found:>4} of {made}");
        assert!(found > 0, "{code}: none of {made}");
    }
}
