//! Rules for times: ranges, keyframe, frames against timestamps, and the clip (DATA_FORMAT.md 4.3, LABELING.md 4).
//! Frame ranges and `time_range` are half-open; the keyframe's own range includes both ends.

use crate::check::clips::ClipFacts;
use crate::check::view::View;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_model::Nanos;
use whyroad_model::label_fields::pointer;
use whyroad_model::messages::KeyframeType;

/// Default frame rate (LABELING.md 4).
const DEFAULT_RATE_HZ: f64 = 10.0;
/// Timestamps are written to the millisecond or finer; a difference up to this is rounding.
const ROUNDING_S: f64 = 0.001;

/// `time_range`: in order, in the clip, frames that match the timestamps.
pub(in crate::check) fn time_range(label: &View<'_>, clip: Option<&ClipFacts>, sink: &mut dyn Sink) {
    if let (Some(start), Some(end)) = (label.start.get(), label.end.get())
        && start >= end
    {
        sink.report(Finding::error("label.time_range.order", pointer::TIME_RANGE_END_TIMESTAMP), &|| {
            Words::new(
                format!("时间范围的结束 {end} 不晚于开始 {start}"),
                format!("the time range ends at {end}, which is not after its start {start}"),
            )
        });
    }
    if let (Some(start), Some(end)) = (label.start_frame.get(), label.end_frame.get())
        && start >= end
    {
        sink.report(Finding::error("label.time_range.order", pointer::TIME_RANGE_END_FRAME_IDX), &|| {
            Words::new(
                format!("时间范围的结束帧 {end} 不大于开始帧 {start}"),
                format!("the time range ends at frame {end}, which is not after its first frame {start}"),
            )
            .hint("结束帧不含在内：最后一帧加一", "the end frame is not included: the last frame plus one")
        });
    }
    let Some(clip) = clip else { return };
    let ends =
        [(pointer::TIME_RANGE_START_TIMESTAMP, label.start), (pointer::TIME_RANGE_END_TIMESTAMP, label.end)];
    for (at, time) in ends {
        outside_clip("label.time_range.outside_clip", at, time, clip, sink);
    }
    if let Some(frame) = label.start_frame.get().filter(|f| *f >= clip.total_frames) {
        frame_outside(
            pointer::TIME_RANGE_START_FRAME_IDX,
            frame,
            clip.total_frames.saturating_sub(1),
            clip,
            sink,
        );
    }
    if let Some(frame) = label.end_frame.get().filter(|f| *f > clip.total_frames) {
        frame_outside(pointer::TIME_RANGE_END_FRAME_IDX, frame, clip.total_frames, clip, sink);
    }
    let anchor = Anchor { time: clip.capture_time, frame: 0, rate_hz: clip.frame_rate_hz };
    mismatch(pointer::TIME_RANGE_START_FRAME_IDX, label.start, label.start_frame, anchor, sink);
    mismatch(pointer::TIME_RANGE_END_FRAME_IDX, label.end, label.end_frame, anchor, sink);
}

/// The keyframe: its type's range, in `time_range` and in the clip, a frame that matches its timestamp.
pub(in crate::check) fn keyframe(label: &View<'_>, clip: Option<&ClipFacts>, sink: &mut dyn Sink) {
    let k = &label.keyframe;
    keyframe_range(label, sink);
    if let (Some(t), Some(start), Some(end)) = (k.timestamp.get(), label.start.get(), label.end.get()) {
        // If the range itself is reversed, that is the finding.
        if start < end && !(start <= t && t < end) {
            sink.report(
                Finding::error("label.keyframe.outside_time_range", pointer::KEYFRAME_TIMESTAMP),
                &|| {
                    Words::new(
                        format!("关键帧 {t} 不在时间范围内（{start} 至 {end}，不含结束时刻）"),
                        format!(
                            "the keyframe {t} is not in the time range ({start} up to, not including, {end})"
                        ),
                    )
                },
            );
        }
    }
    match clip {
        Some(clip) => {
            let ends =
                [(pointer::KEYFRAME_RANGE_START, k.range_start), (pointer::KEYFRAME_RANGE_END, k.range_end)];
            for (at, time) in ends {
                outside_clip("label.keyframe.outside_clip", at, time, clip, sink);
            }
            if let Some(frame) = k.frame.get().filter(|f| *f >= clip.total_frames) {
                frame_outside(
                    pointer::KEYFRAME_FRAME_IDX,
                    frame,
                    clip.total_frames.saturating_sub(1),
                    clip,
                    sink,
                );
            }
            let anchor = Anchor { time: clip.capture_time, frame: 0, rate_hz: clip.frame_rate_hz };
            mismatch(pointer::KEYFRAME_FRAME_IDX, k.timestamp, k.frame, anchor, sink);
        }
        // Without the clip, the label is still checked for consistency with itself.
        None => {
            if let (Some(time), Some(frame)) = (label.start.get(), label.start_frame.get()) {
                let anchor = Anchor { time, frame, rate_hz: DEFAULT_RATE_HZ };
                if label.end.get().is_some_and(|e| e > time)
                    && label.end_frame.get().is_some_and(|e| e > frame)
                {
                    mismatch(pointer::TIME_RANGE_END_FRAME_IDX, label.end, label.end_frame, anchor, sink);
                }
                mismatch(pointer::KEYFRAME_FRAME_IDX, k.timestamp, k.frame, anchor, sink);
            }
        }
    }
}

