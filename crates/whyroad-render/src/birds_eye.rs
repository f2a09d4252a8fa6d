//! The bird's-eye image of one moment: road, crosswalks, lights, boxes with heading, the ego's and the target's path
//! before and after. Ego heading is up; coordinates in the SVG are decimeters.

use crate::markup::Markup;
use crate::view::{Spot, View, path};
use whyroad_model::names::class_name;
use whyroad_model::road_map::{Area, Lane, LaneKind, LaneMark, Point3, RoadMap};
use whyroad_model::scene::{LightColor, Motion, Track};
use whyroad_model::{Drive, Nanos, ObjectClass, TrackId};

/// Frames of trail before the keyframe and of path after it: 3 s and 6 s (a training sample's future, LABELING.md 4).
const TRAIL_FRAMES: usize = 30;
const FUTURE_FRAMES: usize = 60;

/// The image at `frame`; empty when the log has no ego pose there.
pub fn render(drive: &Drive, frame: usize, target: Option<&TrackId>) -> Markup {
    let mut m = Markup::new();
    let Some(ego) = drive.ego.as_ref() else { return m };
    let motion = &ego.motion;
    let pose = |v: &Vec<f64>| v.get(frame).copied().unwrap_or(f64::NAN);
    let (x, y, heading) = (pose(&motion.x), pose(&motion.y), pose(&motion.heading));
    if !(x.is_finite() && y.is_finite() && heading.is_finite()) {
        return m;
    }
    let chosen = target.and_then(|id| drive.track(id));
    let seen = chosen.and_then(|t| t.row_at(frame).map(|r| (t.motion.x[r], t.motion.y[r])));
    let view = View::around(x, y, heading, seen.filter(|p| p.0.is_finite() && p.1.is_finite()));
    let (left, top, w, h) = view.bounds();
    m.raw("<svg class=\"bev\" viewBox=\"").num(left * 10.0, 0).raw(" ").num(top * 10.0, 0).raw(" ");
    m.num(w * 10.0, 0).raw(" ").num(h * 10.0, 0).raw("\" role=\"img\" aria-label=\"bird's-eye view\">");
    if let Some(map) = &drive.map {
        road(&mut m, &view, map);
    }
    if let (Some(map), Some(lights)) = (&drive.map, &drive.lights) {
        for lane in &map.lanes {
            let time = drive.times.get(frame).copied().unwrap_or_default();
            let state = lights.iter().rfind(|l| l.lane_id == lane.id && l.time <= time);
            if let Some(state) = state {
                light(&mut m, &view, lane, state.color, state.time);
            }
        }
    }
    for track in &drive.tracks {
        if chosen.is_some_and(|t| t.id == track.id) {
            continue;
        }
        if let Some(row) = track.row_at(frame) {
            object(&mut m, &view, track, row, "");
        }
    }
    if let Some(track) = chosen {
        let at = |f: usize| track.row_at(f).map(|r| (track.motion.x[r], track.motion.y[r]));
        ways(&mut m, &view, frame, at, "way-target");
        if let Some(row) = track.row_at(frame) {
            ring(&mut m, &view, track, row);
            object(&mut m, &view, track, row, " target");
        }
    }
    let at = |f: usize| Some((*motion.x.get(f)?, *motion.y.get(f)?));
    ways(&mut m, &view, frame, at, "way-ego");
    rectangle(&mut m, &view, (x, y, heading), (ego.length_m, ego.width_m), "ego", "");
    m.raw("<title>ego</title></g>");
    scale_bar(&mut m, &view);
    m.raw("</svg>");
    m
}

fn road(m: &mut Markup, view: &View, map: &RoadMap) {
    area_paths(m, view, &map.drivable_areas, "drivable");
    for lane in &map.lanes {
        let outline: Vec<_> = lane.left.iter().chain(lane.right.iter().rev()).copied().collect();
        let class = match lane.kind {
            LaneKind::Vehicle if lane.in_junction => "lane junction-lane",
            LaneKind::Vehicle => "lane",
            LaneKind::Bus => "lane bus",
            LaneKind::Bike => "lane bike",
            LaneKind::Sidewalk => "sidewalk",
            LaneKind::Shoulder | LaneKind::Other => "lane other",
        };
        closed(m, &view.area(&outline), class);
    }
    area_paths(m, view, &map.junctions, "junction");
    for crossing in &map.crosswalks {
        crosswalk(m, view, crossing);
    }
    for lane in map.lanes.iter().filter(|l| !l.in_junction && l.kind != LaneKind::Sidewalk) {
        // The mark between two lanes is drawn once, by the lane on its left; the left edge by the leftmost lane.
        edge(m, view, &lane.right, lane.right_mark);
        if lane.left_neighbor.is_none() || lane.left_mark == LaneMark::Unknown {
            edge(m, view, &lane.left, lane.left_mark);
        }
    }
    for line in &map.stop_lines {
        open(m, &view.lines(&line.line), "stop-line");
    }
}

