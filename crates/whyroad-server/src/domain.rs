//! The concepts of the service as types: the life of a task ([`workflow`]), and the data of projects, tasks and people.
//! The OpenAPI document is generated from these types, and the page's client from that. No store, no HTTP, no clock.
//!
//! Times in a drive are ISO 8601 texts (a number in a browser cannot represent nanoseconds); the service's own times
//! are milliseconds since 1970.

pub mod gold;
pub mod making;
pub mod mined;
pub mod model;
pub mod oidc;
pub mod people;
pub mod project;
pub mod safety;
pub mod scene;
pub mod settings;
pub mod talk;
pub mod task;
pub mod workflow;
