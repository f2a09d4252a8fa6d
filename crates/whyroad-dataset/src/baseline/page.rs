//! The comparison as a page: methods side by side, overall and by leaf, and reliability diagrams. Legible without
//! color.

use super::Method;
use super::calibration::Reliability;
use super::compare::Comparison;
use crate::score::Target;
use crate::score::figures::Figures;
use crate::score::page::{finish, sizes, start};
use crate::score::resample::Estimate;
use whyroad_model::Lang;
use whyroad_render::markup::Markup;

/// The page; `lang` is shown first.
pub fn page(c: &Comparison, lang: Lang) -> String {
    let mut m = start("基线", "Baseline", lang);
    m.raw("<h1>").say("基线模型", "Baseline").raw("</h1>");
    if let Some(score) = c.methods.get(&Method::Boosted) {
        m.raw("<p>").text(&score.release).raw(" · ").text(score.split.name()).raw(" · ");
        sizes(&mut m, score.samples, score.drives);
        m.raw("</p>");
    }
    m.raw("<h2>").say("总体", "Overall").raw("</h2><table><tr><th>").say("项目", "measure").raw("</th>");
    for method in c.methods.keys() {
        m.raw("<th>");
        name(&mut m, *method);
        m.raw("</th>");
    }
    m.raw("</tr>");
    for target in Target::ALL {
        m.raw("<tr><td>");
        title(&mut m, target);
        m.raw("</td>");
        c.methods.values().for_each(|s| share(&mut m, estimate(&s.overall, target)));
        m.raw("</tr><tr><td>macro F1</td>");
        for s in c.methods.values() {
            share(&mut m, s.classes.get(&target).and_then(|of| of.macro_f1.as_ref()));
        }
        m.raw("</tr>");
    }
    m.raw("</table><h2>").say("可靠性图", "Reliability").raw("</h2><p>");
    m.say("横轴为模型给出的概率，纵轴为实际正确的比例；点的大小为样本数。", "Stated probability (across) and share that is right (up); the size of a dot is the number of samples.");
    m.raw("</p>");
    for (target, of) in &c.reliability {
        m.piece(&diagram(*target, of));
    }
    for target in Target::ALL {
        by_leaf(&mut m, c, target);
    }
    finish(m)
}

fn name(m: &mut Markup, method: Method) {
    match method {
        Method::Boosted => m.say("提升树", "boosted trees"),
        Method::Majority => m.say("多数类", "majority class"),
        Method::RepeatLast => m.say("重复上一动作", "repeat last action"),
    };
}

fn title(m: &mut Markup, target: Target) {
    match target {
        Target::Longitudinal => m.say("纵向决策", "longitudinal decision"),
        Target::Lateral => m.say("横向决策", "lateral decision"),
        Target::Leaf => m.say("L3 场景", "leaf"),
    };
}

fn estimate(f: &Figures, target: Target) -> Option<&Estimate> {
    match target {
        Target::Longitudinal => f.longitudinal.as_ref(),
        Target::Lateral => f.lateral.as_ref(),
        Target::Leaf => f.leaf.as_ref(),
    }
}

fn share(m: &mut Markup, e: Option<&Estimate>) {
    m.raw("<td>");
    match e {
        None => {
            m.raw("–");
        }
        Some(e) => {
            m.num(e.value * 100.0, 1).raw(" %");
            if let (Some(low), Some(high)) = (e.low, e.high) {
                m.raw(" <small>[").num(low * 100.0, 1).raw(", ").num(high * 100.0, 1).raw("]</small>");
            }
        }
    }
    m.raw("</td>");
}

fn by_leaf(m: &mut Markup, c: &Comparison, target: Target) {
    let Some(first) = c.methods.values().next() else { return };
    m.raw("<h2>");
    title(m, target);
    m.say("，按 L3 场景", ", by leaf")
        .raw("</h2><table><tr><th>")
        .say("L3 场景", "leaf")
        .raw("</th><th>")
        .say("样本", "samples")
        .raw("</th>");
    for method in c.methods.keys() {
        m.raw("<th>");
        name(m, *method);
        m.raw("</th>");
    }
    m.raw("</tr>");
    for (leaf, figures) in &first.by_leaf {
        m.raw("<tr><td>").text(leaf).raw("</td><td>").int(figures.samples).raw("</td>");
        for s in c.methods.values() {
            share(m, s.by_leaf.get(leaf).and_then(|f| estimate(f, target)));
        }
        m.raw("</tr>");
    }
    m.raw("</table>");
}

/// The reliability diagram of one target as SVG.
pub fn diagram(target: Target, of: &Reliability) -> Markup {
    const SIDE: f64 = 200.0;
    const LEFT: f64 = 44.0;
    const TOP: f64 = 28.0;
    /// Radius of a dot with all samples.
    const DOT: f64 = 12.0;
    let (x, y) = (|v: f64| LEFT + SIDE * v, |v: f64| TOP + SIDE * (1.0 - v));
    let mut m = Markup::new();
    m.raw(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" font-family=\"sans-serif\" font-size=\"12\" ",
    );
    m.raw("width=\"270\" height=\"262\" viewBox=\"0 0 270 262\"><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>");
    m.raw("<text x=\"8\" y=\"16\" font-weight=\"bold\">").text(target.name()).raw(" · ECE ");
    match of.error {
        Some(e) => m.num(e * 100.0, 1).raw(" %"),
        None => m.raw("–"),
    };
    m.raw("</text><path fill=\"none\" stroke=\"#000\" d=\"M44 28V228H244\"/>");
    m.raw("<path stroke=\"#777\" stroke-dasharray=\"4 4\" d=\"M44 228L244 28\"/>");
    // Beyond the largest dot at the end of an axis.
    for tick in [0.0, 0.5, 1.0] {
        m.raw("<text text-anchor=\"end\" x=\"")
            .num(LEFT - DOT - 2.0, 0)
            .raw("\" y=\"")
            .num(y(tick) + 4.0, 0)
            .raw("\">")
            .num(tick, 1)
            .raw("</text>");
        m.raw("<text text-anchor=\"middle\" y=\"")
            .num(TOP + SIDE + DOT + 12.0, 0)
            .raw("\" x=\"")
            .num(x(tick), 0)
            .raw("\">")
            .num(tick, 1)
            .raw("</text>");
    }
    let all: usize = of.bins.iter().map(|b| b.samples).sum();
    for bin in &of.bins {
        if let (Some(stated), Some(right)) = (bin.stated, bin.right) {
            let radius = 3.0 + (DOT - 3.0) * (bin.samples as f64 / all as f64).sqrt();
            m.raw("<circle fill=\"#fff\" stroke=\"#000\" cx=\"")
                .num(x(stated), 1)
                .raw("\" cy=\"")
                .num(y(right), 1);
            m.raw("\" r=\"").num(radius, 1).raw("\"><title>").int(bin.samples).raw("</title></circle>");
        }
    }
    m.raw("</svg>");
    m
}
