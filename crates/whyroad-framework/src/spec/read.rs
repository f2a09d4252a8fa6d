//! A file of `scenarios/` to a [`SpecFile`], with every problem reported and everything readable kept.

use super::expressions::{Written, expressions};
use super::raw::{
    BoundLayer, ChoiceLayer, KeyframeLayer, LabelingLayer, LeafLayer, MomentLayer, PackLayer, RecordLayer,
    SpecFile, Words,
};
use crate::taxonomy::{Taxonomy, did_you_mean, is_snake_case, read_version, suggestion};
use crate::yaml_text;
use indexmap::IndexMap;
use whyroad_model::decision::Lateral;
use whyroad_model::messages::{KeyframeType, Uncertainty};
use whyroad_model::yaml::{Entry, Fields, FileReport, FormCodes, Mark, Node, Value, from_node};
use whyroad_model::{Bilingual, Diagnostic};

static FAMILY: FormCodes = FormCodes {
    syntax: "spec.yaml",
    missing: "spec.field.missing",
    unknown: "spec.field.unknown",
    kind: "spec.field.type",
    duplicate: "spec.field.duplicate",
    empty: "spec.text.empty",
};

/// A file that was read, and the positions of its leaves.
#[derive(Clone, Debug)]
pub(crate) struct ReadSpec {
    pub spec: SpecFile,
    /// Position of each leaf's key.
    pub leaf_marks: IndexMap<String, Mark>,
    /// Each leaf's `mining:` block.
    pub mining: IndexMap<String, Entry>,
    /// The L2's own `mining:` block.
    pub l2_mining: Option<Entry>,
    /// Every expression of the labeling blocks.
    pub expressions: Vec<Written>,
    /// Id and position of every record of the labeling blocks.
    pub records: Vec<(String, Mark, String)>,
}

/// Reads one file and checks it against the classes.
pub(crate) fn read_spec(file: &str, text: &str, taxonomy: &Taxonomy) -> (Option<ReadSpec>, Vec<Diagnostic>) {
    let mut report = FileReport::new(file, text, &FAMILY);
    let read = yaml_text::parse(&mut report, text).and_then(|root| document(&root, taxonomy, &mut report));
    (read, report.diagnostics)
}

fn document(root: &Node, taxonomy: &Taxonomy, r: &mut FileReport) -> Option<ReadSpec> {
    let mut f = Fields::open(root, r)?;
    let version = read_version(&mut f, "spec.version", r);
    let l1_node = f.need("l1", r);
    let l1 = l1_node.and_then(|n| r.text(n));
    let l2_node = f.get("l2");
    let l2 = l2_node.and_then(|n| r.text(n));
    let labeling = f.get("labeling").and_then(|n| layer(n, r));
    let l2_mining = f.entry("mining").filter(|e| !matches!(e.node.value, Value::Null));
    let leaves_node = if l2_node.is_some() { f.need("leaves", r) } else { f.get("leaves") };
    f.close(r);

    if let Some(e) = l2_mining {
        r.entries(&e.node);
        if l2_node.is_none() {
            let (zh, en) = ("L1 的文件不能含有 mining", "the file of an L1 has no mining rule");
            r.error("spec.field.unknown", &e.node, zh.into(), en.into());
        }
    }
    let (l1, l1_node) = (l1?, l1_node?);
    let mut usable = check_path(&l1, l2.as_deref(), l2_node.unwrap_or(l1_node), r);
    if taxonomy.l1(&l1).is_none() {
        unknown_class(&l1, taxonomy.l1.iter().map(|a| a.id.as_str()), l1_node, r);
        usable = false;
    }
    if let (true, Some(l2), Some(node)) = (usable, &l2, l2_node)
        && taxonomy.l2(&l1, l2).is_none()
    {
        let known = taxonomy.l1(&l1).map_or(&[][..], |a| &a.l2).iter().map(|b| b.id.as_str());
        unknown_class(l2, known, node, r);
        usable = false;
    }
    if let (None, Some(node)) = (&l2, leaves_node) {
        let (zh, en) = ("L1 的文件不能含有 leaves", "the file of an L1 has no leaves");
        r.error("spec.field.unknown", node, zh.into(), en.into());
    }
    let mut out = ReadSpec {
        spec: SpecFile { version, l1, l2, labeling, mining: l2_mining.and_then(as_map), leaves: None },
        l2_mining: l2_mining.cloned(),
        leaf_marks: IndexMap::new(),
        mining: IndexMap::new(),
        expressions: expressions(root),
        records: written_records(root),
    };
    if let (Some(l2), Some(node)) = (&out.spec.l2, leaves_node) {
        let mut leaves = IndexMap::new();
        for entry in r.entries(node).unwrap_or_default() {
            let leaf = leaf(entry, r);
            let mining = leaf.1.and_then(as_map);
            out.mining.extend(leaf.1.map(|mining| (entry.key.clone(), mining.clone())));
            out.leaf_marks.insert(entry.key.clone(), entry.mark);
            leaves.insert(entry.key.clone(), LeafLayer { labeling: leaf.0, mining });
        }
        if usable {
            check_leaves(&out.spec.l1, l2, &out.leaf_marks, node, taxonomy, r);
        }
        out.spec.leaves = Some(leaves);
    }
    usable.then_some(out)
}

