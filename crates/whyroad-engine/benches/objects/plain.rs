//! The questions of this bench as loops over all pairs and frames: what somebody would write first.

use std::io::Write;
use whyroad_model::ObjectClass;
use whyroad_model::scene::{Drive, Motion};

/// One object: class, motion, length and width.
type Object<'a> = (ObjectClass, &'a Motion, f64, f64);

fn objects(drive: &Drive) -> Vec<Object<'_>> {
    let tracks = drive.tracks.iter().map(|t| (t.class, &t.motion, t.length_m[0], t.width_m[0]));
    tracks.chain(drive.ego.iter().map(|e| (ObjectClass::Car, &e.motion, e.length_m, e.width_m))).collect()
}

fn corners(o: &Object<'_>, i: usize) -> [(f64, f64); 4] {
    let (m, c, s) = (o.1, o.1.heading[i].cos(), o.1.heading[i].sin());
    [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(a, b)| {
        let (u, v) = (a * o.2 / 2.0, b * o.3 / 2.0);
        (m.x[i] + u * c - v * s, m.y[i] + u * s + v * c)
    })
}

fn to_segment(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let t = (((p.0 - a.0) * dx + (p.1 - a.1) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    (a.0 + t * dx - p.0).hypot(a.1 + t * dy - p.1)
}

fn distance(a: &Object<'_>, b: &Object<'_>, i: usize) -> f64 {
    let (p, q) = (corners(a, i), corners(b, i));
    let mut least = f64::INFINITY;
    for k in 0..4 {
        for l in 0..4 {
            least = least.min(to_segment(p[k], q[l], q[(l + 1) % 4]));
            least = least.min(to_segment(q[k], p[l], p[(l + 1) % 4]));
        }
    }
    least
}

/// By object and frame, whether question `k` is answered with yes.
pub fn answer(drive: &Drive, k: usize) -> Vec<bool> {
    let all = objects(drive);
    let mut out = Vec::new();
    for a in &all {
        for i in 0..drive.times.len() {
            let mut count = 0;
            for b in all.iter().filter(|b| !std::ptr::eq(b.1, a.1)) {
                let apart = distance(a, b, i);
                let (dx, dy) = (b.1.x[i] - a.1.x[i], b.1.y[i] - a.1.y[i]);
                let (c, s) = (a.1.heading[i].cos(), a.1.heading[i].sin());
                let (x, y) = (dx * c + dy * s, dy * c - dx * s);
                count += usize::from(match k {
                    0 => {
                        b.0 == ObjectClass::Bicycle && apart <= 50.0 && x.abs() <= a.2 / 2.0 && y < -a.3 / 2.0
                    }
                    1 => b.0 == ObjectClass::Car && apart <= 10.0,
                    _ => {
                        b.0 == ObjectClass::Pedestrian
                            && apart <= 50.0
                            && y.atan2(x).abs() <= 22.5_f64.to_radians()
                    }
                });
            }
            out.push(count >= if k == 1 { 2 } else { 1 });
        }
    }
    out
}

/// One line per object and frame: object, class, frame, x, y, heading, length, width.
pub fn write_csv(drive: &Drive, out: &mut impl Write) -> std::io::Result<()> {
    for (n, o) in objects(drive).iter().enumerate() {
        for i in 0..drive.times.len() {
            let (x, y, h) = (o.1.x[i], o.1.y[i], o.1.heading[i]);
            writeln!(out, "{n},{},{i},{x},{y},{h},{},{}", o.0, o.2, o.3)?;
        }
    }
    Ok(())
}
