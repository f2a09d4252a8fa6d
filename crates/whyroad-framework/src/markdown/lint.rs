//! Checks of a TAXONOMY.md against itself and our classes: stated numbers against listed ones, its tree against
//! its tables, its classes against the taxonomy in force.

use super::{Class, MarkdownTaxonomy, Part, Stated, Subject, read_markdown};
use crate::taxonomy::{Taxonomy, another_id, did_you_mean, suggestion};
use std::collections::BTreeMap;
use whyroad_model::{Bilingual, Diagnostic, Location, ScenarioId};

/// All inconsistencies in a TAXONOMY.md. `reference` is the taxonomy in force.
pub fn lint_markdown(file: &str, text: &str, reference: Option<&Taxonomy>) -> Vec<Diagnostic> {
    let md = read_markdown(text);
    let mut out = Vec::new();
    if md.listed.is_empty() {
        let message = Bilingual::new(
            "没有找到分类：应有形如 '## L1: 名称 (id)' 的标题",
            "no classes found: expected headings of the form '## L1: name (id)'",
        );
        out.push(Diagnostic::error("taxonomy.md.structure", message).in_file(file));
        return out;
    }
    duplicates(&md.listed, "", &mut out);
    let (l1, l2, l3) = counts(&md.listed);
    for stated in &md.stated {
        out.extend(count_differs(stated, listed_count(stated, &md.listed, (l1, l2, l3))));
    }
    if !md.tree.is_empty() {
        compare(&md.listed, &md.tree, &mut out, tree_differs);
    }
    if let Some(reference) = reference {
        against_reference(&md, reference, &mut out);
    }
    for d in &mut out {
        d.location.file = Some(file.to_owned());
    }
    out.sort_by_key(|d| (d.location.line, d.location.column));
    out
}

fn counts(classes: &[Class]) -> (usize, usize, usize) {
    let l2 = classes.iter().map(|a| a.children.len()).sum();
    let l3 = classes.iter().flat_map(|a| &a.children).map(|b| b.children.len()).sum();
    (classes.len(), l2, l3)
}

/// The number in the tables that corresponds to `stated`; `None` when its class is not listed at all.
fn listed_count(stated: &Stated, listed: &[Class], whole: (usize, usize, usize)) -> Option<usize> {
    let pick = |(l1, l2, l3): (usize, usize, usize)| match stated.level {
        1 => l1,
        2 => l2,
        _ => l3,
    };
    match &stated.subject {
        Subject::Whole => Some(pick(whole)),
        Subject::L1(id) => {
            listed.iter().find(|a| a.id.text == *id).map(|a| pick(counts(std::slice::from_ref(a))))
        }
        Subject::L2(l1, l2) => {
            let a = listed.iter().find(|a| a.id.text == *l1)?;
            a.children.iter().find(|b| b.id.text == *l2).map(|b| b.children.len())
        }
    }
}

fn count_differs(stated: &Stated, listed: Option<usize>) -> Option<Diagnostic> {
    let listed = listed.filter(|n| *n != stated.number)?;
    let part = match stated.part {
        Part::Header => Bilingual::new("文件头", "the header"),
        Part::Statistics => Bilingual::new("统计表", "the statistics table"),
        Part::Tree => Bilingual::new("树状图", "the tree"),
    };
    let of = match &stated.subject {
        Subject::Whole => Bilingual::new("全部", "in all"),
        Subject::L1(id) => Bilingual::new(format!("'{id}' 之下"), format!("under '{id}'")),
        Subject::L2(l1, l2) => Bilingual::new(format!("'{l1}.{l2}' 之下"), format!("under '{l1}.{l2}'")),
    };
    let (level, number) = (stated.level, stated.number);
    let message = Bilingual::new(
        format!("{}写明{}有 {number} 个 L{level}，各表实际列出 {listed} 个", part.zh, of.zh),
        format!("{} states {number} L{level} {}, the tables list {listed}", part.en, of.en),
    );
    let hint = Bilingual::new(
        format!("改为 {listed}；数量应由程序计算"),
        format!("make it {listed}; counts are best computed, not typed"),
    );
    Some(Diagnostic::error("taxonomy.md.count", message).with_hint(hint).at(stated.place.clone()))
}

fn duplicates(classes: &[Class], prefix: &str, out: &mut Vec<Diagnostic>) {
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    for c in classes {
        let full = format!("{prefix}{}", c.id.text);
        if let Some(line) = seen.insert(&c.id.text, c.id.place.line.unwrap_or(0)) {
            let message = Bilingual::new(
                format!("'{full}' 重复，首次出现在第 {line} 行"),
                format!("'{full}' is listed twice, first on line {line}"),
            );
            let d = Diagnostic::error("taxonomy.id.duplicate", message).with_hint(another_id());
            out.push(d.at(c.id.place.clone()));
        }
        duplicates(&c.children, &format!("{full}."), out);
    }
}

