//! Plausible box sizes. Derivation works along boxes, so its work grows with them: a box of a billion meters, which a
//! damaged or malicious lake may contain, must not cost more than another. People and bicycles are all of much the same
//! size, and head where they go: where a log has sizes and headings, but none of theirs (INTERACTION, drone data), they
//! have the usual ones.

use std::borrow::Cow;
use whyroad_model::scene::{Motion, Track};
use whyroad_model::{Drive, ObjectClass};

/// Maximum length and width of a road user, m (road trains have about 54 m). The size of a larger box is unknown.
const MOST_M: f64 = 100.0;

/// Length and width of an adult and of a bicycle with its rider, m: the targets of Euro NCAP's tests (EPTa, EBTa).
const ADULT_M: (f64, f64) = (0.5, 0.5);
const BICYCLE_M: (f64, f64) = (1.89, 0.5);

/// Slower, nobody is known to go where they head, m/s.
const WALKS_MPS: f64 = 0.3;

fn usual(class: ObjectClass) -> Option<(f64, f64)> {
    match class {
        ObjectClass::Pedestrian => Some(ADULT_M),
        ObjectClass::Bicycle | ObjectClass::Bicyclist | ObjectClass::EBike => Some(BICYCLE_M),
        _ => None,
    }
}

fn lacks_size(track: &Track) -> bool {
    !track.length_m.iter().chain(&track.width_m).any(|m| m.is_finite())
}

fn lacks_heading(track: &Track) -> bool {
    !track.motion.heading.iter().any(|h| h.is_finite())
}

/// Headings by the velocity; who stands heads where it went.
fn head_along(m: &mut Motion) {
    let mut last = f64::NAN;
    for i in 0..m.len() {
        let (vx, vy) = (m.vx[i], m.vy[i]);
        if vx.hypot(vy) >= WALKS_MPS {
            last = vy.atan2(vx);
        }
        m.heading[i] = last;
    }
}

/// `drive` with implausible sizes set to unknown and the usual sizes and headings of people and bicycles; borrowed if
/// there are none of either.
pub(crate) fn with_possible_sizes(drive: &Drive) -> Cow<'_, Drive> {
    let odd = |m: f64| m > MOST_M;
    let of_ego = drive.ego.as_ref().is_some_and(|e| odd(e.length_m) || odd(e.width_m));
    let of_tracks = drive.tracks.iter().any(|t| t.length_m.iter().chain(&t.width_m).any(|m| odd(*m)));
    // A log without any size has no sizes: its people get none.
    let has_sizes = !drive.tracks.iter().all(lacks_size);
    let is_usual = |t: &Track| usual(t.class).is_some() && (lacks_size(t) || lacks_heading(t));
    let has_usual = has_sizes && drive.tracks.iter().any(is_usual);
    if !of_ego && !of_tracks && !has_usual {
        return Cow::Borrowed(drive);
    }
    let mut drive = drive.clone();
    let unknown = |m: &mut f64| {
        if odd(*m) {
            *m = f64::NAN;
        }
    };
    if let Some(ego) = &mut drive.ego {
        unknown(&mut ego.length_m);
        unknown(&mut ego.width_m);
    }
    for track in &mut drive.tracks {
        if let Some((length, width)) = usual(track.class).filter(|_| has_sizes) {
            if lacks_size(track) {
                track.length_m.fill(length);
                track.width_m.fill(width);
            }
            if lacks_heading(track) {
                head_along(&mut track.motion);
            }
        }
        track.length_m.iter_mut().chain(&mut track.width_m).for_each(unknown);
    }
    Cow::Owned(drive)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(class: ObjectClass, length: f64) -> Track {
        Track { class, length_m: vec![length; 2], width_m: vec![length / 2.0; 2], ..Track::default() }
    }

    #[test]
    fn who_goes_heads_there_and_who_stands_heads_where_it_went() {
        let mut walker = track(ObjectClass::Pedestrian, f64::NAN);
        walker.motion =
            Motion { vx: vec![0.0, 0.0, 0.1, 0.0], vy: vec![0.0, 1.0, 0.0, -1.0], ..Motion::unknown(4) };
        let drive = Drive { tracks: vec![walker, track(ObjectClass::Car, 4.0)], ..Drive::default() };
        let found = with_possible_sizes(&drive);
        let [first, rest @ ..] = &found.tracks[0].motion.heading[..] else { panic!("{:?}", found.tracks[0]) };
        let quarter = std::f64::consts::FRAC_PI_2;
        assert!(first.is_nan() && rest == [quarter, quarter, -quarter], "{rest:?}");
    }

    #[test]
    fn people_and_bicycles_have_the_usual_size_where_others_have_one() {
        let people = || [ObjectClass::Pedestrian, ObjectClass::Bicyclist].map(|c| track(c, f64::NAN));
        let with = |other: Track| Drive {
            tracks: people().into_iter().chain([other]).collect(),
            ..Drive::default()
        };
        let sizes = |drive: &Drive| {
            let drive = with_possible_sizes(drive);
            drive.tracks.iter().map(|t| (t.length_m[1], t.width_m[1])).collect::<Vec<_>>()
        };
        assert_eq!(sizes(&with(track(ObjectClass::Car, 4.0))), [(0.5, 0.5), (1.89, 0.5), (4.0, 2.0)]);
        // Stated sizes stay; a log that has none has none.
        assert_eq!(sizes(&with(track(ObjectClass::Pedestrian, 1.0)))[2], (1.0, 0.5));
        assert!(sizes(&with(track(ObjectClass::Car, f64::NAN))).iter().all(|(l, _)| l.is_nan()));
    }
}
