//! An explanation as text: a verdict, then a bar over time for each condition.

use super::Shown;
use serde_json::Value;
use std::fmt::Write as _;
use whyroad_mining::explain::{Cell, ConditionCourse, Course, Duration, Explanation, Outcome};
use whyroad_mining::language::check::Join;
use whyroad_mining::rule::PartPlace;
use whyroad_model::messages::EgoResponse;
use whyroad_model::{Lang, Nanos, Tri};

/// 20 s at 10 Hz are 50 signs of four frames each.
const FRAMES_A_SIGN: usize = 4;

/// The whole text.
pub(super) fn render(shown: &Shown<'_>, lang: Lang) -> String {
    let e = shown.explanation;
    let mut out = verdict(shown, lang);
    out.push('\n');
    if e.parts.is_empty() {
        if let Some(moments) = &shown.moments {
            out += &moments.text(lang);
        }
        return out;
    }
    let _ = writeln!(out, "\n{}", axis(shown.times_s));
    line(&mut out, &e.when, 0, whole(lang), lang);
    for Line { depth, text, condition } in lines(e, lang) {
        line(&mut out, &condition.course, 2 * depth, &text, lang);
    }
    if let Some(frame) = e.moment {
        let at = frame / FRAMES_A_SIGN;
        let _ = writeln!(out, "{:at$}^ {:.1} s", "", shown.seconds(frame));
    }
    let _ = writeln!(out, "\n{}", legend(shown.has_gaps(), lang));
    if e.parts.iter().any(|p| any_kept(&p.condition)) {
        out.push_str(match lang {
            Lang::Zh => "噪声内：与阈值之差不超过噪声，沿用上一帧的结果\n",
            Lang::En => "within noise: too near the threshold to change the answer of the frame before\n",
        });
    }
    if let Some(moments) = &shown.moments {
        out += &moments.text(lang);
    }
    out
}

/// The outcome of the rule, in a sentence; also the title of the image.
pub(super) fn verdict(shown: &Shown<'_>, lang: Lang) -> String {
    let e = shown.explanation;
    let called = |name: &str| match (name, lang) {
        ("target", Lang::Zh) => "目标".to_owned(),
        _ => name.to_owned(),
    };
    let roles: Vec<String> = e.roles.iter().map(|(name, id)| format!("{} {id}", called(name))).collect();
    let who = match (roles.is_empty(), lang) {
        (true, _) => String::new(),
        (_, Lang::Zh) => format!("（{}）", roles.join("、")),
        (_, Lang::En) => format!(" ({})", roles.join(", ")),
    };
    let (class, clip) = (shown.title.get(lang), shown.clip);
    if let Some(outcome) =
        shown.moments.as_ref().and_then(|m| m.outcome(e.moment.map(|f| (f, shown.seconds(f))), lang))
    {
        return match lang {
            Lang::Zh => format!("{class}，片段 {clip}：{outcome}"),
            Lang::En => format!("{class} in {clip}: {outcome}"),
        };
    }
    let mut out = match lang {
        Lang::Zh => format!("{class}，片段 {clip}{who}：{}", outcome_zh(shown)),
        Lang::En => format!("{class} in {clip}{who}: {}", outcome_en(shown)),
    };
    for variant in &shown.variants {
        let class = variant.title.get(lang);
        let at = variant.frame.map(|frame| shown.seconds(frame));
        let _ = match (lang, at) {
            (Lang::Zh, Some(at)) => write!(out, "\n变体已定：挖掘结果中为 {class}，关键帧在 {at:.1} s"),
            (Lang::Zh, None) => write!(out, "\n变体已定：挖掘结果中为 {class}，关键帧在片段之外"),
            (Lang::En, Some(at)) => {
                write!(out, "\nits variant is known: mining reports {class} instead, keyframe at {at:.1} s")
            }
            (Lang::En, None) => write!(
                out,
                "\nits variant is known: mining reports {class} instead, keyframe at a time outside the clip"
            ),
        };
    }
    if e.candidates > 1 {
        let _ = match lang {
            Lang::Zh => write!(out, "\n{} 个候选中最接近的一个", e.candidates),
            Lang::En => write!(out, "\nbest of {} candidates", e.candidates),
        };
    }
    if !e.missing.is_empty() {
        let missing: Vec<&str> = shown.missing.iter().map(|name| name.get(lang)).collect();
        let missing = missing.join(if lang == Lang::Zh { "、" } else { ", " });
        let _ = match lang {
            Lang::Zh => write!(out, "\n此行程不可观测，缺少信号：{missing}"),
            Lang::En => write!(out, "\nnot observable in this drive, which lacks {missing}"),
        };
    }
    out
}

