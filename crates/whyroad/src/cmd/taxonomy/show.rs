//! `whyroad taxonomy show`.

use super::{ListingFormat, list};
use crate::{Global, framework_folder, output};
use std::fmt::Write as _;
use std::process::ExitCode;
use whyroad_framework::listing::{Detail, detail};
use whyroad_framework::spec::{BoundSpec, KeyframeSpec, MomentSpec};
use whyroad_framework::taxonomy::{Resolution, class_ambiguous, class_not_found};
use whyroad_framework::{Framework, ResolvedSpec};
use whyroad_mining::RuleSet;
use whyroad_model::{Bilingual, Lang, yaml};
use whyroad_signals::Catalog;

pub(super) fn run(global: &Global, text: &str, format: ListingFormat) -> anyhow::Result<ExitCode> {
    let (framework, found) = framework_folder::load(global)?;
    let (catalog, _) = Catalog::parse(&framework.signals_yaml);
    let problem = match framework.taxonomy.resolve(text) {
        Resolution::Found(id) => {
            if let Some(detail) = detail(&framework, &id) {
                match format {
                    ListingFormat::Json => output::put_json(&detail)?,
                    ListingFormat::Yaml => output::put(&yaml::to_string(&detail)?),
                    ListingFormat::Text => {
                        let (rules, _) = RuleSet::of_framework(&framework, &catalog);
                        let is_unusable = rules.unusable(&framework).contains(&id);
                        let page = Page { framework: &framework, lang: global.lang, is_unusable };
                        output::put(&page.render(&detail));
                    }
                }
                return Ok(list::exit_code(&found));
            }
            class_not_found(text, &[])
        }
        Resolution::Ambiguous(ids) => class_ambiguous(text, &ids),
        Resolution::Unknown(near) => {
            class_not_found(text, &near.iter().map(ToString::to_string).collect::<Vec<_>>())
        }
    };
    tell!("{}", output::render_text(&problem, global.lang));
    Ok(output::FINDINGS)
}

struct Page<'f> {
    framework: &'f Framework,
    lang: Lang,
    /// The rule of the class has an error.
    is_unusable: bool,
}

