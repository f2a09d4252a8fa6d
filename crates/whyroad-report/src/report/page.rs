//! The page with its parts: head, language switch, coverage, filters, cards. Style and script are in
//! `assets/`; the script only switches language, filters and shows details, and the page is readable without it.

use super::card::Card;
use super::{ReportContext, summary, tree_map};
use crate::coverage::{self, LeafRow, class_title};
use std::collections::BTreeMap;
use whyroad_model::scene::FRAME_RATE_HZ;
use whyroad_model::{Drive, DriveId, Lang, Need, ScenarioId};
use whyroad_render::language::LANGUAGE_SCRIPT;
use whyroad_render::markup::Markup;

const STYLE: &str = include_str!("../../assets/report.css");
const SCRIPT: &str = include_str!("../../assets/report.js");

/// Information about a drive on the page.
#[derive(Clone, Debug)]
pub(super) struct DriveLine {
    id: DriveId,
    format: String,
    place: Option<String>,
    licence: Option<String>,
    seconds: f64,
    /// Tracks as the log has them.
    tracks: usize,
    /// Objects: tracks that break off and go on under another id are joined.
    objects: usize,
    pub(super) episodes: usize,
    missing: Vec<Need>,
}

impl DriveLine {
    /// Of an estimated drive whose log has this many tracks.
    pub(super) fn new(drive: &Drive, tracks: usize, episodes: usize) -> Self {
        // Of frames: gaps of the log were not recorded.
        let seconds = drive.times.len() as f64 / FRAME_RATE_HZ;
        Self {
            id: drive.meta.drive_id.clone(),
            format: drive.meta.format.clone(),
            place: drive.meta.place.clone(),
            licence: drive.meta.licence.clone(),
            seconds,
            tracks,
            objects: drive.tracks.len(),
            episodes,
            missing: drive.meta.missing.clone(),
        }
    }
}

