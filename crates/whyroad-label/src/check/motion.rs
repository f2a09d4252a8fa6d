//! The label against the recording: the ego's motion after the keyframe, the positions of the objects that the texts
//! name, and the episodes that the rules found. Each finding states time, signal and value, and is only made where the
//! signals are known.

mod decision;
mod effect;
mod lateral;
mod moment;
mod object;
mod stated;

pub(super) use decision::said_speed;

use super::recording::Recorded;
use super::silence::Silence;
use super::texts::Texts;
use super::view::View;
use crate::driven::{Driven, across, along};
use std::sync::Arc;
use whyroad_framework::Framework;
use whyroad_framework::check::class_index::ClassIndex;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_model::Drive;
use whyroad_model::label_fields::pointer;
use whyroad_model::time::frame_at;

/// Maximum distance of a keyframe from the nearest frame, s.
const FRAME_SLACK_S: f64 = 0.15;

/// Runs every check against the recording. `history` is the drive as Stage I shows it.
pub(super) fn check(
    label: &View<'_>,
    recorded: &Recorded,
    history: &dyn Fn() -> Option<Arc<Recorded>>,
    framework: &Framework,
    classes: &ClassIndex,
    sink: &mut dyn Sink,
) {
    let (names, words) = (&framework.decisions, framework.label_words());
    let Some(keyframe) = label.keyframe.timestamp.get() else { return };
    let times = &recorded.drive.times;
    let (Some(first), Some(last)) = (times.first(), times.last()) else { return };
    if keyframe.seconds_since(*first) < -FRAME_SLACK_S || last.seconds_since(keyframe) < -FRAME_SLACK_S {
        let (from, to) = (*first, *last);
        sink.report(Finding::error("label.motion.outside", pointer::KEYFRAME_TIMESTAMP), &|| {
            Words::new(
                format!("关键帧 {keyframe} 不在该行程的记录内（{from} 至 {to}）"),
                format!("the keyframe {keyframe} is outside of the recorded drive ({from} to {to})"),
            )
        });
        return;
    }
    let window = driven(label, recorded, frame_at(times, keyframe).min(times.len() - 1));
    decision::check(label, &window, names, sink);
    lateral::check(label, &window, names, sink);
    let texts = Texts::of(label, words);
    // Components were written before anything later was shown: only what contradicts the values of that time, too, is a
    // fault. They are derived only where there may be one.
    let mut quiet = Silence::default();
    object::check(label, &texts, words, &window, None, &mut quiet);
    if quiet.broken {
        match history() {
            Some(history) => components(label, &history, Some(&recorded.drive), framework, sink),
            None => object::check(label, &texts, words, &window, None, sink),
        }
    }
    stated::check(label, &texts, words, &window, sink);
    effect::check(label, &texts, words, &window, sink);
    moment::check(label, recorded, classes, sink);
}

/// Compares the components with `history`, a drive that was cut at the keyframe; an object that only the `whole` drive
/// has appears later.
pub(super) fn components(
    label: &View<'_>,
    history: &Recorded,
    whole: Option<&Drive>,
    framework: &Framework,
    sink: &mut dyn Sink,
) {
    let Some(keyframe) = label.keyframe.timestamp.get() else { return };
    let times = &history.drive.times;
    if times.last().is_none_or(|last| last.seconds_since(keyframe) < -FRAME_SLACK_S) {
        return;
    }
    let words = framework.label_words();
    let window = Driven::after(&history.drive, &history.signals, times.len() - 1, None);
    object::check(label, &Texts::of(label, words), words, &window, whole, sink);
}

/// Channels of the decision that the recorded motion plainly shows: for a class that does not allow them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shown {
    pub longitudinal: bool,
    pub lateral: bool,
}

/// The parts of the label's decision that the ego plainly carries out after the keyframe.
pub(super) fn shown(label: &View<'_>, recorded: &Recorded) -> Shown {
    let times = &recorded.drive.times;
    let (Some(keyframe), Some(first), Some(last)) =
        (label.keyframe.timestamp.get(), times.first(), times.last())
    else {
        return Shown::default();
    };
    if keyframe < *first || keyframe > *last {
        return Shown::default();
    }
    let w = driven(label, recorded, frame_at(times, keyframe).min(times.len() - 1));
    Shown {
        longitudinal: label.longitudinal.get().is_some_and(|d| along::shows(&w, d)),
        lateral: label.lateral.get().is_some_and(|d| across::shows(&w, d, label.direction.get())),
    }
}

/// The recorded motion after the keyframe of a label.
fn driven<'r>(label: &View<'_>, recorded: &'r Recorded, keyframe: usize) -> Driven<'r> {
    Driven::after(&recorded.drive, &recorded.signals, keyframe, label.end.get())
}
