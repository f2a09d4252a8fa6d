//! The label draft of a primary episode, as an annotator would see it.

use whyroad_framework::Framework;
use whyroad_label::draft::draft;
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{Bilingual, Drive, Lang, SignalTable};
use whyroad_render::markup::Markup;

pub(super) fn render(
    framework: &Framework,
    drive: &Drive,
    signals: &SignalTable,
    episode: &EpisodeRecord,
) -> Markup {
    let [zh, en] = [Lang::Zh, Lang::En].map(|lang| draft(framework, drive, signals, episode, lang));
    let mut m = Markup::new();
    m.raw("<div class=\"draft\"><p class=\"title\">")
        .say("标注草稿（须由标注员确认）", "Label draft (needs a person)")
        .raw("</p><p>");
    let decision = &zh.label.driving_decision;
    let null = Bilingual::new("无变化", "no change");
    let names = &framework.decisions;
    let longitudinal = decision.longitudinal.and_then(|d| names.longitudinal(d)).map_or(&null, |t| &t.name);
    let lateral = decision.lateral.and_then(|d| names.lateral(d)).map_or(&null, |t| &t.name);
    m.say("纵向：", "longitudinal: ").raw("<b>").both(longitudinal).raw("</b> · ").say("横向：", "lateral: ");
    m.raw("<b>").both(lateral).raw("</b>");
    if let Some(direction) = decision.lateral_direction {
        m.raw(" <code>").text(direction.id()).raw("</code>");
    }
    m.raw("</p><p>")
        .both(&Bilingual::new(zh.label.coc_trace, en.label.coc_trace))
        .raw("</p><ul class=\"notes faint\">");
    for note in &zh.notes {
        m.raw("<li>").both(note).raw("</li>");
    }
    m.raw("</ul></div>");
    m
}
