//! `schema/scenario_taxonomy.yaml` (DATA_FORMAT.md 2.1 with our optional additions) to a [`Taxonomy`], with
//! every problem reported and everything readable kept.

use super::agreement;
use super::{Decides, L1, L2, L3, Taxonomy, TypicalDecisions, did_you_mean, suggestion};
use crate::version::Version;
use crate::yaml_text;
use std::collections::BTreeMap;
use whyroad_model::decision::{Lateral, Longitudinal};
use whyroad_model::yaml::{Fields, FileReport, FormCodes, Node};
use whyroad_model::{Bilingual, Diagnostic, ScenarioId};

pub(crate) static FAMILY: FormCodes = FormCodes {
    syntax: "taxonomy.yaml",
    missing: "taxonomy.field.missing",
    unknown: "taxonomy.field.unknown",
    kind: "taxonomy.field.type",
    duplicate: "taxonomy.field.duplicate",
    empty: "taxonomy.text.empty",
};

/// Reads a taxonomy. `None` when the text is not a YAML mapping.
pub fn read_taxonomy(file: &str, text: &str) -> (Option<Taxonomy>, Vec<Diagnostic>) {
    let mut report = FileReport::new(file, text, &FAMILY);
    let taxonomy = yaml_text::parse(&mut report, text).and_then(|root| {
        let mut reading = Reading { report: &mut report, against: Vec::new(), nodes: BTreeMap::new() };
        let taxonomy = reading.document(&root)?;
        let (against, nodes) = (reading.against, reading.nodes);
        check_against(&taxonomy, &against, &mut report);
        agreement::decides(&taxonomy, &against, &mut report);
        agreement::named_classes(&taxonomy, &nodes, &mut report);
        Some(taxonomy)
    });
    (taxonomy, report.diagnostics)
}

struct Reading<'r, 't, 'n> {
    report: &'r mut FileReport<'t>,
    /// `decides.against` references, checked once all classes are known: (the class that states it, the id, its
    /// position).
    against: Vec<(ScenarioId, ScenarioId, &'n Node)>,
    /// Where each class was written, by full id.
    nodes: BTreeMap<String, &'n Node>,
}

impl<'n> Reading<'_, '_, 'n> {
    fn document(&mut self, root: &'n Node) -> Option<Taxonomy> {
        let r = &mut *self.report;
        let mut f = Fields::open(root, r)?;
        let version = read_version(&mut f, "taxonomy.version", r);
        let description = f.text_opt("description", r).unwrap_or_default();
        let description_en = f.text_opt("description_en", r).unwrap_or_else(|| description.clone());
        let l1_nodes = f.need("l1_categories", r).map_or(&[][..], |n| r.items(n));
        let l2_lists = f.need("l2_scenarios", r).and_then(|n| r.entries(n)).unwrap_or_default();
        let l3_lists = f.need("l3_variants", r).and_then(|n| r.entries(n)).unwrap_or_default();
        f.close(r);

        let mut l1: Vec<L1> = Vec::new();
        for node in l1_nodes {
            let Some(category) = self.l1(node) else { continue };
            if let Some(category) = self.unless_taken(category, |c| &c.id, &l1, (node, l1_nodes)) {
                l1.push(category);
            }
        }
        // L2 ids key the L3 lists, so they must be unique across L1s. Where each was first written:
        let mut l2_seen: BTreeMap<String, (String, usize)> = BTreeMap::new();
        for entry in &l2_lists {
            let Some(at) = l1.iter().position(|a| a.id == entry.key) else {
                self.unknown_parent(&entry.key, entry.mark, &entry.node, l1.iter().map(|a| a.id.as_str()));
                continue;
            };
            for node in self.report.items(&entry.node) {
                let Some(scenario) = self.l2(&entry.key, node) else { continue };
                let first = || (entry.key.clone(), node.mark.line);
                let (owner, line) = l2_seen.entry(scenario.id.clone()).or_insert_with(first).clone();
                if owner != entry.key {
                    let id = &scenario.id;
                    let message = Bilingual::new(
                        format!("L2 id '{id}' 已属于 '{owner}'（第 {line} 行）；L2 id 在所有 L1 中必须唯一"),
                        format!(
                            "L2 id '{id}' already belongs to '{owner}' (line {line}); L2 ids must be unique across L1s"
                        ),
                    );
                    self.report.error_with_hint("taxonomy.id.duplicate", node, message, another_id());
                } else if let Some(scenario) =
                    self.unless_taken(scenario, |b| &b.id, &l1[at].l2, (node, entry.node.items()))
                {
                    l1[at].l2.push(scenario);
                }
            }
        }
        for entry in &l3_lists {
            let home = l1
                .iter()
                .enumerate()
                .find_map(|(i, a)| Some((i, a.l2.iter().position(|b| b.id == entry.key)?)));
            let Some((i, j)) = home else {
                let known = l1.iter().flat_map(|a| a.l2.iter().map(|b| b.id.as_str()));
                self.unknown_parent(&entry.key, entry.mark, &entry.node, known);
                continue;
            };
            for node in self.report.items(&entry.node) {
                let Some(variant) = self.l3(&l1[i].id.clone(), &l1[i].l2[j], node) else { continue };
                if let Some(variant) =
                    self.unless_taken(variant, |c| &c.id, &l1[i].l2[j].l3, (node, entry.node.items()))
                {
                    l1[i].l2[j].l3.push(variant);
                }
            }
        }
        self.childless(&l1);
        Some(Taxonomy { version, description: Bilingual::new(description, description_en), l1 })
    }

