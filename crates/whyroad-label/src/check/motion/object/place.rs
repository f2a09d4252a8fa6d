//! Where a linked object is, how far away, and how fast, against what the text states.

use super::{SIDE_M, kind};
use crate::check::reading::Named;
use crate::check::view::ComponentView;
use crate::driven::kmh;
use whyroad_framework::LabelWords;
use whyroad_framework::check::{Finding, Sink, Words};

/// Minimum distance along the ego's axis at which ahead and behind are certain, m.
const ALONG_M: f64 = 6.0;
/// Lengths in a text that may be distances; shorter ones are widths and margins, m.
pub(in crate::check::motion) const DISTANCES_M: std::ops::RangeInclusive<f64> = 8.0..=300.0;
/// Distances, m: people estimate, and measure from bumper to bumper or from center to center.
pub(in crate::check::motion) const DISTANCE: Tolerance = Tolerance { share: 0.4, least: 8.0 };
/// Speeds, km/h.
pub(in crate::check::motion) const SPEED: Tolerance = Tolerance { share: 0.4, least: 12.0 };
/// Headings that differ by less are not those of oncoming traffic, rad (100 deg), where the object moves, m/s.
const ONCOMING_RAD: f64 = 1.75;
const MOVES_MPS: f64 = 1.5;
/// Words that place a thing behind the ego: before its name in Chinese, after it in English.
const BEHIND_ZH: [&str; 4] = ["后方的", "后面的", "身后的", "后方"];
const BEHIND_EN: [&str; 3] = [" behind the ego", " behind us", " behind our"];
/// What stands before them where they are about the ego.
const OF_EGO_ZH: [&str; 7] = ["自车", "本车", "我车", "我", "左", "右", "，"];

/// By how much a stated value and a recorded one may differ.
pub(in crate::check::motion) struct Tolerance {
    /// Share of the larger one.
    share: f64,
    /// At least, in the unit of the values.
    least: f64,
}

impl Tolerance {
    /// The two differ by more.
    pub(in crate::check::motion) fn is_exceeded(&self, a: f64, b: f64) -> bool {
        (a - b).abs() > self.least.max(self.share * a.max(b))
    }
}

/// Reports the first contradiction in side, direction or distance. `is_only`: the text names no other road user;
/// `values`: a signal's at the evidence times and at the keyframe.
pub(super) fn check(
    c: &ComponentView<'_>,
    (n, is_only): (&Named, bool),
    words: &LabelWords,
    values: &dyn Fn(&str) -> Vec<f64>,
    at: &str,
    sink: &mut dyn Sink,
) -> bool {
    let all = |v: &[f64], wrong: &dyn Fn(f64) -> bool| !v.is_empty() && v.iter().all(|x| wrong(*x));
    let position = |sink: &mut dyn Sink, is_error: bool, zh: String, en: String| {
        let code = "label.object.position";
        let finding = if is_error {
            Finding::error(code, at.to_owned())
        } else {
            Finding::warning(code, at.to_owned())
        };
        sink.report(finding, &|| {
            Words::new(zh.clone(), en.clone())
                .hint("改正描述，或关联另一个目标", "correct the text, or link another object")
        });
        true
    };
    if let Some(left) = n.side {
        let laterals = values("target.lateral");
        if all(&laterals, &|y| if left { y < -SIDE_M } else { y > SIDE_M }) {
            let (side, y) =
                (if laterals[0] > 0.0 { ("左", "left") } else { ("右", "right") }, laterals[0].abs());
            return position(
                sink,
                true,
                format!("该目标在自车{}侧 {y:.1} m，与描述的方位不符", side.0),
                format!(
                    "the object is {y:.1} m to the {} of the ego, not on the side that the text names",
                    side.1
                ),
            );
        }
    }
    let Some(text) = c.description.get() else { return false };
    let ahead = values("target.longitudinal");
    let behind = said_behind(text, n);
    let wrong =
        if behind { all(&ahead, &|x| x > ALONG_M) } else { n.ahead && all(&ahead, &|x| x < -ALONG_M) };
    if wrong {
        let (x, place) =
            (ahead[0].abs(), if ahead[0] > 0.0 { ("前方", "ahead of") } else { ("后方", "behind") });
        return position(
            sink,
            false,
            format!("该目标在自车{} {x:.0} m，与描述的方位不符", place.0),
            format!("the object is {x:.0} m {} the ego, which differs from the text", place.1),
        );
    }
    if words.objects[n.group].own.meets(kind(words, "oncoming")) || said_oncoming(text, n) {
        let (turned, speeds) = (values("target.heading_difference"), values("target.speed"));
        // Without a speed, of an object that was seen for the first time, its box says where it faces.
        if all(&turned, &|a| a.abs() < ONCOMING_RAD) && speeds.iter().all(|v| *v > MOVES_MPS) {
            let degrees = turned[0].to_degrees().abs();
            return position(
                sink,
                false,
                format!("该目标的航向与自车相差 {degrees:.0}°，不是对向来车"),
                format!(
                    "the object's heading differs from the ego's by {degrees:.0} degrees: it is not oncoming"
                ),
            );
        }
    }
    // A text with one length and one thing: how far away it is.
    let lengths = words.quantities.lengths(text);
    let distances = values("target.distance");
    if let ([said], false) = (lengths.as_slice(), distances.is_empty()) {
        let is = said.value;
        let differs = |d: f64| DISTANCE.is_exceeded(d, is);
        let of_it = is_only && !names_speed(text) && !names_place(text);
        if of_it && DISTANCES_M.contains(&is) && all(&distances, &differs) {
            let d = distances[distances.len() - 1];
            return position(
                sink,
                false,
                format!("该目标距自车 {d:.0} m，描述为 {is:.0} m"),
                format!("the object is {d:.0} m from the ego, the text states {is:.0} m"),
            );
        }
    }
    false
}

