//! The taxonomy and its labeling specs, arranged for quick questions about one label, and suggestions for wrong ids.

use crate::decision_table::ClassDecisions;
use crate::taxonomy::did_you_mean;
use crate::{Framework, ResolvedSpec};
use std::collections::HashMap;
use whyroad_model::decision::Lateral;
use whyroad_model::messages::KeyframeType;
use whyroad_model::{Bilingual, ScenarioId};

pub use whyroad_model::ids::OTHER;

/// Requirements of a class for its labels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prescribed {
    /// The displayed name of the class.
    pub title: Bilingual,
    /// Type of the keyframe.
    pub kind: Option<KeyframeType>,
    /// At least one component has high uncertainty.
    pub uncertainty_high: bool,
    /// The lateral decision.
    pub lateral: Option<Lateral>,
    /// Id, displayed name, unit.
    pub records: Vec<(String, Bilingual, Option<String>)>,
    /// A second keyframe is expected.
    pub two_keyframes: bool,
    /// Start of `time_range` from the keyframe, s, where the spec is such an offset.
    pub start_offset_s: Option<f64>,
    /// Context before the start, s.
    pub pack_before_s: f64,
    /// The decisions that fit it; `None` where the framework has no table.
    pub decisions: Option<ClassDecisions>,
}

#[derive(Clone, Debug, Default)]
struct L2Entry {
    /// The common requirements of all leaves: for labels without an L3.
    common: Prescribed,
    l3: HashMap<String, Prescribed>,
}

/// The classes of one framework.
#[derive(Clone, Debug, Default)]
pub struct ClassIndex {
    l1: HashMap<String, HashMap<String, L2Entry>>,
    /// Every class with its names, in tree order.
    names: Vec<(ScenarioId, Bilingual)>,
}

/// The result of looking up the ids of a class.
#[derive(Clone, Debug, PartialEq)]
pub enum Found<'i> {
    /// A class, or an L2 with the common requirements of its leaves.
    Class(&'i Prescribed),
    /// A class without requirements: `other`.
    Unclassified,
    /// The first id, from the left, that is wrong.
    Wrong {
        /// Its level.
        level: Level,
    },
}

/// A level of the taxonomy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Top level.
    L1,
    /// Middle level.
    L2,
    /// Leaf.
    L3,
}

impl Prescribed {
    fn of(spec: &ResolvedSpec, decisions: Option<&ClassDecisions>) -> Self {
        Self {
            title: Bilingual::default(),
            kind: Some(spec.keyframe.kind),
            uncertainty_high: spec.uncertainty_high,
            lateral: spec.lateral,
            records: spec.records.iter().map(|r| (r.id.clone(), r.name.clone(), r.unit.clone())).collect(),
            two_keyframes: spec.second_keyframe.is_some(),
            start_offset_s: spec.start.expr.as_deref().and_then(keyframe_offset_s),
            pack_before_s: spec.pack.before_s,
            decisions: decisions.cloned(),
        }
    }

    /// The common requirements of two classes.
    fn and(self, other: &Prescribed) -> Self {
        Self {
            title: self.title,
            kind: self.kind.filter(|k| other.kind == Some(*k)),
            uncertainty_high: self.uncertainty_high && other.uncertainty_high,
            lateral: self.lateral.filter(|l| other.lateral == Some(*l)),
            records: self.records.into_iter().filter(|r| other.records.contains(r)).collect(),
            two_keyframes: self.two_keyframes && other.two_keyframes,
            start_offset_s: self.start_offset_s.filter(|s| other.start_offset_s == Some(*s)),
            pack_before_s: self.pack_before_s.max(other.pack_before_s),
            decisions: self.decisions.zip(other.decisions.as_ref()).map(|(a, b)| a.or(b)),
        }
    }
}

/// Seconds of an expression `keyframe`, `keyframe - 2 s` or `keyframe + 3 s`; `None` for any other.
fn keyframe_offset_s(expr: &str) -> Option<f64> {
    let rest = expr.trim().strip_prefix("keyframe")?.trim();
    if rest.is_empty() {
        return Some(0.0);
    }
    let (sign, rest) =
        rest.strip_prefix('-').map(|r| (-1.0, r)).or_else(|| rest.strip_prefix('+').map(|r| (1.0, r)))?;
    Some(sign * rest.trim().strip_suffix('s')?.trim().parse::<f64>().ok()?)
}

impl ClassIndex {
    /// True for the end of exactly one class's id, such as `cutin` or `cutin.urgent`.
    pub fn is_short_id(&self, text: &str) -> bool {
        let ends =
            |id: &ScenarioId| id.to_string().strip_suffix(text).is_some_and(|rest| rest.ends_with('.'));
        self.names.iter().filter(|(id, _)| ends(id)).count() == 1
    }

    /// The displayed name of a class.
    pub fn name(&self, id: &ScenarioId) -> Option<&Bilingual> {
        self.names.iter().find(|(own, _)| own == id).map(|(_, name)| name)
    }

