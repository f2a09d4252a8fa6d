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
/// Something that reverses does not drive forwards at this speed, m/s; the direction is known from the track.
const FORWARDS_MPS: f64 = 0.5;
/// Something that brakes hard gets slower: its acceleration is below this, m/s2.
const HARD_MPS2: f64 = 0.3;
/// "Accelerates", where nothing before it negates it.
const FASTER_ZH: [&str; 3] = ["加速", "提速", "加起速"];
const FASTER_EN: [&str; 4] = ["accelerat", "speeding up", "speeds up", "picking up speed"];
/// "Brakes hard".
const HARD_ZH: [&str; 6] = ["急刹", "猛刹", "重刹", "紧急制动", "急减速", "急停"];
const HARD_EN: [&str; 5] = ["brakes hard", "braking hard", "slams on", "emergency brak", "brakes sharply"];
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
            format!(
                "the object's acceleration is {a:.1} m/s2 at the evidence times, which differs from the text"
            ),
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
        Some(SaidState::Slowing)
            if all(&|a| a > if brakes_hard(text) { HARD_MPS2 } else { OPPOSITE_MPS2 }) =>
        {
            Some(accel())
        }
        Some(SaidState::Reversing) if seen.forwards && seen.slowest > FORWARDS_MPS => Some(Bilingual::new(
            format!("该目标在证据时间以 {:.0} km/h 向前行驶，并未倒车", kmh(seen.slowest)),
            format!("the object drives forwards at {:.0} km/h at the evidence times", kmh(seen.slowest)),
        )),
        None if says_faster(text) && all(&|a| a < -OPPOSITE_MPS2) => Some(accel()),
        _ => None,
    }
}

/// "Brakes hard", of whom the text speaks.
fn brakes_hard(text: &str) -> bool {
    let lower = text.to_ascii_lowercase();
    HARD_ZH.iter().any(|w| lower.contains(w)) || HARD_EN.iter().any(|w| lower.contains(w))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::reading;
    use whyroad_framework::Framework;
    use whyroad_framework::lexicon::units::Units;

    fn is_wrong(text: &str, class: ObjectClass, speed: f64, accel: f64) -> bool {
        let words = Framework::bundled().label_words();
        let mut units = Units::default();
        units.cut(text);
        let facts = reading::read(text, &units, words);
        let n = facts.named.first().copied().unwrap_or_else(|| panic!("{text} names nothing"));
        let seen =
            Seen { class, rows: 2, slowest: speed, fastest: speed, accels: vec![accel; 2], forwards: true };
        contradiction(text, &n, words, &seen).is_some()
    }

    /// A car at 5 m/s that brakes by 1 m/s2; somebody on foot who walks at 1.4 m/s (5 km/h).
    #[test]
    fn what_an_object_does_is_compared() {
        let car = |text: &str| is_wrong(text, ObjectClass::Car, 5.0, -1.0);
        assert!(car("前方的轿车正在加速") && car("the car ahead is accelerating"));
        assert!(car("前方的轿车正在倒车") && car("前方的轿车停着不动"));
        for text in [
            "前方的轿车正在减速",
            "前方的轿车没有加速",
            "前方的轿车不再加速",
            "the car ahead is not accelerating",
        ] {
            assert!(!car(text), "{text}");
        }
        assert!(!is_wrong("前方的轿车正在加速", ObjectClass::Car, 5.0, 0.2));
        // A lead that moves off, at 1.9 km/h and 0.6 m/s2: slowing down may be of a moment ago, not an emergency.
        let lead = |text: &str| is_wrong(text, ObjectClass::Car, 0.53, 0.6);
        assert!(
            lead("前方的轿车正在急刹") && lead("the car ahead is braking hard") && lead("前方的轿车正在倒车")
        );
        assert!(!lead("前方的轿车正在减速") && !lead("前方的轿车刚起步") && !lead("前方的轿车停着"));
        let walker = |text: &str, speed: f64| is_wrong(text, ObjectClass::Pedestrian, speed, 0.0);
        assert!(walker("左前方的行人站在路边不动", 1.4) && !walker("左前方的行人站在路边不动", 0.4));
        assert!(!walker("左前方的行人正在横穿", 1.4));
    }
}
