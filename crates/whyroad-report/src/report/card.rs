//! One episode: the image at its keyframe, the rule's conditions, and the signals that it read.

use super::{ReportContext, draft_box};
use crate::coverage::class_title;
use whyroad_model::messages::{EgoResponse, EpisodeRecord, KeyframeType};
use whyroad_model::names::{class_name, keyframe_kind};
use whyroad_model::time::frame_at;
use whyroad_model::{Drive, FrameRange, Nanos, ScenarioId, SignalTable};
use whyroad_render::birds_eye;
use whyroad_render::markup::Markup;
use whyroad_render::plot::{self, Span};

/// Frames of context in the plots on either side of an episode: 3 s.
const CONTEXT_FRAMES: usize = 30;

/// A finished card and its filter values.
#[derive(Clone, Debug)]
pub(super) struct Card {
    pub(super) leaf: ScenarioId,
    pub(super) html: Markup,
}

/// The card of one episode of `drive`.
pub(super) fn render(
    context: &ReportContext<'_>,
    drive: &Drive,
    signals: &SignalTable,
    episode: &EpisodeRecord,
) -> Card {
    let keyframe =
        frame_at(&drive.times, episode.keyframe.timestamp).min(drive.times.len().saturating_sub(1));
    let range = FrameRange::new(
        frame_at(&drive.times, episode.time_range.start_timestamp),
        frame_at(&drive.times, episode.time_range.end_timestamp),
    );
    let first = range.start.min(keyframe).saturating_sub(CONTEXT_FRAMES);
    let last = (range.end.max(keyframe + 1) + CONTEXT_FRAMES).min(drive.times.len());
    let span = Span { shown: FrameRange::new(first, last), episode: range, keyframe };

    let mut m = Markup::new();
    let id = episode.scenario_id.to_string();
    m.raw("<article class=\"card\" data-leaf=\"")
        .text(&id)
        .raw("\" data-drive=\"")
        .text(episode.drive_id.as_str());
    m.raw("\" data-primary=\"").raw(if episode.is_primary { "1" } else { "0" }).raw("\" id=\"episode-");
    m.text(&episode.episode_id).raw("\"><div class=\"picture\">");
    let picture = birds_eye::render(drive, keyframe, episode.target_id.as_ref());
    let picture_text = picture.clone().into_string();
    if picture_text.is_empty() {
        m.raw("<p class=\"no-picture faint\">")
            .say("该时刻没有自车位姿，无法绘制俯视图", "no ego pose at this moment: no picture");
        m.raw("</p>");
    } else {
        m.piece(&picture);
    }
    if episode.is_primary {
        m.piece(&draft_box::render(context.framework, drive, signals, episode));
    }
    m.raw("</div><div class=\"facts\">");
    head(&mut m, context, episode);
    times(&mut m, drive, episode);
    conditions(&mut m, episode);
    m.raw("</div><div class=\"plots\">");
    for name in &episode.signals {
        m.piece(&plot::render(context.signals, signals, episode.target_id.as_ref(), name, span));
    }
    m.raw("</div></article>\n");
    Card { leaf: episode.scenario_id.clone(), html: m }
}

fn head(m: &mut Markup, context: &ReportContext<'_>, episode: &EpisodeRecord) {
    let name = class_title(&context.framework.taxonomy, &episode.scenario_id);
    m.raw("<h3>").both(&name).raw("</h3><p class=\"sub\">");
    if episode.is_primary {
        m.raw("<span class=\"badge primary\">").say("主场景", "primary").raw("</span>");
    } else {
        m.raw("<span class=\"badge\">").say("次要", "secondary").raw("</span>");
        if let Some(primary) = &episode.primary_episode_id {
            m.raw(" <a class=\"faint\" title=\"")
                .text(primary)
                .raw("\" href=\"#episode-")
                .text(primary)
                .raw("\">");
            m.say("查看主场景", "see the primary one").raw("</a>");
        }
    }
    if let Some(response) = episode.ego_response {
        let (zh, en) = match response {
            EgoResponse::Observed => ("自车有响应", "ego responds"),
            EgoResponse::Absent => ("自车无响应", "no response of the ego"),
            EgoResponse::Unknown => ("响应未知", "response unknown"),
        };
        m.raw(" <span class=\"badge\">").say(zh, en).raw("</span>");
    }
    m.raw(" <span class=\"score\"><span class=\"score-bar\"><i style=\"width:");
    m.num(episode.score.clamp(0.0, 1.0) * 100.0, 0)
        .raw("%\"></i></span>")
        .num(episode.score, 2)
        .raw("</span></p>");
}

