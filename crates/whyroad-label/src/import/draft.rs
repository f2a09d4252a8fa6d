//! The draft of a label from a causal text and its moment in a drive.

use super::{Reasoning, findings};
use std::collections::BTreeMap;
use whyroad_model::messages::{
    CocLabel, CriticalComponent, DrivingDecision, Keyframe, KeyframeType, Provenance, ProvenanceSource,
    ScenarioLabel, TimeRange,
};
use whyroad_model::time::frame_at;
use whyroad_model::{ClipId, Diagnostic, DriveId, FrameRange, Nanos, end_time};

/// Frames of history and future in the range of a label where the source has no range: 2 s and 6 s (LABELING.md 4, 6).
const HISTORY_FRAMES: usize = 20;
const FUTURE_FRAMES: usize = 60;
/// Maximum distance of a moment from the nearest frame, s.
const MAX_OFFSET_S: f64 = 0.1;

/// The drive and the metadata for a text.
pub struct Place<'a> {
    /// The drive.
    pub drive: &'a DriveId,
    /// Its frame times.
    pub times: &'a [Nanos],
    /// Time 0 of the source's clip.
    pub zero: Nanos,
    /// Class of the labels.
    pub scenario: &'a ScenarioLabel,
    /// The author: a model or dataset.
    pub by: &'a str,
}

/// The draft of one text, with the moment at the nearest frame. Returns an error, as a diagnostic, when the drive does
/// not contain the moment.
pub fn draft(reasoning: &Reasoning, place: &Place<'_>) -> Result<CocLabel, Box<Diagnostic>> {
    let times = place.times;
    let at_s = reasoning.at_us as f64 / 1e6;
    let outside = || Box::new(findings::outside(&reasoning.origin, at_s, place.drive.as_str()));
    let absolute = |us: i64| us.checked_mul(1000).and_then(|ns| place.zero.0.checked_add(ns)).map(Nanos);
    let moment = absolute(reasoning.at_us).ok_or_else(outside)?;
    let frame = frame_at(times, moment).min(times.len().saturating_sub(1));
    if !times.get(frame).is_some_and(|t| t.seconds_since(moment).abs() <= MAX_OFFSET_S) {
        return Err(outside());
    }
    let (clip_id, FrameRange { start: first, end: last }) = ClipId::holding(place.drive, frame, times);
    let start = frame.saturating_sub(HISTORY_FRAMES).max(first);
    let until = reasoning.until_us.and_then(absolute).map(|t| frame_at(times, t));
    let end = until.unwrap_or(frame + FUTURE_FRAMES).clamp(frame + 1, last);
    let end_time = end_time(times, end);
    let in_clip = |frame: usize| u32::try_from(frame - first).unwrap_or(u32::MAX);
    let component = |(i, words): (usize, &String)| CriticalComponent {
        category: None,
        description: words.clone(),
        uncertainty: None,
        id: Some(format!("c{}", i + 1)),
        evidence_times: Vec::new(),
        linked_objects: Vec::new(),
    };
    Ok(CocLabel {
        version: Some(whyroad_model::FORMAT_VERSION.to_owned()),
        clip_id: clip_id.0,
        scenario: place.scenario.clone(),
        time_range: TimeRange {
            start_timestamp: times[start],
            end_timestamp: end_time,
            start_frame_idx: Some(in_clip(start)),
            end_frame_idx: Some(in_clip(end)),
        },
        keyframe: Keyframe {
            timestamp: times[frame],
            frame_idx: in_clip(frame),
            kind: KeyframeType::Reactive,
            range_start: None,
            range_end: None,
        },
        driving_decision: DrivingDecision { longitudinal: None, lateral: None, lateral_direction: None },
        critical_components: reasoning.components.iter().enumerate().map(component).collect(),
        coc_trace: reasoning.text.clone(),
        records: BTreeMap::new(),
        causes: None,
        second_keyframe: None,
        secondary_scenarios: Vec::new(),
        safety_filter: None,
        provenance: Some(Provenance {
            source: ProvenanceSource::Model,
            by: Some(place.by.to_owned()),
            at: None,
            tool: Some(format!("whyroad {}", env!("CARGO_PKG_VERSION"))),
            versions: reasoning.versions.clone(),
        }),
    })
}
