//! Changes between two taxonomies, and the resulting version step under DATA_FORMAT.md 1.3.
//!
//! A step is **major** when a label that was right under A may be wrong or invalid under B: a class removed,
//! moved or given another id, or its *meaning* changed. It is **minor** when B only adds: a class, a rule that
//! decides between two classes that had none, other typical decisions (which guide and do not bind). Everything
//! else is wording, order or reference: **patch**.
//!
//! Changes of meaning in a definition, condition or deciding rule are judged in `wording`. Two whole frameworks are
//! compared by [`diff_frameworks`]: their labeling specs (`labelling`), the tables of decisions and records (`tables`)
//! and mining rules (`mining`) too.

mod difference;
mod framework;
mod labelling;
mod mining;
mod tables;
mod wording;

pub use framework::{FileVersion, diff_frameworks};

use crate::taxonomy::{Decides, L1, L2, L3, Taxonomy, TypicalDecisions};
use crate::version::Step;
use serde::Serialize;
use std::collections::BTreeMap;
use whyroad_model::{Bilingual, ScenarioId};
use wording::{Wording, compare_text};

/// All changes from A to B.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TaxonomyDiff {
    /// Version that A states.
    pub from_version: String,
    /// Version that B states.
    pub to_version: String,
    /// By kind; within a kind in tree order of B, removed classes in that of A.
    pub changes: Vec<Change>,
    /// The smallest step that all these changes require.
    pub step: Step,
    /// Result of the version check; the worst of all files.
    pub version_check: VersionCheck,
    /// Each file whose version counts: the taxonomy, then the files of `scenarios/` with changes.
    pub files: Vec<FileVersion>,
}

/// One change.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// What kind.
    pub kind: ChangeKind,
    /// The class: its id in B, or in A where it was removed.
    pub id: ScenarioId,
    /// Its id in A, where it moved.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_id: Option<ScenarioId>,
    /// The field that changed, as named in the file; absent where the class as a whole changed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field: Option<&'static str>,
    /// The text in A.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub before: Option<Bilingual>,
    /// The text in B.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after: Option<Bilingual>,
    /// The step that this change alone requires.
    pub step: Step,
}

/// Kinds of change, as `taxonomy diff` groups them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ChangeKind {
    /// In A only.
    Removed,
    /// Other place or id, same names.
    Moved,
    /// In B only.
    Added,
    /// Same id, other name.
    Renamed,
    /// A label may now be wrong, or the meaning of a class changed.
    MeaningChanged,
    /// Other wording, same meaning.
    Reworded,
    /// Order among siblings, or a reference.
    Arranged,
    /// Another labeling spec, inheritance applied. The id of an L1 or L2 stands for all leaves below it.
    Labelling,
    /// Another mining rule, as written.
    Mining,
    /// Other texts, causes or combinations of a driving decision, whose id stands in the place of a class.
    Decision,
}

/// Whether B's version is high enough. In order of severity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum VersionCheck {
    /// The stated step is at least as large as required.
    Consistent,
    /// A or B states no version.
    Unknown,
    /// B states a smaller step than its changes require.
    TooSmall,
    /// B states an earlier version than A.
    Backwards,
}

/// A class of any level, its texts side by side.
struct Entry<'t> {
    name: &'t Bilingual,
    definition: &'t Bilingual,
    condition: Option<&'t Bilingual>,
    typical: Option<&'t TypicalDecisions>,
    mining_conditions: &'t [Bilingual],
    decides: &'t [Decides],
    spec_ref: Option<&'t str>,
}

/// The comparable fields.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Scope {
    /// All fields.
    Everything,
    /// The content of a TAXONOMY.md: names, and those definitions and conditions that both sides state.
    Page,
}

/// Every full taxonomy states typical decisions (they are required); a TAXONOMY.md states none.
fn states_rules(t: &Taxonomy) -> bool {
    t.l1.iter().flat_map(|a| &a.l2).any(|b| b.typical_decisions != TypicalDecisions::default())
}

