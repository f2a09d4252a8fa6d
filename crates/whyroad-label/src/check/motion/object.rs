//! The objects of the components against the tracks: they exist, could be seen at their evidence times, and have the
//! position and motion that the text states.

mod doing;
pub(super) mod place;

use crate::check::reading::Named;
use crate::check::texts::Texts;
use crate::check::view::{ComponentView, View};
use crate::driven::{Driven, HISTORY_FRAMES};
use whyroad_framework::LabelWords;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_framework::label_words::GroupSet;
use whyroad_model::label_fields::pointer;
use whyroad_model::names::class_name;
use whyroad_model::time::frame_at;
use whyroad_model::{Drive, Nanos, ObjectClass, TrackId, Tri};

/// Maximum distance of an object that a text can mean, m.
const NEAR_M: f64 = 80.0;
/// An object that was not observed for this many frames was still in view.
const UNSEEN_FRAMES: usize = 2;
/// Minimum lateral distance at which the side is certain, m.
const SIDE_M: f64 = 1.5;

pub(super) fn check(
    label: &View<'_>,
    texts: &Texts,
    words: &LabelWords,
    w: &Driven<'_>,
    whole: Option<&Drive>,
    sink: &mut dyn Sink,
) {
    let is_late = |id: &TrackId| match w.drive.track(id) {
        Some(t) => t.frames.first().is_some_and(|f| *f as usize > w.keyframe + 2),
        None => whole.is_some_and(|drive| drive.track(id).is_some()),
    };
    for (c, facts) in label.parts.iter().zip(&texts.components) {
        let mut linked = Vec::new();
        let mut broken = false;
        for (k, id) in c.objects.iter().enumerate() {
            let (track, at) =
                (TrackId::from(*id), pointer::critical_components_item_linked_objects_item(c.index, k));
            if is_late(&track) {
                broken = true;
                sink.report(Finding::error("label.object.unseen", at), &|| {
                    Words::new(
                        "该目标在关键帧之后才出现",
                        "the object came into view only after the keyframe",
                    )
                    .hint("关联关键帧时能看到的目标", "link an object that can be seen at the keyframe")
                });
            } else if w.drive.track(&track).is_none() {
                broken = true;
                sink.report(Finding::error("label.object.unknown", at), &|| {
                    Words::new(
                        format!("该行程中没有编号为 {id} 的目标"),
                        format!("the drive has no object with the id {id}"),
                    )
                    .hint("在画面上重新选择该目标", "choose the object in the scene again")
                });
            } else {
                linked.push(*id);
            }
        }
        if broken || unseen(c, &linked, w, sink) {
            continue;
        }
        let things: Vec<&Named> = facts.there().filter(|n| is_tracked(words, n)).collect();
        let denied = || facts.named.iter().filter(|n| n.absent && !n.supposed && is_tracked(words, n));
        if things.is_empty()
            && !linked.is_empty()
            && facts.named.len() == denied().count()
            && denied().next().is_some()
        {
            let at = pointer::critical_components_item_description(c.index);
            sink.report(Finding::warning("label.object.state", at), &|| {
                Words::new(
                    "描述说没有该目标，却关联了一个目标",
                    "the text says that there is none, and an object is linked",
                )
                .hint("改正描述，或去掉关联", "correct the text, or remove the link")
            });
            continue;
        }
        match (&linked[..], &things[..]) {
            ([id], [first, others @ ..]) => said(c, id, (first, others.is_empty()), words, w, sink),
            ([], things) => things.iter().for_each(|n| anybody(c, n, words, w, sink)),
            _ => {}
        }
        light(c, facts.there(), words, w, sink);
    }
}

fn kind(words: &LabelWords, name: &str) -> GroupSet {
    words.kinds.get(name).copied().unwrap_or_default()
}

pub(super) fn is_tracked(words: &LabelWords, n: &Named) -> bool {
    let own = words.objects[n.group].own;
    let tracked = kind(words, "vehicle").with(kind(words, "vru")).with(kind(words, "animal"));
    own.meets(tracked) && !own.meets(kind(words, "queue"))
}

