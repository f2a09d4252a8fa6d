//! What goes over the wire, as types: the OpenAPI document is made from them and the page's client from that.
//! Moments of a drive are ISO 8601 texts (a browser's numbers do not hold nanoseconds); the service's own moments are
//! milliseconds since 1970.

pub mod making;
pub mod oidc;
pub mod people;
pub mod project;
pub mod scene;
pub mod talk;
pub mod task;
