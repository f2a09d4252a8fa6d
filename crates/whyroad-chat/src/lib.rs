//! Questions to a language model. [`client`] speaks OpenAI-compatible chat completions: schema-constrained answers,
//! retries, a rate limit, a budget, a cache by content, and a report of what was spent. It has no knowledge of drives
//! or labels. Each kind of question has a module: [`draft`], [`judge`], [`ask`]. Drives, labels and images are handed
//! in.

pub mod client;
mod error;
mod request;

mod language;
pub mod scene;

pub mod ask;
pub mod draft;
pub mod judge;

pub use client::{Budget, Client, Price, Settings};
pub use error::{CODES, ChatError};
pub use request::{AnswerForm, ImageKind, Message, Part, Request, Role};
