//! A small project by hand: two drives, four tasks, one release. Expected numbers are counted by hand.

use super::*;
use std::collections::BTreeMap;
use whyroad_label::facts::{Judgement, LabelStage, Revision, TaskFacts};
use whyroad_model::messages::{Coverage, CoverageState, DriveGap, LeafCoverage};
use whyroad_model::{DriveId, Lang};

const URGENT: &str = "reactive_agent.cutin.urgent";
const SLOW: &str = "reactive_agent.cutin.slow";
const LIGHT: &str = "control_traffic.traffic_light.red_light";

fn at(text: &str) -> Nanos {
    Nanos::parse_iso(text).unwrap()
}

fn id(text: &str) -> ScenarioId {
    text.parse().unwrap()
}

/// A leaf that exists, so that a renamed class fails here first.
fn leaf(framework: &Framework, text: &str) -> ScenarioId {
    assert!(framework.taxonomy.leaf(&id(text)).is_some(), "{text}");
    id(text)
}

fn third(framework: &Framework) -> ScenarioId {
    let known = [id(URGENT), id(SLOW)];
    let (l1, l2, l3) = framework.taxonomy.leaves().last().unwrap();
    let last = ScenarioId::leaf(&l1.id, &l2.id, &l3.id);
    assert!(!known.contains(&last) && last != id(LIGHT));
    last
}

fn hours_of(hour: usize, episodes: u64) -> [u64; 24] {
    std::array::from_fn(|h| if h == hour { episodes } else { 0 })
}

fn mined(framework: &Framework) -> MinedFacts {
    let drive = |seconds, place: Option<&str>| DriveFacts {
        seconds,
        place: place.map(str::to_owned),
        source: Some("car".into()),
        weather: None,
        start: Some(at("2026-01-01T08:30:00Z")),
    };
    let leaf_coverage = |scenario_id: ScenarioId, state, episodes, gaps: &[&str]| LeafCoverage {
        scenario_id,
        state,
        episodes,
        primary_episodes: episodes,
        drives_searched: 2 - gaps.len() as u64,
        gaps: if gaps.is_empty() {
            vec![]
        } else {
            let drives: Vec<DriveId> = gaps.iter().map(|d| DriveId::from(*d)).collect();
            vec![DriveGap { drives: drives.into(), missing_signals: vec!["light.state".into()] }]
        },
    };
    let mut out = MinedFacts {
        coverage: Coverage {
            taxonomy_version: framework.taxonomy.version.clone(),
            drives: vec!["a".into(), "b".into()],
            left_out: vec![],
            leaves: vec![
                leaf_coverage(leaf(framework, URGENT), CoverageState::Found, 3, &[]),
                leaf_coverage(leaf(framework, SLOW), CoverageState::NotFound, 0, &[]),
                leaf_coverage(third(framework), CoverageState::NotObservable, 0, &["a", "b"]),
            ],
            unresolved: vec![],
        },
        drives: [("a", drive(3600.0, Some("Suzhou"))), ("b", drive(1800.0, None))]
            .map(|(k, v)| (DriveId::from(k), v))
            .into(),
        ..MinedFacts::default()
    };
    out.episodes.by_class.insert(id(URGENT), [("a".into(), (4, 2)), ("b".into(), (1, 1))].into());
    out.episodes.by_hour = [("a".into(), hours_of(9, 2)), ("b".into(), hours_of(9, 1))].into();
    out
}

fn task(name: &str, episode: &str, stage: LabelStage) -> TaskFacts {
    TaskFacts {
        task: name.into(),
        episode: episode.into(),
        drive: "a".into(),
        scenario: id(URGENT),
        keyframe: at("2026-01-01T09:00:00Z"),
        stage,
        superseded: false,
        author: Some("Ada".into()),
        label: None,
        first: None,
        revision: None,
        created: at("2026-11-02T08:00:00Z"),
        submitted: None,
        accepted: None,
        returned: 0,
        worked_s: 360.0,
    }
}

