//! Signs and stop lines on the ego's path.

mod relevance;

use crate::geometry::{P2, p2};
use crate::road::facilities::line_crossings;
use crate::road::junction::distance_to_next;
use crate::road::network::DEFAULT_HALF_WIDTH_M;
use crate::road::on_road::{OnRoad, time_to};
use crate::road::stretch::Stretch;
use crate::table::TableBuilder;
use relevance::{concerned, route};
use std::collections::BTreeSet;
use whyroad_model::catalog::value::{SignProhibitionKind, SignWarningKind};
use whyroad_model::catalog::{CategoryValue, Number, PerFrame, Signal, id};
use whyroad_model::road_map::{Point3, Sign};
use whyroad_model::scene::Track;
use whyroad_model::vocabulary::{PROHIBITIONS, WARNINGS};

/// Distance signals, with the kinds of signs that each measures.
const DISTANCES: [(Signal<PerFrame, Number>, &[&str]); 6] = [
    (id::SIGN_STOP_DISTANCE, &["stop"]),
    (id::SIGN_YIELD_DISTANCE, &["yield"]),
    (id::SIGN_SPEED_LIMIT_DISTANCE, &["speed_limit"]),
    (id::SIGN_LANE_ARROW_DISTANCE, &["lane_arrow"]),
    (id::SIGN_PROHIBITION_DISTANCE, PROHIBITIONS),
    (id::SIGN_WARNING_DISTANCE, WARNINGS),
];

/// Signs that apply to the ego, in the order in which its path passes them.
struct OnPath<'a> {
    signs: Vec<&'a Sign>,
    stretches: Vec<Stretch>,
}

impl<'a> OnPath<'a> {
    fn new(on: &OnRoad<'a>, tracked: &'a [Sign], kinds: &[&str], route: &BTreeSet<String>) -> Self {
        let all = on.map.signs.iter().chain(tracked);
        let wanted = all.filter(|s| kinds.contains(&s.kind.as_str()));
        let mut found: Vec<(f64, &Sign)> =
            wanted.filter_map(|sign| Some((concerned(on, sign, route)?, sign))).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let stretches = found.iter().map(|(s, _)| Stretch { from: *s, to: *s }).collect();
        Self { signs: found.into_iter().map(|(_, sign)| sign).collect(), stretches }
    }

    /// The kind of the next one, without the prefix of its group; `None` where the ego's position is unknown.
    fn next_kind<C: CategoryValue>(&self, on: &OnRoad<'_>, frame: usize, prefix: &str) -> Option<C> {
        let s = on.path.ego_s[frame];
        if s.is_nan() {
            return None;
        }
        let next = self.stretches.iter().position(|x| x.to >= s);
        let near = next.filter(|&k| distance_to_next(&self.stretches[k..], s, on.ego.front()).is_finite());
        let Some(k) = near else { return C::from_name("none") };
        let kind = self.signs[k].kind.as_str();
        C::from_name(kind.strip_prefix(prefix).unwrap_or(kind)).or_else(|| C::from_name("unspecified"))
    }
}

/// Stop signs that the log contains as objects (as in AV2), at the position of their first observation.
fn tracked_stop_signs(on: &OnRoad<'_>) -> Vec<Sign> {
    let tracks = on.drive.tracks.iter().filter(|t| t.source_class.eq_ignore_ascii_case("stop_sign"));
    let sign = |t: &Track| {
        let (x, y, z) = (*t.motion.x.first()?, *t.motion.y.first()?, *t.motion.z.first()?);
        (x.is_finite() && y.is_finite()).then(|| Sign {
            id: t.id.to_string(),
            kind: "stop".to_owned(),
            position: Point3 { x, y, z },
            facing: t.motion.heading.first().copied().filter(|h| h.is_finite()),
            ..Sign::default()
        })
    };
    tracks.filter_map(sign).collect()
}

/// Positions where the path crosses a stop line; for one given only as a point, where the path passes it within half a
/// lane.
fn stop_lines(on: &OnRoad<'_>) -> Vec<Stretch> {
    let mut found: Vec<Stretch> = Vec::new();
    for line in &on.map.stop_lines {
        let corners: Vec<P2> = line.line.iter().map(|p| p2(p.x, p.y)).collect();
        if let [point] = corners[..] {
            let at = on.path.line.project(point);
            found.extend(
                (at.lateral.abs() <= DEFAULT_HALF_WIDTH_M).then_some(Stretch { from: at.s, to: at.s }),
            );
            continue;
        }
        found.extend(line_crossings(on.path, &corners).into_iter().map(|s| Stretch { from: s, to: s }));
    }
    found.sort_by(|a, b| a.from.total_cmp(&b.from));
    found
}

/// Writes `sign.*`, `map.distance_to_stop_line`, `map.time_to_stop_line`.
pub fn write(on: &OnRoad<'_>, table: &mut TableBuilder<'_>) {
    let front = on.ego.front();
    let next = |stretches: &[Stretch]| -> Vec<f64> {
        (0..on.frames()).map(|i| distance_to_next(stretches, on.path.ego_s[i], front)).collect()
    };
    let route = route(on);
    let tracked = tracked_stop_signs(on);
    for (id, kinds) in DISTANCES {
        let seen = tracked.iter().any(|s| kinds.contains(&s.kind.as_str()));
        if !seen && !kinds.iter().any(|kind| on.map.covers(kind)) {
            continue;
        }
        let found = OnPath::new(on, &tracked, kinds, &route);
        table.number(id, next(&found.stretches));
        if kinds == PROHIBITIONS {
            let kind = |i| found.next_kind::<SignProhibitionKind>(on, i, "");
            table.category(id::SIGN_PROHIBITION_KIND, (0..on.frames()).map(kind));
        } else if kinds == WARNINGS {
            let kind = |i| found.next_kind::<SignWarningKind>(on, i, "warning_");
            table.category(id::SIGN_WARNING_KIND, (0..on.frames()).map(kind));
        }
    }
    let lines = stop_lines(on);
    // A map without stop lines does not show that there are none.
    let distance = if on.map.stop_lines.is_empty() { vec![f64::NAN; on.frames()] } else { next(&lines) };
    let time = distance.iter().zip(&on.ego.forward_speed).map(|(&d, &v)| time_to(d, v)).collect();
    table.number(id::MAP_DISTANCE_TO_STOP_LINE, distance);
    table.number(id::MAP_TIME_TO_STOP_LINE, time);
}