fn area_paths(m: &mut Markup, view: &View, areas: &[Area], class: &'static str) {
    for area in areas {
        closed(m, &view.area(&area.boundary), class);
    }
}

fn closed(m: &mut Markup, spots: &[Spot], class: &'static str) {
    if !spots.is_empty() {
        m.raw("<path class=\"").raw(class).raw("\" d=\"");
        path(m, spots, "Z\"/>");
    }
}

fn open(m: &mut Markup, lines: &[Vec<Spot>], class: &'static str) {
    if lines.is_empty() {
        return;
    }
    m.raw("<path class=\"").raw(class).raw("\" d=\"");
    for line in lines {
        path(m, line, "");
    }
    m.raw("\"/>");
}

fn edge(m: &mut Markup, view: &View, line: &[Point3], mark: LaneMark) {
    let class = match mark {
        LaneMark::None => return,
        LaneMark::Unknown => "mark unknown-mark",
        LaneMark::Dashed => "mark dashed",
        LaneMark::DoubleDashed => "mark dashed double",
        LaneMark::Solid => "mark",
        LaneMark::DoubleSolid | LaneMark::SolidDashed | LaneMark::DashedSolid => "mark double",
    };
    open(m, &view.lines(line), class);
}

/// Zebra stripes along the walking direction's crosswise axis; the plain outline where the area has no two long sides.
fn crosswalk(m: &mut Markup, view: &View, area: &Area) {
    let outline = view.area(&area.boundary);
    if outline.is_empty() {
        return;
    }
    closed(m, &outline, "crosswalk");
    let b = &area.boundary;
    let corners = if b.len() == 5 && b.first() == b.last() { &b[..4] } else { &b[..] };
    let &[a, b, c, d] = corners else { return };
    let length = |p: Point3, q: Point3| (q.x - p.x).hypot(q.y - p.y);
    // Two opposite long sides: people walk along them, the stripes lie across the traffic, along the short ones.
    let (from, to) = if length(a, b) >= length(b, c) { ((a, b), (d, c)) } else { ((b, c), (a, d)) };
    let stripes = (length(from.0, from.1) / 1.2).floor().max(1.0) as usize;
    m.raw("<path class=\"zebra\" d=\"");
    for i in 0..stripes {
        let t = (i as f64 + 0.5) / stripes as f64;
        let along = |s: (Point3, Point3)| Point3 {
            x: s.0.x + t * (s.1.x - s.0.x),
            y: s.0.y + t * (s.1.y - s.0.y),
            z: 0.0,
        };
        for line in view.lines(&[along(from), along(to)]) {
            path(m, &line, "");
        }
    }
    m.raw("\"/>");
}

fn light(m: &mut Markup, view: &View, lane: &Lane, color: LightColor, since: Nanos) {
    let Some(end) = lane.center.last() else { return };
    let spot = view.spot(end.x, end.y);
    let (left, top, w, h) = view.bounds();
    if spot.0 < left || spot.1 < top || spot.0 > left + w || spot.1 > top + h {
        return;
    }
    let class = match color {
        LightColor::Red => "light red",
        LightColor::Yellow | LightColor::RedYellow | LightColor::FlashingYellow => "light yellow",
        LightColor::Green
        | LightColor::GreenYield
        | LightColor::GreenRound
        | LightColor::GreenArrow
        | LightColor::FlashingGreen => "light green",
        LightColor::Off | LightColor::Unknown => "light dark",
    };
    m.raw("<circle class=\"").raw(class).raw("\" r=\"7\" cx=\"").num(spot.0 * 10.0, 0).raw("\" cy=\"");
    m.num(spot.1 * 10.0, 0).raw("\"><title>").text(&format!("{color:?}")).raw(" · ").text(&since.to_string());
    m.raw("</title></circle>");
}

fn object(m: &mut Markup, view: &View, track: &Track, row: usize, role: &'static str) {
    let motion = &track.motion;
    let pose = (motion.x[row], motion.y[row], motion.heading[row]);
    let spot = view.spot(pose.0, pose.1);
    let (left, top, w, h) = view.bounds();
    let reach = 8.0;
    let inside = spot.0 > left - reach
        && spot.0 < left + w + reach
        && spot.1 > top - reach
        && spot.1 < top + h + reach;
    if !inside {
        return;
    }
    let size =
        |v: &Vec<f64>, otherwise: f64| v.get(row).copied().filter(|x| x.is_finite()).unwrap_or(otherwise);
    let class = class_of(track.class);
    rectangle(m, view, pose, (size(&track.length_m, 1.0), size(&track.width_m, 1.0)), class, role);
    let name = class_name(track.class);
    m.raw("<title>").text(track.id.as_str()).raw(" · ").text(&name.zh).raw(" / ").text(&name.en);
    let speed = speed(motion, row);
    if speed.is_finite() {
        m.raw(" · ").num(speed, 1).raw(" m/s");
    }
    m.raw("</title></g>");
}