/// e1 accepted as another class, e2 labeled by two people, e3 waiting, e4 rejected.
fn tasks() -> Vec<TaskFacts> {
    let judged =
        |class: &str, lateral| Judgement { scenario: Some(id(class)), lateral, ..Judgement::default() };
    let accepted = TaskFacts {
        label: Some(judged(SLOW, None)),
        revision: Some(Revision {
            changed: vec!["/scenario/l3", "/keyframe/timestamp"],
            keyframe_shift_s: Some(-0.4),
        }),
        submitted: Some(at("2026-11-03T08:00:00Z")),
        accepted: Some(at("2026-11-10T08:00:00Z")),
        returned: 1,
        ..task("t1", "e1", LabelStage::Accepted)
    };
    let twice = |name: &str, author: &str, lateral| TaskFacts {
        author: Some(author.into()),
        label: Some(judged(URGENT, lateral)),
        first: Some(judged(URGENT, lateral)),
        submitted: Some(at("2026-11-04T08:00:00Z")),
        ..task(name, "e2", LabelStage::Labelled)
    };
    vec![
        accepted,
        twice("t2", "Ada", None),
        twice("t3", "Ben", Some(whyroad_model::decision::Lateral::LaneKeeping)),
        task("t4", "e3", LabelStage::Waiting),
        task("t5", "e4", LabelStage::LeftOut),
    ]
}

fn analytics(with_tasks: bool, with_mined: bool) -> Analytics {
    let mined = mined(Framework::bundled());
    analytics_of(with_tasks, with_mined.then_some(&mined))
}

fn analytics_of(with_tasks: bool, mined: Option<&MinedFacts>) -> Analytics {
    let framework = Framework::bundled();
    let tasks = tasks();
    let wanted: BTreeMap<ScenarioId, u64> = [(id(URGENT), 5), (id(SLOW), 1)].into();
    let rate = HourlyRate { amount: 60.0, currency: "CNY".into() };
    let inputs = AnalyticsInputs {
        mined,
        tasks: with_tasks.then_some(&tasks[..]),
        releases: None,
        wanted: &wanted,
        rate: Some(&rate),
        as_of: None,
        utc_offset_h: 8,
        query: &|_, _| None,
    };
    Analytics::new(framework, &inputs)
}

fn row<'a>(a: &'a Analytics, class: &str) -> &'a StageRow {
    a.stages.iter().find(|r| r.scenario_id == id(class)).unwrap()
}

#[test]
fn stages_count_episodes_by_the_class_that_they_have_there() {
    let a = analytics(true, true);
    let (urgent, slow) = (row(&a, URGENT), row(&a, SLOW));
    // Mined and tasked as urgent; e1 was labeled slow; e2 counts once although two people label it.
    let counts = |r: &StageRow| r.counts.all().map(|c| c.1);
    assert_eq!(counts(urgent), [Some(3), Some(4), Some(1), Some(0), None]);
    assert_eq!(counts(slow), [Some(0), Some(0), Some(1), Some(1), None]);
    assert_eq!((urgent.left_out, urgent.wanted), (Some(1), Some(5)));
    let l2 = row(&a, "reactive_agent.cutin");
    assert_eq!(counts(l2), [Some(3), Some(4), Some(2), Some(1), None]);
    assert_eq!(l2.wanted, Some(6));
}

/// docs/how-to/analytics.md: an episode counts once. Labels that were imported without their episode (`label-...`), one
/// per language, are of the mined episode of their moment and class.
#[test]
fn an_imported_label_counts_with_the_episode_of_its_moment() {
    let count = |tasks: &[TaskFacts]| {
        let framework = Framework::bundled();
        let wanted = BTreeMap::new();
        let inputs = AnalyticsInputs {
            mined: None,
            tasks: Some(tasks),
            releases: None,
            wanted: &wanted,
            rate: None,
            as_of: None,
            utc_offset_h: 8,
            query: &|_, _| None,
        };
        row(&Analytics::new(framework, &inputs), URGENT).counts.tasked
    };
    let of = |name: &str, episode: &str| task(name, episode, LabelStage::Waiting);
    let elsewhere = TaskFacts { keyframe: at("2026-01-01T10:00:00Z"), ..of("t4", "label-3") };
    assert_eq!(
        count(&[of("t1", "label-1"), of("t2", "label-2"), of("t3", "e1"), elsewhere.clone()]),
        Some(2)
    );
    assert_eq!(count(&[of("t1", "label-1"), of("t2", "label-2"), elsewhere]), Some(2));
}

