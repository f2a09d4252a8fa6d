//! A moment that no class explains, with the classes that it comes nearest to: for `other` and `explain other`.

use whyroad_mining::explain::{NearClass, UndecidedClass, nearest, undecided};
use whyroad_mining::rule::Rule;
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{ClipId, FrameRange, SignalTable};
use whyroad_report::unexplained::{
    NearestClass, UndecidedClass as UndecidedShown, UnexplainedMoment, UnmetPart,
};
use whyroad_signals::Catalog;

/// Number of nearest classes kept for each moment.
const NEAREST: usize = 5;

/// The moment of an episode of `other`, as seen from this clip of its drive.
pub(in crate::cmd) fn of_record(
    record: &EpisodeRecord,
    clip: &ClipId,
    rules: &[Rule],
    table: &SignalTable,
) -> UnexplainedMoment {
    let range = &record.time_range;
    let at = |t| table.times.partition_point(|x| *x < t);
    let frames = FrameRange::new(at(range.start_timestamp), at(range.end_timestamp));
    let keyframe = record.keyframe.timestamp;
    let frame = at(keyframe);
    let column = |name: &str| table.frame_columns.get(name);
    let word = |name: &str| column(name).and_then(|c| c.category(frame)).map(str::to_owned);
    let ego_actions: Vec<String> =
        ["ego.meta_longitudinal", "ego.meta_lateral"].into_iter().filter_map(word).collect();
    let of_clip = clip.frames(&record.drive_id, &table.times).unwrap_or_default();
    let since = |start: usize| table.times.get(start).map_or(0.0, |start| keyframe.seconds_since(*start));
    UnexplainedMoment {
        episode_id: record.episode_id.clone(),
        drive_id: record.drive_id.clone(),
        clip_id: clip.clone(),
        keyframe,
        keyframe_s: since(0),
        clip_s: since(of_clip.start),
        ego_speed_mps: column("ego.speed").and_then(|c| c.number(frame)),
        ego_action_names: ego_actions.iter().map(|a| Catalog::bundled().value_name(a)).collect(),
        ego_actions,
        nearest: nearest(rules, table, frames, NEAREST)
            .into_iter()
            .map(|near| class(near, |frame| table.times[frame].seconds_since(keyframe)))
            .collect(),
        undecided: undecided(rules, table, frames, NEAREST).into_iter().map(undecided_class).collect(),
    }
}

fn class(near: NearClass, offset: impl Fn(usize) -> f64) -> NearestClass {
    let unmet = near.unmet.into_iter().map(|part| UnmetPart {
        condition: part.text,
        description: part.words,
        actual_value: part.actual,
        actual_words: part.actual_words,
        unit: part.unit.to_owned(),
        is_unknown: part.is_unknown,
    });
    NearestClass {
        scenario_id: near.scenario,
        held: near.held,
        failed: near.failed,
        conditions: near.conditions,
        target_id: near.target,
        offset_s: offset(near.frame),
        unmet: unmet.collect(),
    }
}

fn undecided_class(open: UndecidedClass) -> UndecidedShown {
    UndecidedShown {
        scenario_id: open.scenario,
        held: open.held,
        conditions: open.conditions,
        target_id: open.target,
        missing_names: open.missing.iter().map(|name| Catalog::bundled().title(name)).collect(),
        missing_signals: open.missing,
    }
}