/// Reports a speed that differs from the recorded ones, m/s.
pub(super) fn speed(
    c: &ComponentView<'_>,
    words: &LabelWords,
    (slowest, fastest): (f64, f64),
    at: &str,
    sink: &mut dyn Sink,
) {
    let Some(text) = c.description.get() else { return };
    let speeds = words.quantities.find(text, "km/h");
    let ([said], true, false) = (speeds.as_slice(), names_speed(text), names_other_speed(text)) else {
        return;
    };
    let is = said.value;
    let differs = |v: f64| SPEED.is_exceeded(v, is);
    let (low, high) = (kmh(slowest), kmh(fastest));
    if !differs(low) || !differs(high) || (low..=high).contains(&is) {
        return;
    }
    sink.report(Finding::warning("label.object.state", at.to_owned()), &|| {
        Words::new(
            format!("该目标的车速为 {high:.0} km/h，描述为 {is:.0} km/h"),
            format!("the object moves at {high:.0} km/h, the text states {is:.0} km/h"),
        )
    });
}

fn names_speed(text: &str) -> bool {
    ["时速", "车速", "km/h", "kph", "公里/小时", "每小时"].iter().any(|w| text.contains(w))
}

/// The text names a limit, or the ego's speed, to which a speed could belong; that of a road user in a junction is its
/// own.
fn names_other_speed(text: &str) -> bool {
    let lower = text.to_ascii_lowercase();
    ["限速", "limit", "自车车速"].iter().any(|w| lower.contains(w))
}

/// The text calls the thing oncoming.
fn said_oncoming(text: &str, n: &Named) -> bool {
    let before = text[..n.start].to_ascii_lowercase();
    ["对向的", "对向", "迎面而来的", "迎面驶来的", "oncoming "].iter().any(|w| before.ends_with(w))
        || text[n.end..].to_ascii_lowercase().starts_with(" is oncoming")
}

/// The text places the thing behind the ego.
fn said_behind(text: &str, n: &Named) -> bool {
    let (before, after) = (&text[..n.start], text[n.end..].to_ascii_lowercase());
    // What is behind a hedge or another vehicle may be ahead of the ego.
    let of_ego = |rest: &str| rest.is_empty() || OF_EGO_ZH.iter().any(|w| rest.ends_with(w));
    BEHIND_ZH.iter().any(|w| before.strip_suffix(w).is_some_and(of_ego))
        || BEHIND_EN.iter().any(|w| after.starts_with(w))
}

/// The text names a place to which a number could belong.
fn names_place(text: &str) -> bool {
    const OTHERS: [&str; 14] = [
        "路口",
        "停止线",
        "斑马线",
        "限速",
        "限高",
        "匝道",
        "junction",
        "intersection",
        "stop line",
        "crosswalk",
        "limit",
        "from the",
        "of the lane",
        "自车车速",
    ];
    let lower = text.to_ascii_lowercase();
    OTHERS.iter().any(|w| lower.contains(w))
}