/// Of the leaves of the third class's L2, mining knows only the one that no drive can show.
#[test]
fn every_class_has_a_state_and_its_mark() {
    let framework = Framework::bundled();
    let a = analytics(true, true);
    let blind = ScenarioId { l3: None, ..third(framework) };
    let l2 = a.stages.iter().find(|r| r.scenario_id == blind).unwrap();
    assert_eq!((l2.state, l2.counts.mined), (Some(CoverageState::NotObservable), None));
    assert_eq!(row(&a, "reactive_agent.cutin").state, Some(CoverageState::Found));
    assert_eq!(row(&a, "reactive_agent").state, Some(CoverageState::Found));
    assert!(a.stages.iter().all(|r| r.state.is_some()));
    for lang in [Lang::Zh, Lang::En] {
        let text = render_text(&a, lang);
        let line = text.lines().find(|l| l.trim_start().starts_with(l2.name.get(lang))).unwrap();
        let mined = line.trim_start().strip_prefix(l2.name.get(lang)).unwrap().split_whitespace().next();
        assert_eq!(mined, Some("?"), "{line}");
    }
    assert!(analytics(true, false).stages.iter().all(|r| r.state.is_none()), "nothing was mined");
}

#[test]
fn what_cannot_be_seen_and_what_was_not_given_is_not_zero() {
    let framework = Framework::bundled();
    let a = analytics(true, true);
    let blind = a.stages.iter().find(|r| r.scenario_id == third(framework)).unwrap();
    assert_eq!((blind.counts.mined, blind.state), (None, Some(CoverageState::NotObservable)));
    let slow = row(&a, SLOW);
    assert_eq!((slow.counts.mined, slow.state), (Some(0), Some(CoverageState::NotFound)));
    let alone = analytics(false, true);
    assert_eq!(row(&alone, URGENT).counts.tasked, None);
    assert!(alone.progress.is_none() && alone.corrections.is_none());
    let no_mining = analytics(true, false);
    assert_eq!(row(&no_mining, URGENT).counts.mined, None);
    assert!(no_mining.unseen.is_none());
}

#[test]
fn corrections_agreement_and_cost_are_those_of_the_project() {
    let a = analytics(true, true);
    let c = a.corrections.as_ref().unwrap();
    assert_eq!((c.labels, c.unchanged, c.keyframes.moved), (1, 0, 1));
    let changed: Vec<&str> = c.fields.iter().filter(|f| f.changed > 0).map(|f| f.pointer).collect();
    assert_eq!(changed.len(), 2, "{changed:?}");
    assert_eq!(c.keyframes_by_class[0].0, id(SLOW));
    let lateral = a.agreement.iter().find(|r| r.measure == Measure::Lateral).unwrap();
    assert_eq!((lateral.pairs, lateral.same), (1, Some(0.0)));
    let p = a.progress.as_ref().unwrap();
    // Five tasks of six minutes each: half an hour at 60 an hour for one accepted label.
    assert_eq!(p.cost.as_ref().map(|c| (c.per_label, c.currency.as_str())), Some((30.0, "CNY")));
    assert_eq!(p.unfinished, 3);
    let weeks: Vec<(&str, u64, u64, u64)> =
        p.weeks.iter().map(|w| (w.week.as_str(), w.created, w.submitted, w.accepted)).collect();
    assert_eq!(weeks, [("2026-11-02", 5, 3, 0), ("2026-11-09", 0, 0, 1)]);
    // 5 + 1 are required, one is accepted; one day of history is not enough for a forecast.
    assert_eq!((p.finish.remaining, p.finish.reason), (5, Some(forecast::NoForecast::TooFewDays)));
}

