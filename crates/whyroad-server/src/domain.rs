//! What the service is about, as types: the life of a task ([`workflow`]), and what is said about projects, tasks and
//! people. The OpenAPI document is made from these types, and the page's client from that. No store, no HTTP, no clock.
//!
//! Moments of a drive are ISO 8601 texts (a browser's numbers do not hold nanoseconds); the service's own moments are
//! milliseconds since 1970.

pub mod gold;
pub mod making;
pub mod mined;
pub mod model;
pub mod oidc;
pub mod people;
pub mod project;
pub mod safety;
pub mod scene;
pub mod talk;
pub mod task;
pub mod workflow;
