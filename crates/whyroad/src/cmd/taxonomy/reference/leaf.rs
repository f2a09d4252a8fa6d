//! The page of one leaf in one language.

use super::sources::Sources;
use super::{GENERATED, cell, ending, say, title};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use whyroad_framework::docs::wrap::wrap;
use whyroad_framework::spec::MomentSpec;
use whyroad_framework::{Framework, L1, L2, L3, ResolvedSpec};
use whyroad_mining::rule::sheet::RuleSheet;
use whyroad_model::{Bilingual, Lang, Need, ScenarioId};

pub(super) fn page(s: &Sources<'_>, (l1, l2, l3): (&L1, &L2, &L3), lang: Lang) -> String {
    let id = ScenarioId::leaf(&l1.id, &l2.id, &l3.id);
    let mut p = Page { s, id: &id, lang, out: String::new() };
    let other = match lang {
        Lang::En => format!("[中文]({id}.zh.md)"),
        Lang::Zh => format!("[English]({id}.md)"),
    };
    let _ = write!(p.out, "{GENERATED}\n\n# {}\n\n`{id}`\n\n{other}\n\n", title(&l3.name, lang));
    let above = format!(
        "{} [{}](../TAXONOMY.md#l2-{}) ({})",
        say(lang, "Variant of", "所属 L2："),
        l2.name.get(lang),
        l2.id,
        l1.name.get(lang)
    );
    p.paragraph(&above);
    p.heading("Definition", "定义");
    p.paragraph(l3.definition.get(lang));
    p.field("Condition", "条件", l3.condition.get(lang));
    let observable =
        if l3.mining_conditions.is_empty() { &l2.mining_conditions } else { &l3.mining_conditions };
    if !observable.is_empty() {
        let each: Vec<&str> = observable.iter().map(|m| m.get(lang)).collect();
        p.field("Observable conditions", "可观测条件", &each.join(say(lang, "; ", "；")));
    }
    let typical = &l3.typical_decisions;
    let ids = typical.longitudinal.iter().map(|d| d.id()).chain(typical.lateral.iter().map(|d| d.id()));
    let ids: Vec<String> = ids.map(|d| format!("`{d}`")).collect();
    if !ids.is_empty() {
        p.field("Typical decisions", "典型决策", &ids.join(", "));
    }
    if let Some(spec) = s.framework.specs.get(&id) {
        p.labelling(spec);
    }
    p.rule(l2);
    p.signals();
    p.cases();
    p.confusable();
    p.out
}

struct Page<'a> {
    s: &'a Sources<'a>,
    id: &'a ScenarioId,
    lang: Lang,
    out: String,
}

