//! Throughput, trend, finish and cost of labeling.

use super::forecast::{DaysLeft, NoForecast, days_left};
use super::input::HourlyRate;
use super::stages::StageRow;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_label::facts::{LabelStage, TaskFacts, unfinished_episodes};
use whyroad_model::Nanos;

const DAY_NS: i64 = 86_400_000_000_000;

/// Everything.
#[derive(Clone, Debug, Serialize)]
pub struct Progress {
    /// Tasks that somebody still has to label, check or choose ([`TaskFacts::is_unfinished`]).
    pub unfinished: u64,
    /// Time that people worked, h: labeling, rework, check, audit.
    pub worked_h: f64,
    /// By week (Monday, UTC), oldest first, without gaps.
    pub weeks: Vec<WeekRow>,
    /// By author, by number of accepted labels.
    pub people: Vec<PersonRow>,
    /// When the required labels will be done.
    pub finish: Finish,
    /// Cost of an accepted label; `None` when no rate was given or nothing is accepted.
    pub cost: Option<Cost>,
}

/// A week.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct WeekRow {
    /// Its Monday, `2026-11-16`.
    pub week: String,
    /// Tasks made.
    pub created: u64,
    /// Labels submitted for the first time.
    pub submitted: u64,
    /// Labels accepted.
    pub accepted: u64,
    /// Of the labels accepted in the week, those that a checker or auditor had returned.
    pub returned: u64,
    /// Mean number of fields in which they differ from their drafts; `None` without an accepted label.
    pub fields_changed: Option<f64>,
}

/// An author.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PersonRow {
    /// Display name.
    pub name: String,
    /// Submitted labels.
    pub submitted: u64,
    /// Of these, accepted.
    pub accepted: u64,
    /// Returns by checkers and auditors.
    pub returned: u64,
}

/// Basis of a finish forecast.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FinishBasis {
    /// The required numbers by leaf.
    Wanted,
    /// The episodes with an unfinished task and without an accepted label: no target is set.
    Unfinished,
}

/// Forecast of the finish.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finish {
    /// Basis of the count.
    pub basis: FinishBasis,
    /// Labels still to be accepted, one for each episode.
    pub remaining: u64,
    /// Days from `as_of`.
    pub days: Option<DaysLeft>,
    /// Why there are none.
    pub reason: Option<NoForecast>,
    /// Median day, `2027-02-01`.
    pub date: Option<String>,
    /// Earliest and latest day of the interval of 80 %.
    pub interval: Option<(String, Option<String>)>,
}

/// Cost of an accepted label.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cost {
    /// Per accepted label.
    pub per_label: f64,
    /// All work so far.
    pub total: f64,
    /// Currency.
    pub currency: String,
}

/// The last entry of all histories.
pub(super) fn last_entry(tasks: &[TaskFacts]) -> Option<Nanos> {
    tasks.iter().flat_map(|t| [Some(t.created), t.submitted, t.accepted]).flatten().max()
}

pub(super) fn of(
    tasks: &[TaskFacts],
    stages: &[StageRow],
    rate: Option<&HourlyRate>,
    as_of: Option<Nanos>,
) -> Progress {
    let worked_h = tasks.iter().map(|t| t.worked_s).sum::<f64>() / 3600.0;
    let accepted = tasks.iter().filter(|t| t.stage == LabelStage::Accepted).count();
    let unfinished = tasks.iter().filter(|t| t.is_unfinished()).count() as u64;
    let cost = rate.filter(|_| accepted > 0).map(|r| Cost {
        per_label: r.amount * worked_h / accepted as f64,
        total: r.amount * worked_h,
        currency: r.currency.clone(),
    });
    Progress {
        unfinished,
        worked_h,
        weeks: weeks(tasks, as_of),
        people: people(tasks),
        finish: finish(tasks, stages, as_of),
        cost,
    }
}

fn week_of(time: Nanos) -> i64 {
    // 1970-01-01 was a Thursday.
    (time.0.div_euclid(DAY_NS) + 3).div_euclid(7)
}

fn monday(week: i64) -> String {
    day_text(week * 7 - 3)
}

fn day_text(day: i64) -> String {
    Nanos(day * DAY_NS).to_string().chars().take(10).collect()
}