/// Id, position and pointer of each record, of the L2 or L1 first.
fn written_records(root: &Node) -> Vec<(String, Mark, String)> {
    let leaves = root.get("leaves").map_or(&[][..], Node::entries).iter().map(|e| &e.node);
    let labeling = std::iter::once(root).chain(leaves).filter_map(|level| level.get("labeling"));
    let records = labeling.filter_map(|l| l.get("records")).flat_map(Node::items);
    let one = |n: &Node| Some((n.get("id")?.text()?.trim().to_owned(), n.mark, n.pointer.clone()));
    records.filter_map(one).collect()
}

/// A `mining:` block as its schema describes it; whyroad-mining finds its errors.
fn as_map(entry: &Entry) -> Option<serde_json::Map<String, serde_json::Value>> {
    from_node(&entry.node).ok()
}

/// The folder and file name must match the fields: people find files by name.
fn check_path(l1: &str, l2: Option<&str>, node: &Node, r: &mut FileReport) -> bool {
    let wanted = match l2 {
        None => format!("scenarios/{l1}.yaml"),
        Some(l2) => format!("scenarios/{l1}/{l2}.yaml"),
    };
    let file = r.file.replace('\\', "/");
    if file == wanted || file.ends_with(&format!("/{wanted}")) {
        return true;
    }
    let message = Bilingual::new(
        format!("文件内容属于 '{wanted}'，与文件路径不符"),
        format!("by its content this file belongs at '{wanted}'"),
    );
    let hint = Bilingual::new(
        "移动或改名该文件，或改正其中的 l1 与 l2",
        "move or rename the file, or correct l1 and l2 in it",
    );
    r.error_with_hint("spec.path", node, message, hint);
    false
}

fn unknown_class<'k>(id: &str, known: impl Iterator<Item = &'k str>, node: &Node, r: &mut FileReport) {
    let mut d = Diagnostic::error(
        "spec.class.unknown",
        Bilingual::new(format!("分类体系中没有 '{id}'"), format!("the taxonomy has no '{id}' here")),
    );
    d = d.with_hint(did_you_mean(id, known).map_or_else(
        || {
            Bilingual::new(
                "新类别须先写入 schema/scenario_taxonomy.yaml",
                "a new class must be in schema/scenario_taxonomy.yaml first",
            )
        },
        suggestion,
    ));
    r.push(d, node.mark, &node.pointer);
}

/// The entry that lists a leaf, and where it belongs.
fn entry_for(id: &str, known: &[&str]) -> Bilingual {
    let before = known.iter().take_while(|k| **k != id).last();
    let (zh, en) = before.map_or(("首位".to_owned(), "first".to_owned()), |b| {
        (format!(" '{b}' 之后"), format!("after '{b}'"))
    });
    Bilingual::new(
        format!("在 'leaves' 中{zh}添加 `{id}: {{}}`；{{}} 表示标注规格同 L2"),
        format!("add `{id}: {{}}` to 'leaves', {en}; {{}} means that it is labeled as its L2 states"),
    )
}

