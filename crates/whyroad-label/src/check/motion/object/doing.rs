//! What a linked object does, against what the text says that it does.

use super::kind;
use crate::check::reading::Named;
use crate::driven::kmh;
use whyroad_framework::LabelWords;
use whyroad_framework::label_words::SaidState;
use whyroad_model::{Bilingual, ObjectClass};

/// Nothing that stands is faster than this, m/s: people, who hardly move anyway, and others.
const VRU_STANDS_MPS: f64 = 0.8;
const STANDS_MPS: f64 = 1.5;
/// Something that crosses or comes over moves at least this fast, m/s.
const CROSSES_MPS: f64 = 0.2;
/// Something that slows is not getting faster by more than this, and the other way round, m/s2.
const OPPOSITE_MPS2: f64 = 0.7;
/// Something that reverses does not drive forwards at this speed, m/s.
const FORWARDS_MPS: f64 = 1.5;
/// "Accelerates", where nothing before it negates it.
const FASTER_ZH: [&str; 3] = ["加速", "提速", "加起速"];
const FASTER_EN: [&str; 4] = ["accelerat", "speeding up", "speeds up", "picking up speed"];
const NOT_ZH: [&str; 8] = ["不", "没", "没有", "未", "停止", "不再", "减速或", "无法"];
const NOT_EN: [&str; 5] = ["not ", "no longer ", "stopped ", "without ", "n't "];

/// The values of the object at the evidence times and at the keyframe.
pub(super) struct Seen {
    pub class: ObjectClass,
    pub rows: usize,
    /// m/s, lowest and highest.
    pub slowest: f64,
    pub fastest: f64,
    /// m/s2.
    pub accels: Vec<f64>,
    /// It drives backwards in none of the rows.
    pub forwards: bool,
}

/// How the text contradicts what is seen. Chinese and English.
pub(super) fn contradiction(text: &str, n: &Named, words: &LabelWords, seen: &Seen) -> Option<Bilingual> {
    let all = |wrong: &dyn Fn(f64) -> bool| !seen.accels.is_empty() && seen.accels.iter().all(|a| wrong(*a));
    let speed = || {
        let v = kmh(seen.slowest);
        Bilingual::new(
            format!("该目标在证据时间的车速为 {v:.0} km/h，与描述的状态不符"),
            format!("the object moves at {v:.0} km/h at the evidence times, which differs from the text"),
        )
    };
    let accel = || {
        let a = seen.accels.last().copied().unwrap_or(f64::NAN);
        Bilingual::new(
            format!("该目标在证据时间的加速度为 {a:.1} m/s2，与描述的状态不符"),
            format!("the object's acceleration is {a:.1} m/s2 at the evidence times, which differs from the text"),
        )
    };
    let vru = words.objects[n.group].own.meets(kind(words, "vru")) && seen.class.is_vru();
    match n.state {
        Some(SaidState::Standing) if seen.slowest > if vru { VRU_STANDS_MPS } else { STANDS_MPS } => {
            Some(speed())
        }
        Some(SaidState::Crossing | SaidState::CuttingIn) if seen.fastest < CROSSES_MPS && seen.rows > 1 => {
            Some(speed())
        }
        Some(SaidState::Slowing) if all(&|a| a > OPPOSITE_MPS2) => Some(speed()),
        Some(SaidState::Reversing) if seen.forwards && seen.slowest > FORWARDS_MPS => Some(Bilingual::new(
            format!("该目标在证据时间以 {:.0} km/h 向前行驶，并未倒车", kmh(seen.slowest)),
            format!("the object drives forwards at {:.0} km/h at the evidence times", kmh(seen.slowest)),
        )),
        None if says_faster(text) && all(&|a| a < -OPPOSITE_MPS2) => Some(accel()),
        _ => None,
    }
}

fn says_faster(text: &str) -> bool {
    let lower = text.to_ascii_lowercase();
    let stated = |words: &[&str], not: &[&str]| {
        words.iter().any(|word| {
            lower.match_indices(word).any(|(at, _)| {
                let before = lower[..at].trim_end_matches(['地', '在', '正']);
                !not.iter().any(|no| before.ends_with(no.trim_end()) || before.ends_with(no))
            })
        })
    };
    stated(&FASTER_ZH, &NOT_ZH) || stated(&FASTER_EN, &NOT_EN)
}
