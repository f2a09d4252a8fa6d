//! The generated parts of `docs/reference/SPEC.md`: the decision tables and the labeling of every L2. They are between
//! `<!-- generated: NAME -->` and `<!-- end generated -->`; the rest of the page is written by hand.

use super::cell;
use crate::decisions::DecisionText;
use crate::spec::{BoundSpec, KeyframeSpec, MomentSpec, PackSpec, RecordSpec};
use crate::{Framework, L1, L2, ResolvedSpec};
use std::fmt::Write as _;
use whyroad_model::decision::LateralDirection;
use whyroad_model::{Bilingual, Lang, ScenarioId};

const END: &str = "<!-- end generated -->";

/// `page` with its generated parts updated, or the marker that is missing.
pub fn fill_spec_page(f: &Framework, page: &str) -> Result<String, String> {
    let mut out = page.to_owned();
    for (name, text) in [
        ("longitudinal decisions", longitudinal(f)),
        ("lateral decisions", lateral(f)),
        ("no decision", no_decision(f)),
        ("labelling", labelling(f)),
    ] {
        let marker = format!("<!-- generated: {name} -->\n");
        let start = out.find(&marker).ok_or_else(|| marker.trim().to_owned())? + marker.len();
        let end = out[start..].find(END).ok_or_else(|| END.to_owned())? + start;
        // Blank lines, or a table or heading would be parsed as part of the comment.
        let text = super::wrap::wrap_page(&text);
        out.replace_range(start..end, &format!("\n{}\n\n", text.trim_end_matches('\n')));
    }
    Ok(out)
}

fn longitudinal(f: &Framework) -> String {
    let rows: Vec<(&str, &DecisionText)> =
        f.decisions.longitudinal.iter().map(|d| (d.id.id(), &d.text)).collect();
    let mut out = "| id | 名称 | 含义 | 不要混淆 |\n|---|---|---|---|\n".to_owned();
    for (id, d) in &rows {
        let _ = writeln!(out, "| `{id}` | {} |", words(d, Lang::Zh));
    }
    out += "\n| id | Name | Meaning | Not to be confused | AR1 table 1 |\n|---|---|---|---|---|\n";
    for (id, d) in &rows {
        let _ = writeln!(out, "| `{id}` | {} | {} |", words(d, Lang::En), ar1(d));
    }
    out
}

fn lateral(f: &Framework) -> String {
    let mut out = "| id | 名称 | 含义 | 不要混淆 | 方向 |\n|---|---|---|---|---|\n".to_owned();
    for d in &f.decisions.lateral {
        let (words, sides) = (words(&d.text, Lang::Zh), sides(&d.directions, Lang::Zh));
        let _ = writeln!(out, "| `{}` | {words} | {sides} |", d.id);
    }
    out += "\n| id | Name | Meaning | Not to be confused | Direction | AR1 table 1 |\n|---|---|---|---|---|---|\n";
    for d in &f.decisions.lateral {
        let (words, sides) = (words(&d.text, Lang::En), sides(&d.directions, Lang::En));
        let _ = writeln!(out, "| `{}` | {words} | {sides} | {} |", d.id, ar1(&d.text));
    }
    out
}

fn sides(directions: &[LateralDirection], lang: Lang) -> String {
    let name = |d: &LateralDirection| match (lang, d) {
        (Lang::En, d) => d.id(),
        (Lang::Zh, LateralDirection::Left) => "左",
        (Lang::Zh, LateralDirection::Right) => "右",
        (Lang::Zh, LateralDirection::Uturn) => "掉头",
    };
    let names: Vec<&str> = directions.iter().map(name).collect();
    match lang {
        Lang::Zh if names.is_empty() => "无".to_owned(),
        Lang::En if names.is_empty() => "none".to_owned(),
        Lang::Zh => names.join("、"),
        Lang::En => names.join(", "),
    }
}

/// Three cells: name, meaning, similar decisions.
fn words(d: &DecisionText, lang: Lang) -> String {
    let not = d.not.as_ref().map(|n| n.get(lang)).unwrap_or_default();
    [d.name.get(lang), d.meaning.get(lang), not].map(cell).join(" | ")
}

