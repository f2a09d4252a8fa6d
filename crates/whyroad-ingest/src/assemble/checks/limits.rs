//! Speed limits in another unit than m/s: maps and lists of signs state km/h.

use super::warning;
use whyroad_model::road_map::{LayerState, MapLayer};
use whyroad_model::{Bilingual, Diagnostic, RoadMap};

/// The highest posted limit is 160 km/h (Abu Dhabi), 44.4 m/s.
const HIGHEST_MPS: f64 = 45.0;
/// All limits are in another unit when at least this share of them is impossible; else those alone are wrong.
const UNIT_SHARE: f64 = 0.1;

/// Sets limits that no road has to unknown, and all others with them where the unit is wrong.
pub(super) fn in_another_unit(map: &mut RoadMap) -> Option<Diagnostic> {
    let impossible = |v: f64| v > HIGHEST_MPS || v <= 0.0;
    let signs = || map.signs.iter().filter(|s| s.kind == "speed_limit").filter_map(|s| s.value);
    let stated: Vec<f64> = map.lanes.iter().filter_map(|l| l.speed_limit_mps).chain(signs()).collect();
    let wrong: Vec<f64> = stated.iter().copied().filter(|v| impossible(*v)).collect();
    let example = *wrong.first()?;
    let all = wrong.len() as f64 >= UNIT_SHARE * stated.len() as f64;
    let forget = |v: &mut Option<f64>| *v = v.filter(|v| !all && !impossible(*v));
    map.lanes.iter_mut().for_each(|l| forget(&mut l.speed_limit_mps));
    map.signs.iter_mut().filter(|s| s.kind == "speed_limit").for_each(|s| forget(&mut s.value));
    map.layers.insert(MapLayer::SpeedLimits, if all { LayerState::Absent } else { LayerState::Partial });
    let (n, lost) = (wrong.len(), if all { stated.len() } else { wrong.len() });
    Some(
        warning(
            "ingest.limit.impossible",
            format!("{n} 处限速不可能，例如 {example} m/s；{lost} 处限速记为未知"),
            format!(
                "{n} speed limits are impossible, for example {example} m/s; {lost} limits are set to unknown"
            ),
        )
        .with_hint(Bilingual::new(
            "限速的单位是 m/s：由 km/h 换算时除以 3.6",
            "limits are in m/s: divide those in km/h by 3.6",
        )),
    )
}
