//! The longitudinal decision against the ego's speed in the 6 s after the keyframe.

use super::window::{STANDSTILL_MPS, Window, kmh};
use crate::check::recording::Recorded;
use crate::check::view::View;
use whyroad_framework::DecisionSets;
use whyroad_framework::check::{Finding, Sink, Slot, Words};
use whyroad_framework::lexicon::SaidSpeed;
use whyroad_model::decision::Longitudinal;
use whyroad_model::label_fields::pointer;
use whyroad_model::{Bilingual, Tri};

/// A change of speed that is no noise, m/s.
const PLAIN_MPS: f64 = 1.5;
/// A change that a labeler cannot have overlooked, m/s.
const LARGE_MPS: f64 = 3.0;
/// What a car that keeps its speed varies by, m/s.
const STEADY_MPS: f64 = 0.5;
/// A share of the speed at the keyframe: below it the car is about to stop.
const NEARLY_STOPPED: f64 = 0.5;

pub(super) fn check(label: &View<'_>, w: &Window<'_>, names: &DecisionSets, sink: &mut dyn Sink) {
    let Some(v0) = w.speed(w.keyframe) else { return };
    let Some(all) = w.speeds(w.keyframe..w.end).filter(|_| w.lasts(2.0)) else { return };
    let decision = match label.longitudinal {
        Slot::Is(d) => d,
        Slot::Absent => return unlabelled(w, v0, sink),
        Slot::Broken => return,
    };
    let name = names
        .longitudinal(decision)
        .map_or_else(|| Bilingual::new(decision.id(), decision.id()), |t| t.name.clone());
    let contradicts = |sink: &mut dyn Sink, zh: String, en: String| {
        sink.report(
            Finding::error("label.motion.contradicts", pointer::DRIVING_DECISION_LONGITUDINAL),
            &|| {
                Words::new(
                    format!("标注为“{}”，但记录显示：{zh}", name.zh),
                    format!("the label says '{}', but the recording shows: {en}", name.en.to_lowercase()),
                )
                .hint(
                    "对照车速曲线检查决策和关键帧",
                    "check the decision and the keyframe against the speed plot",
                )
            },
        );
    };
    let unchanged = |sink: &mut dyn Sink| {
        sink.report(Finding::warning("label.motion.no_change", pointer::DRIVING_DECISION_LONGITUDINAL), &|| {
            let (from, to) = (kmh(all.min), kmh(all.max));
            Words::new(
                format!("关键帧后 6 s 自车车速不变（{from:.0} 至 {to:.0} km/h）：没有“{}”", name.zh),
                format!(
                    "the ego keeps its speed for 6 s after the keyframe ({from:.0} to {to:.0} km/h): no '{}'",
                    name.en.to_lowercase()
                ),
            )
            .hint("没有新的动作时选“无决策变化”；否则检查关键帧", "where nothing changes choose 'no change of decision'; otherwise check the keyframe")
        });
    };
    let stands = v0 < STANDSTILL_MPS;
    let speeds_up = |sink: &mut dyn Sink| {
        let (t, v) = (w.seconds(all.max_at), kmh(all.max));
        contradicts(
            sink,
            format!("自车加速，{t:.1} s 后由 {:.0} 升至 {v:.0} km/h", kmh(v0)),
            format!("the ego speeds up, from {:.0} to {v:.0} km/h {t:.1} s after the keyframe", kmh(v0)),
        );
    };
    let only_faster = all.min > v0 - STEADY_MPS && all.max > v0 + PLAIN_MPS;
    let steady = w.lasts(6.0) && all.max - all.min < STEADY_MPS && !stands;
    match decision {
        Longitudinal::StopForRegulation | Longitudinal::StopForObstacle => {
            if only_faster {
                return speeds_up(sink);
            }
            let Some(range) = w.speeds(w.keyframe..w.range_end) else { return };
            let slows_still = range.last < NEARLY_STOPPED * v0 && range.last <= range.min + STEADY_MPS;
            if range.min >= STANDSTILL_MPS && !slows_still && w.lasts(6.0) {
                let (t, v) = (w.seconds(range.min_at), kmh(range.min));
                contradicts(
                    sink,
                    format!("自车没有停下，最低车速 {v:.0} km/h（关键帧后 {t:.1} s）"),
                    format!(
                        "the ego does not stop; its lowest speed is {v:.0} km/h, {t:.1} s after the keyframe"
                    ),
                );
            }
        }
        Longitudinal::YieldToAgent | Longitudinal::RoadSpeedAdaptation => {
            if only_faster {
                speeds_up(sink);
            } else if steady {
                unchanged(sink);
            }
        }
        Longitudinal::LeadFollowing => {
            let known = |f: &usize| w.flag("lead.exists", *f) != Tri::Unknown;
            let frames = w.keyframe.saturating_sub(10)..w.end;
            let none = frames.clone().all(|f| w.flag("lead.exists", f) == Tri::False);
            if none && frames.filter(known).count() > 20 {
                contradicts(
                    sink,
                    "关键帧前 1 s 至后 6 s，自车行驶路径内没有前车".to_owned(),
                    "no lead in the ego's path from 1 s before to 6 s after the keyframe".to_owned(),
                );
            }
        }
        Longitudinal::SetSpeedTracking => {
            if all.min < STANDSTILL_MPS && v0 > LARGE_MPS {
                let t = w.seconds(all.min_at);
                contradicts(
                    sink,
                    format!("自车由 {:.0} km/h 减速，{t:.1} s 后停下", kmh(v0)),
                    format!("the ego slows from {:.0} km/h and stands {t:.1} s after the keyframe", kmh(v0)),
                );
            }
        }
        Longitudinal::Resume => {
            let from = w.keyframe.saturating_sub(10);
            let moving = w.speeds(from..w.keyframe + 1).is_some_and(|s| s.min > 1.0);
            if moving && w.speeds(w.keyframe..w.end).is_some_and(|s| s.min > 1.0) {
                contradicts(
                    sink,
                    format!("关键帧时自车正以 {:.0} km/h 行驶，并未停车", kmh(v0)),
                    format!("the ego moves at {:.0} km/h at the keyframe; it does not stand", kmh(v0)),
                );
            } else if all.max < 0.5 && w.lasts(6.0) {
                contradicts(
                    sink,
                    "关键帧后 6 s 内自车一直没有起步".to_owned(),
                    "the ego does not move off within 6 s of the keyframe".to_owned(),
                );
            }
        }
        Longitudinal::AccelerationForPassing => {
            if all.max < v0 + STEADY_MPS && all.min < v0 - PLAIN_MPS {
                let (t, v) = (w.seconds(all.min_at), kmh(all.min));
                contradicts(
                    sink,
                    format!("自车减速，{t:.1} s 后由 {:.0} 降至 {v:.0} km/h", kmh(v0)),
                    format!("the ego slows, from {:.0} to {v:.0} km/h {t:.1} s after the keyframe", kmh(v0)),
                );
            } else if steady {
                unchanged(sink);
            }
        }
        Longitudinal::GapMatching => {}
    }
    if decision == Longitudinal::StopForRegulation {
        lead_before_line(w, sink);
    }
}

