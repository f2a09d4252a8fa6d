//! One function a route: read the request, call the service, answer.

pub mod accounts;
pub mod drafts;
pub mod mined;
pub mod model;
pub mod oidc;
pub mod projects;
pub mod scenes;
pub mod session;
pub mod talk;
pub mod tasks;
pub mod transfer;
pub mod webhooks;
