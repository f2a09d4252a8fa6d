//! `whyroad serve`: the labeling service on a lake, with its page. Without any argument it runs on the bundled drives,
//! so that new users see clips at once.

mod first_run;
mod oidc;

use crate::analytics::ServiceReports;
use crate::language_model::ServiceModelArgs;
use crate::output::reason::{cannot_listen, cannot_write, reason};
use crate::output::render_text;
use crate::recordings::ServiceRecordings;
use crate::{Global, output, store_args};
use anyhow::Context as _;
use first_run::FirstAccount;
use std::net::{IpAddr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;
use whyroad_lake::Lake;
use whyroad_model::Lang;
use whyroad_server::App;
use whyroad_server::app::{ImageLinks, Origin};
use whyroad_server::blur::Blur;
use whyroad_server::recordings::Recordings;
use whyroad_server::service::webhooks::Reach;

/// Arguments of `whyroad serve`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Lake whose drives are labeled [default: the bundled drives]
    #[arg(long, value_name = "DIR")]
    lake: Option<PathBuf>,
    /// Folder that `whyroad mine` wrote, or a folder of such folders: tasks can be made from these; may be repeated
    #[arg(long, value_name = "DIR", requires = "lake")]
    mined: Vec<PathBuf>,
    /// Folder or s3:// URL with the camera images that the lake names (the recorded logs); may be repeated
    #[arg(long, value_name = "DIR", requires = "lake")]
    media: Vec<PathBuf>,
    /// Seconds for which a link to an image in an object store works
    #[arg(long, value_name = "S", default_value_t = 60, value_parser = clap::value_parser!(u64).range(1..=3600))]
    media_link_seconds: u64,
    /// Address to listen on. Beyond this machine, put a proxy with TLS in front
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
    /// Second address, for operators: /metrics (Prometheus), /livez and /readyz, without sign-in; keep it from the
    /// public
    #[arg(long, value_name = "ADDR", env = "WHYROAD_OPS_LISTEN")]
    ops_listen: Option<SocketAddr>,
    /// The page is served over https by a proxy in front: cookies are for https only
    #[arg(long)]
    https: bool,
    /// Take client addresses from the last entry of x-forwarded-for; failed sign-ins are counted by address. Only
    /// behind a proxy; otherwise clients can forge it
    #[arg(long)]
    behind_proxy: bool,
    /// Allow webhooks only to this host; may be repeated [default: any host except link-local addresses and, when the
    /// service is reachable from other machines, this machine]
    #[arg(long, value_name = "HOST[:PORT]")]
    webhook_to: Vec<String>,
    /// Program that makes faces and plates in an image unreadable, called as PROGRAM INPUT OUTPUT once per image; an
    /// image for which it fails is not shown
    #[arg(long, value_name = "PROGRAM", env = "WHYROAD_BLUR")]
    blur: Option<PathBuf>,
    #[command(flatten)]
    store: store_args::StoreArgs,
    #[command(flatten)]
    model: ServiceModelArgs,
    #[command(flatten)]
    oidc: oidc::OidcArgs,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    whyroad_server::memory::limit_arenas();
    let framework = store_args::framework(global)?;
    // Before any work: an address in use is the most common reason for a failed start.
    let listener = TcpListener::bind(args.listen).with_context(|| cannot_listen(args.listen))?;
    let at = listener.local_addr()?;
    let bind_ops = |at: SocketAddr| TcpListener::bind(at).with_context(|| cannot_listen(at));
    let ops = args.ops_listen.map(bind_ops).transpose()?;
    // A mistake here is reported before the drives are read.
    let own = Some(at).filter(|at| at.ip().is_loopback() && !args.https);
    let oidc = args.oidc.provider(own, global.lang)?;
    let (lake, mined) = match &args.lake {
        Some(dir) => match Lake::open(dir) {
            Ok(lake) => (lake, args.mined.clone()),
            Err(e) => {
                tell!("{}", render_text(&e.diagnostic(), global.lang));
                return Ok(output::FINDINGS);
            }
        },
        None => first_run::bundled(global, framework, &args.store.data)?,
    };
    let drives = lake.drive_ids().len();
    let reports = ServiceReports::new(lake.clone(), framework, mined.clone());
    let recordings = Arc::new(ServiceRecordings::open(lake, framework, &mined, &args.media)?);
    let store = args.store.open(global.lang)?;
    let image_links = ImageLinks {
        lifetime: Duration::from_secs(args.media_link_seconds),
        origins: recordings.image_origins()?,
    };
    let cache = args.store.data.join("blurred");
    let blur = args.blur.map(|program| Blur::new(program, cache.clone()).map(Arc::new)).transpose();
    let blur = blur.with_context(|| cannot_write(cache.display()))?;
    let recordings: Arc<dyn Recordings> = recordings;
    let model = args.model.model(framework, &recordings, (&args.store.data, blur.clone()), global.lang)?;
    let mut app = App::new(store, framework, recordings).map_err(|p| store_args::error(&p, global.lang))?;
    app.model = model;
    app.oidc = oidc;
    app.image_links = image_links;
    app.blur = blur;
    app.reports = Some(Arc::new(reports));
    if args.https {
        app.cookies = whyroad_server::app::Cookies::Secure;
    }
    if args.behind_proxy {
        app.origin = Origin::Proxy;
    }
    app.reach = match args.webhook_to {
        hosts if !hosts.is_empty() => Reach::Only(hosts),
        _ if at.ip().is_loopback() && !args.https && !args.behind_proxy => Reach::OwnMachine,
        // A proxy on this machine admits other machines, although the service listens only to this machine.
        _ => Reach::Network,
    };
    app.log = Arc::new(output::log::warning);
    if output::log::is_json() {
        app.access_log = Some(Arc::new(output::log::request));
    }
    if args.lake.is_none() {
        first_run::offer_project(&app, global.lang)?;
    } else {
        first_run::say_how_to_begin(&app, &args.mined, global.lang)?;
    }
    let account = first_run::first_account(&mut app, at.ip(), global.lang)?;
    say!("{}", where_to_look(at, &account, drives, global.lang));
    if let Some(at) = ops.as_ref().and_then(|ops| ops.local_addr().ok()) {
        say!("{}", ops_address(at, global.lang));
    }
    run_until_stopped(app, listener, ops).context(reason("服务已停止", "the service stopped"))?;
    Ok(output::FINE)
}

