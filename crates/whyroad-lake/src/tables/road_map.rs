//! `map.parquet`: everything in the map, one row per feature, whose kind is in `feature`. Columns that do not
//! concern a kind are null or empty.

use crate::LakeError;
use crate::columns::{Table, TableBuilder, member_name};
use crate::tables::states::{known_or_none, text_at};
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Area, Facility, Lane, Point3, Sign, StopLine};

/// Order of the features; the rows of `complete_for` and `layer`, which are about the map and no feature of it, come
/// last.
pub(crate) const ROW_ORDER: &str = "lane,crosswalk,junction,drivable_area,stop_line,sign,facility; id";

/// One row, for any feature.
#[derive(Default)]
struct Row<'a> {
    feature: &'static str,
    id: &'a str,
    boundary: &'a [Point3],
    lane_ids: &'a [String],
    purpose: Option<&'a str>,
    value: Option<f64>,
    facing: Option<f64>,
    lane: Option<&'a Lane>,
}

pub(crate) fn to_table(map: &RoadMap) -> TableBuilder {
    let mut rows: Vec<Row> = Vec::new();
    rows.extend(map.lanes.iter().map(|l| Row {
        feature: "lane",
        id: &l.id,
        lane: Some(l),
        ..Row::default()
    }));
    for (feature, areas) in
        [("crosswalk", &map.crosswalks), ("junction", &map.junctions), ("drivable_area", &map.drivable_areas)]
    {
        rows.extend(areas.iter().map(|a| Row {
            feature,
            id: &a.id,
            boundary: &a.boundary,
            ..Row::default()
        }));
    }
    rows.extend(map.stop_lines.iter().map(|s| Row {
        feature: "stop_line",
        id: &s.id,
        boundary: &s.line,
        lane_ids: &s.lane_ids,
        ..Row::default()
    }));
    rows.extend(map.signs.iter().map(|s| Row {
        feature: "sign",
        id: &s.id,
        boundary: std::slice::from_ref(&s.position),
        lane_ids: &s.lane_ids,
        purpose: Some(&s.kind),
        value: s.value,
        facing: s.facing,
        ..Row::default()
    }));
    rows.extend(map.facilities.iter().map(|f| Row {
        feature: "facility",
        id: &f.id,
        boundary: &f.boundary,
        purpose: Some(&f.kind),
        ..Row::default()
    }));
    rows.extend(map.complete_for.iter().map(|kind| Row {
        feature: "complete_for",
        id: kind,
        ..Row::default()
    }));
    let layers: Vec<(String, String)> =
        map.layers.iter().map(|(layer, state)| (member_name(layer), member_name(state))).collect();
    rows.extend(layers.iter().map(|(layer, state)| Row {
        feature: "layer",
        id: layer,
        purpose: Some(state),
        ..Row::default()
    }));
    let lanes = || rows.iter().map(|r| r.lane);
    let number = |v: Option<f64>| v.unwrap_or(f64::NAN);
    TableBuilder::default()
        .texts("feature", rows.iter().map(|r| r.feature))
        .texts("id", rows.iter().map(|r| r.id))
        .points("boundary", rows.iter().map(|r| r.boundary))
        .text_lists("lane_ids", rows.iter().map(|r| r.lane_ids))
        .texts_or_null("purpose", rows.iter().map(|r| r.purpose))
        .numbers("value", rows.iter().map(|r| number(r.value)))
        .numbers("facing_rad", rows.iter().map(|r| number(r.facing)))
        .points("left", lanes().map(|l| l.map_or(&[][..], |l| &l.left)))
        .points("right", lanes().map(|l| l.map_or(&[][..], |l| &l.right)))
        .points("centre", lanes().map(|l| l.map_or(&[][..], |l| &l.center)))
        .texts_or_null("left_mark", lanes().map(|l| l.map(|l| member_name(&l.left_mark))))
        .texts_or_null("right_mark", lanes().map(|l| l.map(|l| member_name(&l.right_mark))))
        .texts_or_null("left_neighbour", lanes().map(|l| l.and_then(|l| l.left_neighbor.as_ref())))
        .texts_or_null("right_neighbour", lanes().map(|l| l.and_then(|l| l.right_neighbor.as_ref())))
        .text_lists("successors", lanes().map(|l| l.map_or(&[][..], |l| &l.successors)))
        .text_lists("predecessors", lanes().map(|l| l.map_or(&[][..], |l| &l.predecessors)))
        .texts_or_null("lane_kind", lanes().map(|l| l.map(|l| member_name(&l.kind))))
        .flags("in_junction", lanes().map(|l| l.map(|l| l.in_junction)))
        .numbers("speed_limit_mps", lanes().map(|l| number(l.and_then(|l| l.speed_limit_mps))))
        .numbers("width_m", lanes().map(|l| number(l.and_then(|l| l.width_m))))
        .texts_or_null("junction_id", lanes().map(|l| l.and_then(|l| l.junction_id.as_ref())))
        .texts_or_null("turn", lanes().map(|l| l.and_then(|l| l.turn.as_ref()).map(member_name)))
        .text_lists("tags", lanes().map(|l| l.map_or(&[][..], |l| &l.tags)))
}

