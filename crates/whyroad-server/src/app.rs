//! The service as one value: what handlers and commands work with.

use crate::blur::Blur;
use crate::domain::project::Dashboard;
use crate::language_model::LanguageModel;
use crate::limits::Limits;
use crate::metrics::{Metrics, Served};
use crate::oidc::provider::Provider;
use crate::problem::Answer;
use crate::recordings::{CheckedDrives, Recordings};
use crate::reports::Reports;
use crate::service::disagreement;
use crate::service::facts::cache::FactsCache;
use crate::service::model_runs::waiting::WaitingCounts;
use crate::service::scene::cache::SceneCache;
use crate::service::shared::SharedReadings;
use crate::service::veil;
use crate::service::webhooks::reach::Reach;
use crate::service::webhooks::tls::Trust;
use crate::store::{Store, Tx, vault};
use crate::{secret, values};
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use whyroad_framework::Framework;
use whyroad_label::check::Checker;

/// Milliseconds since 1970, as the service takes them; tests turn it.
pub type Clock = Arc<dyn Fn() -> i64 + Send + Sync>;

/// Takes one line for the operator.
pub type Log = Arc<dyn Fn(&str) + Send + Sync>;

/// Takes each request that was answered.
pub type AccessLog = Arc<dyn Fn(&Served<'_>) + Send + Sync>;

/// The service.
pub struct App {
    /// Where everything is kept.
    pub store: Store,
    /// Classes, decisions, specs.
    pub framework: &'static Framework,
    /// The label checker, without any recording: for everything that somebody in Stage I may see.
    pub checker: Checker<'static>,
    /// The label checker with the recordings: only for labels whose Stage I is locked.
    pub stage2_checker: Checker<'static>,
    /// Drives.
    pub recordings: Arc<dyn Recordings>,
    /// Makes reports; none where nobody handed them in.
    pub reports: Option<Arc<dyn Reports>>,
    /// Makes drafts and judges labels; none where the service was started without a model.
    pub model: Option<Arc<dyn LanguageModel>>,
    /// The time.
    pub clock: Clock,
    /// By whose clock leases expire.
    pub lease_clock: LeaseClock,
    /// Failed sign-ins.
    pub limits: Limits,
    /// Facts about tasks that reports were made from last.
    pub facts: FactsCache,
    /// Dashboards that are read now.
    pub dashboards: SharedReadings<Dashboard>,
    /// Scenes that were asked for last.
    pub scenes: SceneCache,
    /// Tasks that wait for the language model, as counted last.
    pub waiting_for_model: WaitingCounts,
    /// Key of the CSRF values.
    pub csrf_key: String,
    /// Whether cookies are for HTTPS only.
    pub cookies: Cookies,
    /// Where webhooks may go.
    pub reach: Reach,
    /// What makes faces and plates in images unreadable; images are shown as they are without it.
    pub blur: Option<Arc<Blur>>,
    /// How images in object stores are linked.
    pub image_links: ImageLinks,
    /// Whose certificates webhooks believe.
    pub trust: Trust,
    /// Which source of the client address is trusted.
    pub origin: Origin,
    /// Where failures are reported to the operator; by default nowhere.
    pub log: Log,
    /// Where each request is reported; by default nowhere.
    pub access_log: Option<AccessLog>,
    /// Figures for operators.
    pub metrics: Metrics,
    /// What the maker of the first account has to show; none where only this machine reaches the service.
    pub setup_token: Option<String>,
    /// Where people can sign in beside here.
    pub oidc: Option<Provider>,
}

/// By whose clock leases expire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeaseClock {
    /// The database's, where it is another machine's; else the service's.
    Store,
    /// The service's own: for tests, which turn it.
    Service,
}

/// How images in object stores are linked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImageLinks {
    /// How long a link works.
    pub lifetime: Duration,
    /// Scheme, host and port of the stores: the page may load images from there.
    pub origins: Vec<String>,
}

impl Default for ImageLinks {
    fn default() -> Self {
        Self { lifetime: Duration::from_secs(60), origins: vec![] }
    }
}

/// Whether cookies are for HTTPS only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cookies {
    /// Plain HTTP: a service on this machine only, or behind a proxy that does not use TLS.
    Plain,
    /// `Secure`.
    Secure,
}

/// Which source of the client address is trusted; failed sign-ins are counted by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The connection itself.
    Connection,
    /// A proxy in front: the last address in its `x-forwarded-for`, which it wrote itself.
    Proxy,
}

impl App {
    /// The service on `store`.
    pub fn new(store: Store, framework: &'static Framework, recordings: Arc<dyn Recordings>) -> Answer<Self> {
        let vault = Arc::clone(&store.vault);
        let fresh = vault.seal(vault::CSRF, &secret::random(32)?)?;
        let csrf_key = store.write(move |tx| {
            tx.run(
                "INSERT INTO settings (name, value) VALUES ('csrf_key', $1) ON CONFLICT (name) DO NOTHING",
                values![&fresh],
            )?;
            let row = tx.row("SELECT value FROM settings WHERE name = 'csrf_key'", &[])?;
            row.map_or(Ok(String::new()), |r| r.text("value"))
        })?;
        store.write(move |tx| veil::set_all(tx, framework))?;
        disagreement::note_all(&store)?;
        let csrf_key = vault.open_text(vault::CSRF, &csrf_key)?;
        let limits = Limits::of(&store);
        Ok(Self {
            store,
            framework,
            checker: Checker::new(framework),
            stage2_checker: Checker::new(framework)
                .with_recordings(Arc::new(CheckedDrives(Arc::clone(&recordings)))),
            recordings,
            reports: None,
            model: None,
            clock: Arc::new(wall_clock),
            lease_clock: LeaseClock::Store,
            limits,
            facts: FactsCache::default(),
            dashboards: SharedReadings::default(),
            scenes: SceneCache::default(),
            waiting_for_model: WaitingCounts::default(),
            csrf_key,
            cookies: Cookies::Plain,
            reach: Reach::default(),
            blur: None,
            image_links: ImageLinks::default(),
            trust: Trust::default(),
            origin: Origin::Connection,
            log: Arc::new(|_| {}),
            access_log: None,
            metrics: Metrics::default(),
            setup_token: None,
            oidc: None,
        })
    }

    /// Now as leases have it, ms since 1970: services on several machines go by one clock, that of their store.
    pub fn lease_now(&self, tx: &mut dyn Tx) -> Answer<i64> {
        match self.lease_clock {
            LeaseClock::Service => Ok(self.now()),
            LeaseClock::Store => Ok(tx.clock()?.unwrap_or_else(|| self.now())),
        }
    }

    /// Now, ms since 1970.
    pub fn now(&self) -> i64 {
        (self.clock)()
    }
}

fn wall_clock() -> i64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_millis() as i64)
}
