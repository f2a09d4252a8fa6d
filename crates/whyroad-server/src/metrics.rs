//! Figures of the running service in the text format of Prometheus (exposition format 0.0.4): requests, tasks by state,
//! deliveries that wait, the store, the process. No name of a person, project, drive or task is in them.

use crate::app::App;
use crate::problem::Answer;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Upper bounds of the histogram of durations, s.
const BOUNDS: &[f64] = &[0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0];
/// Figures of the store are asked for again after this time, however often somebody scrapes.
const STORE_AGE: Duration = Duration::from_secs(10);

/// A request that was answered.
#[derive(Clone, Copy, Debug)]
pub struct Served<'a> {
    /// Method in capitals; `other` for one that no route has.
    pub method: &'a str,
    /// The route as the table has it, `page`, or `none`.
    pub route: &'a str,
    /// Status.
    pub status: u16,
    /// From the head of the request to the head of the answer.
    pub took: Duration,
}

/// Counters of one service.
#[derive(Debug)]
pub struct Metrics {
    requests: Mutex<BTreeMap<(String, String), Requests>>,
    in_progress: AtomicI64,
    stopping: AtomicBool,
    started: SystemTime,
    store: Mutex<Option<(Instant, StoreFigures)>>,
}

impl Default for Metrics {
    fn default() -> Self {
        Self {
            requests: Mutex::default(),
            in_progress: AtomicI64::new(0),
            stopping: AtomicBool::new(false),
            started: SystemTime::now(),
            store: Mutex::default(),
        }
    }
}

/// Requests of one route and method.
#[derive(Debug, Default)]
struct Requests {
    by_status: BTreeMap<u16, u64>,
    /// Below or at each of [`BOUNDS`].
    below: [u64; BOUNDS.len()],
    seconds: f64,
    count: u64,
}

/// What a look into the store gave; `None` where it did not answer.
type StoreFigures = Option<Held>;

#[derive(Clone, Debug, Default)]
struct Held {
    tasks: BTreeMap<String, i64>,
    waiting: i64,
    /// Since 1970, ms.
    oldest: Option<i64>,
    took: Duration,
}

/// A request in progress, until it is dropped.
#[derive(Debug)]
pub struct InProgress<'a>(&'a Metrics);

impl Drop for InProgress<'_> {
    fn drop(&mut self) {
        self.0.in_progress.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Metrics {
    /// Counts a request as in progress.
    pub fn begin(&self) -> InProgress<'_> {
        self.in_progress.fetch_add(1, Ordering::Relaxed);
        InProgress(self)
    }

    /// Counts an answer.
    pub fn count(&self, served: &Served<'_>) {
        let mut requests = lock(&self.requests);
        let of = requests.entry((served.method.to_owned(), served.route.to_owned())).or_default();
        let seconds = served.took.as_secs_f64();
        *of.by_status.entry(served.status).or_default() += 1;
        for (n, bound) in of.below.iter_mut().zip(BOUNDS) {
            *n += u64::from(seconds <= *bound);
        }
        of.seconds += seconds;
        of.count += 1;
    }

    /// The service takes no new work: it is not ready any more.
    pub fn stop(&self) {
        self.stopping.store(true, Ordering::Relaxed);
    }

    /// Whether the service can work: why not, otherwise.
    ///
    /// # Errors
    /// The service stops, its store does not answer, or its recordings are away.
    pub fn ready(app: &App) -> Result<(), String> {
        if app.metrics.stopping.load(Ordering::Relaxed) {
            return Err("stopping".to_owned());
        }
        app.store.read(|tx| tx.row("SELECT 1 AS one", &[])).map_err(|p| format!("store: {}", p.code))?;
        app.recordings.ready().map_err(|_| "lake: cannot be read".to_owned())
    }

    /// All figures. Asks the store, and so blocks.
    pub fn text(app: &App) -> String {
        let metrics = &app.metrics;
        let mut out = Text::default();
        out.head("whyroad_build_info", "gauge", "Version of the program");
        out.line("whyroad_build_info", &[("version", env!("CARGO_PKG_VERSION"))], 1.0);
        out.head("whyroad_ready", "gauge", "1 when the service can work: see /readyz");
        out.line("whyroad_ready", &[], f64::from(u8::from(Self::ready(app).is_ok())));
        metrics.http(&mut out);
        metrics.of_store(app, &mut out);
        process(metrics.started, &mut out);
        out.0
    }

    fn http(&self, out: &mut Text) {
        out.head("whyroad_http_requests_in_progress", "gauge", "Requests that are being answered");
        out.line("whyroad_http_requests_in_progress", &[], self.in_progress.load(Ordering::Relaxed) as f64);
        let requests = lock(&self.requests);
        out.head("whyroad_http_requests_total", "counter", "Requests by route and status");
        for ((method, route), of) in &*requests {
            for (status, n) in &of.by_status {
                let labels = [("method", method.as_str()), ("route", route), ("status", &status.to_string())];
                out.line("whyroad_http_requests_total", &labels, *n as f64);
            }
        }
        let name = "whyroad_http_request_seconds";
        out.head(name, "histogram", "Time from the head of a request to the head of its answer");
        for ((method, route), of) in &*requests {
            let labels = |le: Option<&str>| -> Vec<(&str, String)> {
                let mut all = vec![("method", method.clone()), ("route", route.clone())];
                all.extend(le.map(|le| ("le", le.to_owned())));
                all
            };
            let mut put = |suffix: &str, le: Option<&str>, value: f64| {
                let labels = labels(le);
                let labels: Vec<(&str, &str)> = labels.iter().map(|(k, v)| (*k, v.as_str())).collect();
                out.line(&format!("{name}_{suffix}"), &labels, value);
            };
            for (n, bound) in of.below.iter().zip(BOUNDS) {
                put("bucket", Some(&bound.to_string()), *n as f64);
            }
            put("bucket", Some("+Inf"), of.count as f64);
            put("sum", None, of.seconds);
            put("count", None, of.count as f64);
        }
    }

    fn of_store(&self, app: &App, out: &mut Text) {
        let mut kept = lock(&self.store);
        let held = match &*kept {
            Some((at, held)) if at.elapsed() < STORE_AGE => held.clone(),
            _ => {
                let held = look(app).ok();
                *kept = Some((Instant::now(), held.clone()));
                held
            }
        };
        drop(kept);
        out.head("whyroad_store_up", "gauge", "1 when the store answered the last time it was asked");
        out.line("whyroad_store_up", &[], f64::from(u8::from(held.is_some())));
        // Without an answer nothing is known; 0 would be a claim.
        let Some(held) = held else { return };
        out.head("whyroad_store_seconds", "gauge", "How long the store took for these figures");
        out.line("whyroad_store_seconds", &[], held.took.as_secs_f64());
        out.head("whyroad_tasks", "gauge", "Tasks by state");
        for (state, n) in &held.tasks {
            out.line("whyroad_tasks", &[("state", state)], *n as f64);
        }
        out.head("whyroad_webhook_deliveries_waiting", "gauge", "Events that are to be delivered");
        out.line("whyroad_webhook_deliveries_waiting", &[], held.waiting as f64);
        out.head("whyroad_webhook_oldest_seconds", "gauge", "Age of the oldest of them; 0 without one");
        let age = held.oldest.map_or(0, |at| (app.now() - at).max(0));
        out.line("whyroad_webhook_oldest_seconds", &[], age as f64 / 1000.0);
    }
}

