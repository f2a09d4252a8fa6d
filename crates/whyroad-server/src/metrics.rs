//! Metrics of the running service in the text format of Prometheus (exposition format 0.0.4): requests, tasks by state,
//! waiting deliveries, the store, the process. They contain no name of a person, project, drive or task.

use crate::sync::lock;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Upper bounds of the histogram of durations, s.
const BOUNDS: &[f64] = &[0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0];
/// Minimum time between two queries of the store, however often metrics are read.
const STORE_AGE: Duration = Duration::from_secs(10);

/// A request that was answered.
#[derive(Clone, Copy, Debug)]
pub struct Served<'a> {
    /// Method in capitals; `other` for one that no route has.
    pub method: &'a str,
    /// The route as in the table, `page`, or `none`.
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
    store: Mutex<Option<(Instant, Option<StoreFigures>)>>,
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

/// Result of a query of the store.
#[derive(Clone, Debug, Default)]
pub(crate) struct StoreFigures {
    /// Tasks by state.
    pub tasks: BTreeMap<String, i64>,
    /// Events that wait for delivery.
    pub waiting: i64,
    /// When the oldest of them was created, ms since 1970.
    pub oldest: Option<i64>,
    /// Duration of the query.
    pub took: Duration,
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

    /// The service accepts no new work: it is not ready any more.
    pub fn stop(&self) {
        self.stopping.store(true, Ordering::Relaxed);
    }

    /// True once the service accepts no new work.
    pub(crate) fn is_stopping(&self) -> bool {
        self.stopping.load(Ordering::Relaxed)
    }

    /// The result of the last query of the store, if it is recent enough; within, `None` where it did not answer.
    pub(crate) fn recent_figures(&self) -> Option<Option<StoreFigures>> {
        let kept = lock(&self.store);
        kept.as_ref().filter(|(at, _)| at.elapsed() < STORE_AGE).map(|(_, held)| held.clone())
    }

    /// Keeps the result of a query of the store.
    pub(crate) fn keep_figures(&self, held: Option<StoreFigures>) {
        *lock(&self.store) = Some((Instant::now(), held));
    }

    /// Requests.
    pub(crate) fn http(&self, out: &mut Text) {
        out.head("whyroad_http_requests_in_progress", "gauge", "Requests in progress");
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

    /// Metrics of the process under the names that Prometheus' own clients use; without `/proc` only its start.
    pub(crate) fn process(&self, out: &mut Text) {
        let since = self.started.duration_since(UNIX_EPOCH).unwrap_or_default();
        out.head("process_start_time_seconds", "gauge", "Start time of the process, seconds since 1970");
        out.line("process_start_time_seconds", &[], since.as_secs_f64());
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let resident = status.lines().find_map(|l| l.strip_prefix("VmRSS:")?.trim().strip_suffix(" kB"));
        if let Some(kib) = resident.and_then(|n| n.trim().parse::<f64>().ok()) {
            out.head("process_resident_memory_bytes", "gauge", "Memory in use");
            out.line("process_resident_memory_bytes", &[], kib * 1024.0);
        }
        // Fields 14 and 15 in hundredths of a second (USER_HZ); the name in parentheses before them may contain spaces.
        let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
        let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
        if let [Some(user), Some(system)] =
            [11, 12].map(|i| fields.get(i).and_then(|n| n.parse::<f64>().ok()))
        {
            out.head("process_cpu_seconds_total", "counter", "CPU time");
            out.line("process_cpu_seconds_total", &[], (user + system) / 100.0);
        }
        if let Ok(open) = std::fs::read_dir("/proc/self/fd") {
            out.head("process_open_fds", "gauge", "Open files and connections");
            out.line("process_open_fds", &[], open.count() as f64);
        }
    }
}

/// The text format.
#[derive(Default)]
pub(crate) struct Text(pub String);

impl Text {
    /// Announces a metric.
    pub(crate) fn head(&mut self, name: &str, kind: &str, about: &str) {
        let _ = write!(self.0, "# HELP {name} {about}\n# TYPE {name} {kind}\n");
    }

    /// A value. Label values are routes, states and versions: only an invalid state in the store could need escaping.
    pub(crate) fn line(&mut self, name: &str, labels: &[(&str, &str)], value: f64) {
        let escaped = |v: &str| v.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
        let labels: Vec<String> = labels.iter().map(|(k, v)| format!("{k}=\"{}\"", escaped(v))).collect();
        let labels = if labels.is_empty() { String::new() } else { format!("{{{}}}", labels.join(",")) };
        let _ = writeln!(self.0, "{name}{labels} {value}");
    }
}
