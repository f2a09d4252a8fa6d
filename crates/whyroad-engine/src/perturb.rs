//! Deliberate degradation of a drive: noise, lost rows, broken ids, a lower rate, no velocities. Pure and seeded: the
//! same drive, perturbation and seed give the same result, regardless of other perturbations. Used by `whyroad
//! robustness`.

mod random;
mod rate;

use random::{Noise, Random};
use std::collections::BTreeMap;
use whyroad_model::scene::{Motion, Track};
use whyroad_model::{Bilingual, Drive, TrackId};

/// A kind of degradation of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Perturbation {
    /// Noise of the objects, independent from frame to frame.
    White,
    /// Noise of the objects, correlated over a second.
    Correlated,
    /// Rows of objects lost.
    Drops,
    /// Objects that get another id.
    IdBreaks,
    /// A log at 5 Hz.
    FiveHertz,
    /// A log at 2 Hz.
    TwoHertz,
    /// A log without velocities.
    NoVelocities,
    /// Noise of the ego's pose, independent from frame to frame.
    EgoWhite,
    /// Noise of the ego's pose, correlated over a second.
    EgoCorrelated,
}

/// Standard deviation of perturbed coordinates, m.
pub const POSITION_M: f64 = 0.2;
/// Of perturbed headings, rad: 2 degrees.
pub const HEADING_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Of perturbed velocities, each component, m/s.
pub const VELOCITY_MPS: f64 = 0.3;
/// Share of rows that are lost.
pub const DROPPED: f64 = 0.1;
/// Share of ids that break within a second.
pub const BREAKS_PER_S: f64 = 0.1;
/// Maximum number of rows that are lost where an id breaks.
const LOST_AT_BREAK: usize = 4;

impl Perturbation {
    /// All of them, in the order in which they are reported.
    pub const ALL: [Self; 9] = [
        Self::White,
        Self::Correlated,
        Self::Drops,
        Self::IdBreaks,
        Self::FiveHertz,
        Self::TwoHertz,
        Self::NoVelocities,
        Self::EgoWhite,
        Self::EgoCorrelated,
    ];

    /// Its name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::White => "white",
            Self::Correlated => "correlated",
            Self::Drops => "drops",
            Self::IdBreaks => "id_breaks",
            Self::FiveHertz => "5hz",
            Self::TwoHertz => "2hz",
            Self::NoVelocities => "no_velocities",
            Self::EgoWhite => "ego_white",
            Self::EgoCorrelated => "ego_correlated",
        }
    }

    /// The one with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|p| p.name() == name)
    }

    /// Its description.
    pub fn meaning(self) -> Bilingual {
        let noise = "0.2 m, 2 deg, 0.3 m/s";
        match self {
            Self::White => {
                Bilingual::new(format!("目标白噪声：{noise}"), format!("white noise of objects: {noise}"))
            }
            Self::Correlated => Bilingual::new(
                format!("目标噪声（相关时间 1 s）：{noise}"),
                format!("noise of objects, correlated over 1 s: {noise}"),
            ),
            Self::Drops => Bilingual::new("丢失 10 % 的目标行", "10 % of object rows lost"),
            Self::IdBreaks => Bilingual::new(
                "每秒 10 % 的目标更换 id，并丢失最多 0.4 s",
                "10 % of object ids break per second, with up to 0.4 s lost",
            ),
            Self::FiveHertz => Bilingual::new("5 Hz 采样", "sampled at 5 Hz"),
            Self::TwoHertz => Bilingual::new("2 Hz 采样", "sampled at 2 Hz"),
            Self::NoVelocities => Bilingual::new("无速度", "no velocities"),
            Self::EgoWhite => {
                Bilingual::new(format!("自车白噪声：{noise}"), format!("white noise of the ego: {noise}"))
            }
            Self::EgoCorrelated => Bilingual::new(
                format!("自车噪声（相关时间 1 s）：{noise}"),
                format!("noise of the ego, correlated over 1 s: {noise}"),
            ),
        }
    }
}

/// A perturbed drive.
#[derive(Clone, Debug, Default)]
pub struct Perturbed {
    /// The drive.
    pub drive: Drive,
    /// Original id of each track that got another one.
    pub original: BTreeMap<TrackId, TrackId>,
}

