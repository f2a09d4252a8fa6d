//! Plausible box sizes. Derivation works along boxes, so its work grows with them: a box of a billion meters, which a
//! damaged or malicious lake may contain, must not cost more than another. People, bicycles and e-scooters are all of
//! much the same size: where a log states none of theirs (drone data), they have the usual one, whatever else it has.
//! Vehicles differ by more than the distances that matter, and so do animals: theirs stay unknown.

use crate::geometry::{OrientedBox, p2, wrap};
use std::borrow::Cow;
use whyroad_model::scene::Track;
use whyroad_model::{Drive, ObjectClass};

/// Maximum length and width of a road user, m (road trains have about 54 m). The size of a larger box is unknown.
const MOST_M: f64 = 100.0;

/// Length and width of an adult and of a bicycle with its rider, m: the targets of Euro NCAP's tests (EPTa, EBTa); and
/// of a wheelchair, at most (ISO 7193).
const ADULT_M: (f64, f64) = (0.5, 0.5);
const BICYCLE_M: (f64, f64) = (1.89, 0.5);
const WHEELCHAIR_M: (f64, f64) = (1.2, 0.7);

/// The size of a class whose members are all of much the same size, m.
pub(crate) fn usual_size(class: ObjectClass) -> Option<(f64, f64)> {
    match class {
        ObjectClass::Pedestrian => Some(ADULT_M),
        ObjectClass::WheeledPedestrian => Some(WHEELCHAIR_M),
        ObjectClass::Bicycle | ObjectClass::Bicyclist | ObjectClass::EBike => Some(BICYCLE_M),
        _ => None,
    }
}

fn lacks_size(track: &Track) -> bool {
    !track.length_m.iter().chain(&track.width_m).any(|m| m.is_finite())
}

/// `drive` with implausible sizes set to unknown and the usual ones of people and bicycles; borrowed if there are none
/// of either.
pub(crate) fn with_possible_sizes(drive: &Drive) -> Cow<'_, Drive> {
    let odd = |m: f64| m > MOST_M;
    let of_ego = drive.ego.as_ref().is_some_and(|e| odd(e.length_m) || odd(e.width_m));
    let of_tracks = drive.tracks.iter().any(|t| t.length_m.iter().chain(&t.width_m).any(|m| odd(*m)));
    let is_usual = |t: &Track| usual_size(t.class).is_some() && lacks_size(t);
    if !of_ego && !of_tracks && !drive.tracks.iter().any(is_usual) {
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
        if let Some((length, width)) = usual_size(track.class).filter(|_| lacks_size(track)) {
            track.length_m = vec![length; track.frames.len()];
            track.width_m = vec![width; track.frames.len()];
        }
        track.length_m.iter_mut().chain(&mut track.width_m).for_each(unknown);
    }
    Cow::Owned(drive)
}

/// The box of a track in a row.
pub(crate) fn footprint(track: &Track, row: usize) -> OrientedBox {
    let m = &track.motion;
    let center = p2(m.x[row], m.y[row]);
    OrientedBox::new(center, wrap(m.heading[row]), track.length_m[row], track.width_m[row])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(class: ObjectClass, length: f64) -> Track {
        let (length_m, width_m) = (vec![length; 2], vec![length / 2.0; 2]);
        Track { class, frames: vec![0, 1], length_m, width_m, ..Track::default() }
    }

    /// The size of a person does not depend on whether some other object has one.
    #[test]
    fn people_and_bicycles_have_the_usual_size_and_vehicles_and_animals_none() {
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
        // Stated sizes stay.
        assert_eq!(sizes(&with(track(ObjectClass::Pedestrian, 1.0)))[2], (1.0, 0.5));
        for class in [ObjectClass::Car, ObjectClass::Motorcycle, ObjectClass::Animal, ObjectClass::Unknown] {
            let of_log = sizes(&with(track(class, f64::NAN)));
            assert!(of_log[..2] == [(0.5, 0.5), (1.89, 0.5)] && of_log[2].0.is_nan(), "{class:?} {of_log:?}");
        }
    }
}
