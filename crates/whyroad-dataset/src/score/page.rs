//! The score as one HTML page, legible without scripts: both languages, tables, and a chart that needs no color.

use super::figures::{ClassFigures, Figures};
use super::resample::Estimate;
use super::{Score, Target};
use std::collections::BTreeMap;
use whyroad_model::{Bilingual, Lang, counted};
use whyroad_render::language::LANGUAGE_SCRIPT;
use whyroad_render::markup::Markup;

// Intervals are below their values, so that nine columns fit on a screen and on paper. Charts are black on white.
const STYLE: &str = "<style>:root{color-scheme:light dark}body{font:15px/1.5 system-ui,sans-serif;margin:2em auto;max-width:75em;padding:0 1em}\
table{border-collapse:collapse;margin:.5em 0 2em;display:block;width:max-content;max-width:100%;overflow-x:auto}th,td{border-bottom:1px solid #999;padding:.2em .7em;text-align:right;white-space:nowrap;\
font-variant-numeric:tabular-nums}th:first-child,td:first-child{text-align:left}td small{display:block}small{opacity:.75}svg{max-width:100%;background:#fff}\
body:has(#zh:checked) span[lang=en],body:has(#en:checked) span[lang=zh]{display:none}\
@media print{:root{color-scheme:light}.choose{display:none}body{font-size:11px;margin:0}tr,svg{break-inside:avoid}}</style>";

/// The page; `lang` is shown first.
pub fn page(score: &Score, lang: Lang) -> String {
    let mut m = start("评分", "Score", lang);
    m.raw("<h1>").say("模型评分", "Model score").raw("</h1><p>").text(&score.release).raw(" · ");
    m.text(score.split.name()).raw(" · ");
    sizes(&mut m, score.samples, score.drives);
    m.say("，有预测的样本：", ", samples with a prediction: ").int(score.predicted).raw("</p><p><small>");
    m.say("区间为 95 %，按行程重采样 ", "Intervals: 95 %, bootstrap over drives, ").int(score.resamples);
    m.say(" 次，随机种子 ", " resamples, seed ").int(score.seed);
    m.say("。缺少预测的样本按错误计。", ". A sample without a prediction counts as wrong.")
        .raw("</small></p>");
    m.raw("<h2>").say("总体", "Overall").raw("</h2>");
    table(&mut m, [("all".to_owned(), &score.overall)].into_iter());
    for (target, of) in &score.classes {
        classes(&mut m, *target, of);
    }
    let name = |by: &BTreeMap<String, Figures>| by.keys().cloned().collect::<Vec<_>>();
    m.raw("<h2>").say("按 L3 场景", "By leaf").raw("</h2>");
    whiskers(&mut m, &score.by_leaf);
    table(&mut m, name(&score.by_leaf).into_iter().zip(score.by_leaf.values()));
    m.raw("<h2>").say("按地点", "By place").raw("</h2>");
    table(&mut m, name(&score.by_place).into_iter().zip(score.by_place.values()));
    m.raw("<h2>")
        .say("按稀有度（训练集中同场景样本数）", "By rarity (training samples of the leaf)")
        .raw("</h2>");
    table(&mut m, score.by_rarity.iter().map(|(k, v)| (k.name().to_owned(), v)));
    finish(m)
}

/// The end of a page.
pub(crate) fn finish(mut m: Markup) -> String {
    m.raw("<script>\n").raw(LANGUAGE_SCRIPT).raw("</script></body></html>\n");
    m.into_string()
}

/// Numbers of samples and drives.
pub(crate) fn sizes(m: &mut Markup, samples: usize, drives: usize) {
    m.both(&Bilingual::new(
        format!("{samples} 个样本，{drives} 个行程"),
        format!("{}, {}", counted(samples, "sample"), counted(drives, "drive")),
    ));
}

/// Head of a page, up to the choice of language.
pub(crate) fn start(zh: &'static str, en: &'static str, lang: Lang) -> Markup {
    let mut m = Markup::new();
    let (code, title) = if lang == Lang::Zh { ("zh", zh) } else { ("en", en) };
    m.raw("<!doctype html><html lang=\"")
        .text(code)
        .raw("\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>")
        .text(title);
    m.raw("</title>")
        .raw(STYLE)
        .raw("</head><body><p class=\"choose\"><label><input type=\"radio\" name=\"l\" id=\"zh\"");
    m.raw(if lang == Lang::Zh { " checked" } else { "" }).raw(">中文</label> <label>");
    m.raw("<input type=\"radio\" name=\"l\" id=\"en\"").raw(if lang == Lang::Zh { "" } else { " checked" });
    m.raw(">English</label></p>");
    m
}

