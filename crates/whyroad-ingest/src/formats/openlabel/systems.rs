//! Coordinate systems of a document and the transforms between them.

use crate::assemble::se3::{Se3, compose as compose_rotations, unit};
use serde_json::Value;
use std::collections::BTreeMap;

/// Maximum length of a chain of systems.
const MAX_CHAIN: usize = 16;

/// Systems by name.
pub(super) struct Systems {
    /// Parent, and the pose in it where it is constant.
    systems: BTreeMap<String, (Option<String>, Option<Se3>)>,
    /// The one that is fixed to the ground.
    pub world: Option<String>,
    /// The one of the recording vehicle.
    pub ego: Option<String>,
}

/// The way from one system to another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    pub pose: Se3,
    /// True when a part of it was stated for this frame.
    pub moves: bool,
}

impl Systems {
    pub fn of(document: &Value) -> Self {
        let all = document.get("coordinate_systems").and_then(Value::as_object);
        let (mut systems, mut world, mut ego) = (BTreeMap::new(), None, None);
        for (name, v) in all.into_iter().flatten() {
            let parent = v.get("parent").and_then(Value::as_str).filter(|p| !p.is_empty()).map(str::to_owned);
            let pose = v.get("pose_wrt_parent").and_then(transform);
            match v.get("type").and_then(Value::as_str) {
                Some("scene_cs" | "geo_cs" | "geo") => drop(world.get_or_insert_with(|| name.clone())),
                Some("local_cs") => drop(ego.get_or_insert_with(|| name.clone())),
                _ => {}
            }
            systems.insert(name.clone(), (parent, pose));
        }
        Self { systems, world, ego }
    }

    /// The system, when there is only one.
    pub fn only(&self) -> Option<String> {
        self.systems.keys().next().filter(|_| self.systems.len() == 1).cloned()
    }

    /// What maps points of `from` into `to` in a frame.
    pub fn between(&self, from: &str, to: &str, frame: &Value) -> Option<Link> {
        let identity = Se3 { q: [1.0, 0.0, 0.0, 0.0], t: [0.0; 3] };
        let mut link = Link { pose: identity, moves: false };
        let mut at = from.to_owned();
        for _ in 0..MAX_CHAIN {
            if at == to {
                return Some(link);
            }
            let (next, pose, moves) = match stated(frame, &at, to) {
                Some((next, pose)) => (next, pose, true),
                None => {
                    let (parent, pose) = self.systems.get(&at)?;
                    (parent.clone()?, (*pose)?, false)
                }
            };
            link = Link { pose: compose(&pose, &link.pose), moves: link.moves || moves };
            at = next;
        }
        None
    }
}

/// A transform that the frame states from `from` to another system: to `to` if there is one.
fn stated(frame: &Value, from: &str, to: &str) -> Option<(String, Se3)> {
    let all = frame.pointer("/frame_properties/transforms")?.as_object()?;
    let mut found = None;
    for v in all.values() {
        let name = |key: &str| v.get(key).and_then(Value::as_str).unwrap_or_default();
        let Some(pose) = v.get("transform_src_to_dst").and_then(transform) else { continue };
        let (next, pose) = match (name("src"), name("dst")) {
            (src, dst) if src == from => (dst, pose),
            // The other way round only where it leads to the goal: chains go up.
            (src, dst) if dst == from && src == to => (src, inverse(&pose)),
            _ => continue,
        };
        if next == to {
            return Some((next.to_owned(), pose));
        }
        found = Some((next.to_owned(), pose));
    }
    found
}

/// `a` after `b`.
pub(super) fn compose(a: &Se3, b: &Se3) -> Se3 {
    Se3 { q: compose_rotations(a.q, b.q), t: a.apply(b.t) }
}

fn inverse(a: &Se3) -> Se3 {
    let back = Se3 { q: [a.q[0], -a.q[1], -a.q[2], -a.q[3]], t: [0.0; 3] };
    Se3 { t: back.apply(a.t).map(|v| -v), ..back }
}

/// Finite numbers.
pub(super) fn numbers(v: &Value) -> Option<Vec<f64>> {
    v.as_array()?.iter().map(|n| n.as_f64().filter(|n| n.is_finite())).collect()
}

/// x, y, z, w, as OpenLABEL writes it.
pub(super) fn quaternion(v: &[f64]) -> Option<[f64; 4]> {
    let [x, y, z, w] = *v else { return None };
    unit([w, x, y, z])
}

/// Angles about the fixed axes x, then y, then z.
pub(super) fn euler(v: &[f64]) -> [f64; 4] {
    let about = |axis: usize| {
        let (sin, cos) = (v.get(axis).copied().unwrap_or(0.0) / 2.0).sin_cos();
        let mut q = [cos, 0.0, 0.0, 0.0];
        q[axis + 1] = sin;
        q
    };
    compose_rotations(about(2), compose_rotations(about(1), about(0)))
}

/// A pose: a matrix, row by row, or a translation with a quaternion or angles.
fn transform(v: &Value) -> Option<Se3> {
    if let Some(m) = v.get("matrix4x4") {
        let m = numbers(m).filter(|m| m.len() == 16)?;
        return Some(Se3 { q: rotation(&m)?, t: [m[3], m[7], m[11]] });
    }
    let t = numbers(v.get("translation")?).filter(|t| t.len() == 3)?;
    let q = match v.get("quaternion") {
        Some(q) => quaternion(&numbers(q)?)?,
        None => euler(&numbers(v.get("euler_angles")?).filter(|e| e.len() == 3)?),
    };
    Some(Se3 { q, t: [t[0], t[1], t[2]] })
}

/// The rotation in a 4x4 matrix (Shepperd's method); `None` when it is not one.
fn rotation(m: &[f64]) -> Option<[f64; 4]> {
    let r = |i: usize, k: usize| m[4 * i + k];
    let trace = r(0, 0) + r(1, 1) + r(2, 2);
    let q = if trace > 0.0 {
        let s = (trace + 1.0).sqrt() * 2.0;
        [s / 4.0, (r(2, 1) - r(1, 2)) / s, (r(0, 2) - r(2, 0)) / s, (r(1, 0) - r(0, 1)) / s]
    } else {
        let i = (0..3).max_by(|&a, &b| r(a, a).total_cmp(&r(b, b)))?;
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let s = (1.0 + r(i, i) - r(j, j) - r(k, k)).max(0.0).sqrt() * 2.0;
        let mut q = [(r(k, j) - r(j, k)) / s, 0.0, 0.0, 0.0];
        q[i + 1] = s / 4.0;
        q[j + 1] = (r(i, j) + r(j, i)) / s;
        q[k + 1] = (r(i, k) + r(k, i)) / s;
        q
    };
    unit(q)
}
