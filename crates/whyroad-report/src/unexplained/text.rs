//! Groups of unexplained moments for a terminal.

use super::{LISTED_CLASSES, NearestClass, UndecidedClass, Unexplained, UnexplainedMoment, UnmetPart};
use std::fmt::Write as _;
use whyroad_model::{Lang, ScenarioId};

/// Maximum number of conditions shown for a class.
const SHOWN_UNMET: usize = 3;

/// The groups, one paragraph each.
pub fn render(of: &Unexplained, lang: Lang) -> String {
    let zh = lang == Lang::Zh;
    if of.moments == 0 {
        return match lang {
            Lang::Zh => "没有 other：每个决策时刻都有类别解释\n".to_owned(),
            Lang::En => "no `other`: every decision moment is explained by a class\n".to_owned(),
        };
    }
    let (n, drives, groups) = (of.moments, of.drives, of.groups.len());
    let mut out = if zh {
        format!("{drives} 个行程中有 {n} 个时刻没有类别能解释，分为 {groups} 组\n")
    } else {
        format!(
            "{n} moments in {drives} drives are explained by no class, in {groups} groups of similar ones\n"
        )
    };
    for (i, g) in of.groups.iter().enumerate() {
        let (number, count) = (i + 1, g.moments);
        let (clip, at) = (&g.example.clip_id, at(&g.example, lang));
        let what = ego(&g.example, lang);
        let _ = if zh {
            writeln!(out, "\n{number}. {count} 个时刻，{} 个行程；例：{clip}，{at}，自车 {what}", g.drives)
        } else {
            let times = if count == 1 { "moment" } else { "moments" };
            writeln!(
                out,
                "\n{number}. {count} {times}, drives: {}; example: {clip} at {at}, ego {what}",
                g.drives
            )
        };
        out += &moment(&g.example, lang, |id| of.name(id, lang));
        let others =
            g.nearest.iter().filter(|_| count > 1).map(|(id, n)| format!("{} × {n}", of.name(id, lang)));
        let others: Vec<String> = others.collect();
        if !others.is_empty() {
            let _ = writeln!(
                out,
                "   {} {}",
                if zh { "组内最接近的类别：" } else { "near most of the group:" },
                others.join(if zh { "、" } else { ", " })
            );
        }
    }
    out
}

/// The nearest classes of a moment with what they lack, then those that its drive cannot show, indented; `name` says
/// what a class is called.
pub fn moment(of: &UnexplainedMoment, lang: Lang, name: impl Fn(&ScenarioId) -> String) -> String {
    let mut out = String::new();
    // The id is input for the next command.
    let named = |id: &ScenarioId| format!("{} ({id})", name(id));
    for near in of.nearest.iter().take(LISTED_CLASSES) {
        let _ = writeln!(out, "   {}", class(near, &named(&near.scenario_id), lang));
        for part in near.unmet.iter().take(SHOWN_UNMET) {
            let _ = writeln!(out, "     {}{}", word(part, lang), unmet(part, lang));
        }
        let more = near.unmet.len().saturating_sub(SHOWN_UNMET);
        if more > 0 {
            let _ = match lang {
                Lang::Zh => writeln!(out, "     另有 {more} 个"),
                Lang::En => writeln!(out, "     and {more} more"),
            };
        }
    }
    for open in of.undecided.iter().take(LISTED_CLASSES) {
        let _ = writeln!(out, "   {}", undecided(open, &named(&open.scenario_id), lang));
    }
    out
}

/// Introduces a condition that does not hold.
pub(super) fn word(part: &UnmetPart, lang: Lang) -> &'static str {
    match (part.is_unknown, lang) {
        (false, Lang::Zh) => "不成立：",
        (false, Lang::En) => "not met: ",
        (true, Lang::Zh) => "未知：",
        (true, Lang::En) => "unknown: ",
    }
}

/// A class that the drive cannot show, called `name`.
pub(super) fn undecided(open: &UndecidedClass, name: &str, lang: Lang) -> String {
    let (held, all) = (open.held, open.conditions);
    let missing: Vec<&str> = open.missing_names.iter().map(|n| n.get(lang)).collect();
    let target = open.target_id.as_ref();
    match lang {
        Lang::Zh => {
            let of = target.map_or(String::new(), |t| format!("，目标 {t}"));
            let missing = missing.join("、");
            format!("无法排除：{name}：{all} 个条件中 {held} 个成立，其余未知{of}；行程缺少：{missing}")
        }
        Lang::En => {
            let of = target.map_or(String::new(), |t| format!(", target {t}"));
            let missing = missing.join(", ");
            format!(
                "cannot be ruled out: {name}: {held} of {all} conditions hold, the rest is unknown{of}; \
                 missing: {missing}"
            )
        }
    }
}