impl Page<'_> {
    fn word(&self, zh: &'static str, en: &'static str) -> &'static str {
        match self.lang {
            Lang::Zh => zh,
            Lang::En => en,
        }
    }

    fn heading(&self, out: &mut String, zh: &'static str, en: &'static str) {
        let _ = writeln!(out, "\n{}", self.word(zh, en));
    }

    /// Both languages, the reader's first.
    fn both(&self, out: &mut String, zh: &str, en: &str) {
        let (first, second) = if self.lang == Lang::Zh { (zh, en) } else { (en, zh) };
        let _ = writeln!(out, "  {first}");
        if second != first {
            let _ = writeln!(out, "  {second}");
        }
    }

    fn render(&self, d: &Detail) -> String {
        let c = &d.class;
        let (first, second) =
            if self.lang == Lang::Zh { (&c.name_zh, &c.name_en) } else { (&c.name_en, &c.name_zh) };
        let mut out = format!("{}\n  {first}  ({second})\n", c.id);
        self.heading(&mut out, "定义", "Definition");
        self.both(&mut out, &c.definition_zh, &c.definition_en);
        if let (Some(zh), Some(en)) = (&c.condition_zh, &c.condition_en) {
            self.heading(&mut out, "条件", "Condition");
            self.both(&mut out, zh, en);
        }
        if let Some(typical) = &c.typical_decisions {
            self.heading(&mut out, "典型决策", "Typical decisions");
            let name = |text: Option<&whyroad_framework::decisions::DecisionText>| {
                text.map(|t| format!(" ({})", t.name.get(self.lang))).unwrap_or_default()
            };
            let decisions = &self.framework.decisions;
            let longitudinal: Vec<String> = typical
                .longitudinal
                .iter()
                .map(|x| format!("{x}{}", name(decisions.longitudinal(*x))))
                .collect();
            let lateral: Vec<String> =
                typical.lateral.iter().map(|x| format!("{x}{}", name(decisions.lateral(*x)))).collect();
            for (word, ids) in
                [(self.word("纵向", "longitudinal"), longitudinal), (self.word("横向", "lateral"), lateral)]
            {
                if !ids.is_empty() {
                    let _ = writeln!(out, "  {word}: {}", ids.join(", "));
                }
            }
        }
        if !d.mining_conditions.is_empty() {
            self.heading(&mut out, "可观测条件", "Observable conditions");
            for m in &d.mining_conditions {
                let _ = writeln!(out, "  - {}", m.get(self.lang));
            }
        }
        if !d.decides.is_empty() {
            self.heading(&mut out, "与易混类别的判定", "What decides against neighbors");
            for b in &d.decides {
                let _ = writeln!(out, "  {} / {}", b.stated_by, b.against);
                let _ = writeln!(out, "    {}", b.rule.get(self.lang));
            }
        }
        if let Some(spec) = &d.labeling {
            self.labelling(&mut out, spec);
        }
        if c.level == "l3" || d.mining_rule.is_some() {
            self.heading(&mut out, "挖掘规则", "Mining rule");
            let _ = match &d.mining_rule {
                Some(place) if self.is_unusable => {
                    let fault = self.word("有错误，未使用", "it has an error and is not used");
                    writeln!(out, "  {}:{} ({fault})", place.file, place.line)
                }
                Some(place) => writeln!(out, "  {}:{}", place.file, place.line),
                None => writeln!(out, "  {}", self.word("尚无", "none yet")),
            };
        }
        if !d.children.is_empty() {
            let _ = writeln!(out, "\n{} ({})", self.word("下级", "Below"), d.children.len());
            let width = d.children.iter().map(|r| r.id.len()).max().unwrap_or(0);
            for r in &d.children {
                let _ = writeln!(out, "  {:width$}  {}", r.id, list::pick(self.lang, &r.name_zh, &r.name_en));
            }
        }
        out
    }

    fn labelling(&self, out: &mut String, s: &ResolvedSpec) {
        self.heading(out, "标注规格", "Labeling");
        self.keyframe(out, self.word("关键帧", "keyframe"), &s.keyframe);
        if let Some(second) = &s.second_keyframe {
            self.keyframe(out, self.word("第二关键帧", "second keyframe"), second);
        }
        self.bound(out, self.word("起始", "start"), &s.start);
        self.bound(out, self.word("结束", "end"), &s.end);
        let (before, after) = (s.pack.before_s, s.pack.after_s);
        let pack = match self.lang {
            Lang::Zh => format!("起始前 {before} s，结束后 {after} s"),
            Lang::En => format!("{before} s before the start, {after} s after the end"),
        };
        let _ = writeln!(out, "  {}: {pack}", self.word("打包", "pack"));
        if let Some(until) = &s.pack.after_until {
            self.moment(out, self.word("提前截止于", "sooner, at"), until);
        }
        for r in &s.records {
            let unit = r.unit.as_ref().map(|u| format!(" ({u})")).unwrap_or_default();
            let _ = writeln!(
                out,
                "  {}: {} - {}{unit}",
                self.word("记录", "record"),
                r.id,
                r.name.get(self.lang)
            );
        }
        if s.uncertainty_high {
            let text = self
                .word("至少一个关键要素必须标 high", "high on at least one critical component, mandatory");
            let _ = writeln!(out, "  uncertainty: {text}");
        }
        if let Some(lateral) = s.lateral {
            let _ =
                writeln!(out, "  {}: {lateral}", self.word("规定的横向决策", "prescribed lateral decision"));
        }
    }

    fn keyframe(&self, out: &mut String, word: &str, k: &KeyframeSpec) {
        let _ = writeln!(out, "  {word} ({}): {}", k.kind, k.rule.get(self.lang));
        self.expression(out, k.expr.as_deref());
        self.fallback(out, k.fallback.as_ref());
    }

    fn bound(&self, out: &mut String, word: &str, b: &BoundSpec) {
        let _ = writeln!(out, "  {word}: {}", b.rule.get(self.lang));
        self.expression(out, b.expr.as_deref());
        self.fallback(out, b.fallback.as_ref());
    }

    fn fallback(&self, out: &mut String, m: Option<&MomentSpec>) {
        if let Some(m) = m {
            self.moment(out, self.word("否则", "else"), m);
        }
    }

    fn moment(&self, out: &mut String, word: &str, m: &MomentSpec) {
        let rule: &Bilingual = &m.rule;
        let _ = writeln!(out, "    {word}: {}", rule.get(self.lang));
        self.expression(out, m.expr.as_deref());
    }

    fn expression(&self, out: &mut String, expr: Option<&str>) {
        if let Some(expr) = expr {
            let _ = writeln!(out, "      {expr}");
        }
    }
}