/// docs/reference/analytics.md: an episode that several people label counts once, and labels that were overruled in
/// adjudication do not count. e1: accepted, with two overruled labels; e2: three copies on the way; e3: one task; e4:
/// left out; e5: accepted, and a copy that was added later. By hand: 3 + 1 + 1 tasks, 2 episodes.
#[test]
fn what_is_unfinished_are_neither_overruled_labels_nor_copies() {
    let overruled = |name: &str| TaskFacts { superseded: true, ..task(name, "e1", LabelStage::Labelled) };
    let accepted = |name: &str, episode: &str| TaskFacts {
        accepted: Some(at("2026-11-10T08:00:00Z")),
        ..task(name, episode, LabelStage::Accepted)
    };
    let tasks = [
        accepted("t1", "e1"),
        overruled("t2"),
        overruled("t3"),
        task("t4", "e2", LabelStage::Labelled),
        task("t5", "e2", LabelStage::Waiting),
        task("t6", "e2", LabelStage::Labelled),
        task("t7", "e3", LabelStage::Waiting),
        task("t8", "e4", LabelStage::LeftOut),
        accepted("t9", "e5"),
        task("t10", "e5", LabelStage::Waiting),
    ];
    let framework = Framework::bundled();
    let of = |tasks: &[TaskFacts], wanted: &BTreeMap<ScenarioId, u64>| {
        let inputs = AnalyticsInputs {
            mined: None,
            tasks: Some(tasks),
            releases: None,
            wanted,
            rate: None,
            as_of: None,
            utc_offset_h: 0,
            query: &|_, _| None,
        };
        Analytics::new(framework, &inputs)
    };
    let a = of(&tasks, &BTreeMap::new());
    let p = a.progress.as_ref().unwrap();
    assert_eq!((p.unfinished, p.finish.basis, p.finish.remaining), (5, FinishBasis::Unfinished, 2));
    let wanted = [(id(URGENT), 9)].into();
    let a = of(&tasks, &wanted);
    assert_eq!(a.progress.as_ref().unwrap().finish.remaining, 7, "against the target");
    let urgent = a.shortfalls.iter().find(|s| s.scenario_id == id(URGENT)).unwrap();
    assert_eq!(urgent.in_progress, Some(2));
    // With the choice made and accepted, nothing is left.
    let done = of(&tasks[..3], &BTreeMap::new());
    let p = done.progress.unwrap();
    assert_eq!((p.unfinished, p.finish.reason), (0, Some(forecast::NoForecast::Done)));
}

#[test]
fn two_imported_labels_of_one_moment_are_one_label_to_finish() {
    // DATA_FORMAT.md 4: a label is about a keyframe. Two files with a label of the same one need one accepted label.
    let later =
        TaskFacts { keyframe: at("2026-01-01T10:00:00Z"), ..task("t3", "label-3", LabelStage::Waiting) };
    let tasks =
        [task("t1", "label-1", LabelStage::Labelled), task("t2", "label-2", LabelStage::Waiting), later];
    let inputs = AnalyticsInputs {
        mined: None,
        tasks: Some(&tasks),
        releases: None,
        wanted: &BTreeMap::new(),
        rate: None,
        as_of: None,
        utc_offset_h: 0,
        query: &|_, _| None,
    };
    let a = Analytics::new(Framework::bundled(), &inputs);
    let p = a.progress.unwrap();
    assert_eq!((p.unfinished, p.finish.basis, p.finish.remaining), (3, FinishBasis::Unfinished, 2));
}

#[test]
fn contexts_keep_what_is_not_stated() {
    let a = analytics(true, true);
    let place = |value: Option<&str>| {
        a.contexts.iter().find(|r| r.dimension == Dimension::Place && r.value.as_deref() == value).unwrap()
    };
    assert_eq!((place(Some("Suzhou")).hours, place(Some("Suzhou")).mined), (Some(1.0), Some(2)));
    assert_eq!((place(None).hours, place(None).mined), (Some(0.5), Some(1)));
    assert_eq!(place(Some("Suzhou")).accepted, Some(1));
    // 08:30 to 09:30 and 08:30 to 09:00, UTC: an hour at 16, half an hour at 17 in UTC+8.
    let hours: Vec<(&str, f64)> = a
        .contexts
        .iter()
        .filter(|r| r.dimension == Dimension::Hour)
        .map(|r| (r.value.as_deref().unwrap(), r.hours.unwrap()))
        .collect();
    assert_eq!(hours, [("16", 1.0), ("17", 0.5)]);
}

#[test]
fn drives_without_a_date_have_no_hour_of_the_day() {
    let mut mined = mined(Framework::bundled());
    mined.drives.values_mut().for_each(|d| d.start = None);
    let a = analytics_of(true, Some(&mined));
    let hours: Vec<_> = a
        .contexts
        .iter()
        .filter(|r| r.dimension == Dimension::Hour)
        .map(|r| (r.value.as_deref(), r.hours, r.mined, r.accepted))
        .collect();
    assert_eq!(hours, [(None, Some(1.5), Some(3), Some(1))]);
}

