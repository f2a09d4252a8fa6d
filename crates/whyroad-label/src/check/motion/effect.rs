//! The named cause against its counterfactual: a cause whose removal changes nothing is not a cause if the removal of
//! something that the label does not name would have let the ego drive on.

use crate::check::texts::Texts;
use crate::check::view::View;
use crate::counterfactual::{HORIZON_S, Removed, counterfactual};
use crate::driven::Driven;
use whyroad_framework::LabelWords;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_model::decision::Longitudinal;
use whyroad_model::label_fields::pointer;
use whyroad_model::names::class_name;
use whyroad_model::{Bilingual, ObjectClass, TrackId};

pub(super) fn check(
    label: &View<'_>,
    texts: &Texts,
    words: &LabelWords,
    w: &Driven<'_>,
    sink: &mut dyn Sink,
) {
    let answers_to = [
        Longitudinal::YieldToAgent,
        Longitudinal::LeadFollowing,
        Longitudinal::StopForRegulation,
        Longitudinal::StopForObstacle,
    ];
    if !label.longitudinal.get().is_some_and(|d| answers_to.contains(&d)) {
        return;
    }
    let Slot::Is(causes) = &label.causes else { return };
    let Slot::Is(cause) = &causes.longitudinal else { return };
    let is_cause =
        |id: Slot<&str>| id.get().is_some_and(|id| cause.components.iter().any(|c| c.get() == Some(id)));
    let light = words.kinds.get("light").copied().unwrap_or_default();
    let mut named: Vec<Removed> = Vec::new();
    for (c, facts) in label.parts.iter().zip(&texts.components).filter(|(c, _)| is_cause(c.id)) {
        named.extend(c.objects.iter().map(|id| Removed::Object(TrackId::from(*id))));
        if c.objects.is_empty() && facts.groups.meets(light) {
            named.push(Removed::Light);
        }
    }
    // A cause that is only text cannot be removed.
    if named.is_empty() {
        return;
    }
    let Some(found) = counterfactual(w.drive, w.signals, w.keyframe) else { return };
    let was_seen = |thing: &Removed| match thing {
        Removed::Light => true,
        Removed::Object(id) => w.was_seen(id),
    };
    let other = found.instead_of(&named, was_seen);
    let Some(other) = other else { return };
    sink.report(Finding::warning("label.cause.no_effect", pointer::CAUSES_LONGITUDINAL), &|| {
        let what = match &other.removed {
            Removed::Light => Bilingual::new("本车道的信号灯", "the light of the ego's lane"),
            Removed::Object(id) => {
                let class = w.drive.track(id).map_or(ObjectClass::Unknown, |t| t.class);
                let name = class_name(class);
                Bilingual::new(format!("{}（{id}）", name.zh), format!("the {} {id}", name.en))
            }
        };
        let m = other.distance_m;
        Words::new(
            format!(
                "按驾驶员模型估计：去掉标注的原因，自车的行驶不变；去掉{}，自车在 {HORIZON_S:.0} s 内会多行驶约 {m:.0} m",
                what.zh
            ),
            format!(
                "a driver model estimates: without the named cause the ego would drive the same; without {} it \
                 would drive about {m:.0} m farther within {HORIZON_S:.0} s",
                what.en
            ),
        )
        .hint("关联真正限制自车的目标", "link the object that held the ego")
    });
}
