//! Labeling tasks: clip metadata, scenario pre-label, keyframe suggestion (DATA_FORMAT.md 3).

use super::values::{ordered, out_of_range, partial_class, share, suggested_type};
use crate::check::class_index::ClassIndex;
use crate::check::finding::{Finding, Sink, Words};
use crate::check::json::Node;
use crate::check::scenario::{self, ScenarioView};
use crate::check::slot::Slot;
use crate::check::walk::Walk;
use whyroad_model::Severity;

/// Frames per second of a suggestion, which names no clip (LABELING.md 4).
const RATE_HZ: f64 = 10.0;

pub(super) fn clip_metadata<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, classes: &ClassIndex) {
    const BASE: &str = "/clip_metadata";
    let Some(mut o) = walk.object(node, BASE.into()) else { return };
    for key in ["clip_id", "source"] {
        let (n, at) = (walk.need(&mut o, key), o.at(key));
        walk.text(n, &at);
    }
    let (n, at) = (walk.need(&mut o, "capture_time"), o.at("capture_time"));
    walk.time(n, &at);
    let mut positive = |walk: &mut Walk<'d>, key| {
        let (n, at) = (walk.need(&mut o, key), o.at(key));
        let v = walk.number(n, &at).get()?;
        if v > 0.0 {
            return Some(v);
        }
        out_of_range(walk, &at, &v.to_string(), "大于 0", "more than 0");
        None
    };
    let (duration_s, rate_hz) = (positive(walk, "duration_sec"), positive(walk, "frame_rate"));
    let (n, at) = (walk.need(&mut o, "total_frames"), o.at("total_frames"));
    let frames = walk.frame(n, &at).get();
    if let (Some(duration_s), Some(rate_hz), Some(frames)) = (duration_s, rate_hz, frames) {
        let due = duration_s * rate_hz;
        // One frame of rounding, and the additional frame that some logs count.
        if (f64::from(frames) - due).abs() > 1.5 {
            walk.report(Finding::error("message.clip.frames", at), &|| {
                Words::new(
                    format!(
                        "{duration_s} s × {rate_hz} Hz 约 {} 帧，total_frames 却是 {frames}",
                        due.round()
                    ),
                    format!(
                        "{duration_s} s at {rate_hz} Hz are about {} frames, but total_frames is {frames}",
                        due.round()
                    ),
                )
            });
        }
    }
    if let Some(n) = walk.need(&mut o, "data_sources") {
        data_sources(walk, n);
    }
    if let Some(n) = o.get("pre_labels") {
        pre_labels(walk, n, classes);
    }
    for key in ["drive_id", "place", "map_ref", "licence"] {
        let (n, at) = (o.get(key), o.at(key));
        walk.any_text(n, &at);
    }
    walk.close(o, Severity::Warning);
}

fn data_sources<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>) {
    let Some(mut o) = walk.object(node, "/clip_metadata/data_sources".into()) else { return };
    for key in ["video", "sensor"] {
        let (n, at) = (walk.need(&mut o, key), o.at(key));
        walk.texts(n, &at);
    }
    for key in ["can", "map"] {
        let (n, at) = (walk.need(&mut o, key), o.at(key));
        walk.flag(n, &at);
    }
    walk.close(o, Severity::Warning);
}

fn pre_labels<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, classes: &ClassIndex) {
    const SCENARIO: &str = "/clip_metadata/pre_labels/scenario";
    let Some(mut o) = walk.object(node, "/clip_metadata/pre_labels".into()) else { return };
    if let Some(n) = walk.need(&mut o, "scenario") {
        let s = scenario::read(walk, n, SCENARIO);
        partial_class(s, SCENARIO, classes, walk);
    }
    let (n, at) = (walk.need(&mut o, "mining_score"), o.at("mining_score"));
    share(walk, n, &at);
    let (n, at) = (walk.need(&mut o, "mining_method"), o.at("mining_method"));
    walk.text(n, &at);
    walk.close(o, Severity::Warning);
}

