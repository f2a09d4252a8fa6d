//! The numbers as tables for other programs: CSV and Parquet with the same rows. `docs/reference/analytics.md`
//! lists the columns; a test compares it with these.

use super::{Analytics, StageCounts};
use whyroad_lake::sheet::{Sheet, SheetColumn, SheetValues};

/// A table that is being filled column by column from its rows.
struct Filler<'r, R> {
    rows: &'r [R],
    columns: Vec<SheetColumn>,
}

impl<'r, R> Filler<'r, R> {
    fn of(rows: &'r [R]) -> Self {
        Self { rows, columns: vec![] }
    }

    fn texts(self, name: &'static str, of: impl Fn(&R) -> Option<String>) -> Self {
        let values = SheetValues::Texts(self.rows.iter().map(of).collect());
        self.with(name, values)
    }

    fn text(self, name: &'static str, of: impl Fn(&R) -> String) -> Self {
        self.texts(name, |r| Some(of(r)))
    }

    fn count(self, name: &'static str, of: impl Fn(&R) -> Option<u64>) -> Self {
        let number = |n: u64| i64::try_from(n).unwrap_or(i64::MAX);
        let values = SheetValues::Integers(self.rows.iter().map(|r| of(r).map(number)).collect());
        self.with(name, values)
    }

    fn number(self, name: &'static str, of: impl Fn(&R) -> Option<f64>) -> Self {
        let values = SheetValues::Numbers(self.rows.iter().map(of).collect());
        self.with(name, values)
    }

    fn with(mut self, name: &'static str, values: SheetValues) -> Self {
        self.columns.push(SheetColumn { name, values });
        self
    }

    fn sheet(self, name: &'static str) -> Sheet {
        Sheet { name, columns: self.columns }
    }
}

/// All tables, those without rows included.
pub fn tables(a: &Analytics) -> Vec<Sheet> {
    let level = |id: &whyroad_model::ScenarioId| match (&id.l2, &id.l3) {
        (None, _) => "l1",
        (Some(_), None) => "l2",
        _ => "l3",
    };
    let stage = |name: &'static str, of: fn(&StageCounts) -> Option<u64>| (name, of);
    let mut stages = Filler::of(&a.stages)
        .text("scenario_id", |r| r.scenario_id.to_string())
        .text("level", |r| level(&r.scenario_id).to_owned())
        .text("name_zh", |r| r.name.zh.clone())
        .text("name_en", |r| r.name.en.clone())
        .texts("state", |r| r.state.map(|s| s.id().to_owned()));
    stages = stages.count("mined", |r| r.counts.mined).count("secondary", |r| r.secondary);
    for (name, of) in [
        stage("tasked", |c| c.tasked),
        stage("labelled", |c| c.labelled),
        stage("accepted", |c| c.accepted),
        stage("released", |c| c.released),
    ] {
        stages = stages.count(name, |r| of(&r.counts));
    }
    let stages = stages.count("left_out", |r| r.left_out).count("wanted", |r| r.wanted).sheet("stages");
    let decisions = Filler::of(&a.decisions.rows)
        .text("scenario_id", |r| r.scenario_id.to_string())
        .text("channel", |r| r.channel.id().to_owned())
        .texts("decision", |r| r.decision.clone())
        .text("name_zh", |r| r.name.zh.clone())
        .text("name_en", |r| r.name.en.clone())
        .count("labels", |r| Some(r.count))
        .sheet("decisions");
    let contexts = Filler::of(&a.contexts)
        .text("dimension", |r| r.dimension.id().to_owned())
        .texts("value", |r| r.value.clone())
        .number("hours", |r| r.hours)
        .count("mined", |r| r.mined)
        .count("accepted", |r| r.accepted)
        .count("released", |r| r.released)
        .sheet("contexts");
    let none = (vec![], vec![]);
    let (fields, keyframes) =
        a.corrections.as_ref().map_or(none, |c| (c.fields.clone(), c.keyframes_by_class.clone()));
    let labels = a.corrections.as_ref().map(|c| c.labels);
    let corrections = Filler::of(&fields)
        .text("field", |r| r.pointer.to_owned())
        .text("name_zh", |r| r.name.zh.clone())
        .text("name_en", |r| r.name.en.clone())
        .count("changed", |r| Some(r.changed))
        .count("labels", |_| labels)
        .sheet("corrections");
    let keyframes = Filler::of(&keyframes)
        .text("scenario_id", |r| r.0.to_string())
        .count("labels", |r| Some(r.1.labels))
        .count("moved", |r| Some(r.1.moved))
        .number("median_s", |r| r.1.median_s)
        .number("median_distance_s", |r| r.1.median_distance_s)
        .number("worst_s", |r| r.1.worst_s)
        .sheet("keyframes");
    let agreement = Filler::of(&a.agreement)
        .text("measure", |r| r.measure.id().to_owned())
        .count("episodes", |r| Some(r.episodes))
        .count("pairs", |r| Some(r.pairs))
        .number("same", |r| r.same)
        .number("cohen", |r| r.cohen)
        .number("fleiss", |r| r.fleiss)
        .number("median_s", |r| r.median_s)
        .sheet("agreement");
    let (weeks, people) =
        a.progress.as_ref().map_or((vec![], vec![]), |p| (p.weeks.clone(), p.people.clone()));
    let weeks = Filler::of(&weeks)
        .text("week", |r| r.week.clone())
        .count("created", |r| Some(r.created))
        .count("submitted", |r| Some(r.submitted))
        .count("accepted", |r| Some(r.accepted))
        .count("returned", |r| Some(r.returned))
        .number("fields_changed", |r| r.fields_changed)
        .sheet("weeks");
    let people = Filler::of(&people)
        .text("name", |r| r.name.clone())
        .count("submitted", |r| Some(r.submitted))
        .count("accepted", |r| Some(r.accepted))
        .count("returned", |r| Some(r.returned))
        .sheet("people");
    let outlook = a.unseen.as_ref().map_or(vec![], |u| u.leaves.clone());
    let outlook = Filler::of(&outlook)
        .text("scenario_id", |r| r.scenario_id.to_string())
        .count("episodes", |r| Some(r.episodes))
        .count("drives", |r| Some(r.drives as u64))
        .number("hours", |r| Some(r.hours))
        .number("dispersion", |r| Some(r.dispersion))
        .number("coming", |r| r.coming.map(|e| e.value))
        .number("coming_low", |r| r.coming.map(|e| e.low))
        .number("coming_high", |r| r.coming.map(|e| e.high))
        .sheet("outlook");
    let shortfalls = Filler::of(&a.shortfalls)
        .text("scenario_id", |r| r.scenario_id.to_string())
        .text("name_zh", |r| r.name.zh.clone())
        .text("name_en", |r| r.name.en.clone())
        .count("wanted", |r| r.wanted)
        .count("accepted", |r| r.accepted)
        .count("in_progress", |r| r.in_progress)
        .count("untasked", |r| r.untasked)
        .count("missing", |r| r.missing)
        .number("hours", |r| r.hours)
        .text("step", |r| r.step.id().to_owned())
        .texts("query", |r| r.query.as_ref().map(|_| format!("queries/{}.json", r.scenario_id)))
        .sheet("shortfalls");
    vec![
        stages,
        decisions,
        contexts,
        corrections,
        keyframes,
        agreement,
        weeks,
        people,
        outlook,
        shortfalls,
        summary(a),
    ]
}

