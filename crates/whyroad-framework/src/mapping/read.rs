//! YAML to [`ClassMapping`], continuing after each mistake.

use super::{ClassChange, ClassMapping, SplitPart};
use crate::Taxonomy;
use crate::taxonomy::{did_you_mean, suggestion};
use crate::yaml_text;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::label_fields::LabelField;
use whyroad_model::yaml::{Fields, FileReport, FormCodes, Node, Value};
use whyroad_model::{Bilingual, Diagnostic, ScenarioId, Severity};

/// Codes of the diagnostics of a mapping; each has a page in the documentation.
pub const MAPPING_CODES: &[&str] = &[
    "mapping.yaml",
    "mapping.missing",
    "mapping.unknown",
    "mapping.type",
    "mapping.duplicate",
    "mapping.empty",
    "mapping.class",
    "mapping.level",
    "mapping.conflict",
    "mapping.condition",
    "mapping.version",
    "mapping.forgotten",
];

static FORM: FormCodes = FormCodes {
    syntax: "mapping.yaml",
    missing: "mapping.missing",
    unknown: "mapping.unknown",
    kind: "mapping.type",
    duplicate: "mapping.duplicate",
    empty: "mapping.empty",
};

/// A change with where it is written.
struct Written<'n> {
    of: ScenarioId,
    change: ClassChange,
    node: &'n Node,
}

/// The mapping in `text`; `file` is its name in diagnostics. Classes after the change must be in `after`,
/// those before it in `before`, where that is given.
///
/// # Errors
/// All errors in it.
pub fn read_mapping(
    file: &str,
    text: &str,
    before: Option<&Taxonomy>,
    after: &Taxonomy,
) -> Result<ClassMapping, Vec<Diagnostic>> {
    let mut r = FileReport::new(file, text, &FORM);
    let mapping = yaml_text::parse(&mut r, text).and_then(|root| document(&root, before, after, &mut r));
    match mapping {
        Some(mapping) if !r.diagnostics.iter().any(|d| d.severity == Severity::Error) => Ok(mapping),
        _ => Err(r.diagnostics),
    }
}

fn document(
    root: &Node,
    before: Option<&Taxonomy>,
    after: &Taxonomy,
    r: &mut FileReport<'_>,
) -> Option<ClassMapping> {
    let mut f = Fields::open(root, r)?;
    let from = f.text("from", r);
    let to_node = f.need("to", r);
    let to = to_node.and_then(|n| r.text(n));
    let changes = f.need("changes", r);
    f.close(r);
    if let (Some(node), Some(to)) = (to_node, &to)
        && *to != after.version
    {
        r.error(
            "mapping.version",
            node,
            format!("映射的目标版本为 {to}，当前分类体系为 {}", after.version),
            format!("the mapping leads to {to}, the taxonomy in force is {}", after.version),
        );
    }
    let mut written = Vec::new();
    for node in changes.map_or(&[][..], |n| r.items(n)) {
        change(node, before, after, &mut written, r);
    }
    conflicts(&written, r);
    let mut out = ClassMapping { from: from?, to: to?, ..ClassMapping::default() };
    out.changes = written.into_iter().map(|w| (w.of, w.change)).collect();
    out.mark = mark(&out);
    // What a change with a mistake leaves open is not forgotten.
    if let (Some(before), Some(node), true) = (before, changes, r.diagnostics.is_empty()) {
        forgotten(before, after, &out, node, r);
    }
    Some(out)
}

fn change<'n>(
    node: &'n Node,
    before: Option<&Taxonomy>,
    after: &Taxonomy,
    out: &mut Vec<Written<'n>>,
    r: &mut FileReport<'_>,
) {
    let Some(mut f) = Fields::open(node, r) else { return };
    let (rename, merge, split) = (f.get("rename"), f.get("merge"), f.get("split"));
    let kinds = [rename, merge, split].iter().flatten().count();
    if kinds != 1 {
        r.error(
            FORM.missing,
            node,
            "每项须有且只有 rename、merge、split 之一".into(),
            "each change has exactly one of rename, merge, split".into(),
        );
        return;
    }
    if let Some(split) = split {
        let of = class(split, before, r);
        let parts: Vec<SplitPart> = f.list("into", r).iter().filter_map(|n| part(n, after, r)).collect();
        f.close(r);
        if parts.len() < 2 {
            r.error(
                "mapping.missing",
                node,
                "split 至少需要两个 into".into(),
                "a split needs at least two entries of into".into(),
            );
        }
        let Some(of) = of else { return };
        if of.l2.is_none() || parts.iter().any(|p| p.to.l2.is_none()) {
            level(split, r);
        }
        out.push(Written { of, change: ClassChange::Split(parts), node: split });
        return;
    }
    let to_node = f.need("to", r);
    f.close(r);
    let Some(to) = to_node.and_then(|n| class(n, Some(after), r)) else { return };
    let sources: &[Node] = match (rename, merge) {
        (Some(one), _) => std::slice::from_ref(one),
        (None, Some(list)) => r.items(list),
        (None, None) => &[],
    };
    for source in sources {
        let Some(of) = class(source, before, r) else { continue };
        let depth = |id: &ScenarioId| usize::from(id.l2.is_some()) + usize::from(id.l3.is_some());
        // A leaf may be merged into its L2, never the reverse: the variant is unknown.
        if depth(&to) > depth(&of) || to.l2.is_none() != of.l2.is_none() {
            level(source, r);
        }
        if of != to {
            out.push(Written { of, change: ClassChange::To(to.clone()), node: source });
        }
    }
}

