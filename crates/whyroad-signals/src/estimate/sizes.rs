//! Plausible box sizes. Derivation works along boxes, so its work grows with them: a box of a billion meters, which a
//! damaged or malicious lake may contain, must not cost more than another.

use std::borrow::Cow;
use whyroad_model::Drive;

/// Maximum length and width of a road user, m (road trains have about 54 m). The size of a larger box is unknown.
const MOST_M: f64 = 100.0;

/// `drive` with implausible sizes set to unknown; borrowed if there are none.
pub(crate) fn with_possible_sizes(drive: &Drive) -> Cow<'_, Drive> {
    let odd = |m: f64| m > MOST_M;
    let of_ego = drive.ego.as_ref().is_some_and(|e| odd(e.length_m) || odd(e.width_m));
    let of_tracks = drive.tracks.iter().any(|t| t.length_m.iter().chain(&t.width_m).any(|m| odd(*m)));
    if !of_ego && !of_tracks {
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
        track.length_m.iter_mut().chain(&mut track.width_m).for_each(unknown);
    }
    Cow::Owned(drive)
}