    fn l1(&mut self, node: &'n Node) -> Option<L1> {
        let r = &mut *self.report;
        let mut f = Fields::open(node, r)?;
        let id = read_id(&mut f, r);
        let name = read_bilingual(&mut f, "name_zh", "name_en", r);
        let definition = read_bilingual(&mut f, "definition", "definition_en", r);
        f.close(r);
        self.nodes.insert(id.clone()?, node);
        Some(L1 { id: id?, name: name?, definition: definition.unwrap_or_default(), l2: Vec::new() })
    }

    fn l2(&mut self, l1: &str, node: &'n Node) -> Option<L2> {
        let r = &mut *self.report;
        let mut f = Fields::open(node, r)?;
        let id = read_id(&mut f, r);
        let name = read_bilingual(&mut f, "name_zh", "name_en", r);
        let definition = read_bilingual(&mut f, "definition", "definition_en", r);
        let condition = optional_bilingual(&mut f, "condition", "condition_en", r);
        let typical = f.need("typical_decisions", r).map(|n| read_decisions(n, r));
        let mining_conditions = read_conditions(&mut f, r);
        let labeling_spec_ref = f.text_opt("labeling_spec_ref", r);
        let decides = f.list("decides", r);
        f.close(r);
        let id = id?;
        let owner = ScenarioId { l1: l1.to_owned(), l2: Some(id.clone()), l3: None };
        self.nodes.insert(owner.to_string(), node);
        let decides = self.decides(&owner, decides);
        Some(L2 {
            id,
            name: name?,
            definition: definition.unwrap_or_default(),
            condition,
            typical_decisions: typical.unwrap_or_default(),
            mining_conditions,
            labeling_spec_ref,
            decides,
            l3: Vec::new(),
        })
    }