/// The style class of an object: the groups by color are those of the labeling page (`web/src/scene/colors.ts`).
fn class_of(class: ObjectClass) -> &'static str {
    match class {
        ObjectClass::Truck | ObjectClass::Bus | ObjectClass::LargeVehicle => "large",
        ObjectClass::Car | ObjectClass::EmergencyVehicle | ObjectClass::Tricycle | ObjectClass::Vehicle => {
            "vehicle"
        }
        ObjectClass::Motorcycle
        | ObjectClass::Bicycle
        | ObjectClass::Bicyclist
        | ObjectClass::Motorcyclist
        | ObjectClass::EBike => "two",
        ObjectClass::Pedestrian | ObjectClass::WheeledPedestrian | ObjectClass::Animal => "person",
        _ => "fixed",
    }
}

/// A ring around the target, which may be as small as a child.
fn ring(m: &mut Markup, view: &View, track: &Track, row: usize) {
    let (x, y) = view.spot(track.motion.x[row], track.motion.y[row]);
    if x.is_finite() && y.is_finite() {
        let length = track.length_m.get(row).copied().filter(|l| l.is_finite()).unwrap_or(1.0);
        m.raw("<circle class=\"ring\" cx=\"").num(x * 10.0, 0).raw("\" cy=\"").num(y * 10.0, 0);
        m.raw("\" r=\"").num(length * 5.0 + 12.0, 0).raw("\"/>");
    }
}

fn speed(motion: &Motion, row: usize) -> f64 {
    match (motion.vx.get(row), motion.vy.get(row)) {
        (Some(vx), Some(vy)) => vx.hypot(*vy),
        _ => f64::NAN,
    }
}

/// A box with a nose that shows its heading; leaves the group open for a title.
fn rectangle(
    m: &mut Markup,
    view: &View,
    (x, y, heading): (f64, f64, f64),
    (length, width): (f64, f64),
    class: &'static str,
    role: &'static str,
) {
    let (l, w) = (length.max(0.5) / 2.0, width.max(0.4) / 2.0);
    let heading = if heading.is_finite() { heading } else { 0.0 };
    let (s, c) = heading.sin_cos();
    let corner = |f: f64, k: f64| view.spot(x + f * c - k * s, y + f * s + k * c);
    m.raw("<g class=\"").raw(class).raw(role).raw("\"><path class=\"box\" d=\"");
    path(m, &[corner(l, w), corner(l, -w), corner(-l, -w), corner(-l, w)], "Z\"/>");
    m.raw("<path class=\"nose\" d=\"");
    path(m, &[corner(l * 0.35, w), corner(l, 0.0), corner(l * 0.35, -w)], "\"/>");
}

/// Where something came from (solid) and where it went (dashed).
fn ways(
    m: &mut Markup,
    view: &View,
    frame: usize,
    at: impl Fn(usize) -> Option<(f64, f64)>,
    class: &'static str,
) {
    for (frames, style) in
        [(frame.saturating_sub(TRAIL_FRAMES)..=frame, " before"), (frame..=frame + FUTURE_FRAMES, " after")]
    {
        let spots: Vec<Spot> = frames
            .filter_map(&at)
            .filter(|p| p.0.is_finite() && p.1.is_finite())
            .map(|p| view.spot(p.0, p.1))
            .collect();
        let lines = view.cut(&spots);
        if !lines.is_empty() {
            m.raw("<path class=\"way ").raw(class).raw(style).raw("\" d=\"");
            for line in &lines {
                path(m, line, "");
            }
            m.raw("\"/>");
        }
    }
}

fn scale_bar(m: &mut Markup, view: &View) {
    let (left, top, _, h) = view.bounds();
    let (x, y) = ((left + 3.0) * 10.0, (top + h - 3.0) * 10.0);
    m.raw("<path class=\"scale\" d=\"M").num(x, 0).raw(" ").num(y - 10.0, 0).raw("v10h100v-10\"/>");
    m.raw("<text class=\"scale-text\" x=\"")
        .num(x + 50.0, 0)
        .raw("\" y=\"")
        .num(y - 8.0, 0)
        .raw("\">10 m</text>");
}