fn level(node: &Node, r: &mut FileReport<'_>) {
    r.error(
        "mapping.level",
        node,
        "层级不符：变体不能由上级类别推出，L1 只能改名为 L1".into(),
        "the levels do not fit: a variant does not follow from the class above it, and an L1 becomes an L1"
            .into(),
    );
}

fn class(node: &Node, taxonomy: Option<&Taxonomy>, r: &mut FileReport<'_>) -> Option<ScenarioId> {
    let text = r.text(node)?;
    let id: ScenarioId = match text.parse() {
        Ok(id) => id,
        Err(e) => {
            let e: String = e;
            r.error("mapping.class", node, format!("'{text}' 不是完整的类别编号"), e);
            return None;
        }
    };
    if let Some(taxonomy) = taxonomy.filter(|t| !t.contains(&id)) {
        let ids: Vec<String> = taxonomy.ids().iter().map(ToString::to_string).collect();
        let message = Bilingual::new(format!("没有类别 '{text}'"), format!("there is no class '{text}'"));
        let mut d = Diagnostic::error("mapping.class", message);
        if let Some(near) = did_you_mean(&text, ids.iter().map(String::as_str)) {
            d = d.with_hint(suggestion(near));
        }
        r.push(d, node.mark, &node.pointer);
        return None;
    }
    Some(id)
}

fn part(node: &Node, after: &Taxonomy, r: &mut FileReport<'_>) -> Option<SplitPart> {
    let mut f = Fields::open(node, r)?;
    let to = f.need("to", r).and_then(|n| class(n, Some(after), r));
    let mut when: BTreeMap<String, Vec<Option<String>>> = BTreeMap::new();
    for entry in f.get("when").and_then(|n| r.entries(n)).unwrap_or_default() {
        let known = LabelField::at(&entry.key).is_some() || entry.key.starts_with("/records/");
        if !known {
            r.push(
                Diagnostic::error(
                    "mapping.condition",
                    Bilingual::new(
                        format!("'{}' 不是标注的字段", entry.key),
                        format!("'{}' is not a field of a label", entry.key),
                    ),
                ),
                entry.mark,
                &entry.node.pointer,
            );
            continue;
        }
        let values: Vec<&Node> = match &entry.node.value {
            Value::List(items) => items.iter().collect(),
            _ => vec![&entry.node],
        };
        let one = |n: &&Node| match &n.value {
            Value::Null => Some(None),
            _ => n.text().map(|t| Some(t.to_owned())),
        };
        when.insert(entry.key.clone(), values.iter().filter_map(one).collect());
    }
    f.close(r);
    Some(SplitPart { to: to?, when })
}

/// A class is changed once, and the result of a change is not changed by another one: otherwise the order of the
/// changes would matter, and repeating the migration would change labels again. A split may keep its own id for one of
/// its parts.
fn conflicts(written: &[Written<'_>], r: &mut FileReport<'_>) {
    let mut seen: BTreeSet<&ScenarioId> = BTreeSet::new();
    for w in written {
        if !seen.insert(&w.of) {
            r.error(
                "mapping.conflict",
                w.node,
                format!("类别 {} 有多个改动", w.of),
                format!("class {} is changed more than once", w.of),
            );
        }
    }
    for w in written {
        let targets: Vec<&ScenarioId> = match &w.change {
            ClassChange::To(to) => vec![to],
            ClassChange::Split(parts) => parts.iter().map(|p| &p.to).filter(|to| **to != w.of).collect(),
        };
        if let Some(to) = targets.into_iter().find(|to| seen.contains(to)) {
            r.error(
                "mapping.conflict",
                w.node,
                format!("{} 变为 {to}，而 {to} 自身也被改动；请分两次迁移", w.of),
                format!("{} becomes {to}, which is changed itself; migrate in two steps", w.of),
            );
        }
    }
}

/// Classes of labels that are gone after the change although the mapping does not say what becomes of them.
fn forgotten(
    before: &Taxonomy,
    after: &Taxonomy,
    mapping: &ClassMapping,
    changes: &Node,
    r: &mut FileReport<'_>,
) {
    for id in before.ids().into_iter().filter(|id| id.l2.is_some()) {
        let target = match mapping.change(&id) {
            Some(ClassChange::Split(_)) => continue,
            Some(ClassChange::To(to)) => to,
            None => id.clone(),
        };
        if after.contains(&target) {
            continue;
        }
        let message = if target == id {
            Bilingual::new(
                format!("新的分类体系中没有 {id}，映射也没有写明它变为什么"),
                format!("{id} is gone, and the mapping does not say what becomes of it"),
            )
        } else {
            Bilingual::new(
                format!("{id} 按映射变为 {target}，新的分类体系中没有这一类别"),
                format!("{id} becomes {target} by the change of a class above it, which is not a class"),
            )
        };
        let hint = Bilingual::new(
            "为它写一项 rename、merge 或 split；取消的类别并入其上级（merge: [它], to: 上级）",
            "add a rename, merge or split for it; labels of a retired class go to the class above it (merge: [ID], \
             to: L2)",
        );
        r.error_with_hint("mapping.forgotten", changes, message, hint);
    }
}

/// FNV-1a of the changes in their order: identifies the mapping; not for security.
fn mark(mapping: &ClassMapping) -> String {
    let text = format!("{} {} {:?}", mapping.from, mapping.to, mapping.changes);
    let hash = text
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3));
    format!("{hash:016x}")
}
