//! The metrics of a service as one text, and whether it is ready: the responses of the port for operators and of
//! `/healthz`. All query the store or the lake, and wait for them a few seconds at most: a probe that hangs with the
//! database reports nothing, in the very case that it is for.

use crate::app::App;
use crate::metrics::{StoreFigures, Text};
use crate::problem::Answer;
use crate::service::bounded::Turn;
use crate::service::{by_state, webhooks};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Maximum time for an answer: less than the time that probes of Kubernetes files wait (5 s) and Prometheus waits by
/// default (10 s).
const ANSWER_WITHIN: Duration = Duration::from_secs(3);

/// Whether the store answers; otherwise the reason.
///
/// # Errors
/// It does not answer, or not in time.
pub fn store_ready(app: &Arc<App>) -> Result<(), String> {
    let turn = ask_store(app);
    store_answer(app, turn, Instant::now() + ANSWER_WITHIN)
}

/// Whether the service is ready; otherwise the reason.
///
/// # Errors
/// The service stops, its store does not answer, or its recordings are unavailable.
pub fn ready(app: &Arc<App>) -> Result<(), String> {
    ready_by(app, Instant::now() + ANSWER_WITHIN)
}

fn ready_by(app: &Arc<App>, deadline: Instant) -> Result<(), String> {
    if app.metrics.is_stopping() {
        return Err("stopping".to_owned());
    }
    let store = ask_store(app);
    let asked = Arc::clone(app);
    let lake = app.probes.lake.ask(move || asked.recordings.ready().is_ok());
    store_answer(app, store, deadline)?;
    match app.probes.lake.until(lake, deadline) {
        Some(true) => Ok(()),
        Some(false) => Err("lake: cannot be read".to_owned()),
        None => Err(no_answer("lake")),
    }
}

fn ask_store(app: &Arc<App>) -> Turn {
    let asked = Arc::clone(app);
    app.probes
        .store
        .ask(move || asked.store.probe(|tx| tx.row("SELECT 1 AS one", &[])).map(drop).map_err(|p| p.code))
}

fn store_answer(app: &App, turn: Turn, deadline: Instant) -> Result<(), String> {
    match app.probes.store.until(turn, deadline) {
        Some(answer) => answer.map_err(|code| format!("store: {code}")),
        None => Err(no_answer("store")),
    }
}

fn no_answer(from: &str) -> String {
    format!("{from}: no answer within {} s", ANSWER_WITHIN.as_secs())
}

/// All metrics, in the text format of Prometheus.
pub fn text(app: &Arc<App>) -> String {
    let deadline = Instant::now() + ANSWER_WITHIN;
    // Asked for beside the other questions: one that hangs takes the time of all.
    let figures = app.metrics.recent_figures().map_or_else(
        || {
            let asked = Arc::clone(app);
            Err(app.probes.figures.ask(move || look(&asked).ok()))
        },
        Ok,
    );
    let mut out = Text::default();
    out.head("whyroad_build_info", "gauge", "Version of the program");
    out.line("whyroad_build_info", &[("version", env!("CARGO_PKG_VERSION"))], 1.0);
    out.head("whyroad_ready", "gauge", "1 if the service is ready: see /readyz");
    out.line("whyroad_ready", &[], f64::from(u8::from(ready_by(app, deadline).is_ok())));
    app.metrics.http(&mut out);
    let held = figures.unwrap_or_else(|turn| {
        let held = app.probes.figures.until(turn, deadline).flatten();
        app.metrics.keep_figures(held.clone());
        held
    });
    of_store(app, held, &mut out);
    app.metrics.process(&mut out);
    out.0
}

fn of_store(app: &App, held: Option<StoreFigures>, out: &mut Text) {
    out.head("whyroad_store_up", "gauge", "1 if the store answered the last query");
    out.line("whyroad_store_up", &[], f64::from(u8::from(held.is_some())));
    // Without an answer nothing is known; 0 would be a false value.
    let Some(held) = held else { return };
    out.head("whyroad_store_seconds", "gauge", "Time that the store took for these metrics");
    out.line("whyroad_store_seconds", &[], held.took.as_secs_f64());
    out.head("whyroad_tasks", "gauge", "Tasks by state");
    for (state, n) in &held.tasks {
        out.line("whyroad_tasks", &[("state", state)], *n as f64);
    }
    out.head("whyroad_webhook_deliveries_waiting", "gauge", "Events waiting for delivery");
    out.line("whyroad_webhook_deliveries_waiting", &[], held.waiting as f64);
    out.head(
        "whyroad_webhook_oldest_seconds",
        "gauge",
        "Age of the oldest event waiting for delivery; 0 if there is none",
    );
    let age = held.oldest.map_or(0, |at| (app.now() - at).max(0));
    out.line("whyroad_webhook_oldest_seconds", &[], age as f64 / 1000.0);
}

fn look(app: &App) -> Answer<StoreFigures> {
    let begun = Instant::now();
    let mut held = app.store.probe(|tx| {
        let mut held = StoreFigures { tasks: by_state::of_all(tx)?, ..StoreFigures::default() };
        (held.waiting, held.oldest) = webhooks::waiting(tx)?;
        Ok(held)
    })?;
    held.took = begun.elapsed();
    Ok(held)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Served;
    use crate::service::fixtures;

    #[test]
    fn requests_are_counted_by_route_and_bound() {
        let (app, _dir) = fixtures::app();
        let app = Arc::new(app);
        let served = |status, millis| Served {
            method: "GET",
            route: "/tasks/{t}",
            status,
            took: Duration::from_millis(millis),
        };
        app.metrics.count(&served(200, 1));
        app.metrics.count(&served(200, 40));
        app.metrics.count(&served(404, 20_000));
        let _open = app.metrics.begin();
        let all = text(&app);
        let labels = "method=\"GET\",route=\"/tasks/{t}\"";
        for line in [
            format!("whyroad_http_requests_total{{{labels},status=\"200\"}} 2"),
            format!("whyroad_http_requests_total{{{labels},status=\"404\"}} 1"),
            format!("whyroad_http_request_seconds_bucket{{{labels},le=\"0.001\"}} 1"),
            format!("whyroad_http_request_seconds_bucket{{{labels},le=\"0.05\"}} 2"),
            format!("whyroad_http_request_seconds_bucket{{{labels},le=\"10\"}} 2"),
            format!("whyroad_http_request_seconds_bucket{{{labels},le=\"+Inf\"}} 3"),
            format!("whyroad_http_request_seconds_count{{{labels}}} 3"),
            "whyroad_http_requests_in_progress 1".to_owned(),
            "whyroad_ready 1".to_owned(),
            "whyroad_store_up 1".to_owned(),
            "whyroad_webhook_oldest_seconds 0".to_owned(),
        ] {
            assert!(all.lines().any(|l| l == line), "no {line} in\n{all}");
        }
        app.metrics.stop();
        assert!(text(&app).contains("whyroad_ready 0\n"));
        assert_eq!(ready(&app).unwrap_err(), "stopping");
    }
}