/// The whole page.
pub(super) fn render(
    context: &ReportContext<'_>,
    rows: &[LeafRow<'_>],
    drives: &[DriveLine],
    cards: &[Card],
    episodes: usize,
    analytics: Option<&Markup>,
) -> String {
    let unresolved = coverage::unresolved(&context.framework.taxonomy, context.coverage);
    let mut m = Markup::new();
    m.raw("<!doctype html>\n<html lang=\"").raw(if context.lang == Lang::Zh { "zh" } else { "en" });
    m.raw(concat!(
        "\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">",
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">",
        "<title>Whyroad</title><style>\n"
    ));
    m.raw(STYLE).raw("</style></head><body>");
    header(&mut m, context, rows, drives, episodes);
    m.raw("<main><section id=\"coverage\"><h2>").say("场景覆盖", "Coverage").raw("</h2>");
    m.piece(&summary::legend(rows))
        .raw("<div class=\"map\">")
        .piece(&tree_map::render(rows, &unresolved))
        .raw("</div>");
    m.raw("<p id=\"detail\" class=\"faint\" aria-live=\"polite\">");
    m.say(
        "把鼠标移到格子上查看详情，点击跳到表格并筛选事件。",
        "Point at a cell for details; click it for its line in the table and its episodes.",
    );
    m.raw("</p>");
    unexplained(&mut m, context);
    unknown(&mut m, context);
    m.raw("</section>");
    if let Some(analytics) = analytics {
        m.piece(analytics);
    }
    drives_table(&mut m, drives);
    episodes_section(&mut m, context, drives, cards, episodes);
    m.raw("<section id=\"leaves\"><details><summary><h2>")
        .say("全部场景", "All scenarios")
        .raw("</h2></summary>");
    m.piece(&summary::table(rows, &unresolved, context.signals)).raw("</details></section>");
    m.raw("</main><script>\n").raw(LANGUAGE_SCRIPT).raw(SCRIPT).raw("</script></body></html>\n");
    m.into_string()
}

/// Gaps of the taxonomy or its rules.
fn unexplained(m: &mut Markup, context: &ReportContext<'_>) {
    let Some(other) = coverage::unexplained(context.coverage) else { return };
    m.raw("<p class=\"other\">");
    if other.state == whyroad_model::messages::CoverageState::NotObservable {
        m.say(
            "决策时刻不可观测，因此不知道有多少没有类别能解释。",
            "Decision moments are not observable in these drives; how many are unexplained is unknown.",
        );
    } else {
        m.say("没有类别能解释的决策时刻（other）：", "Decision moments that no class explains (other): ");
        m.int(other.episodes as usize);
    }
    m.raw("</p>");
}

fn header(
    m: &mut Markup,
    context: &ReportContext<'_>,
    rows: &[LeafRow<'_>],
    drives: &[DriveLine],
    episodes: usize,
) {
    m.raw("<header><div><h1>Whyroad</h1><p class=\"faint\">")
        .say("从行车记录到因果链标注", "from recorded drives to chain-of-causation labels");
    m.raw("</p></div><dl class=\"figures\">");
    let figure = |m: &mut Markup, n: usize, zh, en| {
        m.raw("<div><dd>").int(n).raw("</dd><dt>").say(zh, en).raw("</dt></div>");
    };
    figure(m, drives.len(), "个行程", "drives");
    figure(m, episodes, "个事件", "episodes");
    m.raw("<div><dd>")
        .int(coverage::counts(rows).found)
        .raw("<small> / ")
        .int(rows.len())
        .raw("</small></dd><dt>");
    m.say("类场景已找到", "leaves found")
        .raw("</dt></div></dl><div class=\"right\"><div class=\"switch\" role=\"group\">");
    m.raw("<button type=\"button\" data-lang=\"zh\">中文</button><button type=\"button\" data-lang=\"en\">English</button></div>");
    m.raw("<p class=\"faint\">")
        .say("分类体系 ", "taxonomy ")
        .text(&context.framework.taxonomy.version)
        .raw("</p></div></header>");
}

fn unknown(m: &mut Markup, context: &ReportContext<'_>) {
    let unknown = coverage::unknown_leaves(&context.framework.taxonomy, context.coverage);
    if unknown.is_empty() {
        return;
    }
    m.raw("<p class=\"warning\">")
        .say("以下类别不在当前分类体系中：", "Mined with another taxonomy, and unknown to this one: ");
    for id in unknown {
        m.raw("<code>").text(&id.to_string()).raw("</code> ");
    }
    m.raw("</p>");
}

fn drives_table(m: &mut Markup, drives: &[DriveLine]) {
    m.raw("<section id=\"drives\"><h2>")
        .say("行程", "Drives")
        .raw("</h2><table><thead><tr><th>ID</th><th>")
        .say("格式", "format");
    m.raw("</th><th>")
        .say("地点", "place")
        .raw("</th><th class=\"n\">")
        .say("时长", "length")
        .raw("</th><th class=\"n\">");
    m.say("轨迹", "tracks")
        .raw("</th><th class=\"n\">")
        .say("目标", "objects")
        .raw("</th><th class=\"n\">")
        .say("事件数", "episodes")
        .raw("</th><th>")
        .say("许可", "licence");
    m.raw("</th><th>").say("记录中缺少", "the log lacks").raw("</th></tr></thead><tbody>");
    for d in drives {
        m.raw("<tr><td><code>").text(d.id.as_str()).raw("</code></td><td>").text(&d.format).raw("</td><td>");
        m.text(d.place.as_deref().unwrap_or("–"))
            .raw("</td><td class=\"n\">")
            .num(d.seconds, 1)
            .raw(" s</td><td class=\"n\">");
        m.int(d.tracks).raw("</td><td class=\"n\">").int(d.objects);
        m.raw("</td><td class=\"n\">").int(d.episodes).raw("</td><td>");
        m.text(d.licence.as_deref().unwrap_or("–")).raw("</td><td class=\"faint\">");
        for (i, need) in d.missing.iter().enumerate() {
            m.raw(if i == 0 { "" } else { ", " }).both(&need.name());
        }
        m.raw("</td></tr>");
    }
    m.raw("</tbody></table><p class=\"faint\">");
    m.say(
        "轨迹：日志中的编号数，同 ingest、inspect；目标：中断后换了编号的轨迹合并后的数目，规则在其上判定。",
        "Tracks: ids of the log, as ingest and inspect count them. Objects: tracks that break off and go on under \
         another id are joined; rules are evaluated on these.",
    )
    .raw("</p></section>");
}

fn episodes_section(
    m: &mut Markup,
    context: &ReportContext<'_>,
    drives: &[DriveLine],
    cards: &[Card],
    episodes: usize,
) {
    m.raw("<section id=\"episodes\"><h2>").say("事件", "Episodes").raw("</h2>");
    if episodes == 0 {
        m.raw("<p>").say("没有找到事件。", "No episodes found.").raw("</p></section>");
        return;
    }
    let mut per_leaf: BTreeMap<&ScenarioId, usize> = BTreeMap::new();
    for card in cards {
        *per_leaf.entry(&card.leaf).or_default() += 1;
    }
    m.raw("<form class=\"filter\"><label>")
        .say("场景", "scenario")
        .raw(" <select name=\"leaf\"><option value=\"\">—</option>");
    let order = context.framework.taxonomy.ids();
    for id in order.iter().filter(|id| per_leaf.contains_key(id)) {
        let (text, title) = (id.to_string(), class_title(&context.framework.taxonomy, id));
        m.raw("<option value=\"").text(&text).raw("\" data-zh=\"").text(&title.zh).raw("\" data-en=\"");
        m.text(&title.en).raw("\" data-n=\"").int(per_leaf[id]).raw("\">").text(&text).raw("</option>");
    }
    m.raw("</select></label><label>")
        .say("行程", "drive")
        .raw(" <select name=\"drive\"><option value=\"\">—</option>");
    for d in drives.iter().filter(|d| d.episodes > 0) {
        m.raw("<option>").text(d.id.as_str()).raw("</option>");
    }
    m.raw("</select></label><label><input type=\"checkbox\" name=\"primary\"> ")
        .say("只看主场景", "primary only");
    m.raw("</label> <output class=\"faint\"><span class=\"shown\">")
        .int(cards.len())
        .raw("</span> / ")
        .int(cards.len());
    m.raw("</output></form>");
    if cards.len() < episodes {
        m.raw("<p class=\"warning\">")
            .say("页面只显示部分事件；未显示：", "The page does not show all episodes; left out: ");
        m.int(episodes - cards.len()).raw("</p>");
    }
    key(m);
    for card in cards {
        m.piece(&card.html);
    }
    m.raw("</section>");
}

/// Legend of the colors and lines of the images.
fn key(m: &mut Markup) {
    m.raw("<ul class=\"key\">");
    for (class, zh, en) in [
        ("ego", "自车", "ego"),
        ("vehicle target", "规则目标（描边）", "rule target (outlined)"),
        ("vehicle", "轿车等", "cars"),
        ("large", "卡车、客车", "trucks, buses"),
        ("two", "骑行者、两轮车", "riders, two-wheelers"),
        ("person", "行人、动物", "pedestrians, animals"),
        ("fixed", "其他", "other"),
    ] {
        m.raw("<li><svg viewBox=\"-26 -12 52 24\" width=\"30\" height=\"14\"><g class=\"").raw(class);
        m.raw("\"><path class=\"box\" d=\"M24 -10V10H-24V-10Z\"/><path class=\"nose\" d=\"M8 -10L24 0L8 10\"/></g></svg> ");
        m.say(zh, en).raw("</li>");
    }
    for (class, zh, en) in [
        ("way way-ego before", "此前 3 s 轨迹", "path in the 3 s before"),
        ("way way-ego after", "此后 6 s 轨迹", "path in the 6 s after"),
    ] {
        m.raw("<li><svg viewBox=\"0 0 60 24\" width=\"34\" height=\"14\"><path class=\"")
            .raw(class)
            .raw("\" d=\"M2 12H58\"/></svg> ");
        m.say(zh, en).raw("</li>");
    }
    m.raw("<li><svg viewBox=\"0 0 34 14\" width=\"34\" height=\"14\"><rect class=\"shade\" width=\"34\" height=\"14\"/>");
    m.raw("<path class=\"keyframe\" d=\"M17 0V14\"/></svg> ")
        .say("起止区间与关键帧", "start to end, and the keyframe");
    m.raw("</li></ul>");
}
