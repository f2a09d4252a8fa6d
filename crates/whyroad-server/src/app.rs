//! The state of the service, shared by handlers and commands.

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
use crate::service::probes::Probes;
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

/// The service's clock, milliseconds since 1970; tests set it.
pub type Clock = Arc<dyn Fn() -> i64 + Send + Sync>;

/// Receives one line for the operator.
pub type Log = Arc<dyn Fn(&str) + Send + Sync>;

/// Receives each answered request.
pub type AccessLog = Arc<dyn Fn(&Served<'_>) + Send + Sync>;

/// The service.
pub struct App {
    /// The store.
    pub store: Store,
    /// Classes, decisions, specs.
    pub framework: &'static Framework,
    /// The label checker without recordings: for everything that may be shown in Stage I.
    pub checker: Checker<'static>,
    /// The label checker that compares components with drives cut at the label's keyframe. In Stage I only for labels
    /// with the keyframe of their task: see [`crate::service::findings`].
    pub stage1_checker: Checker<'static>,
    /// The label checker with recordings: only for labels whose Stage I is locked.
    pub stage2_checker: Checker<'static>,
    /// Drives.
    pub recordings: Arc<dyn Recordings>,
    /// Generates reports; `None` where the caller provided none.
    pub reports: Option<Arc<dyn Reports>>,
    /// Drafts and judges labels; `None` where the service was started without a model.
    pub model: Option<Arc<dyn LanguageModel>>,
    /// The clock.
    pub clock: Clock,
    /// The clock that determines when leases expire.
    pub lease_clock: LeaseClock,
    /// Failed sign-ins.
    pub limits: Limits,
    /// Cached facts about tasks, from which reports were generated last.
    pub facts: FactsCache,
    /// Dashboards that are being read now.
    pub dashboards: SharedReadings<Dashboard>,
    /// Recently requested scenes.
    pub scenes: SceneCache,
    /// Tasks that wait for the language model, as last counted.
    pub waiting_for_model: WaitingCounts,
    /// Key of the CSRF values.
    pub csrf_key: String,
    /// Whether cookies are for HTTPS only.
    pub cookies: Cookies,
    /// Addresses to which webhooks may connect.
    pub reach: Reach,
    /// Blurs faces and plates in images; without it images are shown as they are.
    pub blur: Option<Arc<Blur>>,
    /// How images in object stores are linked.
    pub image_links: ImageLinks,
    /// Certificates that webhooks trust.
    pub trust: Trust,
    /// Which source of the client address is trusted.
    pub origin: Origin,
    /// Where failures are reported to the operator; default: nowhere.
    pub log: Log,
    /// Where each request is reported; default: nowhere.
    pub access_log: Option<AccessLog>,
    /// Metrics for operators.
    pub metrics: Metrics,
    /// What probes ask.
    pub probes: Probes,
    /// Token that is required for creating the first account; `None` where only this machine can reach the service.
    pub setup_token: Option<String>,
    /// Identity provider at which people can also sign in.
    pub oidc: Option<Provider>,
}

/// The clock that determines when leases expire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeaseClock {
    /// The database's, if it may run on another machine; else the service's.
    Store,
    /// The service's own: for tests, which set it.
    Service,
}

/// How images in object stores are linked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImageLinks {
    /// Lifetime of a link.
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
        let drives = || Arc::new(CheckedDrives(Arc::clone(&recordings)));
        let (mut stage1_checker, mut stage2_checker) = (
            Checker::new(framework).with_histories(drives()),
            Checker::new(framework).with_recordings(drives()),
        );
        if recordings.compares() {
            stage1_checker = stage1_checker.reporting_missing_drives();
            stage2_checker = stage2_checker.reporting_missing_drives();
        }
        Ok(Self {
            store,
            framework,
            checker: Checker::new(framework),
            stage1_checker,
            stage2_checker,
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
            probes: Probes::default(),
            setup_token: None,
            oidc: None,
        })
    }

    /// Current time for leases, ms since 1970: services on several machines share the clock of their store.
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
