//! Integration tests of the signals, in one binary. Each file states where its expected values come from.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod behavior;
mod crime;
mod criticality;
mod distances;
mod lane_change_phases;
mod manoeuvres;
mod map_parts;
mod people;
mod proven_turns;
mod recorded;
mod recorded_traps;
mod refav;
mod relevance;
#[path = "../../../whyroad-model/testing/require.rs"]
mod require;
mod road_ahead;
mod scene;
mod sight;
mod sight_recorded;
mod simulated;
mod sumo_road;
mod sumo_truth;
mod target_ramp;
mod terrain;
mod ttc_lane;
mod wanted;
mod whole;