fn outcome_en(shown: &Shown<'_>) -> String {
    let e = shown.explanation;
    let at = match e.moment {
        Some(f) => format!("{:.1} s (frame {f})", shown.seconds(f)),
        None => "a time outside the clip".to_owned(),
    };
    match e.outcome {
        Outcome::Matched => {
            let response = match e.response {
                Some(EgoResponse::Observed) => "; the ego responds",
                Some(EgoResponse::Absent) => "; the ego does not respond",
                Some(EgoResponse::Unknown) => "; whether the ego responds is unknown",
                None => "",
            };
            format!("matches, keyframe at {at}{response}")
        }
        Outcome::NotAtKeyframe => {
            format!("does not match: the conditions required at the keyframe, {at}, do not hold")
        }
        Outcome::WrongDuration => {
            let lasted = e.duration.map(|d| duration(d, Lang::En)).unwrap_or_default();
            format!("does not match: its conditions held together at {at}{lasted}")
        }
        Outcome::NotTogether => {
            format!("does not match: its conditions never held together, nearest at {at}")
        }
        Outcome::Undecided if e.moment.is_some() => {
            format!("cannot be decided in this clip: at {at} no condition is known to fail")
        }
        Outcome::Undecided => "cannot be decided in this clip".to_owned(),
        Outcome::NoCandidate => "no object in this clip can be its target".to_owned(),
    }
}

fn outcome_zh(shown: &Shown<'_>) -> String {
    let e = shown.explanation;
    let at = match e.moment {
        Some(f) => format!("{:.1} s（第 {f} 帧）", shown.seconds(f)),
        None => "片段之外".to_owned(),
    };
    match e.outcome {
        Outcome::Matched => {
            let response = match e.response {
                Some(EgoResponse::Observed) => "；自车有响应",
                Some(EgoResponse::Absent) => "；自车无响应",
                Some(EgoResponse::Unknown) => "；自车是否响应未知",
                None => "",
            };
            format!("匹配，关键帧在 {at}{response}")
        }
        Outcome::NotAtKeyframe => format!("不匹配：关键帧 {at} 处须成立的条件不成立"),
        Outcome::WrongDuration => {
            let lasted = e.duration.map(|d| duration(d, Lang::Zh)).unwrap_or_default();
            format!("不匹配：条件在 {at} 同时成立{lasted}")
        }
        Outcome::NotTogether => format!("不匹配：条件从未同时成立，最接近处在 {at}"),
        Outcome::Undecided if e.moment.is_some() => {
            format!("在此片段中无法判定：在 {at} 没有已知不成立的条件")
        }
        Outcome::Undecided => "在此片段中无法判定".to_owned(),
        Outcome::NoCandidate => "此片段中没有可作目标的对象".to_owned(),
    }
}

/// How long conditions held together, and how long they must.
fn duration(of: Duration, lang: Lang) -> String {
    let seconds = |t: Nanos| (t.0 as f64 / 1e7).round() / 1e2;
    let held = seconds(of.held);
    match (of.most.filter(|most| of.held > *most), lang) {
        (Some(most), Lang::Zh) => format!("，持续 {held} s，超过允许的 {} s", seconds(most)),
        (Some(most), Lang::En) => format!(" for {held} s, longer than the maximum of {} s", seconds(most)),
        (None, Lang::Zh) => format!("，持续 {held} s，短于要求的 {} s", seconds(of.least)),
        (None, Lang::En) => format!(" for {held} s, shorter than the required {} s", seconds(of.least)),
    }
}