/// Which of the two lists has a class that the other lacks.
enum OnlyIn {
    First,
    Second,
}

/// Calls `say` for every class that one list has and the other lacks; but not again for classes below such a class.
fn compare(
    a: &[Class],
    b: &[Class],
    out: &mut Vec<Diagnostic>,
    say: fn(&str, &Location, OnlyIn) -> Diagnostic,
) {
    let mut todo = vec![(String::new(), a, b)];
    while let Some((prefix, a, b)) = todo.pop() {
        for x in a {
            let full = format!("{prefix}{}", x.id.text);
            match b.iter().find(|y| y.id.text == x.id.text) {
                Some(y) => todo.push((format!("{full}."), &x.children, &y.children)),
                None => out.push(say(&full, &x.id.place, OnlyIn::First)),
            }
        }
        for y in b.iter().filter(|y| !a.iter().any(|x| x.id.text == y.id.text)) {
            out.push(say(&format!("{prefix}{}", y.id.text), &y.id.place, OnlyIn::Second));
        }
    }
}

fn tree_differs(full: &str, place: &Location, only: OnlyIn) -> Diagnostic {
    let message = match only {
        OnlyIn::First => Bilingual::new(
            format!("'{full}' 列在表中，但树状图里没有"),
            format!("'{full}' is in the tables but not in the tree"),
        ),
        OnlyIn::Second => Bilingual::new(
            format!("'{full}' 出现在树状图里，但表中没有"),
            format!("'{full}' is in the tree but not in the tables"),
        ),
    };
    Diagnostic::error("taxonomy.md.tree", message).at(place.clone())
}

fn against_reference(md: &MarkdownTaxonomy, reference: &Taxonomy, out: &mut Vec<Diagnostic>) {
    let ours: Vec<(ScenarioId, &str)> = names(reference);
    let theirs = md.to_taxonomy();
    let theirs: Vec<(ScenarioId, &str)> = names(&theirs);
    let places = places(&md.listed);
    for (id, name) in &theirs {
        let place = places.get(&id.to_string()).cloned().unwrap_or_default();
        match ours.iter().find(|(o, _)| o == id) {
            None => {
                let message = Bilingual::new(
                    format!("'{id}' 不在当前分类体系中"),
                    format!("'{id}' is not in the taxonomy in force"),
                );
                let mut d = Diagnostic::error("taxonomy.md.class", message).at(place);
                let known: Vec<String> = ours.iter().map(|(o, _)| o.to_string()).collect();
                if let Some(near) = did_you_mean(&id.to_string(), known.iter().map(String::as_str)) {
                    d = d.with_hint(suggestion(near));
                }
                out.push(d);
            }
            Some((_, ours)) if !name.is_empty() && ours != name => {
                let message = Bilingual::new(
                    format!("'{id}' 在此名为“{name}”，当前分类体系中名为“{ours}”"),
                    format!("'{id}' is named '{name}' here and '{ours}' in the taxonomy in force"),
                );
                out.push(Diagnostic::warning("taxonomy.md.name", message).at(place));
            }
            Some(_) => {}
        }
    }
    for (id, _) in ours.iter().filter(|(o, _)| !theirs.iter().any(|(t, _)| t == o)) {
        let message = Bilingual::new(
            format!("当前分类体系中的 '{id}' 没有列出"),
            format!("'{id}' of the taxonomy in force is not listed"),
        );
        out.push(Diagnostic::error("taxonomy.md.class", message));
    }
}

fn names(t: &Taxonomy) -> Vec<(ScenarioId, &str)> {
    let mut out = Vec::new();
    for a in &t.l1 {
        out.push((ScenarioId { l1: a.id.clone(), l2: None, l3: None }, a.name.zh.as_str()));
        for b in &a.l2 {
            out.push((ScenarioId { l1: a.id.clone(), l2: Some(b.id.clone()), l3: None }, b.name.zh.as_str()));
            out.extend(b.l3.iter().map(|c| (ScenarioId::leaf(&a.id, &b.id, &c.id), c.name.zh.as_str())));
        }
    }
    out
}

fn places(classes: &[Class]) -> BTreeMap<String, Location> {
    let mut out = BTreeMap::new();
    for a in classes {
        out.insert(a.id.text.clone(), a.id.place.clone());
        for b in &a.children {
            out.insert(format!("{}.{}", a.id.text, b.id.text), b.id.place.clone());
            for c in &b.children {
                out.insert(format!("{}.{}.{}", a.id.text, b.id.text, c.id.text), c.id.place.clone());
            }
        }
    }
    out
}
