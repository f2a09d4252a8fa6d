//! The commands as their users run them: one test binary for the whole crate.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../../../whyroad-model/testing/folders.rs"]
mod folders;
#[path = "../../../whyroad-server/tests/it/postgres_server.rs"]
mod postgres;
#[path = "../../../whyroad-model/testing/require.rs"]
mod require;
#[path = "../../../whyroad-chat/testing/scripted.rs"]
mod scripted;
mod service;
mod session;

mod analytics;
mod blur;
mod calibrate;
mod dataset;
mod dataset_images;
mod dataset_labels;
mod demo;
mod docs;
mod duckdb;
mod evaluate;
mod faults;
mod import_cycles;
mod imports;
mod ingest;
mod ingest_again;
mod inspect;
mod instances;
mod labels;
mod lake_delete;
mod media;
mod mine;
mod mine_again;
mod model;
mod ops;
mod other;
mod packs;
mod pages;
mod parts;
mod recorded;
mod robustness;
mod rules;
mod s3;
mod scenario_mining;
mod signals;
mod stage_one;
mod tasks;
mod taxonomy;
mod taxonomy_framework;
mod traps;
mod truth;
mod truth_recorded;
mod truth_rerooted;
mod validate;
mod width;
