//! HTTP: request and response formats, access rules, and the server. Nothing here decides about labels: handlers read a
//! request, call `service`, and answer.

pub mod access;
pub mod call;
pub mod handlers;
mod incoming;
pub mod openapi;
pub mod ops;
pub mod pages;
pub mod reply;
pub mod route;
mod router;
pub mod server;
pub mod stream;
pub mod table;

mod deliver;
mod timed;
