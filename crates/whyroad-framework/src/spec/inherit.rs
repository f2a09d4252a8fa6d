//! Inheritance: an L3's spec over its L2's over its L1's default, field by field.
//!
//! Two fields belong together: `rule` and `expr` state the same thing, so a level that states a rule does not inherit
//! an expression. A level that changes a keyframe's type does not inherit its fallback, because the fallback of a range
//! is not a moment. Records are added.

use super::raw::{
    BoundLayer, ChoiceLayer, KeyframeLayer, LabelingLayer, MomentLayer, PackLayer, RecordLayer, Words,
};
use super::{BoundSpec, KeyframeSpec, MomentSpec, PackSpec, RecordChoice, RecordSpec, ResolvedSpec};
use whyroad_model::messages::Uncertainty;
use whyroad_model::{Bilingual, ScenarioId};

/// `upper` overridden by all fields of `lower`.
pub(crate) fn overlay(upper: &LabelingLayer, lower: &LabelingLayer) -> LabelingLayer {
    let mut records = upper.records.clone().unwrap_or_default();
    for r in lower.records.iter().flatten() {
        match records.iter_mut().find(|o| o.id == r.id) {
            Some(o) => *o = r.clone(),
            None => records.push(r.clone()),
        }
    }
    LabelingLayer {
        keyframe: merge(upper.keyframe.as_ref(), lower.keyframe.as_ref(), overlay_keyframe),
        second_keyframe: merge(
            upper.second_keyframe.as_ref(),
            lower.second_keyframe.as_ref(),
            overlay_keyframe,
        ),
        start: merge(upper.start.as_ref(), lower.start.as_ref(), overlay_bound),
        end: merge(upper.end.as_ref(), lower.end.as_ref(), overlay_bound),
        pack: merge(upper.pack.as_ref(), lower.pack.as_ref(), overlay_pack),
        records: Some(records),
        uncertainty: lower.uncertainty.or(upper.uncertainty),
        lateral: lower.lateral.or(upper.lateral),
    }
}

fn merge<T: Clone>(upper: Option<&T>, lower: Option<&T>, both: fn(&T, &T) -> T) -> Option<T> {
    match (upper, lower) {
        (Some(u), Some(l)) => Some(both(u, l)),
        (u, l) => l.or(u).cloned(),
    }
}

fn overlay_keyframe(upper: &KeyframeLayer, lower: &KeyframeLayer) -> KeyframeLayer {
    let same_kind = lower.kind.is_none() || lower.kind == upper.kind;
    KeyframeLayer {
        kind: lower.kind.or(upper.kind),
        rule: lower.rule.clone().or_else(|| upper.rule.clone()),
        expr: expr_of(lower.rule.as_ref(), lower.expr.as_ref(), upper.expr.as_ref()),
        fallback: lower.fallback.clone().or_else(|| upper.fallback.clone().filter(|_| same_kind)),
    }
}

fn overlay_bound(upper: &BoundLayer, lower: &BoundLayer) -> BoundLayer {
    BoundLayer {
        rule: lower.rule.clone().or_else(|| upper.rule.clone()),
        expr: expr_of(lower.rule.as_ref(), lower.expr.as_ref(), upper.expr.as_ref()),
        fallback: lower.fallback.clone().or_else(|| upper.fallback.clone()),
    }
}

fn overlay_pack(upper: &PackLayer, lower: &PackLayer) -> PackLayer {
    PackLayer {
        before_s: lower.before_s.or(upper.before_s),
        after_s: lower.after_s.or(upper.after_s),
        after_until: lower.after_until.clone().or_else(|| upper.after_until.clone()),
    }
}

/// The expression of the rule in force: from the level that stated the rule, or a later one.
fn expr_of(lower_rule: Option<&Words>, lower: Option<&String>, upper: Option<&String>) -> Option<String> {
    match lower_rule {
        Some(_) => lower.cloned(),
        None => lower.or(upper).cloned(),
    }
}

/// The finished spec, or the names of the fields that no level states.
pub(crate) fn finish(leaf: ScenarioId, layer: &LabelingLayer) -> Result<ResolvedSpec, Vec<&'static str>> {
    let mut missing = Vec::new();
    let keyframe = layer.keyframe.as_ref().and_then(finish_keyframe);
    let start = layer.start.as_ref().and_then(finish_bound);
    let end = layer.end.as_ref().and_then(finish_bound);
    let before_s = layer.pack.as_ref().and_then(|p| p.before_s);
    let after_s = layer.pack.as_ref().and_then(|p| p.after_s);
    let second = layer.second_keyframe.as_ref().map(finish_keyframe);
    for (absent, name) in [
        (keyframe.is_none(), "keyframe"),
        (start.is_none(), "start"),
        (end.is_none(), "end"),
        (before_s.is_none(), "pack.before_s"),
        (after_s.is_none(), "pack.after_s"),
        (matches!(second, Some(None)), "second_keyframe"),
    ] {
        if absent {
            missing.push(name);
        }
    }
    let (Some(keyframe), Some(start), Some(end), Some(before_s), Some(after_s), true) =
        (keyframe, start, end, before_s, after_s, missing.is_empty())
    else {
        return Err(missing);
    };
    Ok(ResolvedSpec {
        leaf,
        keyframe,
        second_keyframe: second.flatten(),
        start,
        end,
        pack: PackSpec {
            before_s,
            after_s,
            after_until: layer.pack.as_ref().and_then(|p| p.after_until.as_ref()).map(finish_moment),
        },
        records: layer.records.iter().flatten().map(finish_record).collect(),
        uncertainty_high: layer.uncertainty == Some(Uncertainty::High),
        lateral: layer.lateral,
    })
}

fn finish_record(r: &RecordLayer) -> RecordSpec {
    let choice = |c: &ChoiceLayer| RecordChoice {
        id: c.id.clone(),
        name: Bilingual::from(&c.name),
        measured: c.measured.clone(),
    };
    RecordSpec {
        id: r.id.clone(),
        name: Bilingual::from(&r.name),
        unit: r.unit.clone(),
        signal: r.signal.clone(),
        object: r.object,
        target: r.target,
        choices: r.choices.iter().map(choice).collect(),
    }
}

fn finish_keyframe(k: &KeyframeLayer) -> Option<KeyframeSpec> {
    Some(KeyframeSpec {
        kind: k.kind?,
        rule: k.rule.as_ref()?.into(),
        expr: k.expr.clone(),
        fallback: k.fallback.as_ref().map(finish_moment),
    })
}

fn finish_bound(b: &BoundLayer) -> Option<BoundSpec> {
    Some(BoundSpec {
        rule: b.rule.as_ref()?.into(),
        expr: b.expr.clone(),
        fallback: b.fallback.as_ref().map(finish_moment),
    })
}

fn finish_moment(m: &MomentLayer) -> MomentSpec {
    MomentSpec { rule: (&m.rule).into(), expr: m.expr.clone() }
}