    fn l3(&mut self, l1: &str, l2: &L2, node: &'n Node) -> Option<L3> {
        let r = &mut *self.report;
        let mut f = Fields::open(node, r)?;
        let id = read_id(&mut f, r);
        let name = read_bilingual(&mut f, "name_zh", "name_en", r);
        let condition = read_bilingual(&mut f, "condition", "condition_en", r);
        let definition = optional_bilingual(&mut f, "definition", "definition_en", r);
        let typical = f.get("typical_decisions").map(|n| read_decisions(n, r));
        let mining_conditions = read_conditions(&mut f, r);
        let labeling_spec_ref = f.text_opt("labeling_spec_ref", r).or_else(|| l2.labeling_spec_ref.clone());
        let decides = f.list("decides", r);
        f.close(r);
        let id = id?;
        let owner = ScenarioId::leaf(l1, &l2.id, &id);
        self.nodes.insert(owner.to_string(), node);
        let decides = self.decides(&owner, decides);
        let condition = condition.unwrap_or_default();
        let definition = definition.unwrap_or_else(|| {
            // DATA_FORMAT.md 2.1 has no definition of an L3, so this is a warning; the condition is used instead.
            let message = Bilingual::new(format!("'{id}' 没有定义"), format!("'{id}' has no definition"));
            self.report.push(
                Diagnostic::warning("taxonomy.definition.none", message),
                node.mark,
                &node.pointer,
            );
            condition.clone()
        });
        Some(L3 {
            id,
            name: name?,
            definition,
            condition,
            typical_decisions: typical.unwrap_or_else(|| l2.typical_decisions.clone()),
            mining_conditions,
            labeling_spec_ref,
            decides,
        })
    }

    fn decides(&mut self, owner: &ScenarioId, nodes: &'n [Node]) -> Vec<Decides> {
        let mut out = Vec::new();
        for node in nodes {
            let r = &mut *self.report;
            let Some(mut f) = Fields::open(node, r) else { continue };
            let against_node = f.need("against", r);
            let against = against_node.and_then(|n| r.text(n));
            let rule = read_bilingual(&mut f, "rule", "rule_en", r);
            f.close(r);
            let (Some(text), Some(at)) = (against, against_node) else { continue };
            match text.parse::<ScenarioId>() {
                Ok(id) => {
                    self.against.push((owner.clone(), id.clone(), at));
                    out.extend(rule.map(|rule| Decides { against: id, rule }));
                }
                Err(_) => self.report.error(
                    "taxonomy.id.malformed",
                    at,
                    format!("'{text}' 不是场景 id（应为小写的 l1.l2 或 l1.l2.l3）"),
                    format!("'{text}' is not a scenario id (expected l1.l2 or l1.l2.l3 in lower snake case)"),
                ),
            }
        }
        out
    }

    /// `item`, unless a sibling has its id already; that is reported. `node` is the item as written, `list` all of its
    /// list.
    fn unless_taken<T>(
        &mut self,
        item: T,
        id: impl Fn(&T) -> &String,
        siblings: &[T],
        (node, list): (&Node, &[Node]),
    ) -> Option<T> {
        if !siblings.iter().any(|s| id(s) == id(&item)) {
            return Some(item);
        }
        let id = id(&item);
        let is_same = |n: &&Node| n.get("id").and_then(Node::text).is_some_and(|text| text.trim() == id);
        let first = list.iter().find(is_same).map_or_else(Bilingual::default, |n| {
            let line = n.mark.line;
            Bilingual::new(format!("，首次出现在第 {line} 行"), format!(", first on line {line}"))
        });
        let message = Bilingual::new(
            format!("id '{id}' 重复{}", first.zh),
            format!("id '{id}' is used twice{}", first.en),
        );
        self.report.error_with_hint("taxonomy.id.duplicate", node, message, another_id());
        None
    }

    fn unknown_parent<'k>(
        &mut self,
        key: &str,
        mark: whyroad_model::yaml::Mark,
        node: &Node,
        known: impl Iterator<Item = &'k str>,
    ) {
        let mut d = Diagnostic::error(
            "taxonomy.parent.unknown",
            Bilingual::new(
                format!("上级 '{key}' 不存在，其下的类别被忽略"),
                format!("no class '{key}' is defined; the entries under it are ignored"),
            ),
        );
        if let Some(near) = did_you_mean(key, known) {
            d = d.with_hint(suggestion(near));
        }
        self.report.push(d, mark, &node.pointer);
    }

    /// An L1 or L2 without children holds no leaf, so it can never be used in a label.
    fn childless(&mut self, l1: &[L1]) {
        let empty_l1 = l1.iter().filter(|a| a.l2.is_empty()).map(|a| (a.id.clone(), "L2"));
        let empty_l2 = l1.iter().flat_map(|a| {
            a.l2.iter().filter(|b| b.l3.is_empty()).map(move |b| (format!("{}.{}", a.id, b.id), "L3"))
        });
        for (id, child) in empty_l1.chain(empty_l2) {
            let Some(node) = self.nodes.get(&id).copied() else { continue };
            self.report.error(
                "taxonomy.children.none",
                node,
                format!("'{id}' 之下没有 {child}"),
                format!("'{id}' has no {child} below it"),
            );
        }
    }
}

