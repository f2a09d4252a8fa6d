//! Visible shares on the recorded AV2 logs compared with lidar hits: points in each annotated box. The lidar is on the
//! roof and sees over cars, the eye in our model does not, so the two agree statistically, not for each object. Prints
//! the figures of docs/reference/accuracy-signals.md. Skipped if the data is not present.
use crate::scene::Table;
use std::path::PathBuf;
use whyroad_ingest::{Options, find_sources, read};
use whyroad_model::ObjectClass;

/// One row of a target from 5 to 60 m away.
struct Row {
    share: f64,
    points: f64,
    /// Points per square meter of a face across the line of sight at 1 m: independent of distance and size.
    density: f64,
    tall: bool,
}

fn rows() -> Vec<Row> {
    let base = std::env::var_os("WHYROAD_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let mut out = Vec::new();
    let folders = std::fs::read_dir(base.join("av2/sensor_logs")).into_iter().flatten().flatten();
    for folder in folders.map(|f| f.path()) {
        let (sources, _) = find_sources(None, &[folder]);
        let Some(drive) = sources.first().and_then(|s| read(s, &Options::default()).0) else { continue };
        let table = Table::of(&drive);
        // Ids as in the table: parts of one object are joined; rows that were added in gaps have no points.
        let drive = whyroad_signals::estimate(&drive).into_owned();
        if table.0.unavailable.contains_key("target.visible_share") {
            continue;
        }
        let ego = drive.ego.as_ref().unwrap();
        for track in &drive.tracks {
            for (row, &frame) in track.frames.iter().enumerate() {
                let f = frame as usize;
                let (dx, dy) = (track.motion.x[row] - ego.motion.x[f], track.motion.y[row] - ego.motion.y[f]);
                let (d, towards) = (dx.hypot(dy), dy.atan2(dx) - track.motion.heading[row]);
                let share = table.num(track.id.as_str(), "target.visible_share", f);
                if share.is_nan() || track.interior_points[row].is_nan() || !(5.0..60.0).contains(&d) {
                    continue;
                }
                let across =
                    track.length_m[row] * towards.sin().abs() + track.width_m[row] * towards.cos().abs();
                let points = track.interior_points[row];
                out.push(Row {
                    share,
                    points,
                    density: points * d * d / (across * track.height_m[row]),
                    tall: track.class.is_vehicle() || track.class == ObjectClass::Pedestrian,
                });
            }
        }
    }
    out
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn visible_shares_go_with_lidar_points() {
    let rows = rows();
    if rows.is_empty() {
        crate::require::skipped("recorded", "no recorded data");
        return;
    }
    let of = |from: f64, to: f64| rows.iter().filter(move |r| r.tall && r.share >= from && r.share < to);
    let bins = [(0.0, 0.1), (0.1, 0.3), (0.3, 0.7), (0.7, 1.0), (1.0, 2.0)];
    for (from, to) in bins {
        let n = of(from, to).count();
        let hit = of(from, to).filter(|r| r.points > 0.0).count();
        let density = median(of(from, to).map(|r| r.density).collect());
        println!(
            "share {from}..{to}: {n} rows, {:.1} % with points, median density {density:.0}",
            100.0 * hit as f64 / n as f64
        );
    }
    let typical = |from: f64, to: f64| median(of(from, to).map(|r| r.density).collect());
    // Targets that are hidden in our computation are hit far less often, and hits increase with the visible share.
    assert!(typical(0.0, 0.1) < 0.4 * typical(1.0, 2.0));
    assert!(typical(0.0, 0.1) < typical(0.1, 0.3) && typical(0.1, 0.3) < typical(0.3, 0.7));
    assert!(of(0.3, 2.0).filter(|r| r.points > 0.0).count() as f64 > 0.98 * of(0.3, 2.0).count() as f64);
    // Share of pairs (one row with points, one without) in which the one with points has the greater visible share.
    let none: Vec<f64> = rows.iter().filter(|r| r.tall && r.points == 0.0).map(|r| r.share).collect();
    let some: Vec<f64> =
        rows.iter().filter(|r| r.tall && r.points > 0.0).step_by(7).map(|r| r.share).collect();
    let score: f64 = none
        .iter()
        .flat_map(|a| {
            some.iter().map(move |b| {
                if b > a {
                    1.0
                } else if b == a {
                    0.5
                } else {
                    0.0
                }
            })
        })
        .sum();
    println!(
        "{} rows without points; pairs in the right order: {:.1} %",
        none.len(),
        100.0 * score / (none.len() * some.len()) as f64
    );
    assert!(score > 0.75 * (none.len() * some.len()) as f64);
}
