//! `lights.parquet`, `context.parquet`, `media.parquet`: records with their own time and without a frame.

use crate::LakeError;
use crate::columns::{Table, TableBuilder, member_name};
use whyroad_model::Nanos;
use whyroad_model::scene::{ContextState, LightState, MediaFrame};

/// Order of the rows of `lights`.
pub(crate) const LIGHTS_ORDER: &str = "lane_id,time_ns";
/// Order of the rows of `context`.
pub(crate) const CONTEXT_ORDER: &str = "as ingested";
/// Order of the rows of `media`.
pub(crate) const MEDIA_ORDER: &str = "camera,time_ns";

pub(crate) fn lights_to_table(lights: &[LightState]) -> TableBuilder {
    TableBuilder::default()
        .texts("lane_id", lights.iter().map(|l| &l.lane_id))
        .texts_or_null("to_lane_id", lights.iter().map(|l| l.to_lane_id.as_ref()))
        .integers("time_ns", lights.iter().map(|l| l.time.0))
        .texts("colour", lights.iter().map(|l| member_name(&l.color)))
        .numbers("countdown_s", lights.iter().map(|l| l.countdown_s.unwrap_or(f64::NAN)))
}

pub(crate) fn lights_from_table(t: &Table) -> Result<Vec<LightState>, LakeError> {
    let (lanes, to_lanes) = (t.texts("lane_id")?, t.texts_or_null("to_lane_id")?);
    let (times, colors) = (t.integers("time_ns")?, t.texts("colour")?);
    let countdowns = known_or_none(t, "countdown_s")?;
    (0..t.rows())
        .map(|i| {
            Ok(LightState {
                lane_id: lanes.value(i).to_owned(),
                to_lane_id: text_at(to_lanes, i),
                time: Nanos(times[i]),
                color: t.member("colour", colors.value(i))?,
                countdown_s: countdowns[i],
            })
        })
        .collect()
}

pub(crate) fn context_to_table(context: &[ContextState]) -> TableBuilder {
    TableBuilder::default()
        .integers("time_ns", context.iter().map(|c| c.time.0))
        .texts("kind", context.iter().map(|c| &c.kind))
        .texts("value", context.iter().map(|c| &c.value))
        .texts("source", context.iter().map(|c| &c.source))
        .numbers("confidence", context.iter().map(|c| c.confidence.unwrap_or(f64::NAN)))
}

pub(crate) fn context_from_table(t: &Table) -> Result<Vec<ContextState>, LakeError> {
    let times = t.integers("time_ns")?;
    let (kinds, values, sources) = (t.texts("kind")?, t.texts("value")?, t.texts("source")?);
    let confidences = known_or_none(t, "confidence")?;
    Ok((0..t.rows())
        .map(|i| ContextState {
            time: Nanos(times[i]),
            kind: kinds.value(i).to_owned(),
            value: values.value(i).to_owned(),
            source: sources.value(i).to_owned(),
            confidence: confidences[i],
        })
        .collect())
}

pub(crate) fn media_to_table(media: &[MediaFrame]) -> TableBuilder {
    TableBuilder::default()
        .texts("camera", media.iter().map(|m| &m.camera))
        .integers("time_ns", media.iter().map(|m| m.time.0))
        .texts("uri", media.iter().map(|m| &m.uri))
        .indices("index", media.iter().map(|m| m.index))
}

pub(crate) fn media_from_table(t: &Table) -> Result<Vec<MediaFrame>, LakeError> {
    let (cameras, uris) = (t.texts("camera")?, t.texts("uri")?);
    let (times, indices) = (t.integers("time_ns")?, t.indices("index")?);
    Ok((0..t.rows())
        .map(|i| MediaFrame {
            camera: cameras.value(i).to_owned(),
            time: Nanos(times[i]),
            uri: uris.value(i).to_owned(),
            index: indices[i],
        })
        .collect())
}

/// A column of numbers that may be unknown; all unknown in a lake of an earlier build, which does not have it.
pub(crate) fn known_or_none(t: &Table, name: &str) -> Result<Vec<Option<f64>>, LakeError> {
    if !t.has(name) {
        return Ok(vec![None; t.rows()]);
    }
    Ok(t.numbers(name)?.into_iter().map(|v| (!v.is_nan()).then_some(v)).collect())
}

/// The text at `row`, `None` for null.
pub(crate) fn text_at(column: &arrow_array::StringArray, row: usize) -> Option<String> {
    use arrow_array::Array;
    (!column.is_null(row)).then(|| column.value(row).to_owned())
}
