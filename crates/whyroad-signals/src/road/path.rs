//! The ego's driven path: the recorded ("posterior") trajectory of its box center by arc length. Before its first and
//! beyond its last recorded point it continues along the lane (starting at the ego's own offset), or straight if there
//! is no lane. Driven part and continuation are distinguished.

use crate::ego::motion::EgoMotion;
use crate::geometry::{P2, Polyline, Projection, Window, interpolate};
use crate::road::corridor::Corridor;
use crate::road::ego_lane::EgoLane;
use crate::road::network::LEVEL_M;

/// Minimum distance of points, m: at very low speed, noise would bend the path.
const SPACING_M: f64 = 0.5;
/// Length of the continuation at either end, m.
const CONTINUATION_M: f64 = 160.0;
/// Heights are means over this distance on either side, m: altitude is the noisiest part of a pose.
const HEIGHT_REACH_M: f64 = 3.0;
/// The path's direction at a position is that of the chord from this far before it to this far behind it, m.
const HEADING_REACH_M: f64 = 1.0;
/// Distance over which the continuation moves from the ego's offset to the lane's center, m.
const FADE_M: f64 = 20.0;
/// Targets are searched on the path from this far behind to this far ahead of the ego, m.
pub const WINDOW_M: (f64, f64) = (110.0, 160.0);

/// The path by arc length; arc length 0 is where the backward continuation begins.
#[derive(Clone, Debug)]
pub struct DrivenPath {
    /// The line.
    pub line: Polyline,
    /// Arc lengths between which it was really driven, m.
    pub driven: (f64, f64),
    /// Arc length of the ego's center in each frame; NaN where its pose is unknown.
    pub ego_s: Vec<f64>,
    /// Direction of the path at the ego's position in each frame, rad; NaN where its pose is unknown.
    pub ego_heading: Vec<f64>,
    z: Vec<f64>,
}

/// The lane along which to continue from a position: the corridor, the arc length there, and the offset from it.
pub type Continuation<'a> = Option<(&'a Corridor, f64, f64)>;

fn continue_from(start: P2, heading: f64, lane: Continuation<'_>, sign: f64) -> Vec<P2> {
    let steps = (CONTINUATION_M / 2.0) as usize;
    (1..=steps)
        .map(|i| {
            let ds = 2.0 * i as f64;
            match lane {
                Some((corridor, s, offset)) => {
                    let at = s + sign * ds;
                    let left = P2::from_heading(corridor.line.smooth_heading_at(at, 2.0)).left();
                    corridor.line.point_at(at) + left * (offset * (1.0 - ds / FADE_M).max(0.0))
                }
                None => start + P2::from_heading(heading) * (sign * ds),
            }
        })
        .collect()
}

impl DrivenPath {
    /// The path of `ego`; `times` in seconds. `None` when no pose is known.
    pub fn new(
        ego: &EgoMotion,
        times: &[f64],
        before: Continuation<'_>,
        after: Continuation<'_>,
    ) -> Option<Self> {
        let known: Vec<usize> = (0..ego.len()).filter(|&i| ego.is_known(i)).collect();
        let (first, last) = (*known.first()?, *known.last()?);
        let mut frames = vec![first];
        for &i in &known {
            let step = ego.position[i] - ego.position[*frames.last()?];
            // Reversing does not fold the path: only forward motion extends it.
            if step.norm() >= SPACING_M && step.dot(P2::from_heading(ego.heading[i])) > 0.0 {
                frames.push(i);
            }
        }
        let end = *frames.last()?;
        let mut points = continue_from(ego.position[first], ego.heading[first], before, -1.0);
        points.reverse();
        let lead_in = points.len();
        points.extend(frames.iter().map(|&i| ego.position[i]));
        // After reversing, the last frame is not the path's end; the heading at its end counts.
        let after = if end == last || (ego.position[end] - ego.position[last]).norm() < SPACING_M {
            after
        } else {
            None
        };
        points.extend(continue_from(ego.position[end], ego.heading[end], after, 1.0));
        let line = Polyline::new(points)?;
        let s = line.arc_lengths();
        let driven = (s[lead_in.min(s.len() - 1)], s[(lead_in + frames.len() - 1).min(s.len() - 1)]);
        let ego_s = Vec::with_capacity(ego.len());
        let mut path = Self { driven, ego_s, ego_heading: Vec::new(), z: Vec::new(), line };
        path.follow(ego, times);
        let known_heading = |s: &f64| if s.is_nan() { f64::NAN } else { path.heading_at(*s) };
        path.ego_heading = path.ego_s.iter().map(known_heading).collect();
        let heights: Vec<(f64, f64)> = known.iter().map(|&i| (path.ego_s[i], ego.z[i])).collect();
        path.z = path.heights(&heights);
        Some(path)
    }

