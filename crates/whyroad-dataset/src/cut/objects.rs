//! Tracked objects of a sample: those seen up to t0 within the radius, with their future.

use super::motion::Window;
use crate::pose::known;
use crate::sample::Object;
use crate::spec::Cut;
use std::collections::BTreeSet;
use whyroad_engine::ObjectStates;

/// Objects observed within the history, nearest at their last observation first; named ones are always included.
pub(super) fn around(window: &Window, cut: &Cut, named: &BTreeSet<String>) -> Vec<Object> {
    let t0 = window.time();
    let seconds = |frame: u32| window.drive.times[frame as usize].seconds_since(t0);
    let mut found: Vec<(f64, &ObjectStates)> = Vec::new();
    for o in &window.past.objects {
        let Some(last) = o.frames.len().checked_sub(1) else { continue };
        if seconds(o.frames[last]) < -cut.history_s - 1e-3 {
            continue;
        }
        let (x, y) = window.pose.local(o.motion.x[last], o.motion.y[last]);
        let distance = x.hypot(y);
        if named.contains(o.id.as_str()) || distance <= cut.radius_m {
            found.push((distance, o));
        }
    }
    let is_named = |o: &ObjectStates| named.contains(o.id.as_str());
    found.sort_by(|(a, p), (b, q)| {
        is_named(q).cmp(&is_named(p)).then(a.total_cmp(b)).then_with(|| p.id.cmp(&q.id))
    });
    let keep = found.iter().filter(|(_, o)| is_named(o)).count().max(cut.max_objects);
    found.truncate(keep);
    found.sort_by(|(a, p), (b, q)| a.total_cmp(b).then_with(|| p.id.cmp(&q.id)));
    found.into_iter().map(|(_, o)| object(window, cut, o, is_named(o))).collect()
}

/// A size; a point (a radar target) has a size that is not known.
fn size(value: f64) -> Option<f32> {
    known(value).filter(|size| *size > 0.0)
}

fn object(window: &Window, cut: &Cut, past: &ObjectStates, named: bool) -> Object {
    let t0 = window.time();
    let last = past.frames.len() - 1;
    let mut out = Object {
        id: past.id.0.clone(),
        class: past.class.id().to_owned(),
        named,
        length_m: size(past.length_m[last]),
        width_m: size(past.width_m[last]),
        height_m: size(past.height_m[last]),
        ..Object::default()
    };
    let mut put = |o: &ObjectStates, from_s: f64, to_s: f64| {
        for (row, frame) in o.frames.iter().enumerate() {
            let t = window.drive.times[*frame as usize].seconds_since(t0);
            if t < from_s - 1e-3 || t > to_s + 1e-3 {
                continue;
            }
            let m = &o.motion;
            let (x, y) = window.pose.local(m.x[row], m.y[row]);
            let (vx, vy) = window.pose.turned(m.vx[row], m.vy[row]);
            out.t_s.push(t as f32);
            out.x.push(known(x));
            out.y.push(known(y));
            out.z.push(known(m.z.get(row).copied().unwrap_or(f64::NAN) - window.pose.z));
            out.heading.push(known(window.pose.relative(m.heading[row])));
            out.vx.push(known(vx));
            out.vy.push(known(vy));
        }
    };
    put(past, -cut.history_s, 0.0);
    // From the first frame after t0: states known at t0 are not changed later.
    if let Some(whole) = window.whole.objects.iter().find(|o| o.id == past.id) {
        put(whole, 0.002, cut.future_s);
    }
    out
}
