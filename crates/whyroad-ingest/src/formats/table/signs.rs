//! `signs`: traffic signs beside or over the road.

use super::problems::Problems;
use super::reader::Reader;
use super::sheet::{Sheet, list};
use super::words::UnknownWords;
use crate::assemble::angles::wrap_angle;
use crate::report::RowCount;
use std::collections::BTreeSet;
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Point3, Sign};
use whyroad_model::vocabulary::SIGN_KINDS;

/// Where the faces of signs point, rad.
fn facings(sheet: &Sheet, problems: &mut Problems) -> Vec<f64> {
    if sheet.has("facing_rad") {
        return sheet.numbers("facing_rad", problems).into_iter().map(wrap_angle).collect();
    }
    let degrees = sheet.numbers("facing_deg", problems);
    degrees.into_iter().map(|v| wrap_angle(v.to_radians())).collect()
}

/// Adds the signs to `map`; false when there is no such table.
pub(super) fn read(map: &mut RoadMap, reader: &mut Reader) -> bool {
    let required: &[&[&str]] = &[&["sign_id"], &["kind"], &["x_m"], &["y_m"]];
    let Some(sheet) = reader.sheet("signs", required) else { return false };
    let (mut problems, mut words) = (Problems::default(), UnknownWords::default());
    let [ids, kinds, lanes] = ["sign_id", "kind", "lane_ids"].map(|n| sheet.texts(n));
    let [x, y, z, value] = ["x_m", "y_m", "z_m", "value"].map(|n| sheet.numbers(n, &mut problems));
    let facing = facings(&sheet, &mut problems);
    let mut count = RowCount { read: sheet.rows, ..RowCount::new("signs") };
    let mut seen = BTreeSet::new();
    for i in 0..sheet.rows {
        let row = sheet.first_row + i;
        let (Some(id), Some(kind)) = (ids[i].clone(), kinds[i].as_deref()) else {
            problems.row("no_id", row, &mut count);
            continue;
        };
        let Some(kind) = words.check("kind", kind, SIGN_KINDS) else {
            problems.row("unknown_word", row, &mut count);
            continue;
        };
        if x[i].is_nan() || y[i].is_nan() {
            problems.row("no_position", row, &mut count);
            continue;
        }
        if !seen.insert(id.clone()) {
            problems.row("duplicate", row, &mut count);
            continue;
        }
        count.keep("sign", 1);
        map.signs.push(Sign {
            id,
            kind,
            position: Point3 { x: x[i], y: y[i], z: z[i] },
            lane_ids: list(&lanes[i]),
            value: Some(value[i]).filter(|v| v.is_finite()),
            facing: Some(facing[i]).filter(|v| v.is_finite()),
        });
    }
    map.signs.sort_by(|a, b| a.id.cmp(&b.id));
    reader.report.diagnostics.extend(problems.diagnostics(&sheet.label));
    reader.report.diagnostics.extend(words.diagnostics(&sheet.label));
    reader.report.tables.push(count);
    true
}
