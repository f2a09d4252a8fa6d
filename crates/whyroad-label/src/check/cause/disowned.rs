//! A trace that states that what it names is not the reason of its decision: "that is not why", "并不是减速的理由", or
//! that the only road user in it makes no difference to the ego. A true trace has no use for either: it gives the
//! reason. In other words than these a denied cause is read clause by clause (`grounds`).

use crate::check::reading::Named;
use crate::check::texts::TextScope;
use whyroad_framework::label_words::Divider;
use whyroad_model::decision::{Lateral, Longitudinal};

/// Bytes of the statement. Not where it is contrasted with the true reason, or only supposed.
pub(super) fn disowned(scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, texts, words, .. } = *scope;
    let text = label.trace.get()?;
    let lower = text.to_ascii_lowercase();
    let at = words
        .forms
        .not_reason
        .find(&lower)
        .or_else(|| words.forms.no_bearing.find(&lower).filter(|at| is_about_the_only_one(*at, scope)))?;
    let (from, to) = words.clauses.around(&texts.units, at.0..at.1, text.len(), &|d| d == Divider::Sentence);
    // "..., but the rain is": a clause that begins so gives the reason.
    let mut behind = lower[at.1..to].split(['，', '；', '：', ',', ';', ':', '-']).skip(1);
    let contrasts =
        behind.any(|c| words.clauses.contrast.iter().any(|w| c.trim_start().starts_with(w.as_str())));
    let supposed = words.forms.supposed.iter().any(|w| lower[from..at.0].contains(w.as_str()));
    (!contrasts && !supposed).then_some(at)
}

/// The ego responds to a road user, or keeps clear of something, and the trace names no other one before the statement.
fn is_about_the_only_one((start, _): (usize, usize), scope: &TextScope<'_>) -> bool {
    let TextScope { label, texts, words, .. } = *scope;
    let responds = matches!(
        label.longitudinal.get(),
        Some(Longitudinal::YieldToAgent | Longitudinal::LeadFollowing | Longitudinal::StopForObstacle)
    );
    let aside = label.longitudinal.get().is_none()
        && matches!(label.lateral.get(), Some(Lateral::InLaneNudge | Lateral::OutOfLaneNudge));
    let obstacle = words.kinds.get("obstacle").copied().unwrap_or_default();
    let kinds = if aside { words.known.actor.with(obstacle) } else { words.known.actor };
    let acts = |n: &&Named| words.objects[n.group].own.meets(kinds) && n.start < start;
    let mut all = texts.trace.there().filter(acts);
    let Some(first) = all.next() else { return false };
    let near = words.objects[first.group].near.with(words.objects[first.group].own);
    (responds || aside)
        && all.all(|n| words.objects[n.group].own.meets(near) || words.objects[n.group].near.meets(near))
}