/// Compares B with A. A field that one side does not state at all (a TAXONOMY.md has no definitions) is not compared.
pub fn diff(a: &Taxonomy, b: &Taxonomy) -> TaxonomyDiff {
    let (old, new) = (entries(a), entries(b));
    let mut gone: Vec<ScenarioId> = a.ids().into_iter().filter(|id| !new.contains_key(id)).collect();
    let mut come: Vec<ScenarioId> = b.ids().into_iter().filter(|id| !old.contains_key(id)).collect();
    let mut changes = Vec::new();
    for (from, to) in moved(&mut gone, &mut come, &old, &new) {
        changes.push(Change { from_id: Some(from), ..Change::of(ChangeKind::Moved, to, Step::Major) });
    }
    let moves = Moves::of(&changes);
    changes.extend(gone.into_iter().map(|id| Change::of(ChangeKind::Removed, id, Step::Major)));
    changes.extend(come.into_iter().map(|id| Change::of(ChangeKind::Added, id, Step::Minor)));
    let scope = if states_rules(a) && states_rules(b) { Scope::Everything } else { Scope::Page };
    for id in b.ids() {
        if let (Some(x), Some(y)) = (old.get(moves.before(&id)), new.get(&id)) {
            fields(&id, x, y, scope, &moves, &mut changes);
        }
    }
    order(a, b, &mut changes);
    // Stable sort: within a kind the tree order is kept.
    changes.sort_by_key(|c| c.kind);
    let step = changes.iter().map(|c| c.step).max().unwrap_or_default();
    let file = FileVersion::of(framework::TAXONOMY, &a.version, &b.version, step);
    TaxonomyDiff {
        from_version: a.version.clone(),
        to_version: b.version.clone(),
        changes,
        step,
        version_check: file.version_check,
        files: vec![file],
    }
}

impl Change {
    fn of(kind: ChangeKind, id: ScenarioId, step: Step) -> Self {
        Self { kind, id, from_id: None, field: None, before: None, after: None, step }
    }

    fn texts(mut self, field: &'static str, before: Bilingual, after: Bilingual) -> Self {
        (self.field, self.before, self.after) = (Some(field), Some(before), Some(after));
        self
    }
}

fn entries(t: &Taxonomy) -> BTreeMap<ScenarioId, Entry<'_>> {
    let mut out = BTreeMap::new();
    for a in &t.l1 {
        out.insert(ScenarioId { l1: a.id.clone(), l2: None, l3: None }, of_l1(a));
        for b in &a.l2 {
            out.insert(ScenarioId { l1: a.id.clone(), l2: Some(b.id.clone()), l3: None }, of_l2(b));
            for c in &b.l3 {
                out.insert(ScenarioId::leaf(&a.id, &b.id, &c.id), of_l3(c));
            }
        }
    }
    out
}

fn of_l1(l1: &L1) -> Entry<'_> {
    Entry {
        name: &l1.name,
        definition: &l1.definition,
        condition: None,
        typical: None,
        mining_conditions: &[],
        decides: &[],
        spec_ref: None,
    }
}

fn of_l2(l2: &L2) -> Entry<'_> {
    Entry {
        name: &l2.name,
        definition: &l2.definition,
        condition: l2.condition.as_ref(),
        typical: Some(&l2.typical_decisions),
        mining_conditions: &l2.mining_conditions,
        decides: &l2.decides,
        spec_ref: l2.labeling_spec_ref.as_deref(),
    }
}

fn of_l3(l3: &L3) -> Entry<'_> {
    Entry {
        name: &l3.name,
        definition: &l3.definition,
        condition: Some(&l3.condition),
        typical: Some(&l3.typical_decisions),
        mining_conditions: &l3.mining_conditions,
        decides: &l3.decides,
        spec_ref: l3.labeling_spec_ref.as_deref(),
    }
}

/// Pairs of a removed and an added class of one level with the same name in some language, where that is unambiguous:
/// the same class under another id or parent. Taken out of both lists.
fn moved(
    gone: &mut Vec<ScenarioId>,
    come: &mut Vec<ScenarioId>,
    old: &BTreeMap<ScenarioId, Entry<'_>>,
    new: &BTreeMap<ScenarioId, Entry<'_>>,
) -> Vec<(ScenarioId, ScenarioId)> {
    let level = |id: &ScenarioId| usize::from(id.l2.is_some()) + usize::from(id.l3.is_some());
    let alike = |x: &ScenarioId, y: &ScenarioId| {
        level(x) == level(y) && old.get(x).zip(new.get(y)).is_some_and(|(x, y)| same_name(x.name, y.name))
    };
    let mut pairs = Vec::new();
    for from in gone.iter() {
        let mut candidates = come.iter().filter(|to| alike(from, to));
        if let (Some(to), None) = (candidates.next(), candidates.next())
            && gone.iter().filter(|other| alike(other, to)).count() == 1
        {
            pairs.push((from.clone(), to.clone()));
        }
    }
    gone.retain(|id| !pairs.iter().any(|(from, _)| from == id));
    come.retain(|id| !pairs.iter().any(|(_, to)| to == id));
    pairs
}