/// Leaves that do not exist, leaves that are left out, and the order.
fn check_leaves(
    l1: &str,
    l2: &str,
    marks: &IndexMap<String, Mark>,
    node: &Node,
    taxonomy: &Taxonomy,
    r: &mut FileReport,
) {
    let Some((_, class)) = taxonomy.l2(l1, l2) else { return };
    let known: Vec<&str> = class.l3.iter().map(|c| c.id.as_str()).collect();
    for (id, mark) in marks.iter().filter(|(id, _)| !known.contains(&id.as_str())) {
        let place = Node { value: Value::Null, mark: *mark, pointer: format!("{}/{id}", node.pointer) };
        unknown_class(id, known.iter().copied(), &place, r);
    }
    for id in known.iter().filter(|id| !marks.contains_key(**id)) {
        let d = Diagnostic::error(
            "spec.class.missing",
            Bilingual::new(
                format!("L3 场景 '{l1}.{l2}.{id}' 没有列出"),
                format!("leaf '{l1}.{l2}.{id}' is not listed"),
            ),
        );
        r.push(d.with_hint(entry_for(id, &known)), node.mark, &node.pointer);
    }
    let written: Vec<&str> = marks.keys().map(String::as_str).filter(|id| known.contains(id)).collect();
    let ordered: Vec<&str> = known.iter().copied().filter(|id| marks.contains_key(*id)).collect();
    if written != ordered {
        let order = ordered.join(", ");
        let d = Diagnostic::warning(
            "spec.order",
            Bilingual::new("L3 场景的顺序与分类体系不同", "the leaves are not in the order of the taxonomy"),
        );
        r.push(d.with_hint(Bilingual::same(order)), node.mark, &node.pointer);
    }
}

fn leaf<'n>(entry: &'n Entry, r: &mut FileReport) -> (Option<LabelingLayer>, Option<&'n Entry>) {
    if matches!(entry.node.value, Value::Null) {
        return (None, None);
    }
    let Some(mut f) = Fields::open(&entry.node, r) else { return (None, None) };
    let labeling = f.get("labeling").and_then(|n| layer(n, r));
    let mining = f.entry("mining").filter(|e| !matches!(e.node.value, Value::Null));
    f.close(r);
    if let Some(e) = mining {
        r.entries(&e.node);
    }
    (labeling, mining)
}

fn layer(node: &Node, r: &mut FileReport) -> Option<LabelingLayer> {
    let mut f = Fields::open(node, r)?;
    let layer = LabelingLayer {
        keyframe: f.get("keyframe").and_then(|n| keyframe(n, r)),
        second_keyframe: f.get("second_keyframe").and_then(|n| keyframe(n, r)),
        start: f.get("start").and_then(|n| bound(n, r)),
        end: f.get("end").and_then(|n| bound(n, r)),
        pack: f.get("pack").and_then(|n| pack(n, r)),
        records: f.get("records").map(|n| records(n, r)),
        uncertainty: f.get("uncertainty").and_then(|n| {
            member(
                n,
                "spec.uncertainty.unknown",
                Uncertainty::from_id,
                Uncertainty::ALL.iter().map(|u| u.id()),
                r,
            )
        }),
        lateral: f.get("lateral").and_then(|n| {
            member(n, "spec.lateral.unknown", Lateral::from_id, Lateral::ALL.iter().map(|d| d.id()), r)
        }),
    };
    f.close(r);
    Some(layer)
}

fn keyframe(node: &Node, r: &mut FileReport) -> Option<KeyframeLayer> {
    let mut f = Fields::open(node, r)?;
    let kind = f.get("type").and_then(|n| {
        member(n, "spec.keyframe.type", KeyframeType::from_id, KeyframeType::ALL.iter().map(|k| k.id()), r)
    });
    let layer = KeyframeLayer {
        kind,
        rule: f.get("rule").and_then(|n| words(n, r)),
        expr: f.text_opt("expr", r),
        fallback: f.get("fallback").and_then(|n| moment(n, r)),
    };
    f.close(r);
    Some(layer)
}

fn bound(node: &Node, r: &mut FileReport) -> Option<BoundLayer> {
    let mut f = Fields::open(node, r)?;
    let layer = BoundLayer {
        rule: f.get("rule").and_then(|n| words(n, r)),
        expr: f.text_opt("expr", r),
        fallback: f.get("fallback").and_then(|n| moment(n, r)),
    };
    f.close(r);
    Some(layer)
}

fn moment(node: &Node, r: &mut FileReport) -> Option<MomentLayer> {
    let mut f = Fields::open(node, r)?;
    let rule = f.need("rule", r).and_then(|n| words(n, r));
    let expr = f.text_opt("expr", r);
    f.close(r);
    Some(MomentLayer { rule: rule?, expr })
}