/// What a text says of the ego's speed, against its speed in the 6 s after the keyframe. Chinese and English.
pub(in crate::check) fn said_speed(
    said: SaidSpeed,
    label: &View<'_>,
    recorded: &Recorded,
    keyframe: usize,
) -> Option<Bilingual> {
    let w = Window::new(label, recorded, keyframe);
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
        // Who stops later has begun to slow by then.
        SaidSpeed::Stops if w.lasts(6.0) && all.min > LARGE_MPS && all.last > NEARLY_STOPPED * v0 => {
            Some(lowest)
        }
        _ => None,
    }
}

/// A null decision, although the ego plainly changes its speed at once.
fn unlabelled(w: &Window<'_>, v0: f64, sink: &mut dyn Sink) {
    let soon = w.keyframe..(w.keyframe + 31).min(w.end);
    let Some(s) = w.speeds(soon) else { return };
    // What was under way at the keyframe is no new decision.
    let before = w.speed(w.keyframe.saturating_sub(10)).unwrap_or(v0);
    let underway = (v0 - before).abs() > 0.6;
    // Gaining speed after a turn or a stop is ordinary; starting from standstill is not.
    let starts = v0 < STANDSTILL_MPS;
    let change = if starts { s.max - v0 } else { s.min - v0 };
    if underway || change.abs() < LARGE_MPS {
        return;
    }
    let t = w.seconds(if change < 0.0 { s.min_at } else { s.max_at });
    sink.report(Finding::warning("label.motion.unlabelled", pointer::DRIVING_DECISION_LONGITUDINAL), &|| {
        let (from, to) = (kmh(v0), kmh(v0 + change));
        Words::new(
            format!("纵向决策为“无决策变化”，但自车在 {t:.1} s 内由 {from:.0} 变为 {to:.0} km/h"),
            format!("the longitudinal decision is 'no change', but the ego goes from {from:.0} to {to:.0} km/h within {t:.1} s"),
        )
        .hint("补上关键帧后的第一个决策", "add the first decision after the keyframe")
    });
}

/// Who stops behind a stopped lead stops for the lead, not for the line beyond it.
fn lead_before_line(w: &Window<'_>, sink: &mut dyn Sink) {
    let f = w.keyframe;
    let (Some(gap), Some(speed)) = (w.number("lead.gap", f), w.number("lead.speed", f)) else { return };
    let Some(line) = w.number("light.distance_to_stop_line", f) else { return };
    if w.flag("lead.exists", f) != Tri::True || speed > 1.0 || gap + 3.0 > line || gap > 60.0 {
        return;
    }
    sink.report(Finding::warning("label.cause.proximate", pointer::DRIVING_DECISION_LONGITUDINAL), &|| {
        Words::new(
            format!("自车与停止线（{line:.0} m）之间有停着的前车（{gap:.0} m）：近因是前车"),
            format!("a stopped lead ({gap:.0} m) stands between the ego and the stop line ({line:.0} m): it is the proximate cause"),
        )
        .hint("停在前车之后是“跟车”", "stopping behind a lead is lead following")
    });
}
