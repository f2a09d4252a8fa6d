//! One function per route: reads the request, calls the service, answers.

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
