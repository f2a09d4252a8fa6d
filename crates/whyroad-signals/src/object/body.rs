//! An object's motion, with one entry per frame from its first to its last observation; NaN where it was not observed.

use crate::geometry::{OrientedBox, P2, p2};
use whyroad_model::scene::{Ego, Motion};
use whyroad_model::{Drive, FrameRange, ObjectClass};

/// One object. All vectors have an entry for each of `frames`.
pub struct Body {
    /// Index of its track; `None` is the ego.
    pub track: Option<usize>,
    /// Class.
    pub class: ObjectClass,
    /// Frames from its first to its last observation.
    pub frames: FrameRange,
    /// Box center, m, world; NaN where it is not observed.
    pub position: Vec<P2>,
    /// Height of the box center, m.
    pub z: Vec<f64>,
    /// rad.
    pub heading: Vec<f64>,
    /// Over ground, m/s, world.
    pub velocity: Vec<P2>,
    /// Along the heading, m/s2.
    pub accel: Vec<f64>,
    /// m.
    pub length: Vec<f64>,
    /// m.
    pub width: Vec<f64>,
}

impl Body {
    fn unseen(track: Option<usize>, class: ObjectClass, frames: FrameRange) -> Self {
        let n = frames.len();
        let (number, point) = (vec![f64::NAN; n], vec![p2(f64::NAN, f64::NAN); n]);
        Self {
            track,
            class,
            frames,
            position: point.clone(),
            z: number.clone(),
            heading: number.clone(),
            velocity: point,
            accel: number.clone(),
            length: number.clone(),
            width: number,
        }
    }

    fn take(&mut self, at: usize, motion: &Motion, row: usize, (length, width): (f64, f64)) {
        self.position[at] = p2(motion.x[row], motion.y[row]);
        self.velocity[at] = p2(motion.vx[row], motion.vy[row]);
        self.z[at] = motion.z[row];
        self.heading[at] = motion.heading[row];
        self.accel[at] = motion.accel[row];
        self.length[at] = length;
        self.width[at] = width;
    }

    /// Index of a frame in the vectors, if the object is observed in it.
    pub fn at(&self, frame: usize) -> Option<usize> {
        let i = self.frames.contains(frame).then(|| frame - self.frames.start)?;
        self.position[i].is_finite().then_some(i)
    }

    /// The box; its sizes or heading may be NaN.
    pub fn footprint(&self, i: usize) -> OrientedBox {
        OrientedBox::new(self.position[i], self.heading[i], self.length[i], self.width[i])
    }

    /// True when its box is known.
    pub fn has_box(&self, i: usize) -> bool {
        self.footprint(i).is_known()
    }

    /// A point of the world in the object's axes, x forward, y left.
    pub fn sees(&self, i: usize, p: P2) -> P2 {
        self.in_axes(i, p - self.position[i])
    }

    /// A vector of the world in the object's axes.
    pub fn in_axes(&self, i: usize, v: P2) -> P2 {
        let forward = P2::from_heading(self.heading[i]);
        p2(v.dot(forward), v.dot(forward.left()))
    }
}

/// All objects: the tracks that have rows in their order, then the ego if it is given and any of its poses is known.
pub fn bodies(drive: &Drive, ego: Option<&Ego>) -> Vec<Body> {
    let mut all = Vec::with_capacity(drive.tracks.len() + 1);
    for (k, track) in drive.tracks.iter().enumerate().filter(|(_, t)| !t.frames.is_empty()) {
        let mut body = Body::unseen(Some(k), track.class, track.span());
        for (row, frame) in track.frames.iter().enumerate() {
            let size = (track.length_m[row], track.width_m[row]);
            body.take(*frame as usize - body.frames.start, &track.motion, row, size);
        }
        all.push(body);
    }
    if let Some(ego) = ego {
        let known = |i: &usize| ego.motion.x[*i].is_finite() && ego.motion.y[*i].is_finite();
        let rows: Vec<usize> = (0..ego.motion.len()).filter(known).collect();
        if let (Some(&first), Some(&last)) = (rows.first(), rows.last()) {
            let mut body = Body::unseen(None, ObjectClass::Car, FrameRange::new(first, last + 1));
            for i in rows {
                body.take(i - first, &ego.motion, i, (ego.length_m, ego.width_m));
            }
            all.push(body);
        }
    }
    all
}
