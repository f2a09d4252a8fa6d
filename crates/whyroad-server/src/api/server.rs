//! The server: converts bytes to a call of a handler and back. Handlers block, so each runs on a thread for blocking
//! work.

use super::access;
use super::call::{Call, Request};
use super::deliver::{Accepted, ReplyKind, deliver, deliver_stream, problem};
use super::incoming::{forwarded, request_of};
use super::openapi;
use super::pages;
use super::reply::Reply;
use super::route::{BodySize, Route, Verb};
use super::router::{find, wrong_method};
use super::table::ROUTES;
use super::timed::{Peer, TimedListener};
use crate::app::App;
use crate::metrics::Served;
use crate::problem::{Answer, Problem};
use crate::service::{drafting, modeling, retention, webhooks};
use axum::Router;
use axum::body::{Body, to_bytes};
use axum::extract::ConnectInfo;
use axum::http::{Method, Response};
use std::future::Future;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::Semaphore;
use whyroad_model::Nanos;

/// All API routes are below this path.
const ROOT: &str = "/api/v1";
/// Maximum time for receiving a body.
const BODY_TIME: Duration = Duration::from_secs(120);
/// Maximum length of the query of a request, bytes.
const QUERY: usize = 4096;
/// Maximum number of requests in work; others wait.
const AT_ONCE: usize = 256;
/// Maximum time for requests in progress when the service stops.
const SHUTDOWN_GRACE: Duration = Duration::from_secs(15);

/// Serves until `shutdown` completes, then finishes the requests in progress.
pub async fn serve(
    app: Arc<App>,
    listener: tokio::net::TcpListener,
    shutdown: impl Future<Output = ()> + Send + 'static,
) -> std::io::Result<()> {
    let deliveries = webhooks::spawn(Arc::clone(&app));
    let drafts = drafting::spawn(&app);
    let questions = modeling::spawn(&app);
    let sweeps = retention::spawn(&app);
    let figures = Arc::clone(&app);
    let service = router(app).into_make_service_with_connect_info::<Peer>();
    let (stopping, stopped) = tokio::sync::oneshot::channel::<()>();
    let signal = async move {
        shutdown.await;
        figures.metrics.stop();
        let _ = stopping.send(());
    };
    let server = axum::serve(TimedListener::new(listener), service).with_graceful_shutdown(signal);
    // An idle open connection must not keep the service from stopping.
    let late = async move {
        if stopped.await.is_ok() {
            tokio::time::sleep(SHUTDOWN_GRACE).await;
        } else {
            std::future::pending::<()>().await;
        }
    };
    let result = tokio::select! {
        result = async { server.await } => result,
        () = late => Ok(()),
    };
    drop((deliveries, drafts, questions, sweeps));
    result
}

/// The service as a router, for [`serve`] and for tests without a socket.
pub fn router(app: Arc<App>) -> Router {
    let turns = Arc::new(Semaphore::new(AT_ONCE));
    Router::new().fallback(move |request: axum::extract::Request| {
        let (app, turns) = (Arc::clone(&app), Arc::clone(&turns));
        async move { counted(app, turns, request).await }
    })
}

/// Answers a request and counts it under its route.
async fn counted(app: Arc<App>, turns: Arc<Semaphore>, request: axum::extract::Request) -> Response<Body> {
    let begun = Instant::now();
    let (method, route) = label(request.method(), request.uri().path());
    let _in_progress = app.metrics.begin();
    let response = answer(Arc::clone(&app), turns, request).await;
    let served = Served { method, route, status: response.status().as_u16(), took: begun.elapsed() };
    app.metrics.count(&served);
    if let Some(log) = &app.access_log {
        log(&served);
    }
    response
}

/// Method and route as metrics name them: from the table, so their number does not depend on what clients send.
fn label(method: &Method, path: &str) -> (&'static str, &'static str) {
    let word = ["GET", "HEAD", "POST", "PATCH", "DELETE"].into_iter().find(|w| *w == method.as_str());
    let route = match path.strip_prefix(ROOT) {
        Some(below) if below.is_empty() || below.starts_with('/') => {
            find(method, below).map_or("none", |(route, _)| route.path)
        }
        _ if path == "/api" || path.starts_with("/api/") => "none",
        _ => "page",
    };
    (word.unwrap_or("other"), route)
}