fn same_name(x: &Bilingual, y: &Bilingual) -> bool {
    let one = |a: &str, b: &str| !a.is_empty() && a == b;
    one(&x.zh, &y.zh) && (x.en.is_empty() || y.en.is_empty() || x.en == y.en)
}

fn fields(id: &ScenarioId, x: &Entry<'_>, y: &Entry<'_>, scope: Scope, moves: &Moves, out: &mut Vec<Change>) {
    let mut push = |kind, field, before: Bilingual, after: Bilingual, step| {
        out.push(Change::of(kind, id.clone(), step).texts(field, before, after));
    };
    if compare_text(x.name, y.name) != Wording::Same {
        push(ChangeKind::Renamed, "name", x.name.clone(), y.name.clone(), Step::Patch);
    }
    let texts =
        [("definition", Some(x.definition), Some(y.definition)), ("condition", x.condition, y.condition)];
    for (field, before, after) in texts {
        let (Some(before), Some(after)) = (before, after) else { continue };
        match moves.compared(before, after) {
            Wording::Same => {}
            Wording::Reworded => {
                push(ChangeKind::Reworded, field, before.clone(), after.clone(), Step::Patch)
            }
            Wording::Meaning => {
                push(ChangeKind::MeaningChanged, field, before.clone(), after.clone(), Step::Major)
            }
        }
    }
    if scope == Scope::Page {
        return;
    }
    for d in y.decides {
        let old = x.decides.iter().find(|o| o.against == *moves.before(&d.against)).map(|o| &o.rule);
        let (kind, step) = match old.map(|rule| moves.compared(rule, &d.rule)) {
            None => (ChangeKind::MeaningChanged, Step::Minor),
            Some(Wording::Same) => continue,
            Some(Wording::Reworded) => (ChangeKind::Reworded, Step::Patch),
            Some(Wording::Meaning) => (ChangeKind::MeaningChanged, Step::Major),
        };
        push(kind, "decides", about(&d.against, old), about(&d.against, Some(&d.rule)), step);
    }
    for o in x.decides.iter().filter(|o| !y.decides.iter().any(|d| *moves.before(&d.against) == o.against)) {
        let (before, after) = (about(&o.against, Some(&o.rule)), about(&o.against, None));
        push(ChangeKind::MeaningChanged, "decides", before, after, Step::Major);
    }
    if let (Some(before), Some(after)) = (x.typical, y.typical)
        && before != after
    {
        push(
            ChangeKind::MeaningChanged,
            "typical_decisions",
            decisions(before),
            decisions(after),
            Step::Minor,
        );
    }
    if x.mining_conditions != y.mining_conditions
        && !x.mining_conditions.is_empty()
        && !y.mining_conditions.is_empty()
    {
        push(
            ChangeKind::Reworded,
            "mining_conditions",
            joined(x.mining_conditions),
            joined(y.mining_conditions),
            Step::Patch,
        );
    }
    if let (Some(before), Some(after)) = (x.spec_ref, y.spec_ref)
        && before != after
    {
        push(
            ChangeKind::Arranged,
            "labeling_spec_ref",
            Bilingual::same(before),
            Bilingual::same(after),
            Step::Patch,
        );
    }
}

/// Classes that were moved or given another id, so that what refers to them is compared under one name.
#[derive(Debug, Default)]
struct Moves(Vec<(ScenarioId, ScenarioId)>);

impl Moves {
    fn of(changes: &[Change]) -> Self {
        Self(changes.iter().filter_map(|c| Some((c.from_id.clone()?, c.id.clone()))).collect())
    }

