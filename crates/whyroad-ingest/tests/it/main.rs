//! Integration tests of the ingest: one module per format.

mod av2_broken;
mod av2_motion;
mod av2_real;
mod comma2k19;
mod mcap;
mod nuscenes;
mod scenarionet;
mod sumo;
mod sumo_egos;
mod table;
mod waymo;
