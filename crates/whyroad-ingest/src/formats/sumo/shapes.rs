//! Polygons and points of interest of SUMO's additional files, as facilities and signs:
//! `<poly type="building" shape=.../>` (any type with this prefix, as OpenStreetMap imports write `building.house`, or
//! a word of our list of facilities) and `<poi type="sign.stop" x= y= or lane= pos=/>` (with `<param key="value"
//! value="8.33"/>` inside for the number on it). What is of any other type is scenery and set aside.

use crate::assemble::geometry::distance;
use crate::encodings::input::Input;
use crate::encodings::xml::{Element, Tag, for_each_tag};
use crate::report::RowCount;
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Facility, Point3, Sign};
use whyroad_model::vocabulary::{FACILITY_KINDS, SIGN_KINDS};

/// Adds what the file holds to `map`; `Err` says why reading stopped.
pub(super) fn read(input: Input<'_>, map: &mut RoadMap, count: &mut RowCount) -> Result<(), String> {
    let mut in_sign = false;
    let end = for_each_tag(input, |tag| match tag {
        Tag::Open(e) if e.name() == "poly" => {
            count.read += 1;
            match facility_kind(&e) {
                None => count.set_aside("scenery", 1),
                Some(kind) => match facility(&e, kind) {
                    Some(f) => {
                        count.keep("facility", 1);
                        map.facilities.push(f);
                    }
                    None => count.drop_rows("no_line", 1),
                },
            }
        }
        Tag::Open(e) if e.name() == "poi" => {
            count.read += 1;
            let kind = e.get("type").and_then(|t| word_of(t.strip_prefix("sign.")?, SIGN_KINDS));
            let Some(kind) = kind else { return count.set_aside("scenery", 1) };
            match sign(&e, kind, map) {
                Some(s) => {
                    count.keep("sign", 1);
                    in_sign = true;
                    map.signs.push(s);
                }
                None => count.drop_rows("no_position", 1),
            }
        }
        Tag::Open(e) if in_sign && e.name() == "param" && e.get("key").as_deref() == Some("value") => {
            if let Some(s) = map.signs.last_mut() {
                s.value = e.number("value");
            }
        }
        Tag::Close("poi") => in_sign = false,
        _ => {}
    });
    map.facilities.sort_by(|a, b| a.id.cmp(&b.id));
    map.signs.sort_by(|a, b| a.id.cmp(&b.id));
    end
}

fn word_of(word: &str, known: &[&'static str]) -> Option<&'static str> {
    known.iter().copied().find(|k| *k == word)
}

fn facility_kind(e: &Element<'_>) -> Option<&'static str> {
    let kind = e.get("type")?;
    if kind.starts_with("building") { Some("building") } else { word_of(&kind, FACILITY_KINDS) }
}

fn facility(e: &Element<'_>, kind: &str) -> Option<Facility> {
    let shape = e.get("shape")?;
    let mut boundary = super::net::points(&shape);
    // Polygons mostly have no heights: unknown, not sea level.
    if shape.split_whitespace().any(|p| p.matches(',').count() < 2) {
        boundary.iter_mut().for_each(|p| p.z = f64::NAN);
    }
    if boundary.len() < 2 {
        return None;
    }
    let at = |p: Option<&Point3>| p.map(|p| (p.x, p.y));
    if boundary.len() > 2 && at(boundary.first()) != at(boundary.last()) {
        boundary.extend(boundary.first().copied());
    }
    Some(Facility { id: e.text("id")?, kind: kind.to_owned(), boundary })
}

fn sign(e: &Element<'_>, kind: &str, map: &RoadMap) -> Option<Sign> {
    let lane = e.text("lane");
    let position = match (e.number("x"), e.number("y")) {
        (Some(x), Some(y)) => Point3 { x, y, z: e.number("z").unwrap_or(0.0) },
        _ => along(&map.lane(lane.as_deref()?)?.center, e.number("pos")?)?,
    };
    let lane_ids = lane.into_iter().collect();
    Some(Sign { id: e.text("id")?, kind: kind.to_owned(), position, lane_ids, value: None, facing: None })
}

/// The point `s` meters along a line, from its end where `s` is negative, as SUMO counts.
fn along(line: &[Point3], s: f64) -> Option<Point3> {
    let length: f64 = line.windows(2).map(|w| distance(w[0], w[1])).sum();
    let mut left = if s < 0.0 { length + s } else { s }.clamp(0.0, length);
    for w in line.windows(2) {
        let step = distance(w[0], w[1]);
        if left <= step && step > 0.0 {
            let at = |a: f64, b: f64| a + (b - a) * (left / step);
            return Some(Point3 { x: at(w[0].x, w[1].x), y: at(w[0].y, w[1].y), z: at(w[0].z, w[1].z) });
        }
        left -= step;
    }
    line.last().copied()
}
