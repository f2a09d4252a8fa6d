//! States of lights of which none applies to the drive: what the lights showed is unknown, and not that there was none.

use super::warning;
use whyroad_model::scene::Drive;
use whyroad_model::{Bilingual, Diagnostic, Need};

/// Sets the lights to unknown when all states are of other lanes than the map has, or later than the drive.
pub(super) fn unused(drive: &mut Drive) -> Option<Diagnostic> {
    let states = drive.lights.as_ref().filter(|states| !states.is_empty())?;
    let end = *drive.times.last()?;
    let map = drive.map.as_ref().filter(|map| !map.lanes.is_empty());
    let has_lane = |id: &str| map.is_none_or(|map| map.lanes.iter().any(|l| l.id == id));
    let (lanes, in_time) = states.iter().fold((false, false), |(lanes, in_time), s| {
        let (a, b) = (!lanes && has_lane(&s.lane_id), s.time <= end);
        (lanes || a, in_time || b)
    });
    if lanes && in_time {
        return None;
    }
    let n = states.len();
    let first = &states[0];
    let why = if lanes {
        Bilingual::new("时刻都在行程之后", "all are later than the drive")
    } else {
        let id = &first.lane_id;
        Bilingual::new(
            format!("地图中没有所述车道，例如 {id}"),
            format!("the map has none of their lanes, for example {id}"),
        )
    };
    drive.lights = None;
    drive.meta.lacks(Need::TrafficLights);
    Some(
        warning(
            "ingest.lights.unused",
            format!("{n} 条灯态无一可用（{}）：灯态为未知，并非没有信号灯", why.zh),
            format!("none of {n} light states can be used ({}): lights are unknown, not absent", why.en),
        )
        .with_hint(Bilingual::new(
            "检查灯态的车道编号与时间",
            "check lane ids and times of the light states",
        )),
    )
}