/// Frames in which the component was visible according to the label: its evidence times, or the history of the
/// keyframe.
fn frames_of(c: &ComponentView<'_>, w: &Driven<'_>) -> Vec<usize> {
    let times = &w.drive.times;
    let given: Vec<Nanos> = c.evidence.iter().filter_map(|t| t.get()).collect();
    let inside = |t: &Nanos| times.first().is_some_and(|f| f <= t) && times.last().is_some_and(|l| t <= l);
    given.iter().filter(|t| inside(t)).map(|t| frame_at(times, *t).min(times.len() - 1)).collect()
}

/// Frames between two observations of objects: 1, or more where the log has objects at a lower rate and the frames
/// between were interpolated. Those after the last observation are withheld from a drive that ends at the keyframe.
fn observation_step(drive: &Drive) -> usize {
    let steps = drive.tracks.iter().filter(|t| t.known_at.len() == t.frames.len()).filter_map(|t| {
        let rows = t.frames.iter().map(|f| *f as usize).zip(&t.known_at);
        let observed: Vec<usize> = rows
            .filter(|(f, known)| drive.times.get(*f).is_some_and(|at| at >= *known))
            .map(|(f, _)| f)
            .collect();
        observed.windows(2).map(|pair| pair[1] - pair[0]).min()
    });
    steps.min().unwrap_or(1)
}

/// No linked object was observed at an evidence time.
fn unseen(c: &ComponentView<'_>, linked: &[&str], w: &Driven<'_>, sink: &mut dyn Sink) -> bool {
    if linked.is_empty() {
        return false;
    }
    for (k, frame) in frames_of(c, w).into_iter().enumerate() {
        let within = |frames: usize| {
            let near = |id: &&str| {
                let track = w.drive.track(&TrackId::from(*id));
                track.is_some_and(|t| t.frames.iter().any(|f| (*f as usize).abs_diff(frame) <= frames))
            };
            linked.iter().any(near)
        };
        if within(UNSEEN_FRAMES) || within(observation_step(w.drive)) {
            continue;
        }
        let at = pointer::critical_components_item_evidence_times_item(c.index, k);
        sink.report(Finding::error("label.object.unseen", at), &|| {
            let (zh, en) = match -w.seconds(frame) {
                t if t < 0.05 => ("即关键帧".to_owned(), "the keyframe".to_owned()),
                t => (format!("关键帧前 {t:.1} s"), format!("{t:.1} s before the keyframe")),
            };
            Words::new(
                format!("证据时间（{zh}）没有观测到该目标"),
                format!("the object was not observed at this evidence time ({en})"),
            )
            .hint("写能看到它的时刻", "give a time at which it can be seen")
        });
        return true;
    }
    false
}

