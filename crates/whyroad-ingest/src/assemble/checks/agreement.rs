//! Stated velocities and headings against the positions: a speed in km/h, a heading in degrees, positions in other
//! units than meters. Decided over the first seconds of a drive, for the ego and for each kind of object on its own:
//! what a filter does to the speeds of two cars says nothing about those of people.

use super::{FIRST_FRAMES, warning};
use crate::assemble::angles::wrap_angle;
use crate::assemble::frames::median;
use std::f64::consts::PI;
use whyroad_model::scene::{Drive, Motion};
use whyroad_model::{Bilingual, Diagnostic, ObjectClass};

/// Objects whose values are judged together.
struct Kind {
    who: Who,
    /// Positions are compared over this time, s: noise of 0.3 m at both ends is 0.4 m/s in 1 s.
    span_s: f64,
    /// Slower motion is mostly noise, m/s.
    moving_mps: f64,
    has: fn(ObjectClass) -> bool,
}

const VEHICLES: Kind =
    Kind {
        who: ("其他车辆", "the vehicles"), span_s: 1.0, moving_mps: 3.0, has: |class| class.is_vehicle()
    };
const KINDS: [Kind; 3] = [
    VEHICLES,
    Kind {
        who: ("自行车", "the bicycles"),
        has: |class| matches!(class, ObjectClass::Bicycle | ObjectClass::Bicyclist | ObjectClass::EBike),
        ..VEHICLES
    },
    Kind {
        who: ("行人", "the people"),
        span_s: 2.0,
        moving_mps: 0.8,
        has: |class| matches!(class, ObjectClass::Pedestrian | ObjectClass::WheeledPedestrian),
    },
];
/// Fewer comparisons are no evidence.
const LEAST: usize = 10;
/// A median ratio of stated speed to that of the positions outside of this is another unit, or no speed.
const RATIO: std::ops::RangeInclusive<f64> = 0.67..=1.5;
/// Inside of this it may also be the lag of a filter while all speed up or brake. Another unit is the same factor at
/// any speed: half of the ratios, slow motion included, lie within this share of their median.
const LAG: std::ops::RangeInclusive<f64> = 0.4..=2.5;
const CONSTANT: f64 = 0.1;
/// The least speed of slow motion, as a share of that of motion.
const SLOW: f64 = 1.0 / 3.0;
/// A median angle between heading and direction of motion above this is another unit or convention, rad (30 deg);
/// driving backwards counts as driving forwards.
const APART_RAD: f64 = PI / 6.0;

/// A median difference of stated yaw rate and turn of the heading above this is another unit, rad/s: a car on dry
/// asphalt reaches it at walking pace only.
const YAW_APART_RADPS: f64 = 0.5;
const GRAVITY_MPS2: f64 = 9.81;
const GRAVITY_WITHIN_MPS2: f64 = 2.0;

/// What the rows of a moving object say.
#[derive(Default)]
struct Comparison {
    /// Stated speed, by that of the positions.
    ratios: Vec<f64>,
    /// The same, slow motion included.
    with_slow: Vec<f64>,
    /// The same of the speed of the bus.
    of_bus: Vec<f64>,
    /// Between the stated velocity and the direction of motion, rad.
    of_velocity: Vec<f64>,
    /// Between heading and direction of motion, rad, 0 to 90 deg.
    angles: Vec<f64>,
}

