//! The client: one question in, one answer out. Answers are kept by the content of their request; requests are spaced,
//! counted and repeated where that helps.

mod answer;
mod budget;
mod cache;
mod key;
mod retry;
mod wire;

pub use budget::{Budget, Limit, Price};
pub use key::Key;

use crate::{ChatError, Request};
use answer::Completion;
use budget::Ledger;
use cache::Cache;
use retry::{Pace, Retry};
use std::path::PathBuf;
use std::time::Duration;
use whyroad_model::ModelSpent;
use wire::{Outcome, Wire};

/// Maximum number of times that one question is asked until its answer has the required form.
const TRIES_FOR_FORM: u32 = 2;

/// How to reach a model, and within which limits.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Address of the interface, `https://host/v1`; `/chat/completions` is added.
    pub url: String,
    /// Name of the model.
    pub model: String,
    /// Sent as bearer token; `None` where the endpoint requires none.
    pub key: Option<Key>,
    /// Time for one request as a whole.
    pub timeout: Duration,
    /// Further requests after a time-out, 429 or 5xx.
    pub retries: u32,
    /// First pause before a retry; doubled each time.
    pub backoff: Duration,
    /// Longest pause, also of a `Retry-After`.
    pub longest_pause: Duration,
    /// Maximum number of requests per minute.
    pub requests_per_minute: Option<u32>,
    /// The budget.
    pub budget: Budget,
    /// Prices, for the report.
    pub price: Option<Price>,
    /// Folder of kept answers.
    pub cache: Option<PathBuf>,
    /// Maximum length of an answer.
    pub max_answer_tokens: u32,
}

impl Settings {
    /// The usual limits: 60 s, 4 retries from 1 s on, 2048 tokens, no budget, no cache.
    pub fn new(url: impl Into<String>, model: impl Into<String>) -> Self {
        Self {
            url: url.into(),
            model: model.into(),
            key: None,
            timeout: Duration::from_secs(60),
            retries: 4,
            backoff: Duration::from_secs(1),
            longest_pause: Duration::from_secs(60),
            requests_per_minute: None,
            budget: Budget::default(),
            price: None,
            cache: None,
            max_answer_tokens: 2048,
        }
    }
}

/// A usable answer: the parsed value, and the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answered<T> {
    /// As parsed by the caller.
    pub value: T,
    /// The model's text.
    pub text: String,
}

/// Asks one model. May be shared between threads.
#[derive(Debug)]
pub struct Client {
    wire: Wire,
    cache: Option<Cache>,
    ledger: Ledger,
    pace: Pace,
    retry: Retry,
    model: String,
    max_answer_tokens: u32,
}

impl Client {
    /// An error where the address is not usable or the cache's folder cannot be made.
    pub fn new(settings: Settings) -> Result<Self, ChatError> {
        Ok(Self {
            wire: Wire::new(&settings.url, settings.key, settings.timeout)?,
            cache: settings.cache.map(Cache::open).transpose()?,
            ledger: Ledger::new(settings.budget, settings.price),
            pace: Pace::new(settings.requests_per_minute),
            retry: Retry { most: settings.retries, first: settings.backoff, longest: settings.longest_pause },
            model: settings.model,
            max_answer_tokens: settings.max_answer_tokens,
        })
    }

    /// Name of the model.
    pub fn model(&self) -> &str {
        &self.model
    }

    /// What was spent so far.
    pub fn spent(&self) -> ModelSpent {
        self.ledger.spent()
    }

    /// Asks, and parses the answer with `read`, whose error describes what is wrong. An answer that `read` accepts is
    /// kept, and so is a refusal; otherwise the question is asked once more.
    pub fn ask<T>(
        &self,
        request: &Request,
        read: impl Fn(&str) -> Result<T, String>,
    ) -> Result<Answered<T>, ChatError> {
        let body = request.body(&self.model, self.max_answer_tokens);
        let name = cache::name(self.wire.url(), &body);
        match self.cache.as_ref().and_then(|c| c.get(&name)) {
            Some(Err(refusal)) => {
                self.ledger.cached();
                return Err(ChatError::Refused(refusal));
            }
            Some(Ok(text)) => {
                if let Ok(value) = read(&text) {
                    self.ledger.cached();
                    return Ok(Answered { value, text });
                }
            }
            None => {}
        }
        let keep = |answer| self.cache.as_ref().map_or(Ok(()), |cache| cache.put(&name, answer));
        let mut fault = String::new();
        for _ in 0..TRIES_FOR_FORM {
            let completion = self.completion(&body)?;
            if let Some(why) = completion.refusal {
                keep(Err(&why))?;
                return Err(ChatError::Refused(why));
            }
            let text = match completion.text() {
                Ok(text) => text,
                Err(why) => {
                    fault = why;
                    continue;
                }
            };
            match read(&text) {
                Ok(value) => {
                    keep(Ok(&text))?;
                    return Ok(Answered { value, text });
                }
                Err(why) => fault = why,
            }
        }
        Err(ChatError::Answer(fault))
    }

    /// One completion, with retries.
    fn completion(&self, body: &str) -> Result<Completion, ChatError> {
        let mut attempts = 0;
        loop {
            self.ledger.take()?;
            self.pace.wait();
            attempts += 1;
            let (why, pause) = match self.wire.post(body) {
                Outcome::Body(text) => match Completion::read(&text) {
                    Ok(completion) => {
                        self.ledger.add(completion.tokens);
                        return Ok(completion);
                    }
                    // A proxy's page, or a connection that was cut: the next request may succeed.
                    Err(why) => (why, None),
                },
                Outcome::Again { why, pause } => (why, pause),
                Outcome::Rejected { status, why } => return Err(ChatError::Rejected { status, why }),
            };
            match self.retry.pause(attempts, pause) {
                Some(pause) => std::thread::sleep(pause),
                None => return Err(ChatError::Unavailable { attempts, why }),
            }
        }
    }
}
