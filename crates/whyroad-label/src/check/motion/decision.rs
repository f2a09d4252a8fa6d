//! The longitudinal decision against the ego's speed in the 6 s after the keyframe.

use super::driven;
use crate::check::recording::Recorded;
use crate::check::view::View;
use crate::driven::along::{self, Conflict, LARGE_MPS, NEARLY_STOPPED, PLAIN_MPS, STEADY_MPS};
use crate::driven::{Driven, STANDSTILL_MPS, kmh};
use whyroad_framework::DecisionSets;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_framework::lexicon::SaidSpeed;
use whyroad_model::decision::Longitudinal;
use whyroad_model::label_fields::pointer;
use whyroad_model::{Bilingual, Tri};

pub(super) fn check(label: &View<'_>, w: &Driven<'_>, names: &DecisionSets, sink: &mut dyn Sink) {
    let decision = match label.longitudinal {
        Slot::Is(d) => Some(d),
        Slot::Absent => None,
        Slot::Broken => return,
    };
    let conflict = along::conflict(w, decision);
    if let Some(conflict) = conflict {
        report(w, decision, conflict, names, sink);
    }
    let faster = matches!(conflict, Some(Conflict::SpeedsUp { .. }));
    if decision == Some(Longitudinal::StopForRegulation) && !faster && along::known_speeds(w).is_some() {
        lead_before_line(w, sink);
    }
}

/// Reports the contradiction between a decision and the recorded motion.
fn report(
    w: &Driven<'_>,
    decision: Option<Longitudinal>,
    conflict: Conflict,
    names: &DecisionSets,
    sink: &mut dyn Sink,
) {
    let at = pointer::DRIVING_DECISION_LONGITUDINAL;
    let Some(decision) = decision else {
        let Conflict::Changes { to, frame } = conflict else { return };
        let (from, to, t) = (kmh(w.speed(w.keyframe).unwrap_or(f64::NAN)), kmh(to), w.seconds(frame));
        sink.report(Finding::warning("label.motion.unlabelled", at), &|| {
            Words::new(
                format!("纵向决策为“无决策变化”，但自车在 {t:.1} s 内由 {from:.0} 变为 {to:.0} km/h"),
                format!("the longitudinal decision is 'no change', but the ego goes from {from:.0} to {to:.0} km/h within {t:.1} s"),
            )
            .hint("补上关键帧后的第一个决策", "add the first decision after the keyframe")
        });
        return;
    };
    let name = names
        .longitudinal(decision)
        .map_or_else(|| Bilingual::new(decision.id(), decision.id()), |t| t.name.clone());
    if let Conflict::Unchanged { min, max } = conflict {
        sink.report(Finding::warning("label.motion.no_change", at), &|| {
            let (from, to) = (kmh(min), kmh(max));
            let en = name.en.to_lowercase();
            let said = if max < STANDSTILL_MPS {
                Words::new(
                    format!("关键帧后 6 s 自车一直停着：没有“{}”", name.zh),
                    format!("the ego goes on standing for 6 s after the keyframe: no '{en}'"),
                )
            } else {
                Words::new(
                    format!("关键帧后 6 s 自车车速不变（{from:.0} 至 {to:.0} km/h）：没有“{}”", name.zh),
                    format!("the ego keeps its speed for 6 s after the keyframe ({from:.0} to {to:.0} km/h): no '{en}'"),
                )
            };
            said.hint(
                "没有新的动作时选“无决策变化”；否则检查关键帧",
                "if nothing changes choose 'no change of decision'; otherwise check the keyframe",
            )
        });
        return;
    }
    if let Conflict::MovesOff { to, frame } = conflict {
        sink.report(Finding::warning("label.motion.no_change", at), &|| {
            let (to, t) = (kmh(to), w.seconds(frame));
            Words::new(
                format!("关键帧时自车已停住，{t:.1} s 后升至 {to:.0} km/h：“{}”在关键帧之前", name.zh),
                format!(
                    "the ego stands at the keyframe and drives {to:.0} km/h {t:.1} s later: '{}' comes before the keyframe",
                    name.en.to_lowercase()
                ),
            )
            .hint(
                "第一个新动作是起步时选“起步”；否则检查关键帧",
                "if moving off is the first new action choose 'resume'; otherwise check the keyframe",
            )
        });
        return;
    }
    let shown = in_words(w, conflict);
    sink.report(Finding::error("label.motion.contradicts", at), &|| {
        Words::new(
            format!("标注为“{}”，但记录显示：{}", name.zh, shown.zh),
            format!("the label is '{}', but the recording shows: {}", name.en.to_lowercase(), shown.en),
        )
        .hint("对照车速曲线检查决策和关键帧", "check the decision and the keyframe against the speed plot")
    });
}