/// The time of a moment in its drive and, where that is another, in its clip, as `explain` counts.
pub(super) fn at(of: &UnexplainedMoment, lang: Lang) -> String {
    let (drive, clip) = (of.keyframe_s, of.clip_s);
    match lang {
        _ if (drive - clip).abs() < 0.05 => format!("{drive:.1} s"),
        Lang::Zh => format!("{drive:.1} s（片段内 {clip:.1} s）"),
        Lang::En => format!("{drive:.1} s ({clip:.1} s into the clip)"),
    }
}

/// The ego's speed at the moment, and its actions from there on.
pub fn ego(of: &UnexplainedMoment, lang: Lang) -> String {
    let (then, comma) = match lang {
        Lang::Zh => ("此后", "、"),
        Lang::En => ("from then on ", ", "),
    };
    let actions: Vec<&str> = of.ego_action_names.iter().map(|name| name.get(lang)).collect();
    let actions = Some(actions.join(comma)).filter(|all| !all.is_empty()).map(|all| format!("{then}{all}"));
    let speed = of.ego_speed_mps.map(|v| format!("{v:.1} m/s"));
    let all: Vec<String> = speed.into_iter().chain(actions).collect();
    match (all.is_empty(), lang) {
        (true, Lang::Zh) => "状态未知".to_owned(),
        (true, Lang::En) => "unknown".to_owned(),
        (false, Lang::Zh) => all.join("，"),
        (false, Lang::En) => all.join(", "),
    }
}

/// A class, called `name`, with how many of its conditions hold.
pub(super) fn class(near: &NearestClass, name: &str, lang: Lang) -> String {
    let (held, all) = (near.held, near.conditions);
    let later = all.saturating_sub(held + near.failed);
    let unknown = near.unmet.iter().filter(|part| part.is_unknown).count();
    let failed = near.failed.saturating_sub(unknown);
    let target = near.target_id.as_ref();
    let when = elsewhere(near.offset_s, lang);
    // Its episode is near, but its time range does not contain the moment.
    let found = held == all && near.unmet.is_empty();
    match lang {
        Lang::Zh => {
            let of = target.map_or(String::new(), |t| format!("，目标 {t}"));
            if found {
                return format!("{name}：{all} 个条件都成立{of}，附近已有该类事件，此刻在其时间范围之外");
            }
            let later =
                if later > 0 { format!("，{later} 个在匹配后才判定") } else { String::new() };
            let unknown = if unknown > 0 { format!("，{unknown} 个未知") } else { String::new() };
            format!("{name}：{all} 个条件中 {held} 个成立，{failed} 个不成立{unknown}{later}{of}{when}")
        }
        Lang::En => {
            let of = target.map_or(String::new(), |t| format!(", target {t}"));
            if found {
                return format!(
                    "{name}: all {all} conditions hold{of}; an episode of it is near, but does not contain the moment"
                );
            }
            let later = match later {
                0 => String::new(),
                1 => ", 1 is checked after a match".to_owned(),
                n => format!(", {n} are checked after a match"),
            };
            let fail = if failed == 1 { "does not" } else { "do not" };
            let unknown = match unknown {
                0 => String::new(),
                1 => ", 1 is unknown".to_owned(),
                n => format!(", {n} are unknown"),
            };
            format!("{name}: {held} of {all} conditions hold, {failed} {fail}{unknown}{later}{of}{when}")
        }
    }
}

/// Where the values are not those of the moment itself, of which moment they are.
fn elsewhere(offset_s: f64, lang: Lang) -> String {
    let apart = offset_s.abs();
    match (apart < 0.05, offset_s < 0.0, lang) {
        (true, ..) => String::new(),
        (false, true, Lang::Zh) => format!("，取该时刻前 {apart:.1} s 的值"),
        (false, false, Lang::Zh) => format!("，取该时刻后 {apart:.1} s 的值"),
        (false, true, Lang::En) => format!(", values {apart:.1} s before the moment"),
        (false, false, Lang::En) => format!(", values {apart:.1} s after the moment"),
    }
}

/// A condition with its measured value.
pub(super) fn unmet(part: &UnmetPart, lang: Lang) -> String {
    // The line itself states that the condition does not hold, or is unknown.
    if part.actual_value.is_boolean() || part.is_unknown {
        return part.description.get(lang).to_owned();
    }
    let Some(actual) = part.actual_words.as_ref().map(|words| words.get(lang)) else {
        return part.description.get(lang).to_owned();
    };
    match lang {
        Lang::Zh => format!("{}（实际 {actual}）", part.description.zh),
        Lang::En => format!("{} (is {actual})", part.description.en),
    }
}