    fn follow(&mut self, ego: &EgoMotion, times: &[f64]) {
        let (mut s, mut t) = (self.driven.0, times.first().copied().unwrap_or(0.0));
        for (i, &now) in times.iter().enumerate() {
            if !ego.is_known(i) {
                self.ego_s.push(f64::NAN);
                continue;
            }
            // Sufficient for 60 m/s over the time since the last pose; narrow enough not to skip a loop.
            let reach = 5.0 + 60.0 * (now - t);
            s = self.line.project_between(ego.position[i], s - 5.0, s + reach).s;
            t = now;
            self.ego_s.push(s);
        }
    }

    fn heights(&self, known: &[(f64, f64)]) -> Vec<f64> {
        let mut ascending: Vec<(f64, f64)> = known.iter().copied().filter(|(_, z)| z.is_finite()).collect();
        ascending.sort_by(|a, b| a.0.total_cmp(&b.0));
        ascending.dedup_by(|a, b| a.0 - b.0 < 1e-3);
        if ascending.is_empty() {
            return Vec::new();
        }
        let (s, raw): (Vec<f64>, Vec<f64>) = ascending.into_iter().unzip();
        let z = evened(&s, &raw);
        self.line.arc_lengths().iter().map(|&at| interpolate(&s, &z, at)).collect()
    }

    /// Height of the path at `s` (of the ego's box center, constant beyond the driven part); NaN when unknown.
    pub fn z_at(&self, s: f64) -> f64 {
        if self.z.is_empty() { f64::NAN } else { self.line.interpolate(&self.z, s) }
    }

    /// Minimum height difference at `s` between the path and what is on another level, m. Where the path is only
    /// continued, the road may climb: 6 % over the distance beyond the driven part.
    pub fn level_at(&self, s: f64) -> f64 {
        let beyond = (s - self.driven.1).max(self.driven.0 - s).max(0.0);
        LEVEL_M + 0.06 * beyond
    }

    /// Foot point of `p` on the part of the path around the ego, in a frame where its arc length is `ego_s`.
    pub fn project_near(&self, p: P2, ego_s: f64) -> Projection {
        self.line.project_within(p, self.window_near(ego_s))
    }

    /// The part of the path on which targets are searched while the ego is at `ego_s`.
    pub fn window_near(&self, ego_s: f64) -> Window {
        self.line.window(ego_s - WINDOW_M.0, ego_s + WINDOW_M.1)
    }

    /// Direction of the path at `s`, rad.
    pub fn heading_at(&self, s: f64) -> f64 {
        self.line.smooth_heading_at(s, HEADING_REACH_M)
    }

    /// The same as a unit vector, to within rounding: without an angle in between.
    pub fn direction_at(&self, s: f64) -> P2 {
        self.line.smooth_direction_at(s, HEADING_REACH_M)
    }
}

/// Heights without the noise of single poses: at each position the value of a line through those around it.
fn evened(s: &[f64], z: &[f64]) -> Vec<f64> {
    let at = |i: usize| {
        let reach = HEIGHT_REACH_M.min(s[i] - s[0]).min(s[s.len() - 1] - s[i]) + 1e-9;
        let (from, to) =
            (s.partition_point(|v| *v < s[i] - reach), s.partition_point(|v| *v <= s[i] + reach));
        // At very low speed many poses are at one position: each is weighted by the path length that it covers.
        let weight = |k: usize| s[(k + 1).min(s.len() - 1)] - s[k.saturating_sub(1)];
        let total: f64 = (from..to).map(weight).sum();
        if total <= 0.0 { z[i] } else { (from..to).map(|k| weight(k) * z[k]).sum::<f64>() / total }
    };
    (0..s.len()).map(at).collect()
}

/// The driven path, continued along the ego's lanes where it has any.
pub fn driven_path(ego: &EgoMotion, lanes: Option<&EgoLane>, times: &[f64]) -> Option<DrivenPath> {
    let first = (0..ego.len()).find(|&i| ego.is_known(i))?;
    let last = (0..ego.len()).rfind(|&i| ego.is_known(i))?;
    let along = |frame: usize| -> Continuation<'_> {
        lanes.and_then(|l| l.at(frame)).map(|on| (on.corridor, on.s, on.lateral))
    };
    DrivenPath::new(ego, times, along(first), along(last))
}