fn look(app: &App) -> Answer<Held> {
    let begun = Instant::now();
    let mut held = app.store.report(|tx| {
        let mut held = Held::default();
        for row in tx.rows("SELECT state, count(*) AS n FROM tasks GROUP BY state", &[])? {
            held.tasks.insert(row.text("state")?, row.int("n")?);
        }
        if let Some(row) = tx.row("SELECT count(*) AS n, min(created) AS oldest FROM outbox", &[])? {
            (held.waiting, held.oldest) = (row.int("n")?, row.maybe_int("oldest")?);
        }
        Ok(held)
    })?;
    held.took = begun.elapsed();
    Ok(held)
}

/// Figures of the process under the names that Prometheus' own clients use; where there is no `/proc` only its start.
fn process(started: SystemTime, out: &mut Text) {
    let since = started.duration_since(UNIX_EPOCH).unwrap_or_default();
    out.head("process_start_time_seconds", "gauge", "Start of the process since 1970");
    out.line("process_start_time_seconds", &[], since.as_secs_f64());
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let resident = status.lines().find_map(|l| l.strip_prefix("VmRSS:")?.trim().strip_suffix(" kB"));
    if let Some(kib) = resident.and_then(|n| n.trim().parse::<f64>().ok()) {
        out.head("process_resident_memory_bytes", "gauge", "Memory in use");
        out.line("process_resident_memory_bytes", &[], kib * 1024.0);
    }
    // Fields 14 and 15 in hundredths of a second (USER_HZ); the name in parentheses before may hold spaces.
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    if let [Some(user), Some(system)] = [11, 12].map(|i| fields.get(i).and_then(|n| n.parse::<f64>().ok())) {
        out.head("process_cpu_seconds_total", "counter", "CPU time");
        out.line("process_cpu_seconds_total", &[], (user + system) / 100.0);
    }
    if let Ok(open) = std::fs::read_dir("/proc/self/fd") {
        out.head("process_open_fds", "gauge", "Open files and connections");
        out.line("process_open_fds", &[], open.count() as f64);
    }
}

#[derive(Default)]
struct Text(String);

impl Text {
    fn head(&mut self, name: &str, kind: &str, about: &str) {
        let _ = write!(self.0, "# HELP {name} {about}\n# TYPE {name} {kind}\n");
    }

    /// Values of labels are routes, states and versions: nothing in them has to be escaped but what a state of a broken
    /// store might hold.
    fn line(&mut self, name: &str, labels: &[(&str, &str)], value: f64) {
        let escaped = |v: &str| v.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
        let labels: Vec<String> = labels.iter().map(|(k, v)| format!("{k}=\"{}\"", escaped(v))).collect();
        let labels = if labels.is_empty() { String::new() } else { format!("{{{}}}", labels.join(",")) };
        let _ = writeln!(self.0, "{name}{labels} {value}");
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::fixtures;

    #[test]
    fn requests_are_counted_by_route_and_bound() {
        let (app, _dir) = fixtures::app();
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
        let text = Metrics::text(&app);
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
            assert!(text.lines().any(|l| l == line), "no {line} in\n{text}");
        }
        app.metrics.stop();
        assert!(Metrics::text(&app).contains("whyroad_ready 0\n"));
        assert_eq!(Metrics::ready(&app).unwrap_err(), "stopping");
    }
}