fn pack(node: &Node, r: &mut FileReport) -> Option<PackLayer> {
    let mut f = Fields::open(node, r)?;
    let layer = PackLayer {
        before_s: f.get("before_s").and_then(|n| seconds(n, r)),
        after_s: f.get("after_s").and_then(|n| seconds(n, r)),
        after_until: f.get("after_until").and_then(|n| moment(n, r)),
    };
    f.close(r);
    Some(layer)
}

fn records(node: &Node, r: &mut FileReport) -> Vec<RecordLayer> {
    let mut out: Vec<RecordLayer> = Vec::new();
    for item in r.items(node) {
        let Some(mut f) = Fields::open(item, r) else { continue };
        let id = f.text("id", r);
        let name = f.need("name", r).and_then(|n| words(n, r));
        let unit = f.text_opt("unit", r);
        let signal = f.text_opt("signal", r);
        let object = f.text_opt("object", r).is_some_and(|text| text == "true");
        let target = f.text_opt("target", r).is_some_and(|text| text == "true");
        let choices = f.get("choices").map(|n| choices(n, r)).unwrap_or_default();
        f.close(r);
        let (Some(id), Some(name)) = (id, name) else { continue };
        if !is_snake_case(&id) || out.iter().any(|o| o.id == id) {
            r.error_with_hint("spec.record.id", item, unusable_id(("记录项", "record"), &id), new_id());
            continue;
        }
        out.push(RecordLayer { id, name, unit, signal, object, target, choices });
    }
    out
}

/// The message for the id of a record or a choice that cannot be used.
fn unusable_id((zh, en): (&str, &str), id: &str) -> Bilingual {
    if is_snake_case(id) {
        Bilingual::new(format!("{zh} id '{id}' 重复"), format!("{en} id '{id}' is used twice"))
    } else {
        Bilingual::new(
            format!("{zh} id '{id}' 不是小写下划线形式"),
            format!("{en} id '{id}' is not lower snake case"),
        )
    }
}

fn new_id() -> Bilingual {
    Bilingual::new(
        "另取一个 id：小写字母开头，由小写字母、数字和下划线组成",
        "give it another id, of lower-case letters, digits and underscores, such as merge_place",
    )
}

fn choices(node: &Node, r: &mut FileReport) -> Vec<ChoiceLayer> {
    let mut out: Vec<ChoiceLayer> = Vec::new();
    for item in r.items(node) {
        let Some(mut f) = Fields::open(item, r) else { continue };
        let id = f.text("id", r);
        let name = f.need("name", r).and_then(|n| words(n, r));
        let measured = f.list("measured", r).iter().filter_map(|n| r.text(n)).collect();
        f.close(r);
        let (Some(id), Some(name)) = (id, name) else { continue };
        if !is_snake_case(&id) || out.iter().any(|o| o.id == id) {
            r.error_with_hint("spec.record.id", item, unusable_id(("选项", "choice"), &id), new_id());
            continue;
        }
        out.push(ChoiceLayer { id, name, measured });
    }
    out
}

fn words(node: &Node, r: &mut FileReport) -> Option<Words> {
    let mut f = Fields::open(node, r)?;
    let zh = f.text("zh", r);
    let en = f.text("en", r);
    f.close(r);
    Some(Words { zh: zh?, en: en? })
}

fn seconds(node: &Node, r: &mut FileReport) -> Option<f64> {
    let text = r.text(node)?;
    match text.parse::<f64>() {
        Ok(s) if s.is_finite() && s >= 0.0 => Some(s),
        _ => {
            r.error(
                "spec.seconds",
                node,
                format!("'{text}' 不是非负的秒数"),
                format!("'{text}' is not a number of seconds that is zero or more"),
            );
            None
        }
    }
}

fn member<T>(
    node: &Node,
    code: &'static str,
    from_id: fn(&str) -> Option<T>,
    all: impl Iterator<Item = &'static str> + Clone,
    r: &mut FileReport,
) -> Option<T> {
    let text = r.text(node)?;
    let found = from_id(&text);
    if found.is_none() {
        let known = all.clone().collect::<Vec<_>>().join(", ");
        let hint = did_you_mean(&text, all).map_or_else(|| Bilingual::same(known), suggestion);
        let message = Bilingual::new(
            format!("'{text}' 不在允许的取值中"),
            format!("'{text}' is not one of the allowed values"),
        );
        r.push(Diagnostic::error(code, message).with_hint(hint), node.mark, &node.pointer);
    }
    found
}
