//! What is done to every drive, whatever its format, when its adapter has made it.

use crate::assemble::{checks, layers, rings};
use whyroad_model::road_map::{LayerState, MapLayer};
use whyroad_model::scene::Drive;
use whyroad_model::{Diagnostic, Nanos};

/// Finishes a drive; the diagnostics say what was repaired or found.
pub(crate) fn finish(drive: &mut Drive) -> Vec<Diagnostic> {
    state_known_at(drive);
    let found = checks::check(drive);
    if let Some(map) = &mut drive.map {
        if map.layers.is_empty() {
            layers::declare(map, &[]);
        }
        layers::derive_absent(map);
        // All rings of lanes are found where all connections are present.
        if map.layer(MapLayer::Connections) == LayerState::Complete {
            rings::add(map);
        }
    }
    found
}

/// Adapters state how much later than its frame a row was known; the tables state when.
fn state_known_at(drive: &mut Drive) {
    let Drive { times, ego, tracks, .. } = drive;
    let at = |lag: &mut Nanos, frame: usize| *lag = Nanos(times[frame].0.saturating_add(lag.0));
    if let Some(ego) = ego {
        ego.known_at.iter_mut().enumerate().for_each(|(frame, lag)| at(lag, frame));
    }
    for track in tracks {
        track.known_at.iter_mut().zip(&track.frames).for_each(|(lag, &frame)| at(lag, frame as usize));
    }
}