/// Name of the line for all conditions together.
pub(super) fn whole(lang: Lang) -> &'static str {
    match lang {
        Lang::Zh => "全部条件",
        Lang::En => "all conditions",
    }
}

/// A condition as it is listed.
pub(super) struct Line<'a> {
    /// Number of conditions that it is a member of.
    pub depth: usize,
    /// Its words, how its members decide it, and the measured value.
    pub text: String,
    pub condition: &'a ConditionCourse,
}

/// The parts of the rule, each above its members.
pub(super) fn lines<'a>(e: &'a Explanation, lang: Lang) -> Vec<Line<'a>> {
    let mut out = Vec::new();
    for part in &e.parts {
        let first = out.len();
        push_lines(&part.condition, 0, lang, &mut out);
        let place = match (part.place, lang) {
            (PartPlace::When, _) => "",
            (PartPlace::Require, Lang::Zh) => "关键帧处：",
            (PartPlace::Require, Lang::En) => "at the keyframe: ",
        };
        out[first].text.insert_str(0, place);
    }
    out
}

fn push_lines<'a>(condition: &'a ConditionCourse, depth: usize, lang: Lang, out: &mut Vec<Line<'a>>) {
    let mut text = label(condition, depth, lang);
    if let Some(value) = actual(condition, lang) {
        let _ = write!(text, "  [{value}]");
    }
    out.push(Line { depth, text, condition });
    condition.members.iter().for_each(|m| push_lines(m, depth + 1, lang, out));
}

/// The words of a condition, and how its members decide it. The words of a conjunction or disjunction without a name
/// are those of its members: below another condition they are left out.
fn label(condition: &ConditionCourse, depth: usize, lang: Lang) -> String {
    let words = condition.words.get(lang);
    let join = match (condition.join, lang) {
        (Join::All, Lang::Zh) => "全部成立",
        (Join::All, Lang::En) => "all of",
        (Join::Any, Lang::Zh) => "任一成立",
        (Join::Any, Lang::En) => "any of",
        (Join::Single | Join::Not | Join::OverTime, _) => "",
    };
    let mut notes: Vec<&str> = Some(join).filter(|j| !j.is_empty()).into_iter().collect();
    if condition.is_listed_above {
        notes.push(if lang == Lang::Zh { "见上" } else { "see above" });
    }
    if notes == [join] && depth > 0 && !condition.is_named {
        return join.to_owned();
    }
    match (notes.is_empty(), lang) {
        (true, _) => words.to_owned(),
        (false, Lang::Zh) => format!("{words}（{}）", notes.join("，")),
        (false, Lang::En) => format!("{words} ({})", notes.join(", ")),
    }
}

/// The measured value with its unit; nothing where the condition itself is the measure.
fn actual(atom: &ConditionCourse, lang: Lang) -> Option<String> {
    let word = |zh: &str, en: &str| Some(if lang == Lang::Zh { zh } else { en }.to_owned());
    if !atom.is_measured {
        return None;
    }
    match &atom.actual {
        Value::Number(_) | Value::String(_) => {
            let value = atom.actual_words.as_ref()?.get(lang);
            Some(match (is_kept(atom), lang) {
                (false, _) => value.to_owned(),
                (true, Lang::Zh) => format!("{value}，噪声内"),
                (true, Lang::En) => format!("{value}, within noise"),
            })
        }
        Value::Null if atom.course.truth == Tri::Unknown => word("未知", "unknown"),
        Value::Null => atom.actual_words.as_ref().map(|words| words.get(lang).to_owned()),
        _ => None,
    }
}

/// True where the answer is that of the frame before, because the value differs from the threshold by no more than its
/// noise: then the margin is 0, although the two are not equal.
fn is_kept(atom: &ConditionCourse) -> bool {
    let differ = |(value, threshold): (f64, f64)| (value - threshold).abs() > 1e-9 * threshold.abs().max(1.0);
    atom.course.truth != Tri::Unknown
        && atom.course.margin == 0.0
        && atom.actual.as_f64().zip(atom.threshold).is_some_and(differ)
}

