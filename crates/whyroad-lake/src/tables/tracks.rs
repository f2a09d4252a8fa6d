//! `tracks.parquet`: every tracked object, a row for each frame in which it was observed, ordered by clip,
//! then track, then frame: a clip's rows are contiguous, and a whole track is found by joining its clips.

use crate::LakeError;
use crate::chunks::runs_of;
use crate::columns::{Table, TableBuilder, empty_if_unknown, member_name};
use crate::tables::ego::{known_at_column, motion_columns, read_known_at, read_motion};
use crate::tables::frames;
use arrow_array::Array;
use std::collections::BTreeMap;
use std::ops::Range;
use whyroad_model::scene::{Motion, Track, TurnSignal};
use whyroad_model::{Drive, Nanos, ObjectClass, TrackId};

pub(crate) const ROW_ORDER: &str = "clip,track_id,frame";

pub(crate) fn to_table(drive: &Drive) -> TableBuilder {
    let (clips, of_frames) = frames::clip_ids(drive);
    // (clip, track, rows) in the promised order: tracks are ordered by id and rows by frame.
    let mut order: Vec<(usize, &Track, Range<usize>)> = Vec::new();
    let mut next_rows = vec![0; drive.tracks.len()];
    for clip in 0..clips.len() {
        for (track, next) in drive.tracks.iter().zip(&mut next_rows) {
            let of_clip =
                track.frames[*next..].iter().take_while(|f| of_frames[**f as usize] == clip).count();
            order.push((clip, track, *next..*next + of_clip));
            *next += of_clip;
        }
    }
    let count = order.iter().map(|(_, _, rows)| rows.len()).sum();
    let number = |pick: fn(&Track) -> &[f64]| {
        let mut out = Vec::with_capacity(count);
        order.iter().for_each(|(_, track, rows)| out.extend_from_slice(&pick(track)[rows.clone()]));
        out
    };
    // Empty where the log has none.
    let number_if_any = |pick: fn(&Track) -> &[f64]| {
        let mut out = Vec::with_capacity(count);
        for (_, track, rows) in &order {
            match pick(track) {
                [] => out.extend(rows.clone().map(|_| f64::NAN)),
                values => out.extend_from_slice(&values[rows.clone()]),
            }
        }
        out
    };
    let motion = Motion {
        x: number(|t| &t.motion.x),
        y: number(|t| &t.motion.y),
        z: number(|t| &t.motion.z),
        heading: number(|t| &t.motion.heading),
        vx: number(|t| &t.motion.vx),
        vy: number(|t| &t.motion.vy),
        accel: number(|t| &t.motion.accel),
        yaw_rate: number(|t| &t.motion.yaw_rate),
        forward: number_if_any(|t| &t.motion.forward),
    };
    // (clip, track, row) of each row.
    let each =
        || order.iter().flat_map(|(clip, track, rows)| rows.clone().map(move |row| (*clip, *track, row)));
    let known_at =
        each().map(|(_, track, row)| (drive.times[track.frames[row] as usize], track.known_at.get(row)));
    // A class and its source's word, for a stretch of rows.
    let stated = order.iter().flat_map(|(_, track, rows)| {
        let step = if track.class_changes.is_empty() { rows.len().max(1) } else { 1 };
        rows.clone().step_by(step).map(move |row| (track.class_at(row), step))
    });
    let table = TableBuilder::default()
        .text_runs("clip_id", order.iter().map(|(clip, _, rows)| (clips[*clip].as_str(), rows.len())))
        .text_runs("track_id", order.iter().map(|(_, track, rows)| (track.id.as_str(), rows.len())))
        .indices("frame", each().map(|(_, track, row)| track.frames[row]))
        .integers("time_ns", each().map(|(_, track, row)| drive.times[track.frames[row] as usize].0))
        .text_runs("class", stated.clone().map(|((class, _), rows)| (class.id(), rows)))
        .text_runs("source_class", stated.map(|((_, word), rows)| (word, rows)));
    motion_columns(known_at_column(table, known_at), motion)
        .numbers("length_m", number(|t| &t.length_m))
        .numbers("width_m", number(|t| &t.width_m))
        .numbers("height_m", number(|t| &t.height_m))
        .numbers("interior_points", number(|t| &t.interior_points))
        .texts_or_null(
            "turn_signal",
            each().map(|(_, track, row)| {
                track.turn_signal.get(row).copied().flatten().map(|s| member_name(&s))
            }),
        )
        .numbers("visible_share", number_if_any(|t| &t.visible_share))
        .texts_or_null(
            "occluder",
            each().map(|(_, track, row)| track.occluder.get(row)?.as_ref().map(TrackId::as_str)),
        )
}