fn check_against(taxonomy: &Taxonomy, against: &[(ScenarioId, ScenarioId, &Node)], report: &mut FileReport) {
    for (owner, id, node) in against {
        if owner == id {
            report.error(
                "taxonomy.against.self",
                node,
                format!("'{id}' 不能与自身比较"),
                format!("'{id}' cannot be decided against itself"),
            );
        } else if !taxonomy.contains(id) {
            let mut d = Diagnostic::error(
                "taxonomy.against.unknown",
                Bilingual::new(format!("类别 '{id}' 不存在"), format!("class '{id}' not found")),
            );
            if let Some(near) = taxonomy.nearest(&id.to_string()).first() {
                d = d.with_hint(suggestion(&near.to_string()));
            }
            report.push(d, node.mark, &node.pointer);
        }
    }
}

/// The `version` field; reported under `code` when it is not a version, and then "0.0.0".
pub(crate) fn read_version(f: &mut Fields, code: &'static str, r: &mut FileReport) -> String {
    let Some(node) = f.need("version", r) else { return Version::default().to_string() };
    let Some(text) = r.text(node) else { return Version::default().to_string() };
    if Version::parse(&text).is_none() {
        let message = Bilingual::new(
            format!("'{text}' 不是 major.minor.patch 形式的版本"),
            format!("'{text}' is not a version of the form major.minor.patch"),
        );
        let hint = Bilingual::new("例如 version: \"2.0.0\"", "such as version: \"2.0.0\"");
        r.error_with_hint(code, node, message, hint);
        return Version::default().to_string();
    }
    text
}

fn read_id(f: &mut Fields, r: &mut FileReport) -> Option<String> {
    let node = f.need("id", r)?;
    let id = r.text(node)?;
    if !is_snake_case(&id) {
        let message = Bilingual::new(
            format!("id '{id}' 只能由小写字母、数字和下划线组成，并以字母开头"),
            format!("id '{id}' must be lower snake case and start with a letter"),
        );
        let meant = snake_case(&id);
        let such = meant.as_deref().unwrap_or("cut_in");
        let hint = Bilingual::new(format!("例如 {such}"), format!("such as {such}"));
        r.error_with_hint("taxonomy.id.malformed", node, message, hint);
        // Read as it is meant: else all that names the class is reported as unknown, too.
        return meant;
    }
    Some(id)
}

/// True for an id in lower snake case that begins with a letter.
pub(crate) fn is_snake_case(id: &str) -> bool {
    id.starts_with(|c: char| c.is_ascii_lowercase())
        && id.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_')
}

/// `FromStationary` and `from-stationary` as `from_stationary`; `None` where other characters remain.
fn snake_case(id: &str) -> Option<String> {
    let mut out = String::new();
    let mut last = ' ';
    for c in id.chars() {
        match c {
            '-' | ' ' | '.' => out.push('_'),
            c if c.is_ascii_uppercase() && (last.is_ascii_lowercase() || last.is_ascii_digit()) => {
                out.extend(['_', c.to_ascii_lowercase()]);
            }
            c => out.push(c.to_ascii_lowercase()),
        }
        last = c;
    }
    let is_plain = out.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_');
    (is_plain && out.starts_with(|c: char| c.is_ascii_lowercase())).then_some(out)
}

/// The remedy for an id that is taken.
pub(crate) fn another_id() -> Bilingual {
    Bilingual::new("给其中一个另取 id，或删除其中一个", "give one of the two another id, or delete one")
}