/// The recorded motion as text. Chinese and English.
fn in_words(w: &Driven<'_>, conflict: Conflict) -> Bilingual {
    let from = kmh(w.speed(w.keyframe).unwrap_or(f64::NAN));
    match conflict {
        Conflict::SpeedsUp { to, frame } => {
            let (v, t) = (kmh(to), w.seconds(frame));
            Bilingual::new(
                format!("自车加速，{t:.1} s 后由 {from:.0} 升至 {v:.0} km/h"),
                format!("the ego speeds up, from {from:.0} to {v:.0} km/h {t:.1} s after the keyframe"),
            )
        }
        Conflict::Slows { to, frame } => {
            let (v, t) = (kmh(to), w.seconds(frame));
            Bilingual::new(
                format!("自车减速，{t:.1} s 后由 {from:.0} 降至 {v:.0} km/h"),
                format!("the ego slows, from {from:.0} to {v:.0} km/h {t:.1} s after the keyframe"),
            )
        }
        Conflict::NoStop { lowest, frame } => {
            let (v, t) = (kmh(lowest), w.seconds(frame));
            Bilingual::new(
                format!("自车没有停下，最低车速 {v:.0} km/h（关键帧后 {t:.1} s）"),
                format!(
                    "the ego does not stop; its lowest speed is {v:.0} km/h, {t:.1} s after the keyframe"
                ),
            )
        }
        Conflict::NoLead => Bilingual::new(
            "关键帧前 1 s 至后 6 s，自车行驶路径内没有前车",
            "no lead in the ego's path from 1 s before to 6 s after the keyframe",
        ),
        Conflict::Stops { frame } => {
            let t = w.seconds(frame);
            Bilingual::new(
                format!("自车由 {from:.0} km/h 减速，{t:.1} s 后停下"),
                format!("the ego slows from {from:.0} km/h and stops {t:.1} s after the keyframe"),
            )
        }
        Conflict::Moves => Bilingual::new(
            format!("关键帧时自车正以 {from:.0} km/h 行驶，并未停车"),
            format!("the ego moves at {from:.0} km/h at the keyframe; it is not stationary"),
        ),
        Conflict::Stays => Bilingual::new(
            "关键帧后 6 s 内自车一直没有起步",
            "the ego does not move off within 6 s of the keyframe",
        ),
        Conflict::Unchanged { .. } | Conflict::Changes { .. } | Conflict::MovesOff { .. } => {
            Bilingual::default()
        }
    }
}

/// The ego's speed as stated in a text, against its speed in the 6 s after the keyframe. Chinese and English.
pub(in crate::check) fn said_speed(
    said: SaidSpeed,
    label: &View<'_>,
    recorded: &Recorded,
    keyframe: usize,
) -> Option<Bilingual> {
    let w = driven(label, recorded, keyframe);
    let v0 = w.speed(keyframe)?;
    let all = w.speeds(keyframe..w.end).filter(|_| w.lasts(2.0))?;
    let shown = |at: usize, v: f64| {
        let (from, to, t) = (kmh(v0), kmh(v), w.seconds(at));
        Bilingual::new(
            format!("自车车速由 {from:.0} 变为 {to:.0} km/h（关键帧后 {t:.1} s）"),
            format!("the ego goes from {from:.0} to {to:.0} km/h, {t:.1} s after the keyframe"),
        )
    };
    let (highest, lowest) = (shown(all.max_at, all.max), shown(all.min_at, all.min));
    match said {
        SaidSpeed::Faster if all.max < v0 + STEADY_MPS && all.min < v0 - PLAIN_MPS => Some(lowest),
        SaidSpeed::Slower if all.min > v0 - STEADY_MPS && all.max > v0 + PLAIN_MPS => Some(highest),
        // An ego that stops later has begun to slow by then.
        SaidSpeed::Stops if w.lasts(6.0) && all.min > LARGE_MPS && all.last > NEARLY_STOPPED * v0 => {
            Some(lowest)
        }
        _ => None,
    }
}

/// An ego that stops behind a stopped lead stops because of the lead, not because of the line beyond it.
fn lead_before_line(w: &Driven<'_>, sink: &mut dyn Sink) {
    let f = w.keyframe;
    let (Some(gap), Some(speed)) = (w.number("lead.gap", f), w.number("lead.speed", f)) else { return };
    let Some(line) = w.number("light.distance_to_stop_line", f) else { return };
    if w.flag("lead.exists", f) != Tri::True || speed > 1.0 || gap + 3.0 > line || gap > 60.0 {
        return;
    }
    sink.report(Finding::warning("label.cause.proximate", pointer::DRIVING_DECISION_LONGITUDINAL), &|| {
        Words::new(
            format!("自车与停止线（{line:.0} m）之间有停着的前车（{gap:.0} m）：近因是前车"),
            format!("a stopped lead ({gap:.0} m) is between the ego and the stop line ({line:.0} m): it is the proximate cause"),
        )
        .hint("停在前车之后是“跟车”", "stopping behind a lead is lead following")
    });
}
