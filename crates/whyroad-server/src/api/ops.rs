//! The port for operators: `/metrics`, `/livez` and `/readyz`, without sign-in, on a separate address that must not be
//! public. It serves neither the API nor the page.

use crate::app::App;
use crate::service::figures;
use axum::Router;
use axum::body::Body;
use axum::http::{Method, Response, StatusCode, header};
use std::sync::Arc;

/// Serves until the runtime ends.
///
/// # Errors
/// Where the listener fails.
pub async fn serve_ops(app: Arc<App>, listener: tokio::net::TcpListener) -> std::io::Result<()> {
    axum::serve(listener, router(app)).await
}

fn router(app: Arc<App>) -> Router {
    Router::new().fallback(move |request: axum::extract::Request| {
        let app = Arc::clone(&app);
        async move { answer(app, request.method(), request.uri().path()).await }
    })
}

async fn answer(app: Arc<App>, method: &Method, path: &str) -> Response<Body> {
    if method != Method::GET && method != Method::HEAD {
        let mut response = plain(StatusCode::METHOD_NOT_ALLOWED, "only GET\n".to_owned());
        response.headers_mut().insert(header::ALLOW, header::HeaderValue::from_static("GET, HEAD"));
        return response;
    }
    match path {
        // The process answers; a restart could not improve anything else.
        "/livez" => plain(StatusCode::OK, "ok\n".to_owned()),
        "/readyz" => match tokio::task::spawn_blocking(move || figures::ready(&app)).await {
            Ok(Ok(())) => plain(StatusCode::OK, "ok\n".to_owned()),
            Ok(Err(why)) => plain(StatusCode::SERVICE_UNAVAILABLE, format!("{why}\n")),
            Err(_) => plain(StatusCode::INTERNAL_SERVER_ERROR, "internal error\n".to_owned()),
        },
        "/metrics" => match tokio::task::spawn_blocking(move || figures::text(&app)).await {
            Ok(text) => plain(StatusCode::OK, text),
            Err(_) => plain(StatusCode::INTERNAL_SERVER_ERROR, "internal error\n".to_owned()),
        },
        _ => plain(StatusCode::NOT_FOUND, "/metrics, /livez, /readyz\n".to_owned()),
    }
}

fn plain(status: StatusCode, text: String) -> Response<Body> {
    let mut response = Response::new(Body::from(text));
    *response.status_mut() = status;
    let kind = header::HeaderValue::from_static("text/plain; version=0.0.4; charset=utf-8");
    response.headers_mut().insert(header::CONTENT_TYPE, kind);
    response
}