impl Comparison {
    /// Adds the rows of `m`, of an object of this kind; `seconds` are their times.
    fn add(&mut self, kind: &Kind, m: &Motion, seconds: &[f64], bus: &[f64]) {
        let mut end = 0;
        for i in 0..m.len().min(seconds.len()) {
            while end < seconds.len() && seconds[end] < seconds[i] + kind.span_s - 1e-3 {
                end += 1;
            }
            if end >= seconds.len().min(m.len()) {
                break;
            }
            let (dx, dy) = (m.x[end] - m.x[i], m.y[end] - m.y[i]);
            let speed = dx.hypot(dy) / (seconds[end] - seconds[i]);
            if speed.is_nan()
                || speed <= SLOW * kind.moving_mps
                || seconds[end] - seconds[i] > 2.0 * kind.span_s
            {
                continue;
            }
            let middle = (i + end) / 2;
            let mean = |of: &dyn Fn(usize) -> f64| (of(i) + of(middle) + of(end)) / 3.0;
            let stated = mean(&|k| {
                let vector = m.speed(k);
                if vector.is_nan() { m.forward.get(k).map_or(f64::NAN, |v| v.abs()) } else { vector }
            });
            if stated.is_finite() {
                self.with_slow.push(stated / speed);
            }
            if speed <= kind.moving_mps {
                continue;
            }
            if stated.is_finite() {
                self.ratios.push(stated / speed);
            }
            let bus = mean(&|k| bus.get(k).copied().unwrap_or(f64::NAN));
            if bus.is_finite() {
                self.of_bus.push(bus.abs() / speed);
            }
            let course = dy.atan2(dx);
            let turned = wrap_angle(m.vy[middle].atan2(m.vx[middle]) - course).abs();
            if turned.is_finite() && m.speed(middle) > kind.moving_mps {
                self.of_velocity.push(turned);
            }
            let angle = wrap_angle(m.heading[i] - course).abs();
            if angle.is_finite() {
                self.angles.push(angle.min(PI - angle));
            }
        }
    }
}

/// The median of enough values, where `is_wrong`.
fn wrong_median(values: &[f64], is_wrong: impl Fn(f64) -> bool) -> Option<f64> {
    (values.len() >= LEAST).then(|| median(values)).filter(|m| m.is_finite() && is_wrong(*m))
}

fn is_other_unit(ratio: f64) -> bool {
    !RATIO.contains(&ratio)
}

/// The median ratio, where it is that of another unit, or of no speed at all.
fn wrong_ratio(ratios: &[f64], with_slow: &[f64]) -> Option<f64> {
    let ratio = wrong_median(ratios, is_other_unit)?;
    let of_slow = median(with_slow);
    let near = with_slow.iter().filter(|r| (*r - of_slow).abs() <= CONSTANT * of_slow).count();
    let is_constant = is_other_unit(of_slow) && 2 * near >= with_slow.len();
    (is_constant || !LAG.contains(&ratio)).then_some(ratio)
}

/// Whose values are compared. Chinese and English.
type Who = (&'static str, &'static str);

/// What is not to be used, and why.
#[derive(Default)]
struct Verdict {
    velocity: bool,
    heading: bool,
    diagnostics: Vec<Diagnostic>,
}

impl Verdict {
    fn of(c: &Comparison, who: Who) -> Self {
        let is_apart = |angle: f64| angle > APART_RAD;
        let ratio = wrong_ratio(&c.ratios, &c.with_slow);
        let turned = wrong_median(&c.of_velocity, is_apart).filter(|_| ratio.is_none());
        let headed = wrong_median(&c.angles, is_apart);
        let diagnostics = [
            ratio.map(|ratio| speeds(who, ratio)),
            turned.map(|angle| directions(who, angle)),
            headed.map(|angle| headings(who, angle)),
        ];
        Self {
            velocity: ratio.or(turned).is_some(),
            heading: headed.is_some(),
            diagnostics: diagnostics.into_iter().flatten().collect(),
        }
    }

    /// Sets what is not to be used to unknown.
    fn forget(&self, m: &mut Motion) {
        if self.velocity {
            m.vx.fill(f64::NAN);
            m.vy.fill(f64::NAN);
            m.accel.fill(f64::NAN);
            m.forward = Vec::new();
        }
        if self.heading {
            m.heading.fill(f64::NAN);
        }
    }
}

/// Seconds since the first frame, of the frames by which a drive is judged.
fn first_seconds(drive: &Drive) -> Vec<f64> {
    let first = drive.times.len().min(FIRST_FRAMES);
    drive.times[..first].iter().map(|t| t.seconds_since(drive.times[0])).collect()
}

