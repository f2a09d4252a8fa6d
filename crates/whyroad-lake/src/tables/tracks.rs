//! `tracks.parquet`: every tracked object, a row for each frame in which it was observed, ordered by clip,
//! then track, then frame: a clip's rows are contiguous, and a whole track is found by joining its clips.

use crate::LakeError;
use crate::columns::{Table, TableBuilder, empty_if_unknown, member_name};
use crate::tables::ego::{motion_columns, read_motion};
use crate::tables::frames;
use arrow_array::Array;
use std::collections::BTreeMap;
use whyroad_model::scene::{CLIP_FRAMES, Motion, Track, TurnSignal};
use whyroad_model::{Drive, ObjectClass, TrackId};

pub(crate) const ROW_ORDER: &str = "clip,track_id,frame";

pub(crate) fn to_table(drive: &Drive) -> TableBuilder {
    let clips = frames::clip_ids(drive);
    // (clip, track, row); tracks are ordered by id and rows by frame, so this sorts into the promised order.
    let mut order: Vec<(usize, usize, usize)> = Vec::new();
    for (t, track) in drive.tracks.iter().enumerate() {
        order.extend(track.frames.iter().enumerate().map(|(row, &f)| (f as usize / CLIP_FRAMES, t, row)));
    }
    order.sort_unstable();
    let tracks = || order.iter().map(|&(_, t, _)| &drive.tracks[t]);
    let number = |pick: fn(&Track) -> &[f64]| {
        order.iter().map(|&(_, t, row)| pick(&drive.tracks[t])[row]).collect::<Vec<_>>()
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
    };
    let frame_of = |&(_, t, row): &(usize, usize, usize)| drive.tracks[t].frames[row];
    let table = TableBuilder::default()
        .texts("clip_id", order.iter().map(|&(c, _, _)| clips[c].as_str()))
        .texts("track_id", tracks().map(|t| t.id.as_str()))
        .indices("frame", order.iter().map(frame_of))
        .integers("time_ns", order.iter().map(|o| drive.times[frame_of(o) as usize].0))
        .texts("class", tracks().map(|t| t.class.id()))
        .texts("source_class", tracks().map(|t| &t.source_class));
    motion_columns(table, &motion)
        .numbers("length_m", number(|t| &t.length_m))
        .numbers("width_m", number(|t| &t.width_m))
        .numbers("height_m", number(|t| &t.height_m))
        .numbers("interior_points", number(|t| &t.interior_points))
        .texts_or_null(
            "turn_signal",
            order.iter().map(|&(_, t, row)| {
                drive.tracks[t].turn_signal.get(row).copied().flatten().map(|s| member_name(&s))
            }),
        )
        .numbers(
            "visible_share",
            order
                .iter()
                .map(|&(_, t, row)| drive.tracks[t].visible_share.get(row).copied().unwrap_or(f64::NAN)),
        )
        .texts_or_null(
            "occluder",
            order.iter().map(|&(_, t, row)| drive.tracks[t].occluder.get(row)?.as_ref().map(TrackId::as_str)),
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

    // Lakes written before these two columns are read as sources that state nothing, which they are.
    let shares = if t.has("visible_share") { t.numbers("visible_share")? } else { Vec::new() };
    let occluders = if t.has("occluder") { Some(t.texts_or_null("occluder")?) } else { None };

    let key = |i: usize| (frames[i] as usize / CLIP_FRAMES, ids.value(i), frames[i]);
    if let Some(row) = (1..t.rows()).find(|&i| key(i - 1) >= key(i)) {
        return Err(LakeError::RowOrder { path: t.path.clone(), row });
    }
    if let Some(f) = frames.iter().find(|&&f| f as usize >= frame_count) {
        return Err(LakeError::broken(
            &t.path,
            format!("frame {f} is beyond the drive's {frame_count} frames"),
        ));
    }
    // Clips ascend, so a track's rows come in the order of its frames although they are apart in the file.
    let mut rows_of: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for i in 0..t.rows() {
        rows_of.entry(ids.value(i)).or_default().push(i);
    }
    rows_of
        .into_iter()
        .map(|(id, rows)| {
            let pick = |v: &[f64]| rows.iter().map(|&i| v[i]).collect::<Vec<_>>();
            let class_text = classes.value(rows[0]);
            let class = ObjectClass::from_id(class_text).ok_or_else(|| {
                LakeError::broken(&t.path, format!("'{class_text}' is not an object class"))
            })?;
            Ok(Track {
                id: TrackId::from(id),
                class,
                source_class: source_classes.value(rows[0]).to_owned(),
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
                },
                length_m: pick(&sizes[0]),
                width_m: pick(&sizes[1]),
                height_m: pick(&sizes[2]),
                interior_points: pick(&points),
                turn_signal: empty_if_unknown(rows.iter().map(|&i| signals[i]).collect(), Option::is_some),
                visible_share: empty_if_unknown(
                    rows.iter().filter_map(|&i| shares.get(i).copied()).collect(),
                    |share| !share.is_nan(),
                ),
                occluder: occluders.map_or_else(Vec::new, |ids| {
                    let id = |&i: &usize| ids.is_valid(i).then(|| TrackId::from(ids.value(i)));
                    empty_if_unknown(rows.iter().map(id).collect(), Option::is_some)
                }),
            })
        })
        .collect()
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
                times: vec![whyroad_model::Nanos(0)],
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

    #[test]
    fn a_lake_from_before_the_sensor_model_columns_is_read_as_one_that_does_not_tell() {
        let stated = Track {
            id: "a".into(),
            frames: vec![0],
            motion: Motion::unknown(1),
            length_m: vec![4.0],
            width_m: vec![2.0],
            height_m: vec![1.5],
            interior_points: vec![1.0],
            visible_share: vec![0.5],
            occluder: vec![Some("b".into())],
            ..Track::default()
        };
        let drive = Drive {
            meta: whyroad_model::scene::DriveMeta { drive_id: "d".into(), ..Default::default() },
            times: vec![whyroad_model::Nanos(0)],
            tracks: vec![stated],
            ..Drive::default()
        };
        let batch = to_table(&drive).finish().unwrap();
        let now = from_table(&Table { path: "now".into(), batch: batch.clone() }, 1).unwrap();
        assert_eq!((now[0].visible_share[0], &now[0].occluder[0]), (0.5, &Some("b".into())));
        let kept: Vec<usize> = (0..batch.num_columns())
            .filter(|&i| !["visible_share", "occluder"].contains(&batch.schema().field(i).name().as_str()))
            .collect();
        assert_eq!(kept.len() + 2, batch.num_columns());
        let old = Table { path: "old".into(), batch: batch.project(&kept).unwrap() };
        let old = from_table(&old, 1).unwrap();
        assert!(old[0].visible_share.is_empty() && old[0].occluder.is_empty());
    }
}