fn any_kept(condition: &ConditionCourse) -> bool {
    is_kept(condition) || condition.members.iter().any(any_kept)
}

fn line(out: &mut String, course: &Course, indent: usize, text: &str, lang: Lang) {
    let bar: String = course.cells.chunks(FRAMES_A_SIGN).map(sign).collect();
    let mark = mark(course.truth, lang);
    let _ = writeln!(out, "{bar}  {:indent$}{mark} {text}", "");
}

/// Text of a truth value; all texts of one language are equally wide.
pub(super) fn mark(truth: Tri, lang: Lang) -> &'static str {
    match (truth, lang) {
        (Tri::True, Lang::En) => "yes",
        (Tri::False, Lang::En) => "no ",
        (Tri::Unknown, Lang::En) => "?  ",
        (Tri::True, Lang::Zh) => "是",
        (Tri::False, Lang::Zh) => "否",
        (Tri::Unknown, Lang::Zh) => "？",
    }
}

fn sign(frames: &[Cell]) -> char {
    let count = |c: Cell| frames.iter().filter(|f| **f == c).count();
    let yes = count(Cell::Known(Tri::True));
    if count(Cell::Absent) == frames.len() {
        ' '
    } else if yes == frames.len() {
        '#'
    } else if yes > 0 {
        '+'
    } else if count(Cell::Known(Tri::Unknown)) > 0 {
        '?'
    } else {
        '.'
    }
}

fn axis(times_s: &[f64]) -> String {
    let mut out = String::new();
    for (frame, seconds) in times_s.iter().enumerate().step_by(48) {
        let at = frame / FRAMES_A_SIGN;
        let gap = at.saturating_sub(out.chars().count());
        let _ = write!(out, "{:gap$}|{seconds:.1} s", "");
    }
    out
}

fn legend(has_gaps: bool, lang: Lang) -> &'static str {
    match lang {
        Lang::Zh if has_gaps => {
            "一格 4 帧（0.4 s，日志缺帧处不占格）：# 成立，+ 部分成立，. 不成立，? 未知，空白为目标不可见；是、否与 [实际值] 均指 ^ 所示时刻"
        }
        Lang::En if has_gaps => {
            "a sign is 4 frames (0.4 s; gaps of the log take no room): # true, + partly true, . false, ? unknown,\n\
             blank where the target is not observed; yes, no and [values] are those at ^"
        }
        Lang::Zh => {
            "一格 0.4 s：# 成立，+ 部分成立，. 不成立，? 未知，空白为目标不可见；是、否与 [实际值] 均指 ^ 所示时刻"
        }
        Lang::En => {
            "a sign is 0.4 s: # true, + partly true, . false, ? unknown, blank where the target is not observed;\n\
             yes, no and [values] are those at ^"
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use whyroad_model::Bilingual;

    /// "x < 2 s" where x is 1.97 s; `margin` as the rule language defines it: 0 where noise keeps an answer.
    fn below_two(margin: f64, value: f64) -> ConditionCourse {
        ConditionCourse {
            text: "x < 2 s".into(),
            words: Bilingual::same("x < 2 s"),
            definition: None,
            is_named: false,
            join: Join::Single,
            members: vec![],
            is_listed_above: false,
            is_measured: true,
            course: Course { cells: vec![], truth: Tri::False, margin },
            actual: value.into(),
            actual_words: Some(Bilingual::same(format!("{value} s"))),
            unit: "s",
            values: vec![],
            threshold: Some(2.0),
        }
    }

    #[test]
    fn a_value_that_noise_keeps_from_changing_the_answer_is_marked() {
        assert_eq!(actual(&below_two(0.0, 1.97), Lang::En).unwrap(), "1.97 s, within noise");
        assert_eq!(actual(&below_two(0.0, 1.97), Lang::Zh).unwrap(), "1.97 s，噪声内");
        assert_eq!(actual(&below_two(-0.4, 2.4), Lang::En).unwrap(), "2.4 s");
        assert_eq!(actual(&below_two(0.0, 2.0), Lang::En).unwrap(), "2 s", "equal, not kept");
    }
}