/// `drive` perturbed.
pub fn perturb(drive: &Drive, how: Perturbation, seed: u64) -> Perturbed {
    let mut out = Perturbed { drive: drive.clone(), ..Perturbed::default() };
    // The content differs: nothing stored for the drive applies to it.
    out.drive.meta.content_hash = String::new();
    let random = |of: &str| Random::new(seed, &[drive.meta.drive_id.as_str(), how.name(), of]);
    let tracks = &mut out.drive.tracks;
    match how {
        Perturbation::White | Perturbation::Correlated => {
            for track in tracks {
                let noise = Noise { correlated: how == Perturbation::Correlated };
                add_noise(&mut track.motion, &track.frames, noise, &mut random(track.id.as_str()));
            }
        }
        Perturbation::EgoWhite | Perturbation::EgoCorrelated => {
            if let Some(ego) = &mut out.drive.ego {
                let frames: Vec<u32> = (0..ego.motion.len() as u32).collect();
                let noise = Noise { correlated: how == Perturbation::EgoCorrelated };
                add_noise(&mut ego.motion, &frames, noise, &mut random("ego"));
            }
        }
        Perturbation::Drops => {
            for track in tracks.iter_mut() {
                let mut random = random(track.id.as_str());
                let kept =
                    (0..track.frames.len()).filter(|_| random.uniform() >= DROPPED).collect::<Vec<_>>();
                *track = rows_of(track, &kept);
            }
            tracks.retain(|t| !t.frames.is_empty());
        }
        Perturbation::IdBreaks => {
            let mut broken = Vec::new();
            for track in tracks.iter() {
                for (part, rows) in
                    parts(track, &drive.times, &mut random(track.id.as_str())).iter().enumerate()
                {
                    let mut piece = rows_of(track, rows);
                    if part > 0 {
                        piece.id = TrackId::from(format!("{}~{part}", track.id).as_str());
                        out.original.insert(piece.id.clone(), track.id.clone());
                    }
                    broken.push(piece);
                }
            }
            broken.sort_by(|a, b| a.id.cmp(&b.id));
            *tracks = broken;
        }
        Perturbation::FiveHertz => rate::lower(&mut out.drive, 2),
        Perturbation::TwoHertz => rate::lower(&mut out.drive, 5),
        Perturbation::NoVelocities => {
            let own = out.drive.ego.iter_mut().map(|e| &mut e.motion);
            own.chain(tracks.iter_mut().map(|t| &mut t.motion)).for_each(forget_velocities);
        }
    }
    out
}

/// Adds noise to all measurements of a motion. Stated accelerations and yaw rates would remain exact, so they become
/// unknown.
fn add_noise(m: &mut Motion, frames: &[u32], noise: Noise, random: &mut Random) {
    let n = m.len();
    let mut series = |sd: f64| noise.series(frames, sd, random);
    let columns = [(&mut m.x, POSITION_M), (&mut m.y, POSITION_M), (&mut m.heading, HEADING_RAD)];
    for (column, sd) in columns {
        column.iter_mut().zip(series(sd)).for_each(|(v, e)| *v += e);
    }
    m.heading.iter_mut().for_each(|h| *h = wrapped(*h));
    for column in [&mut m.vx, &mut m.vy, &mut m.forward] {
        column.iter_mut().zip(series(VELOCITY_MPS)).for_each(|(v, e)| *v += e);
    }
    m.accel = vec![f64::NAN; n];
    m.yaw_rate = vec![f64::NAN; n];
}

fn forget_velocities(m: &mut Motion) {
    for column in [&mut m.vx, &mut m.vy, &mut m.accel, &mut m.yaw_rate] {
        column.fill(f64::NAN);
    }
    m.forward.clear();
}

/// The angle in (-pi, pi].
fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let a = angle.rem_euclid(TAU);
    if a > PI { a - TAU } else { a }
}

/// The rows of a track in the stretches between breaks of its id.
fn parts(track: &Track, times: &[whyroad_model::Nanos], random: &mut Random) -> Vec<Vec<usize>> {
    let mut parts = vec![Vec::new()];
    let mut lost = 0;
    for row in 0..track.frames.len() {
        if lost > 0 {
            lost -= 1;
            continue;
        }
        let dt = row.checked_sub(1).map_or(0.0, |before| {
            let time = |r: usize| times[track.frames[r] as usize];
            time(row).seconds_since(time(before)).min(1.0)
        });
        let current = parts.len() - 1;
        if !parts[current].is_empty() && random.uniform() < BREAKS_PER_S * dt {
            lost = (random.uniform() * (LOST_AT_BREAK + 1) as f64) as usize;
            parts.push(Vec::new());
            if lost > 0 {
                lost -= 1;
                continue;
            }
        }
        let current = parts.len() - 1;
        parts[current].push(row);
    }
    parts.retain(|p| !p.is_empty());
    parts
}

/// Some rows of a track, ascending.
fn rows_of(track: &Track, rows: &[usize]) -> Track {
    fn some<T: Clone>(values: &[T], rows: &[usize]) -> Vec<T> {
        rows.iter().filter_map(|&r| values.get(r).cloned()).collect()
    }
    let m = &track.motion;
    let mut out = track.clone();
    out.frames = some(&track.frames, rows);
    for (to, from) in [
        (&mut out.motion.x, &m.x),
        (&mut out.motion.y, &m.y),
        (&mut out.motion.z, &m.z),
        (&mut out.motion.heading, &m.heading),
        (&mut out.motion.vx, &m.vx),
        (&mut out.motion.vy, &m.vy),
        (&mut out.motion.accel, &m.accel),
        (&mut out.motion.yaw_rate, &m.yaw_rate),
        (&mut out.motion.forward, &m.forward),
        (&mut out.length_m, &track.length_m),
        (&mut out.width_m, &track.width_m),
        (&mut out.height_m, &track.height_m),
        (&mut out.interior_points, &track.interior_points),
        (&mut out.visible_share, &track.visible_share),
    ] {
        *to = some(from, rows);
    }
    out.turn_signal = some(&track.turn_signal, rows);
    out.occluder = some(&track.occluder, rows);
    out.known_at = some(&track.known_at, rows);
    if !track.class_changes.is_empty() {
        out.state_classes(rows.iter().map(|&r| track.class_at(r)));
    }
    out
}

#[cfg(test)]
mod tests;
