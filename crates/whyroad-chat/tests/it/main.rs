//! The client, drafts, the judge and questions against a local endpoint that misbehaves.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../../../whyroad-model/testing/hand_drive.rs"]
mod hand_drive;
#[path = "../../testing/scripted.rs"]
mod scripted;

mod ask;
mod client;
mod draft;
mod judge;