fn weeks(tasks: &[TaskFacts], as_of: Option<Nanos>) -> Vec<WeekRow> {
    let mut weeks: BTreeMap<i64, (WeekRow, u64)> = BTreeMap::new();
    for t in tasks {
        weeks.entry(week_of(t.created)).or_default().0.created += 1;
        if let Some(at) = t.submitted {
            weeks.entry(week_of(at)).or_default().0.submitted += 1;
        }
        if let Some(at) = t.accepted.filter(|_| t.stage == LabelStage::Accepted) {
            let (row, fields) = weeks.entry(week_of(at)).or_default();
            row.accepted += 1;
            row.returned += u64::from(t.returned > 0);
            *fields += t.revision.as_ref().map_or(0, |r| r.changed.len() as u64);
        }
    }
    let (Some(first), Some(last)) = (weeks.keys().next().copied(), weeks.keys().next_back().copied()) else {
        return vec![];
    };
    // At most ten years of weeks: a task with an impossible date must not fill the page.
    let last = as_of.map_or(last, |t| last.max(week_of(t)));
    (first.max(last - 520)..=last)
        .map(|week| {
            let (row, fields) = weeks.remove(&week).unwrap_or_default();
            let fields_changed = (row.accepted > 0).then(|| fields as f64 / row.accepted as f64);
            WeekRow { week: monday(week), fields_changed, ..row }
        })
        .collect()
}

fn people(tasks: &[TaskFacts]) -> Vec<PersonRow> {
    let mut by_name: BTreeMap<&str, PersonRow> = BTreeMap::new();
    for t in tasks.iter().filter(|t| t.submitted.is_some()) {
        let Some(name) = t.author.as_deref() else { continue };
        let row = by_name.entry(name).or_insert_with(|| PersonRow {
            name: name.to_owned(),
            submitted: 0,
            accepted: 0,
            returned: 0,
        });
        row.submitted += 1;
        row.accepted += u64::from(t.stage == LabelStage::Accepted);
        row.returned += u64::from(t.returned);
    }
    let mut out: Vec<PersonRow> = by_name.into_values().collect();
    out.sort_by(|a, b| b.accepted.cmp(&a.accepted).then_with(|| a.name.cmp(&b.name)));
    out
}

fn finish(tasks: &[TaskFacts], stages: &[StageRow], as_of: Option<Nanos>) -> Finish {
    let leaves = stages.iter().filter(|s| s.scenario_id.is_leaf());
    let wanted: Vec<u64> =
        leaves.filter_map(|s| Some(s.wanted?.saturating_sub(s.counts.accepted.unwrap_or(0)))).collect();
    let (basis, remaining) = if wanted.is_empty() {
        (FinishBasis::Unfinished, unfinished_episodes(tasks).len() as u64)
    } else {
        (FinishBasis::Wanted, wanted.iter().sum())
    };
    let mut out = Finish { basis, remaining, days: None, reason: None, date: None, interval: None };
    let Some(today) = as_of.map(|t| t.0.div_euclid(DAY_NS)) else {
        out.reason = Some(if remaining == 0 { NoForecast::Done } else { NoForecast::TooFewDays });
        return out;
    };
    match days_left(&daily(tasks, today), remaining) {
        Ok(days) => {
            // The first day of the forecast is today, which is not complete.
            let date = |days: usize| day_text(today + days as i64 - 1);
            out.date = Some(date(days.median));
            out.interval = Some((date(days.low), days.high.map(date)));
            out.days = Some(days);
        }
        Err(reason) => out.reason = Some(reason),
    }
    out
}

/// Accepted labels of each complete day before `today`, from the first one on; an episode counts once.
fn daily(tasks: &[TaskFacts], today: i64) -> Vec<u64> {
    let mut episodes = BTreeSet::new();
    let accepted = tasks.iter().filter(|t| t.is_accepted());
    let days: Vec<i64> = accepted
        .filter(|t| episodes.insert(&t.episode))
        .filter_map(|t| Some(t.accepted?.0.div_euclid(DAY_NS)))
        .filter(|d| *d < today)
        .collect();
    let Some(first) = days.iter().min().copied() else { return vec![] };
    let mut out = vec![0; usize::try_from(today - first).unwrap_or(0)];
    for day in days {
        if let Ok(i) = usize::try_from(day - first) {
            out[i] += 1;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weeks_begin_on_monday() {
        // 2026-11-22 is a Sunday; its week began on the 16th.
        let sunday = Nanos::parse_iso("2026-11-22T23:59:59Z").unwrap();
        assert_eq!(monday(week_of(sunday)), "2026-11-16");
        assert_eq!(monday(week_of(sunday.plus_secs(2.0))), "2026-11-23");
        assert_eq!(monday(week_of(Nanos(0))), "1969-12-29");
    }
}
