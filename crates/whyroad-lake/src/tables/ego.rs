//! `ego.parquet`: the recording vehicle, one row per frame.

use crate::LakeError;
use crate::columns::{Table, TableBuilder, empty_if_unknown, member_name};
use crate::tables::frames;
use whyroad_model::scene::{Ego, EgoBus, Motion};
use whyroad_model::{Drive, Nanos};

pub(crate) const ROW_ORDER: &str = "frame";

pub(crate) fn to_table(drive: &Drive, ego: &Ego) -> TableBuilder {
    let n = drive.times.len();
    let (clips, of_frames) = frames::clip_ids(drive);
    let bus = &ego.bus;
    let constant = |v: f64| std::iter::repeat_n(v, n);
    let table = TableBuilder::default()
        .texts("clip_id", of_frames.iter().map(|&clip| clips[clip].as_str()))
        .indices("frame", (0..).take(n))
        .integers("time_ns", drive.times.iter().map(|t| t.0));
    let known_at = (0..n).map(|i| (drive.times[i], ego.known_at.get(i)));
    motion_columns(known_at_column(table, known_at), ego.motion.clone())
        .numbers("length_m", constant(ego.length_m))
        .numbers("width_m", constant(ego.width_m))
        .numbers("height_m", constant(ego.height_m))
        .numbers("reference_to_centre_m", constant(ego.reference_to_centre_m))
        .numbers("bus_speed_mps", (0..n).map(|i| bus.speed_mps.get(i).copied().unwrap_or(f64::NAN)))
        .numbers("steering_rad", (0..n).map(|i| bus.steering.get(i).copied().unwrap_or(f64::NAN)))
        .flags("brake", (0..n).map(|i| bus.brake.get(i).copied().flatten()))
        .numbers("throttle", (0..n).map(|i| bus.throttle.get(i).copied().unwrap_or(f64::NAN)))
        .texts_or_null("gear", (0..n).map(|i| bus.gear.get(i).copied().flatten().map(String::from)))
        .texts_or_null(
            "turn_signal",
            (0..n).map(|i| bus.turn_signal.get(i).copied().flatten().map(|t| member_name(&t))),
        )
        .flags("aeb", (0..n).map(|i| bus.aeb.get(i).copied().flatten()))
        .flags("cruise", (0..n).map(|i| bus.cruise.get(i).copied().flatten()))
        .flags("wipers", (0..n).map(|i| bus.wipers.get(i).copied().flatten()))
        .numbers(
            "vertical_accel_mps2",
            (0..n).map(|i| bus.vertical_accel.get(i).copied().unwrap_or(f64::NAN)),
        )
        .texts_or_null("route_command", (0..n).map(|i| bus.route_command.get(i).and_then(Option::as_ref)))
}

/// When the rows at `times` were known, where that is later than their frame.
pub(crate) fn known_at_column<'a>(
    table: TableBuilder,
    rows: impl Iterator<Item = (Nanos, Option<&'a Nanos>)>,
) -> TableBuilder {
    let later = rows.map(|(time, at)| at.filter(|at| **at > time).map(|at| at.0));
    table.integers_or_null("known_at_ns", later)
}

/// The inverse of [`known_at_column`].
pub(crate) fn read_known_at(t: &Table) -> Result<Vec<Nanos>, LakeError> {
    let later = t.integers_or_null("known_at_ns")?;
    if later.iter().all(Option::is_none) {
        return Ok(Vec::new());
    }
    let times = t.integers("time_ns")?;
    Ok(later.into_iter().zip(times).map(|(at, time)| Nanos(at.unwrap_or(time))).collect())
}

/// The columns of [`Motion`], shared by `ego` and `tracks`.
pub(crate) fn motion_columns(table: TableBuilder, mut m: Motion) -> TableBuilder {
    m.forward.resize(m.len(), f64::NAN);
    table
        .numbers("x_m", m.x)
        .numbers("y_m", m.y)
        .numbers("z_m", m.z)
        .numbers("heading_rad", m.heading)
        .numbers("vx_mps", m.vx)
        .numbers("vy_mps", m.vy)
        .numbers("accel_mps2", m.accel)
        .numbers("yaw_rate_radps", m.yaw_rate)
        .numbers("forward_mps", m.forward)
}

/// The inverse of [`motion_columns`].
pub(crate) fn read_motion(t: &Table) -> Result<Motion, LakeError> {
    Ok(Motion {
        x: t.numbers("x_m")?,
        y: t.numbers("y_m")?,
        z: t.numbers("z_m")?,
        heading: t.numbers("heading_rad")?,
        vx: t.numbers("vx_mps")?,
        vy: t.numbers("vy_mps")?,
        accel: t.numbers("accel_mps2")?,
        yaw_rate: t.numbers("yaw_rate_radps")?,
        forward: empty_if_unknown(t.numbers("forward_mps")?, |v| !v.is_nan()),
    })
}

pub(crate) fn from_table(t: &Table, frame_count: usize) -> Result<Ego, LakeError> {
    let frames = t.indices("frame")?;
    if let Some(row) = (0..frames.len()).find(|&i| frames[i] as usize != i) {
        return Err(LakeError::RowOrder { path: t.path.clone(), row });
    }
    if frames.len() != frame_count {
        return Err(LakeError::broken(&t.path, format!("{} rows for {frame_count} frames", frames.len())));
    }
    let first = |name: &str| t.numbers(name).map(|v| v.first().copied().unwrap_or(f64::NAN));
    let number = |name: &str| t.numbers(name).map(|v| empty_if_unknown(v, |x| !x.is_nan()));
    let flag = |name: &str| t.flags(name).map(|v| empty_if_unknown(v, Option::is_some));
    let gear = t.texts_or_null("gear")?.iter().map(|g| g.and_then(|g| g.chars().next())).collect();
    let route = t.texts_or_null("route_command")?.iter().map(|g| g.map(str::to_owned)).collect();
    Ok(Ego {
        length_m: first("length_m")?,
        width_m: first("width_m")?,
        height_m: first("height_m")?,
        reference_to_centre_m: first("reference_to_centre_m")?,
        motion: read_motion(t)?,
        bus: EgoBus {
            speed_mps: number("bus_speed_mps")?,
            steering: number("steering_rad")?,
            brake: flag("brake")?,
            throttle: number("throttle")?,
            gear: empty_if_unknown(gear, Option::is_some),
            turn_signal: empty_if_unknown(t.members("turn_signal")?, Option::is_some),
            aeb: flag("aeb")?,
            wipers: if t.has("wipers") { flag("wipers")? } else { Vec::new() },
            vertical_accel: if t.has("vertical_accel_mps2") {
                number("vertical_accel_mps2")?
            } else {
                Vec::new()
            },
            cruise: flag("cruise")?,
            route_command: empty_if_unknown(route, Option::is_some),
        },
        known_at: read_known_at(t)?,
    })
}
