//! What the service does, one part a file. Functions take a transaction where several of them make one change.

pub mod actions;
pub mod answer;
pub mod audits;
pub mod bulk;
pub mod classes;
pub mod create;
pub mod dashboard;
pub mod drafting;
pub mod drafts;
pub mod facts;
pub mod findings;
#[cfg(test)]
mod fixtures;
pub mod gold;
pub mod history;
pub mod identities;
pub mod leases;
pub mod list;
pub mod migration;
pub mod people;
pub mod permissions;
pub mod pickers;
pub mod projects;
pub mod queue;
pub mod retention;
pub mod review;
pub mod safety;
pub mod scene;
pub mod seen;
pub mod tasks;
pub mod thumbnail;
pub mod tokens;
pub mod transfer;
pub mod veil;
pub mod visible;
pub mod webhooks;
pub mod work;
