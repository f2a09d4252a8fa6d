//! `objects`: tracked objects, one row per object and time, brought to frames.

use super::ego::{states, velocities};
use super::findings;
use super::problems::Problems;
use super::reader::{Clock, Reader, gap_for};
use super::sheet::{Sheet, TIME};
use crate::assemble::class_names::class_of;
use crate::assemble::frames::{Sample, Sampled, median};
use crate::assemble::resample::{latest, linear};
use crate::report::RowCount;
use crate::source::impossible_speeds;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::scene::{FRAME_RATE_HZ, Track, TurnSignal};
use whyroad_model::{Need, ObjectClass, TrackId};

pub(super) const REQUIRED: &[&[&str]] = &[TIME, &["track_id"], &["class"], &["x_m"], &["y_m"]];

/// A column in which every row is unknown counts as absent.
fn empty_if<T>(values: Vec<T>, unknown: impl Fn(&T) -> bool) -> Vec<T> {
    if values.iter().all(unknown) { Vec::new() } else { values }
}

/// The tracks, and what the table does not have.
pub(super) fn tracks(sheet: Sheet, clock: &Clock, reader: &mut Reader) -> (Vec<Track>, Vec<Need>) {
    let mut problems = Problems::default();
    let p = &mut problems;
    let times = sheet.times(reader.start, p);
    let ids = sheet.texts("track_id");
    let classes = sheet.texts("class");
    let [x, y, z, points] = ["x_m", "y_m", "z_m", "interior_points"].map(|n| sheet.numbers(n, p));
    let [length, width, height] = ["length_m", "width_m", "height_m"].map(|n| sheet.sizes(n, p));
    let headings = sheet.headings(p);
    let velocity = velocities(&sheet, p);
    let signals: Vec<Option<TurnSignal>> = sheet.words("turn_signal", "one of off, left, right, hazard", p);

    let share = |text: &str| text.parse::<f64>().ok().filter(|v| (0.0..=1.0).contains(v));
    let shares = sheet.parsed("visible_share", "a number from 0 to 1", p, share);
    let occluders = sheet.texts("occluder");

    let mut count = RowCount { read: sheet.rows, ..RowCount::new("objects") };
    let mut by_track: BTreeMap<&str, Vec<(i64, usize)>> = BTreeMap::new();
    for (i, time) in times.iter().enumerate() {
        let row = sheet.first_row + i;
        match (time, ids[i].as_deref()) {
            (None, _) => problems.row("no_time", row, &mut count),
            (_, None) => problems.row("no_id", row, &mut count),
            _ if x[i].is_nan() || y[i].is_nan() => problems.row("no_position", row, &mut count),
            (Some(t), Some(id)) => by_track.entry(id).or_default().push((*t, i)),
        }
    }
    let all_times: BTreeSet<i64> = by_track.values().flatten().map(|r| r.0).collect();
    let steps: Vec<f64> = all_times
        .iter()
        .zip(all_times.iter().skip(1))
        .map(|(a, b)| b.saturating_sub(*a) as f64 / 1e9)
        .collect();
    let step_s = median(&steps);
    let max_gap_s = gap_for(step_s);
    // Rows farther from every frame than half a step are in no frame.
    let half_step_s = 0.5 * step_s.max(1.0 / FRAME_RATE_HZ) + 1e-3;
    let in_a_frame = |time: f64| {
        let next = clock.frames.partition_point(|f| *f < time);
        let near = |i: usize| clock.frames.get(i).is_some_and(|f| (f - time).abs() <= half_step_s);
        near(next) || next.checked_sub(1).is_some_and(near)
    };

    let mapping = reader.mapping.map(|m| m.1);
    let class_of = |word: &str| mapping.map_or_else(|| class_of(word), |mapping| mapping.class(word));
    let mut unknown_classes: BTreeMap<&str, usize> = BTreeMap::new();
    let mut impossible = BTreeMap::new();
    let mut tracks = Vec::new();
    for (id, mut rows) in by_track {
        rows.sort_unstable();
        let mut samples = Sampled::default();
        let mut kept = Vec::new();
        for (t, i) in rows {
            let time = clock.seconds(t);
            if samples.times.last() == Some(&time) {
                problems.row("duplicate", sheet.first_row + i, &mut count);
                continue;
            }
            kept.push(i);
            samples.push(Sample {
                time,
                position: [x[i], y[i], z[i]],
                heading: headings[i],
                velocity: velocity[i].vector,
                forward: velocity[i].forward,
                size: [length[i], width[i], height[i]],
                points: points[i],
            });
        }
        let stated = |i: usize| {
            let word = classes[i].as_deref().unwrap_or("unknown");
            (class_of(word), word)
        };
        for &i in &kept {
            if let (None, word) = stated(i) {
                *unknown_classes.entry(word).or_default() += 1;
            }
        }
        // By time: a class that becomes known later does not apply earlier.
        let by_row: Vec<(ObjectClass, &str)> =
            kept.iter().map(|&i| stated(i)).map(|(class, word)| (class.unwrap_or_default(), word)).collect();
        let mut whole = Track::default();
        whole.state_classes(by_row.iter().copied());
        let (mut track, rows) =
            samples.track_at(id, whole.class, &whole.source_class, &clock.frames, max_gap_s);
        if rows > 0 {
            impossible.insert(id.to_owned(), rows);
        }
        if track.frames.is_empty() {
            count.set_aside("ego_away", kept.len());
            continue;
        }
        let away = samples.times.iter().filter(|time| !in_a_frame(**time)).count();
        count.keep("track", kept.len() - away);
        count.set_aside("ego_away", away);
        let own: Vec<f64> = track.frames.iter().map(|&f| clock.frames[f as usize]).collect();
        let of_rows: Vec<Option<TurnSignal>> = kept.iter().map(|&i| signals[i]).collect();
        let last = latest(&samples.times, &own, max_gap_s);
        track.turn_signal = states(&of_rows, &last);
        track.state_classes(last.iter().map(|i| i.map_or((ObjectClass::Unknown, "unknown"), |i| by_row[i])));
        let hidden_by: Vec<Option<TrackId>> =
            kept.iter().map(|&i| occluders[i].as_deref().map(TrackId::from)).collect();
        track.occluder = empty_if(states(&hidden_by, &last), Option::is_none);
        let seen: Vec<f64> = kept.iter().map(|&i| shares[i].unwrap_or(f64::NAN)).collect();
        track.visible_share = empty_if(linear(&samples.times, &seen, &own, max_gap_s), |s| s.is_nan());
        tracks.push(track);
    }
    let out = &mut reader.report.diagnostics;
    out.extend(problems.diagnostics(&sheet.label));
    let known: Vec<&str> = ObjectClass::ALL.iter().map(|c| c.id()).collect();
    out.extend(
        unknown_classes.iter().map(|(word, rows)| findings::unknown_class(&sheet.label, word, *rows, &known)),
    );
    out.extend(impossible_speeds(&sheet.label, &impossible));
    reader.report.tables.push(count);

    let none = |of: fn(&Track) -> &[f64]| tracks.iter().all(|t| of(t).iter().all(|v| v.is_nan()));
    let lacking = [
        (Need::ObjectSizes, none(|t| &t.length_m) || none(|t| &t.width_m)),
        (Need::ObjectHeadings, none(|t| &t.motion.heading)),
        (Need::LidarPointsInBoxes, none(|t| &t.interior_points)),
    ];
    // An empty table says that there is nobody: nothing is lacking.
    let any = !tracks.is_empty();
    (tracks, lacking.into_iter().filter(|(_, absent)| any && *absent).map(|(name, _)| name).collect())
}
