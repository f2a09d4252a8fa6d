//! The program's HTTP client, adapted to `object_store`: blocking calls on threads of their own, TLS by
//! rustls with the system's certificates. No redirect is followed: requests are signed for one address.

use http_body_util::BodyExt as _;
use object_store::ClientOptions;
use object_store::client::{
    ClientConfigKey, HttpClient, HttpConnector, HttpError, HttpErrorKind, HttpRequest, HttpResponse,
    HttpService,
};
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;
use ureq::Agent;
use ureq::http::{Method, Request, Response};
use ureq::tls::{Certificate, RootCerts, TlsConfig};

const CONNECT: Duration = Duration::from_secs(5);
/// For one call as a whole: some 16 MB.
const CALL: Duration = Duration::from_secs(120);
/// Until a store begins to answer.
const ANSWER: Duration = Duration::from_secs(60);

/// Makes clients.
#[derive(Debug, Default)]
pub(super) struct UreqConnector {}

impl HttpConnector for UreqConnector {
    fn connect(&self, options: &ClientOptions) -> object_store::Result<HttpClient> {
        // A machine outside a cloud has no metadata service: the request fails quickly.
        let stated = options.get_config_value(&ClientConfigKey::ConnectTimeout);
        let seconds = stated.and_then(|text| text.strip_suffix('s')?.trim().parse::<u64>().ok());
        let connect = seconds.map_or(CONNECT, |s| Duration::from_secs(s).min(CONNECT));
        Ok(HttpClient::new(UreqService { agent: agent(connect) }))
    }
}

fn agent(connect: Duration) -> Agent {
    let native = rustls_native_certs::load_native_certs().certs;
    let roots: Vec<Certificate<'static>> =
        native.iter().map(|c| Certificate::from_der(c.as_ref()).to_owned()).collect();
    let tls = TlsConfig::builder()
        .root_certs(RootCerts::Specific(Arc::new(roots)))
        .unversioned_rustls_crypto_provider(Arc::new(rustls::crypto::ring::default_provider()))
        .build();
    Agent::config_builder()
        .tls_config(tls)
        .timeout_connect(Some(connect))
        .timeout_recv_response(Some(ANSWER))
        .timeout_global(Some(CALL))
        .max_redirects(0)
        .max_redirects_will_error(false)
        .http_status_as_error(false)
        .max_idle_connections_per_host(super::super::PARALLEL_CALLS)
        .user_agent("whyroad")
        .build()
        .new_agent()
}

#[derive(Debug)]
struct UreqService {
    agent: Agent,
}

type Answer<'a> = Pin<Box<dyn Future<Output = Result<HttpResponse, HttpError>> + Send + 'a>>;

impl HttpService for UreqService {
    fn call<'life, 'call>(&'life self, request: HttpRequest) -> Answer<'call>
    where
        'life: 'call,
        Self: 'call,
    {
        let agent = self.agent.clone();
        Box::pin(async move {
            let (parts, body) = request.into_parts();
            let body = body.collect().await?.to_bytes();
            let run = move || send(&agent, Request::from_parts(parts, body.to_vec()));
            tokio::task::spawn_blocking(run).await.map_err(|e| HttpError::new(HttpErrorKind::Unknown, e))?
        })
    }
}

fn send(agent: &Agent, request: Request<Vec<u8>>) -> Result<HttpResponse, HttpError> {
    let (parts, body) = request.into_parts();
    let has_body = !body.is_empty() || matches!(parts.method, Method::PUT | Method::POST);
    let answered = if has_body {
        agent.run(Request::from_parts(parts, body))
    } else {
        agent.run(Request::from_parts(parts, ()))
    };
    let (parts, mut body) = answered.map_err(failed)?.into_parts();
    // A connection that is cut in the middle of an answer is an error here, not a short file.
    let content = body.with_config().limit(u64::MAX).read_to_vec().map_err(failed)?;
    Ok(Response::from_parts(parts, content.into()))
}

/// What may be retried: every request without an answer; the store decides by the request.
fn failed(e: ureq::Error) -> HttpError {
    let kind = match &e {
        ureq::Error::Timeout(_) => HttpErrorKind::Timeout,
        ureq::Error::HostNotFound | ureq::Error::ConnectionFailed => HttpErrorKind::Connect,
        ureq::Error::Io(io) if io.kind() == std::io::ErrorKind::ConnectionRefused => HttpErrorKind::Connect,
        ureq::Error::Io(io) if io.kind() == std::io::ErrorKind::TimedOut => HttpErrorKind::Timeout,
        ureq::Error::Io(_) | ureq::Error::Protocol(_) => HttpErrorKind::Interrupted,
        _ => HttpErrorKind::Unknown,
    };
    HttpError::new(kind, e)
}