    /// The id in A of a class of B.
    fn before<'i>(&'i self, id: &'i ScenarioId) -> &'i ScenarioId {
        self.0.iter().find(|(_, to)| to == id).map_or(id, |(from, _)| from)
    }

    /// The id in B of a class of A.
    fn after<'i>(&'i self, id: &'i ScenarioId) -> &'i ScenarioId {
        self.0.iter().find(|(from, _)| from == id).map_or(id, |(_, to)| to)
    }

    /// Compares texts, whether the later one calls the moved classes by their ids in B or still by those in A.
    fn compared(&self, before: &Bilingual, after: &Bilingual) -> Wording {
        compare_text(&self.applied(before), after).min(compare_text(before, after))
    }

    /// A text of A with the ids of B: in full, without the L1, and the last part alone where it is no plain word.
    fn applied(&self, text: &Bilingual) -> Bilingual {
        let mut out = text.clone();
        for (from, to) in &self.0 {
            let (from, to) = (from.to_string(), to.to_string());
            let mut names = vec![(from.as_str(), to.as_str())];
            while let Some((x, y)) = names.last().and_then(|(x, y)| x.split_once('.').zip(y.split_once('.')))
            {
                names.push((x.1, y.1));
            }
            for (x, y) in names.into_iter().filter(|(x, _)| x.contains(['.', '_'])) {
                out = Bilingual::new(replaced(&out.zh, x, y), replaced(&out.en, x, y));
            }
        }
        out
    }
}

/// `text` with the name `from`, where it stands alone, replaced.
fn replaced(text: &str, from: &str, to: &str) -> String {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(from) {
        let (before, after) = (&rest[..at], &rest[at + from.len()..]);
        let stands_alone =
            !before.ends_with(is_part) && !before.ends_with('.') && !after.starts_with(is_part);
        out += before;
        out += if stands_alone { to } else { from };
        rest = after;
    }
    out + rest
}

fn about(against: &ScenarioId, rule: Option<&Bilingual>) -> Bilingual {
    match rule {
        Some(r) => Bilingual::new(format!("{against}：{}", r.zh), format!("{against}: {}", r.en)),
        None => Bilingual::new(format!("{against}：无规则"), format!("{against}: no rule")),
    }
}

fn decisions(d: &TypicalDecisions) -> Bilingual {
    let ids = d.longitudinal.iter().map(|x| x.id()).chain(d.lateral.iter().map(|x| x.id()));
    Bilingual::same(ids.collect::<Vec<_>>().join(", "))
}

fn joined(texts: &[Bilingual]) -> Bilingual {
    let zh: Vec<&str> = texts.iter().map(|t| t.zh.as_str()).collect();
    let en: Vec<&str> = texts.iter().map(|t| t.en.as_str()).collect();
    Bilingual::new(zh.join("；"), en.join("; "))
}

/// Siblings that both have, in another order.
fn order(a: &Taxonomy, b: &Taxonomy, out: &mut Vec<Change>) {
    let (ours, theirs) = (a.ids(), b.ids());
    let parents = std::iter::once(None).chain(ours.iter().filter(|id| !id.is_leaf()).map(Some));
    for parent in parents {
        let children = |all: &[ScenarioId], other: &[ScenarioId]| -> Vec<ScenarioId> {
            all.iter().filter(|id| is_child(id, parent) && other.contains(id)).cloned().collect()
        };
        let (before, after) = (children(&ours, &theirs), children(&theirs, &ours));
        if let Some(first) = before.iter().zip(&after).find(|(x, y)| x != y) {
            let text = |ids: &[ScenarioId]| {
                Bilingual::same(ids.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "))
            };
            let id = parent.unwrap_or(first.0).clone();
            out.push(Change {
                field: Some("order"),
                before: Some(text(&before)),
                after: Some(text(&after)),
                ..Change::of(ChangeKind::Arranged, id, Step::Patch)
            });
        }
    }
}

fn is_child(id: &ScenarioId, parent: Option<&ScenarioId>) -> bool {
    match parent {
        None => id.l2.is_none(),
        Some(p) if p.l2.is_none() => id.l1 == p.l1 && id.l2.is_some() && id.l3.is_none(),
        Some(p) => id.l1 == p.l1 && id.l2 == p.l2 && id.l3.is_some(),
    }
}