pub(super) fn scenario_pre_label<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, classes: &ClassIndex) {
    const BASE: &str = "/scenario_pre_label";
    let Some(mut o) = walk.object(node, BASE.into()) else { return };
    let mut need = |walk: &mut Walk<'d>, key| {
        let (n, at) = (walk.need(&mut o, key), o.at(key));
        if n.is_some() { walk.text(n, &at) } else { Slot::Broken }
    };
    let (l1, l2) = (need(walk, "l1"), need(walk, "l2"));
    let mut optional = |walk: &mut Walk<'d>, key| {
        let (n, at) = (o.get(key), o.at(key));
        walk.text(n, &at)
    };
    let (l3, suggested) = (optional(walk, "l3"), optional(walk, "suggested_l3"));
    partial_class(ScenarioView { l1, l2, l3, full_id: Slot::Absent }, BASE, classes, walk);
    if let (Slot::Is(_), Slot::Is(_), Slot::Is(_)) = (l1, l2, suggested) {
        let view = ScenarioView { l1, l2, l3: suggested, full_id: Slot::Absent };
        let mut aside = OnlySuggested { walk };
        scenario::check(&view, classes, BASE, &mut aside);
    }
    let (n, at) = (walk.need(&mut o, "confidence"), o.at("confidence"));
    share(walk, n, &at);
    let (n, at) = (walk.need(&mut o, "mining_conditions_matched"), o.at("mining_conditions_matched"));
    walk.texts(n, &at);
    walk.close(o, Severity::Warning);
}

/// Findings about the suggested variant, under its own name; those about L1 and L2 were already made.
struct OnlySuggested<'w, 'd> {
    walk: &'w mut Walk<'d>,
}

impl Sink for OnlySuggested<'_, '_> {
    fn report(&mut self, finding: Finding, words: &dyn Fn() -> Words) {
        if finding.pointer.ends_with("/l3") {
            self.walk
                .report(Finding { pointer: "/scenario_pre_label/suggested_l3".into(), ..finding }, words);
        }
    }
}

pub(super) fn keyframe_suggestion<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>) {
    const BASE: &str = "/keyframe_suggestion";
    let Some(mut o) = walk.object(node, BASE.into()) else { return };
    let (n, at) = (walk.need(&mut o, "type"), o.at("type"));
    suggested_type(walk, n, &at);
    let (n, time_at) = (walk.need(&mut o, "suggested_timestamp"), o.at("suggested_timestamp"));
    let time = walk.time(n, &time_at);
    let (n, frame_at) = (walk.need(&mut o, "suggested_frame_idx"), o.at("suggested_frame_idx"));
    let frame = walk.frame(n, &frame_at);
    let (n, at) = (walk.need(&mut o, "detection_rule"), o.at("detection_rule"));
    walk.text(n, &at);
    let context = walk.need(&mut o, "context_range");
    walk.close(o, Severity::Warning);

    let Some(mut c) = context.and_then(|n| walk.object(n, format!("{BASE}/context_range"))) else { return };
    let (n, at) = (walk.need(&mut c, "start_timestamp"), c.at("start_timestamp"));
    let start = walk.time(n, &at);
    let (n, end_at) = (walk.need(&mut c, "end_timestamp"), c.at("end_timestamp"));
    let end = walk.time(n, &end_at);
    let (n, at) = (c.get("start_frame_idx"), c.at("start_frame_idx"));
    let start_frame = walk.frame(n, &at);
    let (n, end_frame_at) = (c.get("end_frame_idx"), c.at("end_frame_idx"));
    let end_frame = walk.frame(n, &end_frame_at);
    walk.close(c, Severity::Warning);

    if !ordered(walk, &end_at, start, end) {
        return;
    }
    if let (Some(t), Some(start), Some(end)) = (time.get(), start.get(), end.get())
        && !(start <= t && t < end)
    {
        walk.report(Finding::error("message.keyframe.outside_range", time_at), &|| {
            Words::new(
                format!("建议的关键帧 {t} 不在 context_range 内（{start} 至 {end}）"),
                format!("the suggested keyframe {t} is not in context_range ({start} to {end})"),
            )
        });
    }
    let (Some(t0), Some(f0)) = (start.get(), start_frame.get()) else { return };
    for (pointer, time, frame) in [(frame_at, time, frame), (end_frame_at, end, end_frame)] {
        let (Some(t), Some(f)) = (time.get(), frame.get()) else { continue };
        let due_s = (f64::from(f) - f64::from(f0)) / RATE_HZ;
        if (t.seconds_since(t0) - due_s).abs() > 0.5 / RATE_HZ + 0.001 {
            walk.report(Finding::error("message.frame.timestamp_mismatch", pointer), &|| {
                let due = t0.plus_secs(due_s);
                Words::new(
                    format!("按 {RATE_HZ} Hz，第 {f} 帧应在 {due}，而时间戳为 {t}"),
                    format!("at {RATE_HZ} Hz, frame {f} is at {due}, but the timestamp says {t}"),
                )
            });
        }
    }
}
