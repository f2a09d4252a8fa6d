//! Components that only describe the road and the weather as they mostly are: together they are no cause of a decision.

use crate::check::reading::{Named, TextFacts};
use crate::check::texts::TextScope;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_model::decision::Longitudinal;
use whyroad_model::label_fields::pointer;

/// Some component is more than that. A set speed needs no cause of its own.
pub(in crate::check) fn ordinary(scope: &TextScope<'_>, sink: &mut dyn Sink) -> bool {
    let TextScope { label, texts, words, about, .. } = *scope;
    let set_speed =
        label.longitudinal.get() == Some(Longitudinal::SetSpeedTracking) && label.lateral.get().is_none();
    let none = label.longitudinal.get().is_none() && label.lateral.get().is_none();
    if label.parts.is_empty() || set_speed || none {
        return false;
    }
    let known = &words.known;
    let causes =
        known.adverse.with(known.sight).with(known.sign).with(known.route).with(about.without(known.actor));
    let is_ordinary = |text: &str, facts: &TextFacts| {
        let lower = text.to_ascii_lowercase();
        let cause = |n: &Named| {
            let own = words.objects[n.group].own;
            own.meets(causes.without(known.road).without(known.no_cause))
                || own.meets(known.actor) && !is_few(text, n)
        };
        facts.acts.is_empty()
            && facts.states.is_empty()
            && !facts.named.iter().any(|n| n.state.is_some() || cause(n))
            && words.forms.free.find(&lower).is_none()
            && !lower.contains('空')
    };
    // At least one says so, or names nothing of driving.
    let says = |text: &str| words.forms.ordinary.find(&text.to_ascii_lowercase()).is_some();
    let is_plain =
        |text: &str, facts: &TextFacts| says(text) || facts.words == 0 && !words.is_of_driving(text);
    let parts = || label.parts.iter().zip(&texts.components);
    // How a road is may be told in any words.
    let all = !about.meets(known.condition) || parts().all(|(c, _)| c.description.get().is_some_and(says));
    let any = all && parts().any(|(c, f)| c.description.get().is_some_and(|t| is_plain(t, f)));
    if !any || !parts().all(|(c, f)| c.description.get().is_some_and(|t| is_ordinary(t, f))) {
        return false;
    }
    let at = if label.longitudinal.get().is_some() {
        pointer::CAUSES_LONGITUDINAL
    } else {
        pointer::CAUSES_LATERAL
    };
    sink.report(Finding::warning("label.cause.missing", at), &|| {
        Words::new(
            "关键要素只描述了道路或天气的平常样子，没有一个会引起这个决策",
            "the components only describe the road or the weather as they mostly are: none of them causes a decision",
        )
        .hint("写出引起决策的要素", "add the component that causes the decision")
    });
    true
}

/// "There are few cars": nobody in particular.
fn is_few(text: &str, n: &Named) -> bool {
    let behind = text.get(n.end..).unwrap_or_default();
    behind.starts_with("不多") || behind.starts_with("很少")
}