/// How long work that is still running may take after the last answer, when the service stops.
const LAST_WAIT: Duration = Duration::from_secs(2);

/// Serves until Ctrl-C or a request to terminate; then finishes running work.
fn run_until_stopped(app: App, listener: TcpListener, ops: Option<TcpListener>) -> std::io::Result<()> {
    listener.set_nonblocking(true)?;
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    let app = Arc::new(app);
    let result = runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        if let Some(ops) = ops {
            ops.set_nonblocking(true)?;
            let ops = tokio::net::TcpListener::from_std(ops)?;
            // It ends with the runtime, after the last request: until then it reports that the service is stopping.
            tokio::spawn(whyroad_server::serve_ops(Arc::clone(&app), ops));
        }
        whyroad_server::serve(Arc::clone(&app), listener, stop_signal()).await
    });
    // Work that does not end, a derivation from a broken drive, must not keep the process: what was acknowledged is
    // stored.
    runtime.shutdown_timeout(LAST_WAIT);
    result
}

fn ops_address(at: SocketAddr, lang: Lang) -> String {
    match lang {
        Lang::Zh => format!("运维端口：http://{at}/metrics"),
        Lang::En => format!("for operators: http://{at}/metrics"),
    }
}

async fn stop_signal() {
    let interrupt = tokio::signal::ctrl_c();
    #[cfg(unix)]
    let terminate = async {
        match tokio::signal::unix::signal(tokio::signal::unix::SignalKind::terminate()) {
            Ok(mut signal) => signal.recv().await,
            // Without a handler the system's default applies.
            Err(_) => std::future::pending().await,
        }
    };
    #[cfg(not(unix))]
    let terminate = std::future::pending::<()>();
    tokio::select! {
        _ = interrupt => {}
        _ = terminate => {}
    }
}

/// The address of the page; with how to create the first account as long as no account exists.
fn where_to_look(at: SocketAddr, account: &FirstAccount, drives: usize, lang: Lang) -> String {
    // The unspecified address cannot be opened.
    let host = match at.ip() {
        ip if !ip.is_unspecified() => at.to_string(),
        IpAddr::V4(_) => format!("127.0.0.1:{}", at.port()),
        IpAddr::V6(_) => format!("[::1]:{}", at.port()),
    };
    let query = match account {
        FirstAccount::ByToken(token) => format!("?setup={token}"),
        FirstAccount::Made | FirstAccount::Open => String::new(),
    };
    let first = match (lang, account) {
        (_, FirstAccount::Made) => "",
        (Lang::Zh, _) => "首次运行：打开该页面创建管理员\n",
        (Lang::En, _) => "first run: open this page to create the administrator\n",
    };
    match lang {
        Lang::Zh => format!("标注服务：http://{host}/{query}\n{first}{drives} 个行程；Ctrl-C 停止"),
        Lang::En => {
            let s = if drives == 1 { "" } else { "s" };
            format!("labeling service: http://{host}/{query}\n{first}{drives} drive{s}; stop with Ctrl-C")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_address_can_be_opened() {
        let printed = |at: &str, account| where_to_look(at.parse().unwrap(), &account, 3, Lang::En);
        assert!(printed("0.0.0.0:8080", FirstAccount::Made).contains("http://127.0.0.1:8080/\n"));
        assert!(printed("[::]:1", FirstAccount::Made).contains("http://[::1]:1/\n"));
        let by_token = FirstAccount::ByToken("abc".into());
        assert!(printed("10.1.2.3:80", by_token).contains("http://10.1.2.3:80/?setup=abc\nfirst run"));
        assert!(printed("127.0.0.1:80", FirstAccount::Open).contains("first run"));
        assert!(printed("127.0.0.1:80", FirstAccount::Made).ends_with("\n3 drives; stop with Ctrl-C"));
        let one = where_to_look("127.0.0.1:80".parse().unwrap(), &FirstAccount::Made, 1, Lang::En);
        assert!(one.ends_with("\n1 drive; stop with Ctrl-C"), "{one}");
        assert!(!printed("127.0.0.1:80", FirstAccount::Made).contains("first run"));
    }
}