/// Single numbers by name, with their intervals.
fn summary(a: &Analytics) -> Sheet {
    type Row = (&'static str, Option<f64>, Option<f64>, Option<f64>, Option<String>);
    let mut rows: Vec<Row> = Vec::new();
    if let Some(u) = &a.unseen {
        let estimate = |name, e: Option<super::unseen::Estimate>| -> Row {
            (name, e.map(|e| e.value), e.map(|e| e.low), e.map(|e| e.high), None)
        };
        rows.push(("hours_searched", Some(u.hours), None, None, None));
        rows.push(("leaves_observable", Some(u.observable as f64), None, None, None));
        rows.push(("leaves_found", Some(u.found as f64), None, None, None));
        rows.push(estimate("unseen_mass", u.mass));
        rows.push(estimate("new_leaves_in_100_h", u.new_leaves));
    }
    if let Some(p) = &a.progress {
        rows.push(("tasks_unfinished", Some(p.unfinished as f64), None, None, None));
        rows.push(("labels_remaining", Some(p.finish.remaining as f64), None, None, None));
        rows.push(("worked_h", Some(p.worked_h), None, None, None));
        let days = p.finish.days;
        rows.push((
            "days_to_finish",
            days.map(|d| d.median as f64),
            days.map(|d| d.low as f64),
            days.and_then(|d| d.high).map(|d| d as f64),
            p.finish.date.clone(),
        ));
        rows.push((
            "cost_per_accepted_label",
            p.cost.as_ref().map(|c| c.per_label),
            None,
            None,
            p.cost.as_ref().map(|c| c.currency.clone()),
        ));
    }
    Filler::of(&rows)
        .text("name", |r| r.0.to_owned())
        .number("value", |r| r.1)
        .number("low", |r| r.2)
        .number("high", |r| r.3)
        .texts("note", |r| r.4.clone())
        .sheet("summary")
}