/// Labels of drives that the mined folder does not have, or without a mined folder: whether their times are dates is
/// unknown.
#[test]
fn drives_that_were_not_searched_have_no_known_hour_of_the_day() {
    let accepted = |a: &Analytics| -> Vec<(Option<String>, Option<u64>)> {
        let hours = a.contexts.iter().filter(|r| r.dimension == Dimension::Hour);
        hours.filter(|r| r.accepted.is_some_and(|n| n > 0)).map(|r| (r.value.clone(), r.accepted)).collect()
    };
    let framework = Framework::bundled();
    // The label of `a` is at 09:00 UTC, 17:00 in UTC+8.
    assert_eq!(accepted(&analytics(true, true)), [(Some("17".into()), Some(1))]);
    let mut other = mined(framework);
    other.drives.remove(&DriveId::from("a"));
    assert_eq!(accepted(&analytics_of(true, Some(&other))), [(None, Some(1))]);
    assert_eq!(accepted(&analytics(true, false)), [(None, Some(1))]);
}

#[test]
fn shortfalls_say_what_to_do() {
    let a = analytics(true, true);
    let of = |class: &ScenarioId| a.shortfalls.iter().find(|s| s.scenario_id == *class);
    // Urgent: 5 required, none accepted, e2 and e3 on the way, nothing mined is without a task: 3 to mine.
    let urgent = of(&id(URGENT)).unwrap();
    assert_eq!(
        (urgent.step, urgent.in_progress, urgent.missing),
        (ShortfallStep::MineMore, Some(2), Some(3))
    );
    // The rate is 3 in 1.5 h.
    assert_eq!(urgent.hours, Some(1.5));
    assert!(of(&id(SLOW)).is_none(), "its one label is there");
    let framework = Framework::bundled();
    assert_eq!(of(&third(framework)).unwrap().step, ShortfallStep::OtherDrives);
}

/// docs/reference/analytics.md: without a target, a leaf has a shortfall when it was never found. One with a secondary
/// episode was found, and so was one with a label or a task; the same leaf without any of them was not.
#[test]
fn what_was_found_beside_another_class_is_no_shortfall() {
    let framework = Framework::bundled();
    let short = |mined: &MinedFacts, tasks: &[TaskFacts]| {
        let wanted = BTreeMap::new();
        let inputs = AnalyticsInputs {
            mined: Some(mined),
            tasks: Some(tasks),
            releases: None,
            wanted: &wanted,
            rate: None,
            as_of: None,
            utc_offset_h: 0,
            query: &|_, _| None,
        };
        Analytics::new(framework, &inputs).shortfalls.iter().any(|s| s.scenario_id == id(SLOW))
    };
    let nothing = mined(framework);
    assert!(short(&nothing, &[]));
    let mut secondary = mined(framework);
    secondary.coverage.leaves[1].state = CoverageState::Found;
    secondary.coverage.leaves[1].episodes = 1;
    secondary.episodes.by_class.insert(id(SLOW), [("a".into(), (1, 0))].into());
    assert!(!short(&secondary, &[]));
    let waiting = TaskFacts { scenario: id(SLOW), ..task("t1", "e1", LabelStage::Waiting) };
    assert!(!short(&nothing, std::slice::from_ref(&waiting)));
    let left_out = TaskFacts { stage: LabelStage::LeftOut, ..waiting };
    assert!(short(&nothing, &[left_out]), "people said that it is not one");
}

#[test]
fn the_unseen_is_counted_over_observable_leaves_only() {
    let a = analytics(true, true);
    let u = a.unseen.as_ref().unwrap();
    assert_eq!((u.hours, u.drives, u.observable, u.found), (1.5, 2, 2, 1));
    // One leaf, in two drives: f2 = 1, n = 2, nothing alone.
    assert_eq!(u.mass.map(|m| m.value), Some(0.0));
    assert_eq!(u.new_leaves, None, "100 h are beyond what 1.5 h can say");
}

