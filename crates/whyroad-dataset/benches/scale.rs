//! `scale`: a release from the drives of a lake, repeated under new ids, places and noise until there are enough
//! keyframes. Prints time, peak memory and bytes. Labels are made up (one per second of each drive); what is measured
//! is the build.
//!
//! `cargo bench -p whyroad-dataset --bench scale -- LAKE SAMPLES [--images] [--work FOLDER] [--keep]`; with
//! `--keep` the release stays, for the benches of exports and loaders.
#![allow(clippy::print_stdout)] // a bench prints

use std::fmt::Write as _;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::time::Instant;
use whyroad_dataset::licence::{BUNDLED, LicenceTable};
use whyroad_dataset::{Inputs, LabelStream, Media, build, spec};
use whyroad_framework::Framework;
use whyroad_lake::Lake;
use whyroad_model::{ClipId, Drive, DriveId};

const EXAMPLE: &str = include_str!("../../../examples/cutin_urgent_example.en.json");
const LEAVES: [&str; 4] = ["urgent", "slow", "congestion", "intersection"];
/// Places; drives of one place are kilometers from those of the next.
const PLACES: usize = 200;

type Failure = Box<dyn std::error::Error>;

/// The drive as another one: other id, other place, every object a little elsewhere.
fn repeated(drive: &Drive, n: usize) -> Drive {
    let mut out = drive.clone();
    let mut state = 0x9e37_79b9_u64.wrapping_mul(n as u64 + 1) | 1;
    let mut noise = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    out.meta.drive_id = DriveId(format!("{}-{n}", drive.meta.drive_id));
    out.meta.place = Some(format!("place{}", n % PLACES));
    out.meta.session = Some(format!("session{n}"));
    out.meta.content_hash = format!("{}-{n}", drive.meta.content_hash);
    out.meta.licence = Some("Apache-2.0".into());
    let factor = 1.0 + 0.4 * noise();
    for track in &mut out.tracks {
        let (dx, dy) = (6.0 * noise(), 2.0 * noise());
        track.motion.x.iter_mut().for_each(|x| *x += dx);
        track.motion.y.iter_mut().for_each(|y| *y += dy);
    }
    if let Some(ego) = &mut out.ego {
        // A little faster or slower along the same way: positions are scaled around the first.
        let m = &mut ego.motion;
        let (x0, y0) = (m.x.first().copied().unwrap_or(0.0), m.y.first().copied().unwrap_or(0.0));
        m.x.iter_mut().for_each(|x| *x = x0 + factor * (*x - x0));
        m.y.iter_mut().for_each(|y| *y = y0 + factor * (*y - y0));
        for v in m.vx.iter_mut().chain(&mut m.vy) {
            *v *= factor;
        }
    }
    out
}

fn label(drive: &Drive, second: usize, leaf: &str) -> Result<String, Failure> {
    let mut label: serde_json::Value = serde_json::from_str(EXAMPLE)?;
    let start = drive.times.first().copied().unwrap_or_default();
    let at = |offset: f64| start.plus_secs(second as f64 + offset).to_string();
    let clip = second / 20;
    let frame = (second % 20) * 10;
    label["clip_id"] = ClipId::of(&drive.meta.drive_id, clip).to_string().into();
    label["scenario"]["l3"] = leaf.into();
    label["scenario"]["full_id"] = format!("reactive_agent.cutin.{leaf}").into();
    label["time_range"] = serde_json::json!({
        "start_timestamp": at(-1.0), "end_timestamp": at(1.0),
        "start_frame_idx": frame.saturating_sub(10), "end_frame_idx": frame + 10,
    });
    label["keyframe"]["timestamp"] = at(0.0).into();
    label["keyframe"]["frame_idx"] = frame.into();
    for component in label["critical_components"].as_array_mut().into_iter().flatten() {
        component["evidence_times"] = serde_json::json!([at(0.0)]);
    }
    Ok(label.to_string())
}

/// Bytes below a folder.
fn bytes(dir: &Path) -> u64 {
    let entries = std::fs::read_dir(dir).into_iter().flatten().flatten();
    entries
        .map(|e| if e.path().is_dir() { bytes(&e.path()) } else { e.metadata().map_or(0, |m| m.len()) })
        .sum()
}

/// Most resident memory of this process, MB.
fn peak_mb() -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find(|l| l.starts_with("VmHWM:")).unwrap_or_default();
    line.split_whitespace().nth(1).and_then(|kb| kb.parse::<f64>().ok()).unwrap_or(f64::NAN) / 1024.0
}

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let images = arguments.iter().any(|a| a == "--images");
    let work =
        arguments.iter().position(|a| a == "--work").and_then(|i| arguments.get(i + 1)).map(PathBuf::from);
    let (Some(lake), Some(wanted)) =
        (arguments.first(), arguments.get(1).and_then(|n| n.parse::<usize>().ok()))
    else {
        println!("scale: not run; give a lake and a number of samples");
        return Ok(());
    };
    let work = work.unwrap_or_else(std::env::temp_dir).join(format!("whyroad-scale-{}", std::process::id()));
    let source = Lake::open(lake)?;
    let drives: Vec<Drive> =
        source.drive_ids().iter().map(|id| source.read_drive(id)).collect::<Result<_, _>>()?;
    let fleet = Lake::create_or_open(work.join("lake"))?;
    let (mut labels, mut n, mut made) = (String::new(), 0, 0);
    let started = Instant::now();
    'all: for round in 0.. {
        for drive in &drives {
            let drive = repeated(drive, round);
            fleet.write_drive(&drive)?;
            n += 1;
            let seconds = drive.times.last().map_or(0.0, |t| t.seconds_since(drive.times[0])) as usize;
            for second in 2..seconds.saturating_sub(6) {
                if made == wanted {
                    break 'all;
                }
                // Whole seconds inside a clip, so that the label's range is inside it too.
                if !(1..19).contains(&(second % 20)) {
                    continue;
                }
                writeln!(labels, "{}", label(&drive, second, LEAVES[made % LEAVES.len()])?)?;
                made += 1;
            }
        }
    }
    println!("{n} drives, {made} labels made in {:.0} s", started.elapsed().as_secs_f64());
    let spec_text = format!("name: scale\nsample: {{images: {}}}\n", if images { "bev" } else { "none" });
    let framework = Framework::bundled();
    let table = LicenceTable::read(BUNDLED, "licences.yaml").map_err(|_| "licences")?;
    let out = work.join("release");
    let inputs = Inputs {
        spec: spec::read(&spec_text, "spec", framework).map_err(|_| "spec")?,
        spec_text,
        framework,
        licences: &table,
        lake: &fleet,
        recordings: None,
        media: Media::default(),
        spec_dir: &work,
        out: &out,
        queries: &|_, _| None,
        restart: false,
    };
    let stream = LabelStream { name: "labels".into(), lines: Box::new(Cursor::new(labels)) };
    let started = Instant::now();
    let built = build(&inputs, vec![stream], &|_, _, _| true)?;
    let counts = &built.manifest.counts;
    println!(
        "{} samples of {made} in {:.1} s; peak {:.0} MB with the labels' text; {} bytes, {} images; dropped {:?}",
        counts.samples,
        started.elapsed().as_secs_f64(),
        peak_mb(),
        bytes(&out),
        counts.images,
        counts.dropped
    );
    if arguments.iter().any(|a| a == "--keep") {
        println!("{}", out.display());
        std::fs::remove_dir_all(work.join("lake"))?;
    } else {
        std::fs::remove_dir_all(&work)?;
    }
    Ok(())
}