/// The linked object has the class, the place, the speed and the state that the text gives it.
/// `n`: the thing that the text names, and whether it names no other.
fn said(
    c: &ComponentView<'_>,
    id: &str,
    (n, is_only): (&Named, bool),
    words: &LabelWords,
    w: &Driven<'_>,
    sink: &mut dyn Sink,
) {
    let signals = w.signals;
    let track = TrackId::from(id);
    let Some(span) = signals.target(&track) else { return };
    let at = pointer::critical_components_item_description(c.index);
    let class = w.drive.track(&track).map_or(ObjectClass::Unknown, |t| t.class);
    let fits = class_fits(words, n, class) && !walks_or_rides(c.description.get(), n, class, words);
    if !fits {
        sink.report(Finding::error("label.object.class", at.clone()), &|| {
            let name = class_name(class);
            Words::new(
                format!("关联的目标是{}，与描述不符", name.zh),
                format!("the linked object is of class '{}', which is not what the text names", name.en),
            )
            .hint("改正描述，或关联另一个目标", "correct the text, or link another object")
        });
    }
    let mut frames = frames_of(c, w);
    frames.push(w.keyframe);
    let rows: Vec<(usize, usize)> = frames.iter().filter_map(|f| Some((*f, span.row(*f)?))).collect();
    let values = |name: &str| -> Vec<f64> {
        let column = signals.target_columns.get(name);
        rows.iter().filter_map(|(_, r)| column.and_then(|c| c.number(*r))).filter(|v| v.is_finite()).collect()
    };
    if place::check(c, (n, is_only), words, &values, &at, sink) {
        return;
    }
    let speeds = values("target.speed");
    let Some(slowest) = speeds.iter().copied().min_by(f64::total_cmp) else { return };
    let fastest = speeds.iter().copied().fold(0.0, f64::max);
    let reverses = signals.target_columns.get("target.reverses");
    let seen = doing::Seen {
        class,
        rows: rows.len(),
        slowest,
        fastest,
        accels: values("target.accel"),
        forwards: reverses.is_some_and(|c| rows.iter().all(|(_, r)| c.flag(*r) == Tri::False)),
    };
    let text = c.description.get().unwrap_or_default();
    if let Some(wrong) = doing::contradiction(text, n, words, &seen) {
        sink.report(Finding::warning("label.object.state", at), &|| {
            Words::new(wrong.zh.clone(), wrong.en.clone())
        });
        return;
    }
    if is_only {
        place::speed(c, words, (slowest, fastest), &at, sink);
    }
}

fn class_fits(words: &LabelWords, n: &Named, class: ObjectClass) -> bool {
    let own = words.objects[n.group].own;
    let (vehicle, vru) = (kind(words, "vehicle"), kind(words, "vru"));
    let motorcycle = own.meets(kind(words, "motorcycle")) || own.meets(kind(words, "rider"));
    match class {
        ObjectClass::Unknown | ObjectClass::StaticObject | ObjectClass::Cone => true,
        ObjectClass::Vehicle => own.meets(vehicle),
        ObjectClass::Car => {
            own.meets(vehicle) && !own.meets(kind(words, "bus")) && !own.meets(kind(words, "truck"))
        }
        ObjectClass::Animal => own.meets(kind(words, "animal")),
        ObjectClass::Motorcycle | ObjectClass::Motorcyclist => motorcycle || own.meets(vehicle),
        c if c.is_vru() => own.meets(vru),
        c if c.is_large_vehicle() => {
            own.meets(vehicle) && !own.meets(kind(words, "car")) && !own.meets(kind(words, "motorcycle"))
        }
        _ => own.meets(vehicle) && !own.meets(kind(words, "bus")),
    }
}

/// The text says that somebody on foot rides, or that a cyclist is on foot.
fn walks_or_rides(text: Option<&str>, n: &Named, class: ObjectClass, words: &LabelWords) -> bool {
    let word = text.and_then(|t| t.get(n.start..n.end)).unwrap_or_default().to_ascii_lowercase();
    // Scooters and the like are people on foot in some logs.
    let rides = ["骑车", "骑行", "自行车", "单车", "cyclist", "bicycl"].iter().any(|w| word.contains(w));
    let walks = ["行人", "路人", "pedestrian"].iter().any(|w| word.contains(w));
    let own = words.objects[n.group].own;
    match class {
        ObjectClass::Pedestrian => rides && own.meets(kind(words, "rider")),
        ObjectClass::Bicyclist => walks && own.meets(kind(words, "pedestrian")),
        _ => false,
    }
}