fn table<'a>(m: &mut Markup, rows: impl Iterator<Item = (String, &'a Figures)>) {
    m.raw("<table><tr><th>")
        .say("分组", "group")
        .raw("</th><th>")
        .say("样本", "samples")
        .raw("</th><th>")
        .say("纵向", "longitudinal");
    m.raw("</th><th>").say("横向", "lateral").raw("</th><th>").say("两者", "both").raw("</th><th>");
    m.say("L3 场景", "leaf").raw("</th><th>L2</th><th>ADE (m)</th><th>FDE (m)</th></tr>");
    for (name, f) in rows {
        m.raw("<tr><td>").text(&name).raw("</td><td>").int(f.samples).raw("</td>");
        for e in [&f.longitudinal, &f.lateral, &f.decisions, &f.leaf, &f.l2] {
            share(m, e.as_ref());
        }
        for e in [&f.ade_m, &f.fde_m] {
            cell(m, e.as_ref(), 1.0, "");
        }
        m.raw("</tr>");
    }
    m.raw("</table>");
}

fn share(m: &mut Markup, e: Option<&Estimate>) {
    cell(m, e, 100.0, " %");
}

fn cell(m: &mut Markup, e: Option<&Estimate>, scale: f64, unit: &'static str) {
    let digits = if unit.is_empty() { 2 } else { 1 };
    m.raw("<td>");
    match e {
        None => {
            m.raw("–");
        }
        Some(e) => {
            m.num(e.value * scale, digits).raw(unit);
            if let (Some(low), Some(high)) = (e.low, e.high) {
                m.raw(" <small>[")
                    .num(low * scale, digits)
                    .raw(", ")
                    .num(high * scale, digits)
                    .raw("]</small>");
            }
        }
    }
    m.raw("</td>");
}

fn classes(m: &mut Markup, target: Target, of: &ClassFigures) {
    m.raw("<h2>");
    match target {
        Target::Longitudinal => m.say("纵向决策", "Longitudinal decision"),
        Target::Lateral => m.say("横向决策", "Lateral decision"),
        Target::Leaf => m.say("L3 场景", "Leaf"),
    };
    m.raw("</h2><table><tr><th>")
        .say("类别", "class")
        .raw("</th><th>")
        .say("样本", "samples")
        .raw("</th><th>")
        .say("预测", "predicted");
    m.raw("</th><th>")
        .say("精确率", "precision")
        .raw("</th><th>")
        .say("召回率", "recall")
        .raw("</th><th>F1</th></tr>");
    for (class, c) in &of.by_class {
        m.raw("<tr><td>")
            .text(class)
            .raw("</td><td>")
            .int(c.samples)
            .raw("</td><td>")
            .int(c.predicted)
            .raw("</td>");
        for v in [c.precision, c.recall, c.f1] {
            m.raw("<td>");
            match v {
                Some(v) => m.num(v * 100.0, 1).raw(" %"),
                None => m.raw("–"),
            };
            m.raw("</td>");
        }
        m.raw("</tr>");
    }
    m.raw("<tr><td>macro F1</td><td></td><td></td><td></td><td></td>");
    share(m, of.macro_f1.as_ref());
    m.raw("</tr></table>");
}

/// Share of right leaves with its interval, one row per leaf: a dot and a line.
fn whiskers(m: &mut Markup, by: &BTreeMap<String, Figures>) {
    const LEFT: f64 = 330.0;
    const WIDE: f64 = 400.0;
    const ROW: f64 = 18.0;
    let rows: Vec<(&String, Estimate)> = by.iter().filter_map(|(k, f)| Some((k, f.leaf?))).collect();
    if rows.is_empty() {
        return;
    }
    let height = 26.0 + ROW * rows.len() as f64;
    m.raw("<svg role=\"img\" font-family=\"sans-serif\" font-size=\"12\" width=\"780\" viewBox=\"0 0 780 ");
    m.num(height, 0).raw("\"><title>leaf accuracy</title>");
    for tick in 0u32..=4 {
        let x = LEFT + WIDE * f64::from(tick) / 4.0;
        m.raw("<path stroke=\"#bbb\" d=\"M")
            .num(x, 1)
            .raw(" 18V")
            .num(height, 0)
            .raw("\"/><text text-anchor=\"middle\" y=\"12\" x=\"");
        m.num(x, 1).raw("\">").int(u64::from(tick) * 25).raw(" %</text>");
    }
    for (i, (name, e)) in rows.iter().enumerate() {
        let y = 30.0 + ROW * i as f64;
        let x = |v: f64| LEFT + WIDE * v;
        m.raw("<text text-anchor=\"end\" x=\"322\" y=\"")
            .num(y + 4.0, 0)
            .raw("\">")
            .text(name)
            .raw("</text>");
        if let (Some(low), Some(high)) = (e.low, e.high) {
            m.raw("<path stroke=\"#000\" stroke-width=\"2\" d=\"M").num(x(low), 1).raw(" ").num(y, 0);
            m.raw("H").num(x(high), 1).raw("\"/>");
        }
        m.raw("<circle r=\"4\" cx=\"").num(x(e.value), 1).raw("\" cy=\"").num(y, 0).raw("\"/>");
    }
    m.raw("</svg>");
}