fn ar1(d: &DecisionText) -> String {
    d.ar1.as_deref().map_or_else(|| "—".to_owned(), cell)
}

fn no_decision(f: &Framework) -> String {
    let d = &f.decisions.null_decision;
    let not = d.not.clone().unwrap_or_default();
    format!("{}{}\n\n*{} {}*\n", d.meaning.zh, not.zh, d.meaning.en, not.en)
}

fn labelling(f: &Framework) -> String {
    let mut out = String::new();
    for l1 in &f.taxonomy.l1 {
        let _ = writeln!(out, "---\n\n**`{}` {} · {}**\n", l1.id, l1.name.zh, l1.name.en);
        for l2 in &l1.l2 {
            let (zh, en) = (&l2.name.zh, &l2.name.en);
            let _ = writeln!(out, "### {}\n\n**{zh} · {en}** (`{}.{}`)\n", l2.id, l1.id, l2.id);
            for lang in [Lang::Zh, Lang::En] {
                section(f, l1, l2, lang, &mut out);
                out.push('\n');
            }
        }
    }
    out
}

fn section(f: &Framework, l1: &L1, l2: &L2, lang: Lang, out: &mut String) {
    let s = Say { lang };
    let mut line = |text: String| {
        let _ = writeln!(out, "- {text}");
    };
    if let Some(condition) = &l2.condition {
        line(s.field("触发", "Trigger", condition.get(lang)));
    }
    let id = ScenarioId { l1: l1.id.clone(), l2: Some(l2.id.clone()), l3: None };
    let whole = f.l2_specs.get(&id);
    if let Some(spec) = whole {
        s.differences(None, spec).into_iter().for_each(&mut line);
    }
    let mut differing = Vec::new();
    for l3 in &l2.l3 {
        let leaf = f.specs.get(&ScenarioId::leaf(&l1.id, &l2.id, &l3.id));
        let parts = leaf.map(|leaf| s.differences(whole, leaf)).unwrap_or_default();
        if !parts.is_empty() {
            let colon = s.pick("：", ": ");
            differing.push(format!("  - `{}`{colon}{}", l3.id, parts.join(s.pick("；", "; "))));
        }
    }
    if !differing.is_empty() {
        line(format!("{}\n{}", s.pick("各变体另有规定：", "Variants that differ:"), differing.join("\n")));
    }
    let variants: Vec<String> =
        l2.l3.iter().map(|c| format!("`{}` {}", c.id, c.condition.get(lang))).collect();
    line(s.field("变体", "Variants", &variants.join(s.pick("；", "; "))));
    // An L1's defaults apply to its L2s unchanged; the page states where nothing differs.
    let default = f.l1_specs.get(&ScenarioId { l1: l1.id.clone(), l2: None, l3: None });
    if differing.is_empty()
        && let (Some(default), Some(whole)) = (default, whole)
        && s.differences(Some(default), whole).is_empty()
    {
        line(s.pick("全部取 L1 默认值。", "All of it is the L1 default.").to_owned());
    }
}

/// Specs as text in one language.
struct Say {
    lang: Lang,
}

impl Say {
    fn pick<'t>(&self, zh: &'t str, en: &'t str) -> &'t str {
        if self.lang == Lang::Zh { zh } else { en }
    }

    fn field(&self, zh: &str, en: &str, text: &str) -> String {
        format!("{}{}{text}", self.pick(zh, en), self.pick("：", ": "))
    }

