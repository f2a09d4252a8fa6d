//! Files of `docs/reference/leaves/` and the index above them.

use super::cases::{self, ClassCases};
use super::sources::Sources;
use super::{GENERATED, cell, ending, leaf, say, title};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use whyroad_framework::Framework;
use whyroad_mining::RuleSet;
use whyroad_mining::cases::drawing::drawn;
use whyroad_model::{Bilingual, Lang, ScenarioId};
use whyroad_signals::Catalog;

/// Path below `docs/reference/` and text of: a page in each language and a drawing for every leaf, and the index.
/// `files` are the framework's, among them the cases beside the rules.
pub(in crate::cmd::taxonomy) fn pages(
    framework: &Framework,
    catalog: &Catalog,
    files: &BTreeMap<String, String>,
) -> Result<BTreeMap<String, String>, Bilingual> {
    let rules = RuleSet::of_framework(framework, catalog).0;
    let mut all = Vec::new();
    for (_, text) in files.iter().filter(|(name, _)| name.ends_with(".cases.yaml")) {
        all.extend(drawn(text, &rules.rules, catalog)?);
    }
    let sources = Sources { framework, catalog, rules, cases: cases::by_class(all) };
    let mut out = BTreeMap::new();
    for (l1, l2, l3) in framework.taxonomy.leaves() {
        let id = ScenarioId::leaf(&l1.id, &l2.id, &l3.id);
        for lang in [Lang::En, Lang::Zh] {
            out.insert(format!("leaves/{id}{}", ending(lang)), leaf::page(&sources, (l1, l2, l3), lang));
        }
        if let Some(svg) = sources.cases.get(&id).and_then(ClassCases::svg) {
            out.insert(format!("leaves/{id}.svg"), svg);
        }
    }
    for lang in [Lang::En, Lang::Zh] {
        out.insert(format!("leaves{}", ending(lang)), index(framework, lang));
    }
    Ok(out)
}

/// All leaves by L2 with their conditions.
fn index(framework: &Framework, lang: Lang) -> String {
    let (other, name) = match lang {
        Lang::En => ("leaves.zh.md", "中文"),
        Lang::Zh => ("leaves.md", "English"),
    };
    let mut out = format!(
        "{GENERATED}\n\n# {}\n\n[{name}]({other})\n\n{}\n",
        say(lang, "All leaves", "全部 L3 场景"),
        say(
            lang,
            "One page per leaf: definition, keyframe, rule, parameters, needed signals, cases, confusable classes.",
            "每个 L3 场景一页：定义、关键帧、规则、参数、所需信号、用例、易混场景。"
        )
    );
    for l1 in &framework.taxonomy.l1 {
        let _ = writeln!(out, "\n## {} (`{}`)", l1.name.get(lang), l1.id);
        for l2 in &l1.l2 {
            let _ = writeln!(out, "\n### {}\n\n`{}.{}`\n", title(&l2.name, lang), l1.id, l2.id);
            out.push_str(say(lang, "| leaf | name | condition |\n", "| L3 | 名称 | 条件 |\n"));
            out.push_str("|---|---|---|\n");
            for l3 in &l2.l3 {
                let page = format!("leaves/{}.{}.{}{}", l1.id, l2.id, l3.id, ending(lang));
                let (name, condition) = (cell(l3.name.get(lang)), cell(l3.condition.get(lang)));
                let _ = writeln!(out, "| [`{}`]({page}) | {name} | {condition} |", l3.id);
            }
        }
    }
    out
}