async fn answer(app: Arc<App>, turns: Arc<Semaphore>, request: axum::extract::Request) -> Response<Body> {
    let (parts, body) = request.into_parts();
    let peer = parts.extensions.get::<ConnectInfo<Peer>>().map(|c| c.0.clone());
    let _open = peer.as_ref().map(Peer::asks);
    let head = parts.method == Method::HEAD;
    let accepted = Accepted::of(&parts.headers, head);
    let path = parts.uri.path();
    let Some(path) = path.strip_prefix(ROOT).filter(|p| p.is_empty() || p.starts_with('/')) else {
        return outside(&app, &parts.method, path, &accepted);
    };
    let refuse = |p: &Problem| deliver(problem(p), ReplyKind::Done, &accepted);
    if parts.uri.query().is_some_and(|q| q.len() > QUERY) {
        return refuse(&Problem::new(414, "request.too_long", "查询参数过长", "the query is too long"));
    }
    let (route, params) = match find(&parts.method, path) {
        Ok(found) => found,
        Err(p) => return refuse(&p),
    };
    let address = peer.as_ref().map(|p| p.address.ip().to_string()).unwrap_or_default();
    let address = forwarded(&parts.headers, app.origin).unwrap_or(address);
    let mut request = request_of(&parts.headers, &parts.uri, params, address);
    // A large body is only read from callers who may send it.
    if route.body_size == BodySize::Bulk {
        let (app, asked) = (Arc::clone(&app), request.clone());
        let passed = tokio::task::spawn_blocking(move || access::pass(&app, route, &asked)).await;
        if let Ok(Err(p)) = passed {
            return refuse(&p);
        }
    }
    match read(route, body).await {
        Ok(bytes) => request.body = bytes,
        Err(p) => return refuse(&p),
    }
    let _working = peer.as_ref().map(Peer::works);
    // The semaphore is never closed.
    let turn = if route.is_probe { None } else { turns.acquire_owned().await.ok() };
    let (log, clock) = (Arc::clone(&app.log), Arc::clone(&app.clock));
    let work = tokio::task::spawn_blocking(move || {
        let _turn = turn;
        run(&app, route, &request)
    });
    let p = match work.await {
        Ok(Ok(mut reply)) => {
            if let Some(stream) = reply.stream.take() {
                let route = route.path;
                return deliver_stream(&reply, &stream, &accepted, move |p| {
                    log(&format!("{} {} GET {route}: {p}", Nanos(clock() * 1_000_000), p.status));
                });
            }
            return deliver(
                reply,
                if route.verb == Verb::Get { ReplyKind::Read } else { ReplyKind::Done },
                &accepted,
            );
        }
        Ok(Err(p)) => p,
        Err(_) => Problem::new(500, "internal", "内部错误", "internal error"),
    };
    if p.status >= 500 {
        // The route as in the table: ids and bodies do not belong in a log.
        log(&format!("{} {} {} {}: {p}", Nanos(clock() * 1_000_000), p.status, parts.method, route.path));
    }
    refuse(&p.without_internals())
}

/// Paths outside the API: the page.
fn outside(app: &App, method: &Method, path: &str, accepted: &Accepted) -> Response<Body> {
    if path == "/api" || path.starts_with("/api/") {
        return deliver(problem(&Problem::missing()), ReplyKind::Done, accepted);
    }
    if method != Method::GET && method != Method::HEAD {
        return deliver(problem(&wrong_method([Verb::Get])), ReplyKind::Done, accepted);
    }
    let (mut reply, keep) = pages::page(path);
    reply.image_origins.clone_from(&app.image_links.origins);
    deliver(reply, ReplyKind::Page(keep), accepted)
}

fn run(app: &Arc<App>, route: &Route, request: &Request) -> Answer<Reply> {
    let (caller, grant) = access::pass(app, route, request)?;
    (route.run)(&Call { app, request, caller, grant, document: || openapi::text(ROUTES) })
}

async fn read(route: &Route, body: Body) -> Answer<Vec<u8>> {
    let limit = route.body_size.bytes();
    match tokio::time::timeout(BODY_TIME, to_bytes(body, limit)).await {
        Ok(Ok(bytes)) => Ok(bytes.to_vec()),
        Ok(Err(_)) => Err(Problem::new(
            413,
            "request.too_large",
            format!("请求不完整或超过 {limit} 字节"),
            format!("the request is incomplete or larger than {limit} bytes"),
        )),
        Err(_) => Err(Problem::new(408, "request.slow", "请求太慢", "the request arrived too slowly")),
    }
}
