//! Groups of unexplained moments for a terminal.

use super::{LISTED_CLASSES, NearestClass, Unexplained, UnexplainedMoment, UnmetPart};
use std::fmt::Write as _;
use whyroad_model::{Bilingual, Lang};

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
        let (clip, at) = (&g.example.clip_id, g.example.keyframe_s);
        let what = ego(&g.example, lang);
        let _ = if zh {
            writeln!(
                out,
                "\n{number}. {count} 个时刻，{} 个行程；例：{clip}，{at:.1} s，自车{what}",
                g.drives
            )
        } else {
            let times = if count == 1 { "moment" } else { "moments" };
            writeln!(
                out,
                "\n{number}. {count} {times}, drives: {}; example: {clip} at {at:.1} s, ego {what}",
                g.drives
            )
        };
        for near in g.example.nearest.iter().take(LISTED_CLASSES) {
            // The id is input for the next command.
            let name = format!("{} ({})", of.name(&near.scenario_id, lang), near.scenario_id);
            let _ = writeln!(out, "   {}", class(near, &name, lang));
            for part in near.unmet.iter().take(SHOWN_UNMET) {
                let _ =
                    writeln!(out, "     {} {}", if zh { "不成立：" } else { "not met:" }, unmet(part, lang));
            }
        }
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

/// Summary of the ego's action.
pub(super) fn ego(of: &UnexplainedMoment, lang: Lang) -> String {
    let speed = of.ego_speed_mps.map(|v| format!("{v:.1} m/s"));
    let actions = of.ego_action_names.iter().map(|name| name.get(lang).to_owned());
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
    let target = near.target_id.as_ref();
    // Its episode is near, but its time range does not contain the moment.
    let found = held == all && near.unmet.is_empty();
    match lang {
        Lang::Zh => {
            let of = target.map_or(String::new(), |t| format!("，目标 {t}"));
            let found = if found { "，附近已有该类事件" } else { "" };
            format!("{name}：{all} 个条件中 {held} 个成立{of}{found}")
        }
        Lang::En => {
            let of = target.map_or(String::new(), |t| format!(", target {t}"));
            let found = if found { ", found nearby" } else { "" };
            format!("{name}: {held} of {all} conditions{of}{found}")
        }
    }
}

/// A condition with its measured value.
pub(super) fn unmet(part: &UnmetPart, lang: Lang) -> String {
    // The line itself states that the condition does not hold.
    if part.actual_value.is_boolean() {
        return part.description.get(lang).to_owned();
    }
    let unknown = Bilingual::new("未知", "unknown");
    let actual = part.actual_words.as_ref().unwrap_or(&unknown).get(lang);
    match lang {
        Lang::Zh => format!("{}（实际 {actual}）", part.description.zh),
        Lang::En => format!("{} (is {actual})", part.description.en),
    }
}