/// The rate of a leaf is that of the drives that were searched for it: `a` (1 h), not `b`, which lacks a signal.
#[test]
fn the_outlook_counts_only_drives_that_were_searched() {
    let framework = Framework::bundled();
    let mut mined = mined(framework);
    let slow = &mut mined.coverage.leaves[1];
    slow.gaps = vec![DriveGap {
        drives: vec![DriveId::from("b")].into(),
        missing_signals: vec!["light.state".into()],
    }];
    slow.drives_searched = 1;
    let of = |mined: &MinedFacts, class: &str| -> (u64, usize, f64, Option<f64>) {
        let a = analytics_of(false, Some(mined));
        let leaves = a.unseen.unwrap().leaves;
        let leaf = leaves.into_iter().find(|l| l.scenario_id == id(class)).unwrap();
        (leaf.episodes, leaf.drives, leaf.hours, leaf.coming.map(|e| e.value))
    };
    assert_eq!(of(&mined, SLOW), (0, 1, 1.0, Some(0.0)));
    assert_eq!(of(&mined, URGENT), (3, 2, 1.5, Some(200.0)));
    // An alternative of the rule found two in `b`; then in both; then no drive has all signals.
    mined.coverage.leaves[1].state = CoverageState::Found;
    mined.coverage.leaves[1].episodes = 3;
    mined.episodes.by_class.insert(id(SLOW), [("b".into(), (2, 2))].into());
    assert_eq!(of(&mined, SLOW), (0, 1, 1.0, Some(0.0)));
    mined.episodes.by_class.insert(id(SLOW), [("a".into(), (1, 1)), ("b".into(), (2, 2))].into());
    assert_eq!(of(&mined, SLOW), (1, 1, 1.0, Some(100.0)));
    mined.coverage.leaves[1].drives_searched = 0;
    mined.coverage.leaves[1].gaps[0].drives = vec![DriveId::from("a"), DriveId::from("b")].into();
    assert_eq!(of(&mined, SLOW), (0, 0, 0.0, None));
}

#[test]
fn the_page_shows_unknown_and_not_observable_by_their_marks() {
    let page = page::fragment(&analytics(false, true)).into_string();
    assert!(page.contains("Not given: ") && page.contains(">…<"), "unknown is marked");
    assert!(page.contains(">?</td>"), "not observable is marked");
    let whole = page::fragment(&analytics(true, true)).into_string();
    assert!(whole.contains("30</b>") || whole.contains("<b>30 CNY</b>"), "the cost is shown");
    assert_eq!(whole.matches("<svg").count(), whole.matches("</svg>").count());
    assert_eq!(whole.matches("lang=\"zh\"").count(), whole.matches("lang=\"en\"").count());
}

/// Two drives of 5 s are 0.0028 h together; 3 episodes in them make 3 more in another 0.0028 h.
#[test]
fn a_short_drive_is_not_shown_as_no_hours() {
    let mut mined = mined(Framework::bundled());
    mined.drives.values_mut().for_each(|d| d.seconds = 5.0);
    let page = page::fragment(&analytics_of(true, Some(&mined))).into_string();
    // Two places, an hour, a weather, a source, and the two observable leaves.
    assert_eq!(page.matches("<td class=\"n\">&lt; 0.01</td>").count(), 7, "{page}");
    assert!(page.contains("<td class=\"n\">&lt; 0.1 h</td>"));
}

#[test]
fn text_and_tables_have_the_same_numbers() {
    let a = analytics(true, true);
    let text = render_text(&a, Lang::En);
    assert!(text.contains("cost per accepted label: 30 CNY"), "{text}");
    assert!(render_text(&a, Lang::Zh).contains("每个已接受标注的成本：30 CNY"));
    let sheets = tables(&a);
    let stages = sheets.iter().find(|s| s.name == "stages").unwrap().csv();
    assert!(stages.lines().any(|l| l.starts_with(URGENT) && l.ends_with(",3,2,4,1,0,,1,5")), "{stages}");
    let names: std::collections::BTreeSet<_> = sheets.iter().map(|s| s.name).collect();
    assert_eq!(names.len(), sheets.len());
    for sheet in &sheets {
        assert!(sheet.columns.iter().all(|c| c.values.len() == sheet.rows()), "{}", sheet.name);
    }
}
