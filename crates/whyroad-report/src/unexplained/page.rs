//! Groups of unexplained moments as one HTML page without scripts: each with the scene of its example.

use super::text::{at, class, ego, undecided, unmet, word};
use super::{LISTED_CLASSES, Unexplained};
use whyroad_model::Lang;
use whyroad_model::text::counted;
use whyroad_render::markup::Markup;

const STYLE: &str = ".group{display:flex;gap:1.5rem;flex-wrap:wrap;border-top:1px solid var(--rule);padding:1rem 0}\
.group svg{width:22rem;height:auto}.group div{flex:1;min-width:20rem}.unmet{color:var(--faint);margin:0 0 .5em 1em}h1{margin:1rem 0 0}main{padding-bottom:2rem}";

/// The page; `scenes` has an SVG for each group, in their order (empty: none).
pub fn page(of: &Unexplained, scenes: &[Markup], lang: Lang) -> String {
    let zh = lang == Lang::Zh;
    let title = if zh { "没有类别能解释的时刻" } else { "Moments that no class explains" };
    let mut m = Markup::new();
    m.raw("<!doctype html>\n<html lang=\"").raw(if zh { "zh" } else { "en" });
    m.raw("\">\n<head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n<title>").text(title).raw("</title>\n<style>");
    m.raw(crate::STYLE).raw(STYLE).raw("</style></head>\n<body>\n<main><h1>").text(title).raw("</h1>\n<p>");
    m.text(&if zh {
        format!("{} 个时刻，{} 个行程，{} 组", of.moments, of.drives, of.groups.len())
    } else {
        format!(
            "{}, {}, {}",
            counted(of.moments, "moment"),
            counted(of.drives, "drive"),
            counted(of.groups.len(), "group")
        )
    });
    m.raw("</p>\n");
    for (i, g) in of.groups.iter().enumerate() {
        m.raw("<section class=\"group\">");
        if let Some(scene) = scenes.get(i) {
            m.piece(scene);
        }
        m.raw("<div><h2>");
        m.text(&if zh {
            format!("{}. {} 个时刻，{} 个行程", i + 1, g.moments, g.drives)
        } else {
            format!("{}. {}, {}", i + 1, counted(g.moments, "moment"), counted(g.drives, "drive"))
        });
        m.raw("</h2><p>").text(g.example.clip_id.as_str()).raw(" · ").text(&at(&g.example, lang)).raw(" · ");
        m.text(&ego(&g.example, lang)).raw("</p>");
        for near in g.example.nearest.iter().take(LISTED_CLASSES) {
            let name = of.name(&near.scenario_id, lang);
            m.raw("<p><b>").text(&class(near, &name, lang)).raw("</b></p><ul class=\"unmet\">");
            for part in &near.unmet {
                m.raw("<li>").text(word(part, lang)).text(&unmet(part, lang)).raw("</li>");
            }
            m.raw("</ul>");
        }
        for open in g.example.undecided.iter().take(LISTED_CLASSES) {
            m.raw("<p>").text(&undecided(open, &of.name(&open.scenario_id, lang), lang)).raw("</p>");
        }
        if g.moments > 1 {
            m.raw("<p>").text(if zh { "组内最接近的类别：" } else { "Near most of the group: " });
            let all: Vec<String> =
                g.nearest.iter().map(|(id, n)| format!("{} × {n}", of.name(id, lang))).collect();
            m.text(&all.join(if zh { "、" } else { ", " })).raw("</p><details><summary>");
            m.raw(if zh { "事件编号" } else { "Ids of the episodes" }).raw("</summary><small>");
            m.text(&g.episode_ids.join(", ")).raw("</small></details>");
        }
        m.raw("</div></section>\n");
    }
    m.raw("</main></body>\n</html>\n");
    m.into_string()
}