/// A required Chinese text with its English one. Chinese alone is DATA_FORMAT.md's own form: a warning, and the Chinese
/// stands in.
pub(crate) fn read_bilingual(
    f: &mut Fields,
    zh: &'static str,
    en: &'static str,
    r: &mut FileReport,
) -> Option<Bilingual> {
    f.need(zh, r);
    optional_bilingual(f, zh, en, r)
}

/// The same where both may be absent.
pub(crate) fn optional_bilingual(
    f: &mut Fields,
    zh: &'static str,
    en: &'static str,
    r: &mut FileReport,
) -> Option<Bilingual> {
    let zh_node = f.get(zh);
    let zh_text = zh_node.and_then(|n| r.text(n));
    let en_node = f.get(en);
    let en_text = en_node.and_then(|n| r.text(n));
    match (zh_text, en_text) {
        (Some(zh), Some(en)) => Some(Bilingual { zh, en }),
        (Some(zh_text), None) => {
            if let (Some(node), None) = (zh_node, en_node) {
                let message = Bilingual::new(
                    format!("'{zh}' 没有英文 '{en}'"),
                    format!("'{zh}' has no English '{en}' beside it"),
                );
                let hint =
                    Bilingual::new(format!("在其下补上 '{en}: …'"), format!("add '{en}: ...' below it"));
                let d = Diagnostic::warning("taxonomy.text.untranslated", message).with_hint(hint);
                r.push(d, node.mark, &node.pointer);
            }
            Some(Bilingual::same(zh_text))
        }
        (None, Some(en_text)) => Some(Bilingual::same(en_text)),
        (None, None) => None,
    }
}

fn read_conditions(f: &mut Fields, r: &mut FileReport) -> Vec<Bilingual> {
    let zh: Vec<String> = f.list("mining_conditions", r).iter().filter_map(|n| r.text(n)).collect();
    let en_node = f.get("mining_conditions_en");
    let en: Vec<String> = en_node.map_or(&[][..], |n| r.items(n)).iter().filter_map(|n| r.text(n)).collect();
    if let Some(node) = en_node.filter(|_| zh.len() != en.len()) {
        r.error(
            "taxonomy.conditions.unpaired",
            node,
            format!("mining_conditions 有 {} 条，mining_conditions_en 有 {} 条", zh.len(), en.len()),
            format!("{} mining_conditions, but {} mining_conditions_en", zh.len(), en.len()),
        );
    }
    zh.into_iter()
        .enumerate()
        .map(|(i, zh)| Bilingual { en: en.get(i).cloned().unwrap_or_else(|| zh.clone()), zh })
        .collect()
}

fn read_decisions(node: &Node, r: &mut FileReport) -> TypicalDecisions {
    let Some(mut f) = Fields::open(node, r) else { return TypicalDecisions::default() };
    let longitudinal = f.list("longitudinal", r);
    let lateral = f.list("lateral", r);
    f.close(r);
    TypicalDecisions {
        longitudinal: read_members(
            longitudinal,
            Longitudinal::from_id,
            Longitudinal::ALL.iter().map(|d| d.id()),
            r,
        ),
        lateral: read_members(lateral, Lateral::from_id, Lateral::ALL.iter().map(|d| d.id()), r),
    }
}

fn read_members<T>(
    nodes: &[Node],
    from_id: fn(&str) -> Option<T>,
    all: impl Iterator<Item = &'static str> + Clone,
    r: &mut FileReport,
) -> Vec<T> {
    let mut out = Vec::new();
    for node in nodes {
        let Some(text) = r.text(node) else { continue };
        match from_id(&text) {
            Some(member) => out.push(member),
            None => {
                let hint = match did_you_mean(&text, all.clone()) {
                    Some(near) => suggestion(near),
                    None => Bilingual::same(all.clone().collect::<Vec<_>>().join(", ")),
                };
                let message = Bilingual::new(
                    format!("驾驶决策 '{text}' 不存在"),
                    format!("driving decision '{text}' not found on this channel"),
                );
                r.push(
                    Diagnostic::error("taxonomy.decision.unknown", message).with_hint(hint),
                    node.mark,
                    &node.pointer,
                );
            }
        }
    }
    out
}
