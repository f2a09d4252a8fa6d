//! Changes that people make to drafts until the label is accepted: by field of the label, and the shifts of keyframes.

use serde::Serialize;
use std::collections::BTreeMap;
use whyroad_label::agreement::median;
use whyroad_label::facts::{LabelStage, Revision, TaskFacts};
use whyroad_model::label_fields::LABEL_FIELDS;
use whyroad_model::{Bilingual, ScenarioId};

/// Maximum difference of keyframes that count as not moved, s: half a frame at 10 Hz.
const MOVED_S: f64 = 0.05;
/// Upper ends of the classes of keyframe shifts, s; there is one more class below the first and one above the last.
pub(super) const SHIFTS_S: [f64; 8] = [-2.0, -1.0, -0.5, -MOVED_S, MOVED_S, 0.5, 1.0, 2.0];

/// Everything.
#[derive(Clone, Debug, Serialize)]
pub struct Corrections {
    /// Accepted labels that were compared with their drafts.
    pub labels: u64,
    /// Of these, unchanged labels.
    pub unchanged: u64,
    /// By field, the most changed first.
    pub fields: Vec<FieldCorrections>,
    /// Keyframes of all classes.
    pub keyframes: KeyframeShifts,
    /// Keyframes by class of the label.
    pub keyframes_by_class: Vec<(ScenarioId, KeyframeShifts)>,
}

/// How often a field was changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldCorrections {
    /// JSON pointer.
    pub pointer: &'static str,
    /// Its name.
    pub name: Bilingual,
    /// Labels in which it differs from the draft.
    pub changed: u64,
}

/// Shifts of keyframes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct KeyframeShifts {
    /// Labels and drafts with a keyframe.
    pub labels: u64,
    /// Moved by more than half a frame.
    pub moved: u64,
    /// Median of label minus draft, s.
    pub median_s: Option<f64>,
    /// Median of the distance, s.
    pub median_distance_s: Option<f64>,
    /// Greatest distance, s.
    pub worst_s: Option<f64>,
    /// Labels by shift; classes end at -2, -1, -0.5, -0.05, 0.05, 0.5, 1, 2 s and infinity.
    pub histogram: [u64; 9],
}

impl KeyframeShifts {
    fn of(shifts: &[f64]) -> Self {
        let distances: Vec<f64> = shifts.iter().map(|s| s.abs()).collect();
        let mut histogram = [0; 9];
        for s in shifts {
            let class = SHIFTS_S.iter().position(|end| *s < *end || (*end == MOVED_S && *s <= MOVED_S));
            histogram[class.unwrap_or(SHIFTS_S.len())] += 1;
        }
        Self {
            labels: shifts.len() as u64,
            moved: distances.iter().filter(|d| **d > MOVED_S).count() as u64,
            median_s: median(shifts.to_vec()),
            worst_s: distances.iter().copied().reduce(f64::max),
            median_distance_s: median(distances),
            histogram,
        }
    }
}

pub(super) fn of(tasks: &[TaskFacts]) -> Corrections {
    let accepted = tasks.iter().filter(|t| t.stage == LabelStage::Accepted && !t.superseded);
    let compared: Vec<(&TaskFacts, &Revision)> =
        accepted.filter_map(|t| Some((t, t.revision.as_ref()?))).collect();
    let mut counts: BTreeMap<&str, u64> = BTreeMap::new();
    let mut shifts: Vec<f64> = Vec::new();
    let mut by_class: BTreeMap<&ScenarioId, Vec<f64>> = BTreeMap::new();
    for (t, revision) in &compared {
        for pointer in &revision.changed {
            *counts.entry(pointer).or_default() += 1;
        }
        if let Some(shift) = revision.keyframe_shift_s {
            shifts.push(shift);
            let class = t.label.as_ref().and_then(|l| l.scenario.as_ref()).unwrap_or(&t.scenario);
            by_class.entry(class).or_default().push(shift);
        }
    }
    let mut fields: Vec<FieldCorrections> = Revision::fields()
        .filter_map(|f| {
            let changed = counts.get(f.pointer).copied().unwrap_or(0);
            Some(FieldCorrections { pointer: f.pointer, name: field_name(f.pointer)?, changed })
        })
        .collect();
    fields.sort_by_key(|f| std::cmp::Reverse(f.changed));
    Corrections {
        labels: compared.len() as u64,
        unchanged: compared.iter().filter(|(_, r)| r.changed.is_empty()).count() as u64,
        fields,
        keyframes: KeyframeShifts::of(&shifts),
        keyframes_by_class: by_class
            .into_iter()
            .map(|(class, shifts)| (class.clone(), KeyframeShifts::of(&shifts)))
            .collect(),
    }
}

/// Name of a field with those of the fields that it lies in; `None` for fields that the page does not show, whose
/// content follows from others.
fn field_name(pointer: &str) -> Option<Bilingual> {
    let part = |p: &str| LABEL_FIELDS.iter().find(|f| f.pointer == p).and_then(|f| f.names);
    let own = match pointer {
        "/scenario/l1" => ("L1", "L1"),
        "/scenario/l2" => ("L2", "L2"),
        "/scenario/l3" => ("L3", "L3"),
        "/keyframe/type" => ("类型", "type"),
        _ => part(pointer)?,
    };
    let (mut zh, mut en) = (own.0.to_owned(), own.1.to_owned());
    let mut above = pointer;
    while let Some((outer, _)) = above.rsplit_once('/').filter(|(o, _)| !o.is_empty()) {
        if let Some((outer_zh, outer_en)) = part(outer) {
            (zh, en) = (format!("{outer_zh} · {zh}"), format!("{outer_en} · {en}"));
        }
        above = outer;
    }
    Some(Bilingual::new(zh, en))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifts_fall_into_their_classes() {
        let shifts = KeyframeShifts::of(&[-3.0, -0.3, -0.05, 0.0, 0.05, 0.2, 5.0]);
        assert_eq!(shifts.histogram, [1, 0, 0, 1, 3, 1, 0, 0, 1]);
        assert_eq!((shifts.labels, shifts.moved), (7, 4));
        assert_eq!((shifts.median_s, shifts.worst_s), (Some(0.0), Some(5.0)));
        assert_eq!(KeyframeShifts::of(&[]).median_s, None);
    }

    #[test]
    fn fields_have_names_for_people() {
        let names: Vec<String> =
            Revision::fields().filter_map(|f| field_name(f.pointer)).map(|n| n.en).collect();
        assert!(names.iter().any(|n| n == "Decision · longitudinal"), "{names:?}");
        assert!(names.iter().any(|n| n == "Scenario · L3"), "{names:?}");
        assert!(!names.iter().any(|n| n.contains('/')), "{names:?}");
    }
}
