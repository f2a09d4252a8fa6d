//! Summary of a mined folder: its drives from the metadata of their clips, its episodes from the four columns that
//! counts need. Neither reads the lake, and neither holds all episodes.

use super::{MinedFile, MinedFolder};
use crate::LakeError;
use crate::file::next_batch;
use arrow_array::cast::AsArray;
use arrow_array::types::Int64Type;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader};
use whyroad_model::messages::ClipMetadataMessage;
use whyroad_model::{ClipId, DriveId, Nanos, ScenarioId};

/// A drive that was searched.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriveSummary {
    /// Recorded time of the clips that it is divided into, together, s.
    pub seconds: f64,
    /// City or road network.
    pub place: Option<String>,
    /// Vehicle or fleet.
    pub source: Option<String>,
    /// First frame.
    pub start: Option<Nanos>,
}

/// Summary of an episode.
#[derive(Clone, Debug, PartialEq)]
pub struct EpisodeSummary {
    /// Class.
    pub scenario_id: ScenarioId,
    /// Drive.
    pub drive_id: DriveId,
    /// Keyframe.
    pub keyframe: Nanos,
    /// Arbitration made it primary.
    pub is_primary: bool,
}

impl MinedFolder {
    /// The drives that were searched, by the metadata of their clips.
    ///
    /// # Errors
    /// When the file cannot be read; a line that is not clip metadata is an error too, since hours would be missing.
    pub fn drive_summaries(&self) -> Result<BTreeMap<DriveId, DriveSummary>, LakeError> {
        let path = self.path(MinedFile::Clips);
        let file = BufReader::new(File::open(&path).map_err(LakeError::io(&path))?);
        let mut out: BTreeMap<DriveId, DriveSummary> = BTreeMap::new();
        for line in file.lines() {
            let line = line.map_err(LakeError::io(&path))?;
            if line.trim().is_empty() {
                continue;
            }
            let message: ClipMetadataMessage =
                serde_json::from_str(&line).map_err(|e| LakeError::broken(&path, e))?;
            let clip = message.clip_metadata;
            let id = ClipId(clip.clip_id);
            // Its frames are also in the regular clips.
            if id.is_around_keyframe() {
                continue;
            }
            let named = id.drive().map(|drive| drive.0);
            let Some(drive) = clip.drive_id.or(named) else { continue };
            let known = out.entry(DriveId(drive)).or_default();
            // Of frames: gaps of the log were not recorded.
            known.seconds += if clip.frame_rate > 0.0 {
                f64::from(clip.total_frames) / clip.frame_rate
            } else {
                clip.duration_sec
            };
            known.place = known.place.take().or(clip.place);
            known.source = known.source.take().or(Some(clip.source).filter(|s| !s.is_empty()));
            known.start = Some(known.start.map_or(clip.capture_time, |t| t.min(clip.capture_time)));
        }
        Ok(out)
    }

    /// Calls `each` for every episode, in the order of the table.
    ///
    /// # Errors
    /// When the table cannot be read.
    pub fn each_episode(&self, mut each: impl FnMut(EpisodeSummary)) -> Result<(), LakeError> {
        let path = self.path(MinedFile::EpisodeTable);
        let broken = |e: &dyn std::fmt::Display| LakeError::broken(&path, e);
        let file = File::open(&path).map_err(LakeError::io(&path))?;
        let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(|e| broken(&e))?;
        let names = ["scenario_id", "drive_id", "keyframe_ns", "is_primary"];
        let mask = ProjectionMask::columns(builder.parquet_schema(), names);
        let mut reader = builder.with_projection(mask).build().map_err(|e| broken(&e))?;
        while let Some(batch) = next_batch(&mut reader).map_err(|e| broken(&e))? {
            let column = |name: &str| {
                batch.column_by_name(name).ok_or_else(|| broken(&format!("column '{name}' is missing")))
            };
            let odd = |name: &str| broken(&format!("column '{name}' is not as expected"));
            let (classes, drives) = (column(names[0])?, column(names[1])?);
            let (times, primary) = (column(names[2])?, column(names[3])?);
            let classes = classes.as_string_opt::<i32>().ok_or_else(|| odd(names[0]))?;
            let drives = drives.as_string_opt::<i32>().ok_or_else(|| odd(names[1]))?;
            let times = times.as_primitive_opt::<Int64Type>().ok_or_else(|| odd(names[2]))?;
            let primary = primary.as_boolean_opt().ok_or_else(|| odd(names[3]))?;
            for row in 0..batch.num_rows() {
                each(EpisodeSummary {
                    scenario_id: classes.value(row).parse().map_err(|e: String| broken(&e))?,
                    drive_id: DriveId::from(drives.value(row)),
                    keyframe: Nanos(times.value(row)),
                    is_primary: primary.value(row),
                });
            }
        }
        Ok(())
    }
}