    /// The content of `spec`, or its differences from `upper`: one text per field, each field in full.
    fn differences(&self, upper: Option<&ResolvedSpec>, spec: &ResolvedSpec) -> Vec<String> {
        let mut out = Vec::new();
        if upper.is_none_or(|u| self.keyframe(&u.keyframe) != self.keyframe(&spec.keyframe)) {
            out.push(self.field("关键帧", "Keyframe", &self.keyframe(&spec.keyframe)));
        }
        if let Some(second) = &spec.second_keyframe
            && upper.is_none_or(|u| u.second_keyframe != spec.second_keyframe)
        {
            out.push(self.field("第二关键帧", "Second keyframe", &self.keyframe(second)));
        }
        if upper.is_none_or(|u| self.bound(&u.start) != self.bound(&spec.start)) {
            out.push(self.field("起点", "Start", &self.bound(&spec.start)));
        }
        if upper.is_none_or(|u| self.bound(&u.end) != self.bound(&spec.end)) {
            out.push(self.field("终点", "End", &self.bound(&spec.end)));
        }
        if upper.is_none_or(|u| u.pack != spec.pack) {
            out.push(self.field("打包", "Pack", &self.pack(&spec.pack)));
        }
        let known = upper.map(|u| u.records.as_slice()).unwrap_or_default();
        let records: Vec<String> =
            spec.records.iter().filter(|r| !known.contains(r)).map(|r| self.record(r)).collect();
        if !records.is_empty() {
            out.push(self.field("必填记录", "Required records", &records.join(self.pick("、", ", "))));
        }
        let demanded = upper.is_some_and(|u| u.uncertainty_high);
        if spec.uncertainty_high && !demanded {
            let text = self.pick("至少一个关键要素必须为 `high`", "at least one component must be `high`");
            out.push(self.field("不确定性", "Uncertainty", text));
        } else if demanded && !spec.uncertainty_high {
            out.push(self.field("不确定性", "Uncertainty", self.pick("不作要求", "nothing is demanded")));
        }
        if let Some(lateral) = spec.lateral
            && upper.is_none_or(|u| u.lateral != Some(lateral))
        {
            let text = format!("{} `{lateral}`", self.pick("必须为", "must be"));
            out.push(self.field("横向决策", "Lateral decision", &text));
        }
        out
    }

    fn keyframe(&self, k: &KeyframeSpec) -> String {
        let fallback = self.fallback(&k.rule, k.fallback.as_ref());
        format!("`{}`{}{}{fallback}", k.kind, self.pick("，", ", "), k.rule.get(self.lang))
    }

    fn bound(&self, b: &BoundSpec) -> String {
        let fallback = self.fallback(&b.rule, b.fallback.as_ref());
        format!("{}{fallback}", b.rule.get(self.lang))
    }

    /// An inherited fallback that repeats the rule is left out.
    fn fallback(&self, rule: &Bilingual, fallback: Option<&MomentSpec>) -> String {
        let Some(other) = fallback.map(|m| &m.rule).filter(|other| *other != rule) else {
            return String::new();
        };
        match self.lang {
            Lang::Zh => format!("（后备：{}）", other.zh),
            Lang::En => format!(" (fallback: {})", other.en),
        }
    }

    fn pack(&self, p: &PackSpec) -> String {
        let (before, after) = (p.before_s, p.after_s);
        let plain = match self.lang {
            Lang::Zh => format!("前 {before} s，后 {after} s"),
            Lang::En => format!("{before} s before, {after} s after"),
        };
        let Some(until) = &p.after_until else { return plain };
        match self.lang {
            Lang::Zh => format!("{plain}（或{}）", until.rule.zh),
            Lang::En => format!("{plain} (or {})", until.rule.en),
        }
    }

    fn record(&self, r: &RecordSpec) -> String {
        let unit = r.unit.as_ref().map(|u| format!(" ({u})")).unwrap_or_default();
        let choices: Vec<String> =
            r.choices.iter().map(|c| format!("{} `{}`", c.name.get(self.lang), c.id)).collect();
        let choices = match (choices.is_empty(), self.lang) {
            (true, _) => String::new(),
            (_, Lang::Zh) => format!("：{}", choices.join("、")),
            (_, Lang::En) => format!(": {}", choices.join(", ")),
        };
        let signal = r.signal.as_ref().map(|s| format!(" ← `{s}`")).unwrap_or_default();
        format!("{} `{}`{unit}{signal}{choices}", r.name.get(self.lang), r.id)
    }
}
