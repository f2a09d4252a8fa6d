//! A reason, marked as one, that names a light, a sign or a place and nobody, where the ego responds to a road user:
//! "on account of that red light we brake behind the queue" (LABELING.md 6, proximate cause).

use crate::check::reading::Named;
use crate::check::texts::TextScope;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_model::label_fields::pointer;

/// The reason that the trace marks names the road user that the class is about.
pub(in crate::check) fn far_reason(scope: &TextScope<'_>, sink: &mut dyn Sink) -> bool {
    let TextScope { label, texts, words, .. } = *scope;
    let known = &words.known;
    if !scope.answers_a_road_user() || label.lateral.get().is_some() {
        return false;
    }
    let Some(text) = label.trace.get() else { return false };
    let lower = text.to_ascii_lowercase();
    let kind = |id: &str| words.kinds.get(id).copied().unwrap_or_default();
    let far = known.sign.with(known.light).with(kind("site")).with(kind("ramp")).with(kind("facility"));
    let far = far.with(known.route).without(known.actor);
    let Some((_, from)) = words.forms.because.find(&lower) else { return false };
    let to = lower[from..].find(['，', '。', ',', '.', ';', '；']).map_or(lower.len(), |i| from + i);
    // "Because of that red light we follow": the reason ends where the ego acts.
    let ego = [" we ", " i ", " the ego ", " ego ", " that we "];
    let acts = ego.iter().filter_map(|w| lower[from..to].find(w)).min();
    let to = acts.filter(|_| text.is_ascii()).map_or(to, |i| from + i);
    let inside = || texts.trace.named.iter().filter(|n| (from..to).contains(&n.start));
    let own = |n: &Named| words.objects[n.group].own;
    let somebody = inside().any(|n| own(n).meets(known.actor))
        || text.get(from..to).is_none_or(|t| words.subjects.has_pronoun(t));
    let Some(n) = inside().find(|n| own(n).meets(far)).filter(|_| !somebody) else { return false };
    let (start, end) = (n.start, n.end);
    sink.report(Finding::warning("label.cause.proximate", pointer::COC_TRACE).part(start, end), &|| {
        let thing = &text[start..end];
        Words::new(
            format!("因果描述把“{thing}”当作原因，而这个类别里自车响应的是道路使用者"),
            format!(
                "the trace gives '{thing}' as the reason, but in this class the ego responds to a road user"
            ),
        )
        .hint("写出直接引起决策的那一个要素", "name the component that causes the decision")
    });
    true
}
