//! The labeling service: tasks from episodes, two-stage labels, check and audit, in a store of its own.
//!
//! `workflow` defines who may do what; `store` persists it; `service` implements it; `api` exposes it over HTTP. The
//! caller provides recordings: this crate reads no lake and derives no signals.

pub mod api;
pub mod app;
pub mod blur;
pub mod domain;
pub mod language_model;
pub mod limits;
pub mod memory;
pub mod metrics;
pub mod oidc;
pub mod problem;
pub mod recordings;
pub mod reports;
pub mod secret;
pub mod service;
pub mod store;
mod sync;
mod url;

pub use api::ops::serve_ops;
pub use api::server::serve;
pub use app::App;

#[cfg(test)]
#[path = "../../whyroad-model/testing/require.rs"]
mod require;
