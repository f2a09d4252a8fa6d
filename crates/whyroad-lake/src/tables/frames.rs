//! `frames.parquet`: the time of every frame and the clip that it is in.

use crate::LakeError;
use crate::columns::{Table, TableBuilder};
use whyroad_model::{ClipId, Drive, Nanos, clip_of_frames};

pub(crate) const ROW_ORDER: &str = "frame";

/// Clips of a drive: their ids, and the clip of each frame.
pub(crate) fn clip_ids(drive: &Drive) -> (Vec<ClipId>, Vec<usize>) {
    let of_frames = clip_of_frames(&drive.times);
    let clips = of_frames.last().map_or(0, |last| last + 1);
    ((0..clips).map(|i| ClipId::of(&drive.meta.drive_id, i)).collect(), of_frames)
}

pub(crate) fn to_table(drive: &Drive) -> TableBuilder {
    let (clips, of_frames) = clip_ids(drive);
    TableBuilder::default()
        .texts("clip_id", of_frames.iter().map(|&clip| clips[clip].as_str()))
        .indices("frame", (0..).take(drive.times.len()))
        .integers("time_ns", drive.times.iter().map(|t| t.0))
}

pub(crate) fn from_table(t: &Table) -> Result<Vec<Nanos>, LakeError> {
    let frames = t.indices("frame")?;
    let times = t.integers("time_ns")?;
    if let Some(row) =
        (0..frames.len()).find(|&i| frames[i] as usize != i || (i > 0 && times[i] <= times[i - 1]))
    {
        return Err(LakeError::RowOrder { path: t.path.clone(), row });
    }
    Ok(times.into_iter().map(Nanos).collect())
}