/// Sets velocities and headings of the ego that contradict its positions to unknown, and what else of its motion
/// contradicts itself.
pub(super) fn of_ego(drive: &mut Drive) -> Vec<Diagnostic> {
    let mut out = Vec::new();
    let seconds = first_seconds(drive);
    if let Some(ego) = &mut drive.ego {
        let mut of = Comparison::default();
        of.add(&VEHICLES, &ego.motion, &seconds, &ego.bus.speed_mps);
        let verdict = Verdict::of(&of, ("自车", "the ego"));
        verdict.forget(&mut ego.motion);
        out.extend(verdict.diagnostics);
        out.extend(with_gravity(&mut ego.bus.vertical_accel, seconds.len()));
        if let Some(ratio) = wrong_ratio(&of.of_bus, &of.of_bus) {
            ego.bus.speed_mps = Vec::new();
            out.push(speeds(("车辆总线", "the vehicle bus"), ratio));
        }
    }
    out
}

/// The same of each kind of object; positions have to be over ground. Objects of which too little can be compared share
/// the fault of all the others.
pub(super) fn of_objects(drive: &mut Drive) -> Vec<Diagnostic> {
    let seconds = first_seconds(drive);
    let first = seconds.len();
    let judge = |kind: &Kind| {
        let mut of = Comparison::default();
        for track in drive.tracks.iter().filter(|t| (kind.has)(t.class)) {
            let rows = track.frames.partition_point(|&f| (f as usize) < first);
            let times: Vec<f64> = track.frames[..rows].iter().map(|&f| seconds[f as usize]).collect();
            of.add(kind, &track.motion, &times, &[]);
        }
        let judged = [&of.ratios, &of.angles].map(|values| values.len() >= LEAST);
        (Verdict::of(&of, kind.who), judged)
    };
    let verdicts = KINDS.each_ref().map(judge);
    let all = |fault: fn(&Verdict) -> bool, column: usize| {
        let mut judged = verdicts.iter().filter(|(_, judged)| judged[column]).peekable();
        judged.peek().is_some() && judged.all(|(verdict, _)| fault(verdict))
    };
    let (velocity, heading) = (all(|v| v.velocity, 0), all(|v| v.heading, 1));
    for track in &mut drive.tracks {
        let own = KINDS.iter().position(|kind| (kind.has)(track.class)).map(|k| &verdicts[k]);
        let judged = own.map_or([false; 2], |(_, judged)| *judged);
        let of = |fault: fn(&Verdict) -> bool| own.is_some_and(|(verdict, _)| fault(verdict));
        let verdict = Verdict {
            velocity: if judged[0] { of(|v| v.velocity) } else { velocity },
            heading: if judged[1] { of(|v| v.heading) } else { heading },
            diagnostics: Vec::new(),
        };
        verdict.forget(&mut track.motion);
    }
    verdicts.into_iter().flat_map(|(verdict, _)| verdict.diagnostics).collect()
}

/// Sets stated yaw rates that the headings contradict to unknown.
pub(super) fn turning(m: &mut Motion, seconds: &[f64]) -> Option<Diagnostic> {
    let apart = |i: usize| {
        let shown = wrap_angle(m.heading[i + 1] - m.heading[i]) / (seconds[i + 1] - seconds[i]);
        (m.yaw_rate[i] - shown).abs()
    };
    let rows = m.yaw_rate.len().min(seconds.len()).saturating_sub(1);
    let differences: Vec<f64> = (0..rows).map(apart).filter(|d| d.is_finite()).collect();
    let apart = wrong_median(&differences, |d| d > YAW_APART_RADPS)?;
    m.yaw_rate.fill(f64::NAN);
    let d = warning(
        "ingest.yaw_rate.contradicts",
        format!(
            "自车的横摆角速度与航向矛盾：行程开始时相差 {apart:.1} rad/s（中位数）；横摆角速度记为未知，改由航向估计"
        ),
        format!(
            "the yaw rates of the ego contradict its headings: at the start of the drive they are {apart:.1} rad/s apart \
             (median); they are set to unknown and estimated from the headings"
        ),
    );
    Some(d.with_hint(Bilingual::new(
        "检查横摆角速度的单位（rad/s）：由度每秒换算时乘以 pi/180",
        "check the unit of yaw rates (rad/s): multiply those in degrees per second by pi/180",
    )))
}