fn keyframe_range(label: &View<'_>, sink: &mut dyn Sink) {
    let k = &label.keyframe;
    let ends = [
        (pointer::KEYFRAME_RANGE_START, ("区间起点", "start of the range"), k.range_start),
        (pointer::KEYFRAME_RANGE_END, ("区间终点", "end of the range"), k.range_end),
    ];
    match k.kind.get() {
        Some(KeyframeType::Proactive) => {
            for (at, names, _) in ends.iter().filter(|(.., t)| t.is_absent()) {
                sink.report(Finding::error("label.keyframe.range_missing", *at), &|| {
                    Words::new(
                        format!("区间型（proactive）关键帧必须有{}", names.0),
                        format!("a proactive keyframe needs its {}", names.1),
                    )
                });
            }
        }
        Some(KeyframeType::Reactive) => {
            for (at, names, _) in ends.iter().filter(|(.., t)| matches!(t, Slot::Is(_))) {
                sink.report(Finding::warning("label.keyframe.range_on_reactive", *at), &|| {
                    Words::new(
                        format!("单一时刻（reactive）的关键帧没有{}", names.0),
                        format!("a reactive keyframe is one moment and has no {}", names.1),
                    )
                    .hint("删去，或把关键帧改为区间型", "remove it, or make the keyframe a range (proactive)")
                });
            }
        }
        None => {}
    }
    let (Some(start), Some(end)) = (k.range_start.get(), k.range_end.get()) else { return };
    if start >= end {
        sink.report(Finding::error("label.keyframe.range_order", pointer::KEYFRAME_RANGE_END), &|| {
            Words::new(
                format!("关键帧区间的结束 {end} 不晚于开始 {start}"),
                format!("the keyframe range ends at {end}, which is not after its start {start}"),
            )
        });
    } else if let Some(t) = k.timestamp.get().filter(|t| *t < start || end < *t) {
        sink.report(Finding::error("label.keyframe.outside_range", pointer::KEYFRAME_TIMESTAMP), &|| {
            Words::new(
                format!("关键帧 {t} 不在它自己的区间内（{start} 至 {end}）"),
                format!("the keyframe {t} is not in its own range ({start} to {end})"),
            )
        });
    }
}

/// A frame whose time is known.
#[derive(Clone, Copy)]
struct Anchor {
    time: Nanos,
    frame: u32,
    rate_hz: f64,
}

/// A frame index and a timestamp that are more than half a frame apart.
fn mismatch(pointer: &'static str, time: Slot<Nanos>, frame: Slot<u32>, anchor: Anchor, sink: &mut dyn Sink) {
    let (Some(time), Some(frame)) = (time.get(), frame.get()) else { return };
    let due_s = (f64::from(frame) - f64::from(anchor.frame)) / anchor.rate_hz;
    // In whole nanoseconds first: differences of present-day times are exact then; as f64 seconds since 1970 they are
    // not.
    let off_s = time.seconds_since(anchor.time) - due_s;
    if off_s.abs() <= 0.5 / anchor.rate_hz + ROUNDING_S {
        return;
    }
    sink.report(Finding::error("label.frame.timestamp_mismatch", pointer), &|| {
        let rate = anchor.rate_hz;
        let due = anchor.time.plus_secs(due_s);
        let fitting = f64::from(anchor.frame) + (time.seconds_since(anchor.time) * rate).round();
        Words::new(
            format!("按 {rate} Hz，第 {frame} 帧应在 {due}，而时间戳为 {time}"),
            format!("at {rate} Hz, frame {frame} is at {due}, but the timestamp says {time}"),
        )
        .hint(
            format!("该时间戳对应第 {fitting} 帧；检查两者中哪一个有误"),
            format!("that timestamp is frame {fitting}; check which of the two is wrong"),
        )
    });
}

fn outside_clip(
    code: &'static str,
    pointer: &'static str,
    time: Slot<Nanos>,
    clip: &ClipFacts,
    sink: &mut dyn Sink,
) {
    let Some(time) = time.get() else { return };
    let at_s = time.seconds_since(clip.capture_time);
    let slack_s = 0.5 / clip.frame_rate_hz + ROUNDING_S;
    if (-slack_s..=clip.duration_s + slack_s).contains(&at_s) {
        return;
    }
    sink.report(Finding::error(code, pointer), &|| {
        let (start, end) = (clip.capture_time, clip.capture_time.plus_secs(clip.duration_s));
        Words::new(
            format!("{time} 在片段之外（{start} 至 {end}）"),
            format!("{time} is outside the clip ({start} to {end})"),
        )
    });
}

fn frame_outside(pointer: &'static str, frame: u32, largest: u32, clip: &ClipFacts, sink: &mut dyn Sink) {
    sink.report(Finding::error("label.frame.outside_clip", pointer), &|| {
        let total = clip.total_frames;
        Words::new(
            format!("帧 {frame} 在片段之外：片段共 {total} 帧，此处最大为 {largest}"),
            format!("frame {frame} is outside the clip, which has {total} frames; at most {largest} here"),
        )
    });
}