pub(crate) fn from_table(t: &Table) -> Result<RoadMap, LakeError> {
    let (features, ids) = (t.texts("feature")?, t.texts("id")?);
    let (boundaries, lane_ids) = (t.points("boundary")?, t.text_lists("lane_ids")?);
    let (purposes, values) = (t.texts_or_null("purpose")?, t.numbers("value")?);
    let (left, right, center) = (t.points("left")?, t.points("right")?, t.points("centre")?);
    let (left_marks, right_marks) = (t.members("left_mark")?, t.members("right_mark")?);
    let (left_ids, right_ids) = (t.texts_or_null("left_neighbour")?, t.texts_or_null("right_neighbour")?);
    let (successors, predecessors) = (t.text_lists("successors")?, t.text_lists("predecessors")?);
    let (kinds, turns) = (t.members("lane_kind")?, t.members("turn")?);
    let in_junction = t.flags("in_junction")?;
    let (limits, widths) = (t.numbers("speed_limit_mps")?, t.numbers("width_m")?);
    let junctions = t.texts_or_null("junction_id")?;
    let tags = t.text_lists("tags")?;
    let known = |v: f64| (!v.is_nan()).then_some(v);
    let facings = known_or_none(t, "facing_rad")?;

    let mut map = RoadMap::default();
    for i in 0..t.rows() {
        let id = ids.value(i).to_owned();
        let boundary = boundaries[i].clone();
        let purpose = || text_at(purposes, i).unwrap_or_default();
        match features.value(i) {
            "lane" => map.lanes.push(Lane {
                id,
                left: left[i].clone(),
                right: right[i].clone(),
                center: center[i].clone(),
                left_mark: left_marks[i].unwrap_or_default(),
                right_mark: right_marks[i].unwrap_or_default(),
                left_neighbor: text_at(left_ids, i),
                right_neighbor: text_at(right_ids, i),
                successors: successors[i].clone(),
                predecessors: predecessors[i].clone(),
                kind: kinds[i].unwrap_or_default(),
                in_junction: in_junction[i].unwrap_or(false),
                speed_limit_mps: known(limits[i]),
                width_m: known(widths[i]),
                junction_id: text_at(junctions, i),
                turn: turns[i],
                tags: tags[i].clone(),
            }),
            "crosswalk" => map.crosswalks.push(Area { id, boundary }),
            "junction" => map.junctions.push(Area { id, boundary }),
            "drivable_area" => map.drivable_areas.push(Area { id, boundary }),
            "stop_line" => {
                map.stop_lines.push(StopLine { id, line: boundary, lane_ids: lane_ids[i].clone() })
            }
            "sign" => map.signs.push(Sign {
                id,
                kind: purpose(),
                position: boundary.first().copied().unwrap_or_default(),
                lane_ids: lane_ids[i].clone(),
                value: known(values[i]),
                facing: facings[i],
            }),
            "facility" => map.facilities.push(Facility { id, kind: purpose(), boundary }),
            "complete_for" => map.complete_for.push(id),
            "layer" => {
                let (layer, state) = (t.member("id", &id)?, t.member("purpose", &purpose())?);
                map.layers.insert(layer, state);
            }
            other => return Err(LakeError::broken(&t.path, format!("'{other}' is not a map feature"))),
        }
    }
    Ok(map)
}