/// Sets vertical accelerations that contain gravity to unknown: at rest they are 9.81 m/s2.
fn with_gravity(vertical: &mut Vec<f64>, first: usize) -> Option<Diagnostic> {
    let start = &vertical[..vertical.len().min(first)];
    let middle = wrong_median(start, |m| (m.abs() - GRAVITY_MPS2).abs() < GRAVITY_WITHIN_MPS2)?;
    *vertical = Vec::new();
    let d = warning(
        "ingest.vertical_accel.gravity",
        format!("垂直加速度含重力（行程开始时的中位数为 {middle:.1} m/s2）；记为未知"),
        format!(
            "vertical accelerations contain gravity (their median at the start of the drive is {middle:.1} m/s2); they are \
             set to unknown"
        ),
    );
    Some(d.with_hint(Bilingual::new(
        "在来源中减去 9.81 m/s2，使静止时为 0",
        "subtract 9.81 m/s2 at the source, so that they are 0 at rest",
    )))
}

fn speeds((zh, en): Who, ratio: f64) -> Diagnostic {
    let d = warning(
        "ingest.speed.contradicts",
        format!("{zh}的速度与位置矛盾：行程开始时为位置变化的 {ratio:.2} 倍；速度记为未知，改由位置估计"),
        format!(
            "the speeds of {en} contradict the positions: at the start of the drive they are {ratio:.2} times what the \
             positions show; they are set to unknown and estimated from the positions"
        ),
    );
    let unit = [(3.6, "km/h"), (2.237, "mph"), (1.944, "kn")];
    let unit = unit.iter().find(|(factor, _)| (ratio / factor - 1.0).abs() < 0.1);
    d.with_hint(match unit {
        Some((_, unit)) => Bilingual::new(
            format!("速度的单位像是 {unit}：请换算为 m/s 后重新导入"),
            format!("the speeds seem to be in {unit}: convert them to m/s and ingest again"),
        ),
        None => Bilingual::new(
            "检查速度的单位（m/s）与位置的单位（m）",
            "check the units of speeds (m/s) and of positions (m)",
        ),
    })
}

fn headings((zh, en): Who, angle: f64) -> Diagnostic {
    let degrees = angle.to_degrees();
    warning(
        "ingest.heading.contradicts",
        format!("{zh}的航向与行驶方向矛盾：行程开始时相差 {degrees:.0} 度（中位数）；航向记为未知，改由位置估计"),
        format!(
            "the headings of {en} contradict the direction of motion: at the start of the drive they are {degrees:.0} \
             degrees apart (median); they are set to unknown and estimated from the positions"
        ),
    )
    .with_hint(Bilingual::new(
        "检查航向：弧度，自 x 轴逆时针",
        "check the headings: radians, counter-clockwise from x",
    ))
}

fn directions((zh, en): Who, angle: f64) -> Diagnostic {
    let degrees = angle.to_degrees();
    warning(
        "ingest.speed.contradicts",
        format!("{zh}的速度方向与位置变化的方向相差 {degrees:.0} 度（中位数）；速度记为未知，改由位置估计"),
        format!(
            "the velocities of {en} point {degrees:.0} degrees away from where the positions go (median); they are set to \
             unknown and estimated from the positions"
        ),
    )
    .with_hint(Bilingual::new(
        "vx、vy 须在位置的坐标轴上，而不是车身坐标轴",
        "vx and vy have to be in the axes of the positions, not in those of the car",
    ))
}