pub(crate) fn from_table(t: &Table, frame_count: usize) -> Result<Vec<Track>, LakeError> {
    let ids = t.texts("track_id")?;
    let frames = t.indices("frame")?;
    let classes = t.texts("class")?;
    let source_classes = t.texts("source_class")?;
    let motion = read_motion(t)?;
    let sizes = [t.numbers("length_m")?, t.numbers("width_m")?, t.numbers("height_m")?];
    let points = t.numbers("interior_points")?;
    let signals: Vec<Option<TurnSignal>> = t.members("turn_signal")?;

    let shares = t.numbers("visible_share")?;
    let occluders = t.texts_or_null("occluder")?;
    let (known_at, times) = (read_known_at(t)?, t.integers("time_ns")?);

    // The number of each row's clip, which its id ends in.
    let number = |id: Option<&str>| id.and_then(|id| id.rsplit('_').next()?.parse::<usize>().ok());
    let clips: Vec<Option<usize>> =
        runs_of(t.texts("clip_id")?).flat_map(|(id, rows)| std::iter::repeat_n(number(id), rows)).collect();
    let clip = |i: usize| clips[i];
    // Rows one after another of the same object.
    let mut runs: Vec<(&str, Range<usize>)> = Vec::new();
    for (id, rows) in runs_of(ids) {
        let start = runs.last().map_or(0, |(_, before)| before.end);
        runs.push((id.unwrap_or_default(), start..start + rows));
    }
    let out_of_order = |before: Option<&str>, (id, rows): &(&str, Range<usize>)| {
        let follows = |i: usize| {
            let is_first = i == rows.start;
            clip(i - 1) < clip(i)
                || (clip(i - 1) == clip(i)
                    && if is_first { before < Some(*id) } else { frames[i - 1] < frames[i] })
        };
        rows.clone().find(|&i| i > 0 && !follows(i))
    };
    let before = std::iter::once(None).chain(runs.iter().map(|(id, _)| Some(*id)));
    if let Some(row) = before.zip(&runs).find_map(|(before, run)| out_of_order(before, run)) {
        return Err(LakeError::RowOrder { path: t.path.clone(), row });
    }
    if let Some(f) = frames.iter().find(|&&f| f as usize >= frame_count) {
        return Err(LakeError::broken(
            &t.path,
            format!("frame {f} is beyond the drive's {frame_count} frames"),
        ));
    }
    // Clips ascend, so a track's rows come in the order of its frames although they are apart in the file.
    let mut runs_by_id: BTreeMap<&str, Vec<Range<usize>>> = BTreeMap::new();
    for (id, rows) in runs {
        runs_by_id.entry(id).or_default().push(rows);
    }
    runs_by_id
        .into_iter()
        .map(|(id, runs)| {
            let pick = |v: &[f64]| {
                let mut out = Vec::with_capacity(runs.iter().map(Range::len).sum());
                runs.iter().for_each(|rows| out.extend_from_slice(&v[rows.clone()]));
                out
            };
            let rows: Vec<usize> = runs.iter().cloned().flatten().collect();
            let class = |row: usize| {
                ObjectClass::from_id(classes.value(row)).ok_or_else(|| {
                    LakeError::broken(&t.path, format!("'{}' is not an object class", classes.value(row)))
                })
            };
            let mut last: Option<(ObjectClass, &str)> = None;
            let stated = rows.iter().map(|&i| {
                // Mostly it is the class of the row before.
                let same = last.filter(|(known, _)| known.id() == classes.value(i));
                let known = same.map_or_else(|| class(i), |(known, _)| Ok(known))?;
                Ok(*last.insert((known, source_classes.value(i))))
            });
            let stated = stated.collect::<Result<Vec<_>, LakeError>>()?;
            let mut track = Track {
                id: TrackId::from(id),
                frames: rows.iter().map(|&i| frames[i]).collect(),
                motion: Motion {
                    x: pick(&motion.x),
                    y: pick(&motion.y),
                    z: pick(&motion.z),
                    heading: pick(&motion.heading),
                    vx: pick(&motion.vx),
                    vy: pick(&motion.vy),
                    accel: pick(&motion.accel),
                    yaw_rate: pick(&motion.yaw_rate),
                    forward: empty_if_unknown(
                        rows.iter().filter_map(|&i| motion.forward.get(i).copied()).collect(),
                        |v| !v.is_nan(),
                    ),
                },
                length_m: pick(&sizes[0]),
                width_m: pick(&sizes[1]),
                height_m: pick(&sizes[2]),
                interior_points: pick(&points),
                turn_signal: empty_if_unknown(rows.iter().map(|&i| signals[i]).collect(), Option::is_some),
                visible_share: empty_if_unknown(rows.iter().map(|&i| shares[i]).collect(), |share: &f64| {
                    !share.is_nan()
                }),
                occluder: empty_if_unknown(
                    rows.iter()
                        .map(|&i| occluders.is_valid(i).then(|| TrackId::from(occluders.value(i))))
                        .collect(),
                    Option::is_some,
                ),
                known_at: later_than_frames(&rows, &known_at, &times),
                ..Track::default()
            };
            track.state_classes(stated);
            Ok(track)
        })
        .collect()
}

/// When the rows of one track were known; empty when none was known later than its frame.
fn later_than_frames(rows: &[usize], known_at: &[Nanos], times: &[i64]) -> Vec<Nanos> {
    if !rows.iter().any(|&i| known_at.get(i).is_some_and(|at| at.0 > times[i])) {
        return Vec::new();
    }
    rows.iter().map(|&i| known_at[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file;

    #[test]
    fn rows_out_of_order_are_refused() {
        let track = |id: &str| Track {
            id: id.into(),
            frames: vec![0],
            motion: Motion::unknown(1),
            length_m: vec![4.0],
            width_m: vec![2.0],
            height_m: vec![1.5],
            interior_points: vec![1.0],
            ..Track::default()
        };
        let read_back = |tracks: Vec<Track>| {
            let drive = Drive {
                meta: whyroad_model::scene::DriveMeta { drive_id: "d".into(), ..Default::default() },
                times: vec![Nanos(0)],
                tracks,
                ..Drive::default()
            };
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join("tracks.parquet");
            file::write_table(&path, to_table(&drive), ROW_ORDER).unwrap();
            from_table(&file::read_table(&path, ROW_ORDER).unwrap().unwrap(), 1)
        };
        assert_eq!(read_back(vec![track("a"), track("b")]).unwrap().len(), 2);
        // A writer that does not sort its tracks first.
        assert_eq!(read_back(vec![track("b"), track("a")]).unwrap_err().code(), "lake.row_order");
    }
}
