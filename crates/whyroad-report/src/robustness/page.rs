//! Agreement as one HTML page in both languages, legible without scripts: a matrix of classes and perturbations.

use super::{ClassAgreement, Robustness};
use std::collections::BTreeSet;
use whyroad_model::{Bilingual, Lang, ScenarioId};
use whyroad_render::language::LANGUAGE_SCRIPT;
use whyroad_render::markup::Markup;

const STYLE: &str = "small,.small{color:var(--faint);font-size:12px;font-weight:400}table{width:auto;margin:.5em 0 2em}th,td{text-align:right;\
font-variant-numeric:tabular-nums}th:first-child,td:first-child{text-align:left}thead th{vertical-align:bottom;\
max-width:8em}.low{font-weight:700;background:color-mix(in srgb,var(--person) 18%,transparent)}\
.same{color:var(--faint)}.choose{margin:1rem 0}.scroll{overflow-x:auto}\
html[lang] [lang]{display:inline}body:has(#zh:checked) span[lang=en],body:has(#en:checked) span[lang=zh]{display:none}\
@media print{.choose{display:none}}";

/// The page; `lang` is shown first, agreement below `floor` is marked, `name` returns the displayed name of a class.
pub fn page(of: &Robustness, lang: Lang, floor: f64, name: impl Fn(&ScenarioId) -> Bilingual) -> String {
    let mut m = Markup::new();
    let (code, title) = if lang == Lang::Zh { ("zh", "鲁棒性") } else { ("en", "Robustness") };
    m.raw("<!doctype html><html lang=\"")
        .raw(code)
        .raw("\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>")
        .raw(title);
    m.raw("</title><style>")
        .raw(crate::STYLE)
        .raw(STYLE)
        .raw("</style></head><body><main><p class=\"choose\"><label>");
    m.raw("<input type=\"radio\" name=\"l\" id=\"zh\"").raw(if lang == Lang::Zh { " checked" } else { "" });
    m.raw(">中文</label> <label><input type=\"radio\" name=\"l\" id=\"en\"");
    m.raw(if lang == Lang::Zh { "" } else { " checked" }).raw(">English</label></p><h1>");
    m.say("挖掘的鲁棒性", "Robustness of mining").raw("</h1><p>");
    m.int(of.drives).say(" 个行程，随机种子 ", " drives, seed ").int(of.seed);
    if of.left_out > 0 {
        m.say("；未比较：", "; left out: ").int(of.left_out);
    }
    m.raw("</p><p class=\"small\">");
    m.say(
        "一致率：2 × 相同事件 /（原有 + 扰动后）。相同：同一场景、同一目标，关键帧相差不超过 1 s 或时间范围重叠不少于 0.3。",
        "Agreement: 2 x same / (before + after). Same: one class and target, keyframes within 1 s or time ranges that \
         overlap by at least 0.3.",
    );
    m.raw("</p><table><thead><tr><th>")
        .say("扰动", "perturbation")
        .raw("</th><th>")
        .say("一致率", "agreement")
        .raw("</th><th>");
    m.say("原有", "before").raw("</th><th>").say("扰动后", "after").raw("</th><th>").say("倍数", "ratio");
    m.raw("</th><th>").say("关键帧偏移 (s)", "keyframe shift (s)").raw("</th></tr></thead>");
    for p in &of.perturbations {
        m.raw("<tr><td>").both(&p.meaning).raw(" <code>").text(&p.name).raw("</code></td>");
        share(&mut m, Some(&p.all), floor);
        for n in [p.all.before, p.all.after] {
            m.raw("<td>").int(n).raw("</td>");
        }
        for v in [p.all.ratio, p.all.keyframe_shift_s] {
            m.raw("<td>");
            match v {
                Some(v) => m.num(v, 2),
                None => m.raw("–"),
            };
            m.raw("</td>");
        }
        m.raw("</tr>");
    }
    m.raw("</table><h2>")
        .say("按场景", "By class")
        .raw("</h2><div class=\"scroll\"><table><thead><tr><th>")
        .say("场景", "class");
    m.raw("</th><th>").say("原有", "before").raw("</th>");
    for p in &of.perturbations {
        m.raw("<th title=\"").text(&p.name).raw("\">").both(&short(&p.meaning)).raw("</th>");
    }
    m.raw("</tr></thead>");
    let classes: BTreeSet<&ScenarioId> = of.perturbations.iter().flat_map(|p| p.classes.keys()).collect();
    for class in classes {
        let before = of.perturbations.iter().find_map(|p| p.classes.get(class)).map_or(0, |c| c.before);
        m.raw("<tr><td title=\"")
            .text(&class.to_string())
            .raw("\">")
            .both(&name(class))
            .raw("</td><td>")
            .int(before)
            .raw("</td>");
        for p in &of.perturbations {
            share(&mut m, p.classes.get(class), floor);
        }
        m.raw("</tr>");
    }
    m.raw("</table></div></main><script>\n").raw(LANGUAGE_SCRIPT).raw("</script></body></html>\n");
    m.into_string()
}

/// Description of a perturbation, without its figures: those are in the table above.
fn short(meaning: &Bilingual) -> Bilingual {
    let before = |text: &str, mark: char| text.split(mark).next().unwrap_or_default().to_owned();
    Bilingual::new(before(&meaning.zh, '：'), before(&meaning.en, ':'))
}

/// A cell: agreement and, where the number changed, the number.
fn share(m: &mut Markup, of: Option<&ClassAgreement>, floor: f64) {
    let Some(c) = of else {
        m.raw("<td>–</td>");
        return;
    };
    m.raw(if c.agreement < floor {
        "<td class=\"low\">"
    } else if c.agreement >= 1.0 {
        "<td class=\"same\">"
    } else {
        "<td>"
    });
    m.num(c.agreement, 2);
    if c.after != c.before {
        m.raw(" <small>(").int(c.after).raw(")</small>");
    }
    m.raw("</td>");
}