/// An object of the kind was near in the history, on the side that the text names.
fn anybody(c: &ComponentView<'_>, n: &Named, words: &LabelWords, w: &Driven<'_>, sink: &mut dyn Sink) {
    let signals = w.signals;
    let from = w.keyframe.saturating_sub(HISTORY_FRAMES);
    let number = |name: &str, row: usize| signals.target_columns.get(name).and_then(|c| c.number(row));
    let mut of_kind = false;
    for t in
        signals.targets.iter().filter(|t| class_fits(words, n, t.class) && t.class != ObjectClass::Unknown)
    {
        for f in from..=w.keyframe {
            let Some(row) = t.row(f) else { continue };
            let Some(distance) = number("target.distance", row) else { return };
            if distance > NEAR_M {
                continue;
            }
            of_kind = true;
            let Some(lateral) = number("target.lateral", row) else { return };
            if n.side.is_none_or(|left| if left { lateral > -SIDE_M } else { lateral < SIDE_M }) {
                return;
            }
        }
    }
    // A log that never tracks this kind of object may not support it at all.
    let tracked = signals.targets.iter().any(|t| class_fits(words, n, t.class));
    if !tracked || signals.targets.is_empty() {
        return;
    }
    let at = pointer::critical_components_item_description(c.index);
    let code = if of_kind { "label.object.position" } else { "label.object.unknown" };
    sink.report(Finding::warning(code, at), &|| {
        if of_kind {
            Words::new(
                "关键帧前 2 s 内，描述的那一侧没有这类目标",
                "no such object was on the side that the text names in the 2 s before the keyframe",
            )
        } else {
            Words::new(
                format!("关键帧前 2 s 内，{NEAR_M:.0} m 范围内没有观测到这类目标"),
                format!("no such object was observed within {NEAR_M:.0} m in the 2 s before the keyframe"),
            )
        }
        .hint("检查描述，或关联画面中的目标", "check the text, or link the object in the scene")
    });
}

/// The light has the color that the text states, at one of the evidence times or within the second before the keyframe.
fn light<'n>(
    c: &ComponentView<'_>,
    named: impl Iterator<Item = &'n Named>,
    words: &LabelWords,
    w: &Driven<'_>,
    sink: &mut dyn Sink,
) {
    let Some(text) = c.description.get() else { return };
    let group = kind(words, "light");
    let colors: Vec<&str> = named
        .filter(|n| words.objects[n.group].own.meets(group))
        .filter_map(|n| {
            let word = text[n.start..n.end].to_ascii_lowercase();
            let after =
                word.rsplit_once('变').or_else(|| word.rsplit_once('转')).map_or(&*word, |(_, to)| to);
            let has = |words: &[&str]| words.iter().any(|w| after.contains(w));
            if has(&["红绿灯"]) || has(&["闪", "flash"]) {
                None
            } else if has(&["绿", "green"]) {
                Some("green")
            } else if has(&["黄", "yellow", "amber"]) {
                Some("yellow")
            } else if has(&["红", "red "]) || after.ends_with("red") {
                Some("red")
            } else {
                None
            }
        })
        .collect();
    // "From red to green" names both: then only the last one is compared.
    let Some(said) = colors.last() else { return };
    let mut frames = frames_of(c, w);
    if frames.is_empty() {
        frames.extend(w.keyframe.saturating_sub(10)..=(w.keyframe + 3).min(w.end.saturating_sub(1)));
    } else {
        // A change may be visible slightly before or after.
        frames = frames.iter().flat_map(|f| f.saturating_sub(3)..=f + 3).collect();
    }
    let states: Vec<&str> = frames.iter().filter_map(|f| w.category("light.state", *f)).collect();
    // A kind of green is green; a flashing light is not compared.
    let is = |s: &&&str| s.contains(*said) || s.contains("flashing");
    if states.is_empty() || states.contains(&"none") || states.iter().any(|s| is(&s)) {
        return;
    }
    let at = pointer::critical_components_item_description(c.index);
    sink.report(Finding::error("label.object.light", at), &|| {
        let state = states[states.len() - 1];
        let zh = match state {
            "red" => "红灯",
            "yellow" => "黄灯",
            s if s.contains("green") => "绿灯",
            "off" => "熄灭",
            _ => "其他灯色",
        };
        Words::new(
            format!("关键帧时本车道的信号灯为{zh}，与描述不符"),
            format!("the light for the ego's lane is {state} at the keyframe, which differs from the text"),
        )
    });
}