fn times(m: &mut Markup, drive: &Drive, episode: &EpisodeRecord) {
    let zero = drive.times.first().copied().unwrap_or_default();
    let at = |m: &mut Markup, t: Nanos| {
        m.raw("<span title=\"")
            .text(&t.to_string())
            .raw("\">")
            .num(t.seconds_since(zero), 1)
            .raw(" s</span>");
    };
    m.raw("<dl><dt>")
        .say("片段", "clip")
        .raw("</dt><dd><code>")
        .text(episode.clip_id.as_str())
        .raw("</code> · ");
    m.say("第 ", "frame ")
        .int(episode.keyframe.frame_idx)
        .say(" 帧", "")
        .raw("</dd><dt>")
        .say("关键帧", "keyframe");
    m.raw("</dt><dd><b>");
    at(m, episode.keyframe.timestamp);
    m.raw("</b> (").both(&keyframe_kind(episode.keyframe.kind));
    if let (KeyframeType::Proactive, Some(a), Some(b)) =
        (episode.keyframe.kind, episode.keyframe.range_start, episode.keyframe.range_end)
    {
        m.raw(" ");
        at(m, a);
        m.raw(" – ");
        at(m, b);
    }
    m.raw(")<br><span class=\"faint\">")
        .both(&episode.keyframe_rule)
        .raw("</span></dd><dt>")
        .say("起止", "start – end");
    m.raw("</dt><dd>");
    at(m, episode.time_range.start_timestamp);
    m.raw(" – ");
    at(m, episode.time_range.end_timestamp);
    m.raw("</dd>");
    if let Some(target) = &episode.target_id {
        m.raw("<dt>").say("目标", "target").raw("</dt><dd>");
        if let Some(track) = drive.track(target) {
            m.both(&class_name(track.class)).raw(" ");
        }
        m.raw("<code>").text(target.as_str()).raw("</code></dd>");
    }
    m.raw("</dl>");
}

fn conditions(m: &mut Markup, episode: &EpisodeRecord) {
    if episode.conditions_matched.is_empty() {
        return;
    }
    m.raw("<table class=\"conditions\"><thead><tr><th>").say("命中条件", "condition").raw("</th><th>");
    m.say("关键帧实际值", "at the keyframe").raw("</th></tr></thead><tbody>");
    for c in &episode.conditions_matched {
        m.raw("<tr><td>");
        match &c.description {
            Some(words) => m.both(words),
            // For results mined before conditions had texts, or by other programs.
            None => m.raw("<code>").text(&c.condition).raw("</code>"),
        };
        m.raw("</td><td>");
        match (&c.actual_words, &c.actual_value) {
            (Some(words), _) => m.both(words),
            (None, serde_json::Value::Number(n)) => m.num(n.as_f64().unwrap_or(f64::NAN), 2),
            (None, serde_json::Value::String(s)) => m.text(s),
            (None, serde_json::Value::Bool(true)) => m.say("成立", "holds"),
            (None, serde_json::Value::Bool(false)) => m.say("不成立", "does not hold"),
            (None, _) => m.raw("–"),
        };
        m.raw("</td></tr>");
    }
    m.raw("</tbody></table>");
}
