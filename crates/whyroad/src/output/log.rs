//! Messages on stderr in the log format: text for people, or one JSON object per line for log collectors. Fields:
//! `time`, `level` (`info`, `warning`, `error`), `event`, and the fields of the event.

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Map, Value, json};
use std::io::Write as _;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use whyroad_model::{Diagnostic, Lang, Nanos, Severity};
use whyroad_server::metrics::Served;

/// The log format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum LogFormat {
    /// For people
    #[default]
    Text,
    /// One JSON object per line
    Json,
}

/// Set once, when the command line has been read.
static JSON: AtomicBool = AtomicBool::new(false);

/// Sets the format for the whole run.
pub(crate) fn set(format: LogFormat) {
    JSON.store(format == LogFormat::Json, Ordering::Relaxed);
}

/// Whether messages are JSON.
pub(crate) fn is_json() -> bool {
    JSON.load(Ordering::Relaxed)
}

/// A message. One that begins with `error:`, or the same in Chinese, is an error.
pub(crate) fn message(text: &str) {
    let error = text.strip_prefix("error: ").or_else(|| text.strip_prefix("错误："));
    let level = if error.is_some() { "error" } else { "info" };
    put(text, level, "message", json!({ "message": error.unwrap_or(text).trim_end() }));
}

/// A message of the service to its operator.
pub(crate) fn warning(text: &str) {
    put(text, "warning", "service", json!({ "message": text }));
}

/// A request that the service answered; only in JSON.
pub(crate) fn request(served: &Served<'_>) {
    let level = if served.status >= 500 { "error" } else { "info" };
    let seconds = (served.took.as_secs_f64() * 1e6).round() / 1e6;
    let fields =
        json!({"method": served.method, "route": served.route, "status": served.status, "seconds": seconds});
    put("", level, "request", fields);
}

/// A diagnostic as a line of JSON, with its line end.
pub(crate) fn of_diagnostic(d: &Diagnostic, lang: Lang) -> String {
    let level = match d.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Note => "info",
    };
    let fields = json!({
        "code": d.code, "message": d.message.get(lang), "place": d.location,
        "hint": d.hint.as_ref().map(|h| h.get(lang)),
    });
    line(level, "diagnostic", fields)
}

/// A closed stderr is not a reason to stop.
fn put(text: &str, level: &str, event: &str, fields: Value) {
    let mut out = anstream::stderr();
    let _ = if is_json() {
        out.write_all(line(level, event, fields).as_bytes())
    } else {
        writeln!(out, "{text}")
    };
}

fn line(level: &str, event: &str, fields: Value) -> String {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_nanos());
    let time = Nanos(i64::try_from(now).unwrap_or(i64::MAX) / 1_000_000 * 1_000_000).to_string();
    let mut all = Map::new();
    all.insert("time".to_owned(), time.into());
    all.insert("level".to_owned(), level.into());
    all.insert("event".to_owned(), event.into());
    if let Value::Object(fields) = fields {
        all.extend(fields.into_iter().filter(|(_, v)| !v.is_null()));
    }
    format!("{}\n", Value::Object(all))
}

/// Between two lines of progress.
const PROGRESS_EVERY: Duration = Duration::from_secs(10);

/// Progress of a long run: a bar on a terminal, or lines of JSON.
pub(crate) struct Progress {
    bar: ProgressBar,
    steps: usize,
    done: AtomicUsize,
    begun: Instant,
    reported: Mutex<Instant>,
}

impl Progress {
    pub(crate) fn new(steps: usize) -> Self {
        let bar = if is_json() { ProgressBar::hidden() } else { ProgressBar::new(steps as u64) };
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed} {msg}") {
            bar.set_style(style);
        }
        let begun = Instant::now();
        Self { bar, steps, done: AtomicUsize::new(0), begun, reported: Mutex::new(begun) }
    }

    /// The current item.
    pub(crate) fn set_message(&self, text: impl Into<std::borrow::Cow<'static, str>>) {
        self.bar.set_message(text);
    }

    /// Adds finished steps.
    pub(crate) fn inc(&self, steps: u64) {
        self.bar.inc(steps);
        let steps = usize::try_from(steps).unwrap_or(usize::MAX);
        let done = self.done.fetch_add(steps, Ordering::Relaxed) + steps;
        let mut reported = self.reported.lock().unwrap_or_else(PoisonError::into_inner);
        if reported.elapsed() >= PROGRESS_EVERY {
            *reported = Instant::now();
            self.report(done);
        }
    }

    /// Steps done.
    pub(crate) fn position(&self) -> u64 {
        self.done.load(Ordering::Relaxed) as u64
    }

    /// Sets the number of finished steps.
    pub(crate) fn set_position(&self, done: u64) {
        self.inc(done.saturating_sub(self.position()));
    }

    /// Prints without the bar in between.
    pub(crate) fn suspend(&self, print: impl FnOnce()) {
        self.bar.suspend(print);
    }

    /// All steps are finished.
    pub(crate) fn finish_and_clear(&self) {
        self.bar.finish_and_clear();
        self.report(self.done.load(Ordering::Relaxed));
    }

    fn report(&self, done: usize) {
        if is_json() {
            let seconds = (self.begun.elapsed().as_secs_f64() * 1e3).round() / 1e3;
            put("", "info", "progress", json!({"done": done, "total": self.steps, "seconds": seconds}));
        }
    }
}
