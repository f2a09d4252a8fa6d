//! Context of the data: hours driven, episodes, labels and samples by place, hour of the day, weather and source.
//! Values that a drive does not state have their own row and are never left out.

use super::input::{AnalyticsInputs, DriveFacts, MinedFacts, hour};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_label::facts::LabelStage;
use whyroad_model::DriveId;

/// Dimension of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Dimension {
    /// City or road network.
    Place,
    /// Hour of the day, `00` to `23`.
    Hour,
    /// Stated weather.
    Weather,
    /// Vehicle or fleet.
    Source,
}

impl Dimension {
    /// All, in the order of the page.
    pub const ALL: [Self; 4] = [Self::Place, Self::Hour, Self::Weather, Self::Source];

    /// Its id.
    pub fn id(self) -> &'static str {
        match self {
            Self::Place => "place",
            Self::Hour => "hour",
            Self::Weather => "weather",
            Self::Source => "source",
        }
    }
}

/// One value of a dimension. Counts are `None` where their input was not given or does not state the value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContextRow {
    /// Which dimension.
    pub dimension: Dimension,
    /// The value; `None` where drives state none.
    pub value: Option<String>,
    /// Hours driven.
    pub hours: Option<f64>,
    /// Primary episodes.
    pub mined: Option<u64>,
    /// Accepted labels.
    pub accepted: Option<u64>,
    /// Samples of releases.
    pub released: Option<u64>,
}

type Key = (Dimension, Option<String>);

pub(super) fn rows(inputs: &AnalyticsInputs<'_>) -> Vec<ContextRow> {
    let shift = inputs.utc_offset_h;
    let mut hours: BTreeMap<Key, f64> = BTreeMap::new();
    let mut mined: BTreeMap<Key, u64> = BTreeMap::new();
    let mut accepted: BTreeMap<Key, u64> = BTreeMap::new();
    let mut released: BTreeMap<Key, u64> = BTreeMap::new();
    if let Some(facts) = inputs.mined {
        for drive in facts.drives.values() {
            for (dimension, value) in stated(Some(drive)) {
                *hours.entry((dimension, value)).or_default() += drive.seconds / 3600.0;
            }
            driven(drive, shift, &mut hours);
        }
        for (drive, n) in facts.episodes.by_class.values().flatten() {
            for key in stated(facts.drives.get(drive)) {
                *mined.entry(key).or_default() += n.1;
            }
        }
        for (drive, by_hour) in &facts.episodes.by_hour {
            let dated = is_dated(facts, drive);
            for (h, n) in by_hour.iter().enumerate().filter(|(_, n)| **n > 0) {
                *mined.entry((Dimension::Hour, dated.then(|| shifted(h, shift)))).or_default() += n;
            }
        }
    }
    let mut episodes = BTreeSet::new();
    for t in inputs.tasks.unwrap_or_default() {
        if t.stage != LabelStage::Accepted || t.superseded || !episodes.insert(&t.episode) {
            continue;
        }
        // Without the mined folder the location of a drive is unknown.
        if let Some(facts) = inputs.mined {
            for key in stated(facts.drives.get(&t.drive)) {
                *accepted.entry(key).or_default() += 1;
            }
        }
        let at = t.label.as_ref().and_then(|l| l.keyframe).unwrap_or(t.keyframe);
        let dated = inputs.mined.is_some_and(|facts| is_dated(facts, &t.drive));
        *accepted.entry((Dimension::Hour, dated.then(|| shifted(hour(at), shift)))).or_default() += 1;
    }
    let mut samples = BTreeSet::new();
    for s in inputs.releases.unwrap_or_default().iter().flat_map(|r| &r.samples) {
        if !samples.insert(s.sample.as_str()) {
            continue;
        }
        let at = s.judgement.keyframe.filter(|_| s.dated).map(|t| shifted(hour(t), shift));
        let values = [
            (Dimension::Place, s.place.clone()),
            (Dimension::Hour, at),
            (Dimension::Weather, s.weather.clone()),
            (Dimension::Source, s.source.clone()),
        ];
        for key in values {
            *released.entry(key).or_default() += 1;
        }
    }
    let tasks_located =
        |d: Dimension| inputs.tasks.is_some() && (inputs.mined.is_some() || d == Dimension::Hour);
    let keys: BTreeSet<&Key> =
        hours.keys().chain(mined.keys()).chain(accepted.keys()).chain(released.keys()).collect();
    let count =
        |of: &BTreeMap<Key, u64>, key: &Key, given: bool| given.then(|| of.get(key).copied().unwrap_or(0));
    let mut out: Vec<ContextRow> = keys
        .into_iter()
        .map(|key| ContextRow {
            dimension: key.0,
            value: key.1.clone(),
            hours: inputs.mined.map(|_| hours.get(key).copied().unwrap_or(0.0)),
            mined: count(&mined, key, inputs.mined.is_some()),
            accepted: count(&accepted, key, tasks_located(key.0)),
            released: count(&released, key, inputs.releases.is_some()),
        })
        .collect();
    // Hours of the day by the clock, everything else by its size; unstated values last.
    out.sort_by(|a, b| {
        let size = |r: &ContextRow| r.hours.unwrap_or(0.0).max(r.released.unwrap_or(0) as f64);
        let by_size = || size(b).total_cmp(&size(a));
        let order = if a.dimension == Dimension::Hour { std::cmp::Ordering::Equal } else { by_size() };
        (a.dimension, a.value.is_none())
            .cmp(&(b.dimension, b.value.is_none()))
            .then(order)
            .then_with(|| a.value.cmp(&b.value))
    });
    out
}

/// Whether the times of a drive are known to be dates; of a drive that was not searched it is unknown.
fn is_dated(facts: &MinedFacts, drive: &DriveId) -> bool {
    facts.drives.get(drive).is_some_and(|d| d.start.is_some())
}

fn stated(drive: Option<&DriveFacts>) -> [Key; 3] {
    let of = |value: fn(&DriveFacts) -> &Option<String>| drive.and_then(|d| value(d).clone());
    [
        (Dimension::Place, of(|d| &d.place)),
        (Dimension::Weather, of(|d| &d.weather)),
        (Dimension::Source, of(|d| &d.source)),
    ]
}

/// Adds the hours of the day that a drive covers.
fn driven(drive: &DriveFacts, shift: i8, hours: &mut BTreeMap<Key, f64>) {
    let Some(start) = drive.start else {
        *hours.entry((Dimension::Hour, None)).or_default() += drive.seconds / 3600.0;
        return;
    };
    let (mut at, mut left) = (start, drive.seconds.clamp(0.0, 366.0 * 86_400.0));
    while left > 1e-9 {
        let into = (at.0.rem_euclid(3_600_000_000_000)) as f64 / 1e9;
        let part = left.min(3600.0 - into).max(1e-3);
        *hours.entry((Dimension::Hour, Some(shifted(hour(at), shift)))).or_default() += part / 3600.0;
        at = at.plus_secs(part);
        left -= part;
    }
}

/// The hour on a clock that is `shift` hours ahead of UTC.
fn shifted(hour: usize, shift: i8) -> String {
    format!("{:02}", (hour as i64 + i64::from(shift)).rem_euclid(24))
}