    /// The classes of a framework with their requirements.
    pub fn new(framework: &Framework) -> Self {
        let mut index = Self::default();
        for a in &framework.taxonomy.l1 {
            let id = |l2: Option<&str>, l3: Option<&str>| ScenarioId {
                l1: a.id.clone(),
                l2: l2.map(str::to_owned),
                l3: l3.map(str::to_owned),
            };
            index.names.push((id(None, None), a.name.clone()));
            let l2s = index.l1.entry(a.id.clone()).or_default();
            for b in &a.l2 {
                index.names.push((id(Some(&b.id), None), b.name.clone()));
                let entry = l2s.entry(b.id.clone()).or_default();
                let mut common: Option<Prescribed> = None;
                for c in &b.l3 {
                    let leaf = id(Some(&b.id), Some(&c.id));
                    let mut prescribed = framework
                        .specs
                        .get(&leaf)
                        .map(|s| Prescribed::of(s, framework.decision_table().leaves.get(&leaf)))
                        .unwrap_or_default();
                    prescribed.title = c.name.clone();
                    index.names.push((leaf, c.name.clone()));
                    common = Some(match common {
                        Some(so_far) => so_far.and(&prescribed),
                        None => prescribed.clone(),
                    });
                    entry.l3.insert(c.id.clone(), prescribed);
                }
                entry.common = common.unwrap_or_default();
                entry.common.title = b.name.clone();
            }
        }
        index
    }

    /// Looks the ids up, from the left; an absent L3 is allowed (DATA_FORMAT.md 4.2).
    pub fn find(&self, l1: &str, l2: Option<&str>, l3: Option<&str>) -> Found<'_> {
        let Some(l2s) = self.l1.get(l1) else { return Found::Wrong { level: Level::L1 } };
        let Some(l2) = l2 else { return Found::Unclassified };
        let Some(entry) = l2s.get(l2) else {
            let other = l2 == OTHER && l3.is_none_or(|l3| l3 == OTHER);
            return if other { Found::Unclassified } else { Found::Wrong { level: Level::L2 } };
        };
        match l3 {
            None => Found::Class(&entry.common),
            Some(OTHER) => Found::Class(&entry.common),
            Some(l3) => entry.l3.get(l3).map_or(Found::Wrong { level: Level::L3 }, Found::Class),
        }
    }

    /// Classes elsewhere in the tree that have this id at this level, in tree order.
    pub fn elsewhere(&self, level: Level, id: &str) -> Vec<&ScenarioId> {
        self.at(level).filter(|(s, _)| own_id(s) == id).map(|(s, _)| s).collect()
    }

    /// The probable meaning of `text` at `level`, under `l1` and `l2` as far as they are given: by name in
    /// either language, then by similarity of the id, siblings before the rest of the tree.
    pub fn meant(&self, level: Level, text: &str, l1: Option<&str>, l2: Option<&str>) -> Option<&ScenarioId> {
        let sibling = |s: &ScenarioId| {
            l1.is_none_or(|l1| s.l1 == l1) && l2.is_none_or(|l2| s.l2.as_deref() == Some(l2))
        };
        let by_name = |only_siblings: fn(bool) -> bool| {
            self.at(level)
                .filter(|(s, _)| only_siblings(sibling(s)))
                .find(|(_, n)| {
                    let bare = |t: &str| t.to_lowercase().replace([' ', '-', '_'], "");
                    bare(&n.zh) == bare(text)
                        || bare(&n.en) == bare(text)
                        || (text.chars().count() > 1 && !text.is_ascii() && n.zh.contains(text))
                })
                .map(|(s, _)| s)
        };
        let near = |only_siblings: fn(bool) -> bool| {
            let pool = || self.at(level).filter(|(s, _)| only_siblings(sibling(s)));
            let id = did_you_mean(text, pool().map(|(s, _)| own_id(s)))?;
            pool().find(|(s, _)| own_id(s) == id).map(|(s, _)| s)
        };
        by_name(|is| is).or_else(|| near(|is| is)).or_else(|| by_name(|_| true)).or_else(|| near(|_| true))
    }

    /// The ids that are accepted at `level` under `l1` and `l2`, in tree order.
    pub fn choices(&self, level: Level, l1: Option<&str>, l2: Option<&str>) -> Vec<&str> {
        self.at(level)
            .filter(|(s, _)| level == Level::L1 || l1 == Some(s.l1.as_str()))
            .filter(|(s, _)| level != Level::L3 || l2 == s.l2.as_deref())
            .map(|(s, _)| own_id(s))
            .collect()
    }

    fn at(&self, level: Level) -> impl Iterator<Item = &(ScenarioId, Bilingual)> {
        self.names.iter().filter(move |(s, _)| match level {
            Level::L1 => s.l2.is_none(),
            Level::L2 => s.l2.is_some() && s.l3.is_none(),
            Level::L3 => s.l3.is_some(),
        })
    }
}

/// The last part of an id.
pub fn own_id(s: &ScenarioId) -> &str {
    s.l3.as_deref().or(s.l2.as_deref()).unwrap_or(&s.l1)
}
