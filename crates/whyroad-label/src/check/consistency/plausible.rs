//! Times that are in order but not plausible: evidence from before the history, a range of hours, a start that differs
//! from the labeling spec.

use crate::check::clips::ClipFacts;
use crate::check::view::View;
use whyroad_framework::check::class_index::Prescribed;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_model::Nanos;
use whyroad_model::label_fields::pointer;

/// A clip has 20 s (LABELING.md 4); an episode that is labeled over several clips is longer.
const LONGEST_S: f64 = 120.0;
/// Minimum duration of a response in a label.
const SHORTEST_S: f64 = 0.2;
/// History before the keyframe that Stage I shows (LABELING.md 6), s.
const HISTORY_S: f64 = 2.0;
/// Maximum difference of a start from the labeling spec, s.
const START_SLACK_S: f64 = 0.55;

/// `time_range` has a plausible length.
pub(in crate::check) fn length(label: &View<'_>, sink: &mut dyn Sink) {
    let (Some(start), Some(end)) = (label.start.get(), label.end.get()) else { return };
    let seconds = end.seconds_since(start);
    // A reversed range is a separate finding.
    if seconds <= 0.0 || (SHORTEST_S..=LONGEST_S).contains(&seconds) {
        return;
    }
    sink.report(Finding::error("label.time_range.implausible", pointer::TIME_RANGE_END_TIMESTAMP), &|| {
        Words::new(
            format!("时间范围长 {seconds:.1} s，不合理"),
            format!("the time range is {seconds:.1} s long, which is implausible"),
        )
        .hint(
            format!("片段长 20 s；标注范围应在 {SHORTEST_S} s 至 {LONGEST_S} s 之间"),
            format!("a clip is 20 s long; a label covers {SHORTEST_S} s to {LONGEST_S} s"),
        )
    });
}

/// The keyframe's range lies in `time_range`.
pub(in crate::check) fn range_inside(label: &View<'_>, sink: &mut dyn Sink) {
    let (Some(start), Some(end)) = (label.start.get(), label.end.get()) else { return };
    let k = &label.keyframe;
    if start >= end || k.range_start.get().zip(k.range_end.get()).is_some_and(|(a, b)| a >= b) {
        return;
    }
    let ends = [(pointer::KEYFRAME_RANGE_START, k.range_start), (pointer::KEYFRAME_RANGE_END, k.range_end)];
    let outside = |t: Nanos| t < start || end < t;
    let Some((at, t)) = ends.iter().find_map(|(at, t)| Some((*at, t.get().filter(|t| outside(*t))?))) else {
        return;
    };
    sink.report(Finding::error("label.keyframe.range_outside", at), &|| {
        Words::new(
            format!("关键帧区间的 {t} 不在时间范围内（{start} 至 {end}）"),
            format!("the keyframe range reaches {t}, outside of the time range ({start} to {end})"),
        )
    });
}

/// Evidence lies in the history that the annotator was shown.
pub(in crate::check) fn evidence(label: &View<'_>, class: Option<&Prescribed>, sink: &mut dyn Sink) {
    let Some(keyframe) = label.keyframe.timestamp.get() else { return };
    let before_s = class.map_or(0.0, |c| c.pack_before_s);
    let shown = keyframe.plus_secs(-HISTORY_S);
    let from = label.start.get().map_or(shown, |s| s.plus_secs(-before_s).min(shown));
    for c in &label.parts {
        let early =
            c.evidence.iter().enumerate().filter_map(|(k, t)| Some((k, t.get().filter(|t| *t < from)?)));
        for (k, t) in early {
            let at = pointer::critical_components_item_evidence_times_item(c.index, k);
            sink.report(Finding::error("label.evidence.before_history", at), &|| {
                Words::new(
                    format!("证据时间 {t} 早于可见的历史（从 {from} 开始）"),
                    format!("evidence at {t} is before the history that is shown (from {from})"),
                )
                .hint("写关键帧之前看到它的时刻", "give the time before the keyframe at which it was seen")
            });
        }
    }
}

/// Start and end where the spec states them as an offset from the keyframe.
pub(in crate::check) fn start(
    label: &View<'_>,
    class: &Prescribed,
    clip: Option<&ClipFacts>,
    sink: &mut dyn Sink,
) {
    let (Some(keyframe), Some(start)) = (label.keyframe.timestamp.get(), label.start.get()) else { return };
    let Some(wanted_s) = class.start_offset_s else { return };
    let found_s = start.seconds_since(keyframe);
    // A keyframe outside of the range is a separate finding.
    let inside = found_s <= 0.0 && label.end.get().is_none_or(|e| keyframe < e);
    if (found_s - wanted_s).abs() <= START_SLACK_S || !inside {
        return;
    }
    // If the clip begins later, the range is cut off there.
    let at_clip_start = clip.is_some_and(|c| start.seconds_since(c.capture_time).abs() < START_SLACK_S)
        || label.start_frame.get() == Some(0);
    if found_s > wanted_s && at_clip_start {
        return;
    }
    sink.report(Finding::warning("label.time_range.start", pointer::TIME_RANGE_START_TIMESTAMP), &|| {
        let name = &class.title;
        let due = keyframe.plus_secs(wanted_s);
        // A start at the keyframe is 0 s before it, not -0.
        let (due_s, before_s) = (wanted_s.abs(), found_s.abs());
        Words::new(
            format!("“{}”的起点应为关键帧前 {:.1} s（{due}），此处为前 {:.1} s", name.zh, due_s, before_s),
            format!(
                "'{}' starts {:.1} s before the keyframe ({due}), but this label {:.1} s",
                name.en, due_s, before_s
            ),
        )
        .hint("调整起点，或检查场景类别", "move the start, or check the scenario class")
    });
}