impl Page<'_> {
    fn say(&self, en: &'static str, zh: &'static str) -> &'static str {
        say(self.lang, en, zh)
    }

    fn heading(&mut self, en: &'static str, zh: &'static str) {
        let _ = write!(self.out, "## {}\n\n", self.say(en, zh));
    }

    fn paragraph(&mut self, text: &str) {
        let _ = write!(self.out, "{}\n\n", wrap(text, "", ""));
    }

    fn field(&mut self, en: &'static str, zh: &'static str, text: &str) {
        let text = format!("**{}**{}{text}", self.say(en, zh), self.say(": ", "："));
        self.paragraph(&text);
    }

    fn labelling(&mut self, spec: &ResolvedSpec) {
        self.heading("Keyframe and time range", "关键帧与时间范围");
        let head = self.say(
            "| moment | rule | expression | otherwise |\n|---|---|---|---|\n",
            "| 时刻 | 规则 | 表达式 | 否则 |\n|---|---|---|---|\n",
        );
        self.out.push_str(head);
        let keyframes = [
            (self.say("keyframe", "关键帧"), Some(&spec.keyframe)),
            (self.say("second keyframe", "第二关键帧"), spec.second_keyframe.as_ref()),
        ];
        for (name, k) in keyframes.into_iter().filter_map(|(name, k)| Some((name, k?))) {
            self.moment(&format!("{name} (`{}`)", k.kind), &k.rule, k.expr.as_deref(), k.fallback.as_ref());
        }
        for (name, b) in [(self.say("start", "起始"), &spec.start), (self.say("end", "结束"), &spec.end)]
        {
            self.moment(name, &b.rule, b.expr.as_deref(), b.fallback.as_ref());
        }
        self.out.push('\n');
        let (before, after) = (spec.pack.before_s, spec.pack.after_s);
        let mut context = match self.lang {
            Lang::En => format!("{before} s before the start, {after} s after the end"),
            Lang::Zh => format!("起始前 {before} s，结束后 {after} s"),
        };
        if let Some(until) = &spec.pack.after_until {
            let rule = until.rule.get(self.lang);
            let _ = write!(context, "{}{rule}", self.say("; ends sooner if ", "；提前截止于："));
        }
        self.field("Context", "上下文", &context);
        let records: Vec<String> = spec
            .records
            .iter()
            .map(|r| {
                let unit = r.unit.as_ref().map(|u| format!(" ({u})")).unwrap_or_default();
                format!("`{}`{}{}{unit}", r.id, self.say(": ", "："), r.name.get(self.lang))
            })
            .collect();
        if !records.is_empty() {
            self.field("Required records", "必填记录", &records.join(self.say("; ", "；")));
        }
        if let Some(lateral) = spec.lateral {
            self.field("Prescribed lateral decision", "规定的横向决策", &format!("`{lateral}`"));
        }
        if spec.uncertainty_high {
            let text = self.say("`high` on at least one critical component", "至少一个关键要素须为 `high`");
            self.field("Uncertainty", "不确定度", text);
        }
    }

    fn moment(&mut self, name: &str, rule: &Bilingual, expr: Option<&str>, fallback: Option<&MomentSpec>) {
        let code = |e: Option<&str>| e.map(|e| format!("`{}`", cell(e))).unwrap_or_default();
        let otherwise = fallback.map(|f| {
            let expr = code(f.expr.as_deref());
            format!("{}{}{expr}", cell(f.rule.get(self.lang)), if expr.is_empty() { "" } else { "<br>" })
        });
        let (rule, expr) = (cell(rule.get(self.lang)), code(expr));
        let _ = writeln!(self.out, "| {name} | {rule} | {expr} | {} |", otherwise.unwrap_or_default());
    }

    fn rule(&mut self, l2: &L2) {
        self.heading("Mining rule", "挖掘规则");
        let Some(sheet) = RuleSheet::of(self.s.framework, self.id) else {
            let none = self.say("No rule is written yet.", "尚无规则。");
            return self.paragraph(none);
        };
        let path = Framework::spec_path(&self.id.l1, &l2.id);
        let source = format!(
            "{} [{path}](../../../{path}){} [{}](../rules{}){}",
            self.say("From", "来自"),
            self.say(", in the", "，写法见"),
            self.say("rule language", "规则语言"),
            ending(self.lang),
            self.say(".", "。")
        );
        self.paragraph(&source);
        self.out.push_str("```yaml\n");
        if let Some(target) = &sheet.target {
            let _ = writeln!(self.out, "target: {target}");
        }
        self.block("roles", &sheet.roles);
        self.list("when", &sheet.when);
        self.list("require", &sheet.require);
        self.list("response", &sheet.response);
        for (name, value) in &sheet.durations {
            let _ = writeln!(self.out, "{name}: {value}");
        }
        self.block("define", &sheet.define);
        self.out.push_str("```\n\n");
        if sheet.parameters.is_empty() {
            return;
        }
        self.heading("Parameters", "参数");
        let head = self.say(
            "| name | value | reason |\n|---|---|---|\n",
            "| 名称 | 取值 | 理由（原文） |\n|---|---|---|\n",
        );
        self.out.push_str(head);
        for p in &sheet.parameters {
            let _ = writeln!(self.out, "| `{}` | {} | {} |", p.name, cell(&p.value), cell(&p.reason));
        }
        self.out.push('\n');
    }

    fn block(&mut self, key: &str, entries: &[(String, String)]) {
        if !entries.is_empty() {
            let _ = writeln!(self.out, "{key}:");
        }
        for (name, text) in entries {
            let _ = writeln!(self.out, "  {name}: {text}");
        }
    }

    fn list(&mut self, key: &str, texts: &[String]) {
        match texts {
            [] => {}
            [one] => {
                let _ = writeln!(self.out, "{key}: {one}");
            }
            all => {
                let _ = writeln!(self.out, "{key}:");
                for text in all {
                    let _ = writeln!(self.out, "  - {text}");
                }
            }
        }
    }

    fn signals(&mut self) {
        let Some(rule) = self.s.rules.rules.iter().find(|r| r.scenario == *self.id) else { return };
        self.heading("Signals", "信号");
        let needs = rule.needs();
        let text = self.say(
            "Without a signal marked *needed*, the leaf is not observable. Full definitions: [signals](../signals.md).",
            "缺少标为“必需”的信号时，该场景不可观测。完整定义见[信号](../signals.md)。",
        );
        self.paragraph(text);
        let head = self.say(
            "| signal | unit | meaning | the log must have | |\n|---|---|---|---|---|\n",
            "| 信号 | 单位 | 含义 | 日志须有 | |\n|---|---|---|---|---|\n",
        );
        self.out.push_str(head);
        for name in rule.signals() {
            let Some(def) = self.s.catalog.get(&name) else { continue };
            let log = Need::list(&def.needs, self.lang);
            let needed = if needs.contains(&name) { self.say("needed", "必需") } else { "" };
            let (meaning, unit) = (cell(def.meaning.get(self.lang)), def.unit_symbol());
            let _ = writeln!(self.out, "| `{name}` | {unit} | {meaning} | {log} | {needed} |");
        }
        self.out.push('\n');
    }

    fn cases(&mut self) {
        let Some(cases) = self.s.cases.get(self.id) else { return };
        self.heading("Cases", "用例");
        let text = self.say(
            "Short traces by hand that the rule is tested on. Drawn are the first of each kind: the expected time range \
             is shaded, the keyframe is the red line, a gap is unknown, a dotted line is infinite. Signals that stay \
             constant are left out.",
            "检验规则的手写信号轨迹。每种取第一个画出：底色为应得的时间范围，红线为关键帧，空白为未知，虚线为无穷大；不变的信号从略。用例名称为英文原文。",
        );
        self.paragraph(text);
        let _ =
            write!(self.out, "![{}]({}.svg)\n\n", self.say("Cases of this leaf", "该场景的用例"), self.id);
        let table = cases.table(self.lang);
        self.out.push_str(&table);
        self.out.push('\n');
    }

    /// Classes that overlap this one; either of the two may state the rule.
    fn confusable(&mut self) {
        let mut others: Vec<(&Bilingual, Vec<ScenarioId>)> = Vec::new();
        for l1 in &self.s.framework.taxonomy.l1 {
            for l2 in &l1.l2 {
                let l2_id = ScenarioId { l1: l1.id.clone(), l2: Some(l2.id.clone()), l3: None };
                let leaves = l2.l3.iter().map(|c| (ScenarioId::leaf(&l1.id, &l2.id, &c.id), &c.decides));
                for (stated_by, rules) in std::iter::once((l2_id, &l2.decides)).chain(leaves) {
                    for d in rules {
                        let other = match (self.id.is_within(&stated_by), self.id.is_within(&d.against)) {
                            (true, false) => d.against.clone(),
                            (false, true) => stated_by.clone(),
                            _ => continue,
                        };
                        match others.iter_mut().find(|(rule, _)| **rule == d.rule) {
                            Some((_, ids)) if ids.contains(&other) => {}
                            Some((_, ids)) => ids.push(other),
                            None => others.push((&d.rule, vec![other])),
                        }
                    }
                }
            }
        }
        if others.is_empty() {
            self.out.truncate(self.out.trim_end_matches('\n').len() + 1);
            return;
        }
        self.heading("Confusable classes", "易混场景");
        let head = self.say("| class | what decides |\n|---|---|\n", "| 场景 | 判定 |\n|---|---|\n");
        self.out.push_str(head);
        for (rule, ids) in others {
            let links: BTreeMap<String, String> = ids.iter().map(|o| (o.to_string(), self.link(o))).collect();
            let links: Vec<String> = links.into_values().collect();
            let _ = writeln!(self.out, "| {} | {} |", links.join("<br>"), cell(rule.get(self.lang)));
        }
    }

    fn link(&self, class: &ScenarioId) -> String {
        match (&class.l3, &class.l2) {
            (Some(_), _) => format!("[`{class}`]({class}{})", ending(self.lang)),
            (None, Some(l2)) => format!("[`{class}`](../TAXONOMY.md#l2-{l2})"),
            (None, None) => format!("`{class}`"),
        }
    }
}
