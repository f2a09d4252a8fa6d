//! Runs of a language model in the background: one run at a time, several questions at once. A draft replaces the
//! rule's draft of a task that nobody has started; if somebody starts it while the model is asked, their draft is kept.
//! After a restart the service continues with the remaining tasks; received answers are in the model's cache.

use crate::app::App;
use crate::domain::model::ModelRunKind;
use crate::language_model::{LanguageModel, ModelFailure, ModelSession};
use crate::problem::{Answer, Problem};
use crate::secret;
use crate::service::model_runs::{self, Claimed, Outcome};
use crate::service::projects::json;
use crate::service::tasks::{self, Entry, TaskRow};
use crate::service::{create, drafting, history, judgements, projects};
use crate::sync::lock;
use crate::values;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use whyroad_model::messages::CocLabel;
use whyroad_model::{Bilingual, Lang, ModelSpent};

/// Time between two queries for runs.
const LOOK_EVERY: Duration = Duration::from_millis(500);
/// Time between two checks whether a run was stopped or is finished.
const WATCH_EVERY: Duration = Duration::from_millis(100);
/// Time between two renewals of a run's lease.
const KEEP_EVERY: Duration = Duration::from_secs(1);

/// Processes runs until the service ends. `None` if it has no model. The thread is not joined: a question may take
/// minutes.
pub fn spawn(app: &Arc<App>) -> Option<JoinHandle<()>> {
    let model = Arc::clone(app.model.as_ref()?);
    let service = Arc::downgrade(app);
    let worker = secret::id().ok()?;
    Some(std::thread::spawn(move || {
        while let Some(app) = service.upgrade() {
            if app.metrics.is_stopping() {
                return;
            }
            let worked = next(&app, model.as_ref(), &worker);
            if let Err(why) = &worked {
                (app.log)(&format!("language model: {}", why.text.en));
            }
            drop(app);
            if !matches!(worked, Ok(true)) {
                std::thread::sleep(LOOK_EVERY);
            }
        }
    }))
}

/// Processes one run until it ends; false if none waits.
fn next(app: &Arc<App>, model: &dyn LanguageModel, worker: &str) -> Answer<bool> {
    let (service, me) = (Arc::clone(app), worker.to_owned());
    let claim = move |tx: &mut dyn crate::store::Tx| {
        let now = service.lease_now(tx)?;
        model_runs::claim(tx, &me, now)
    };
    // A read first: an idle service writes nothing.
    let open = "SELECT 1 FROM model_runs WHERE ended IS NULL LIMIT 1";
    if app.store.read(|tx| tx.row(open, &[]))?.is_none() {
        return Ok(false);
    }
    let Some(run) = app.store.write(claim)? else { return Ok(false) };
    match model.begin(&run.spent) {
        Ok(session) => Progress::new(app, session.as_ref(), &run, worker).work(model.at_once())?,
        Err(why) => end(app, &run.id, Some(why))?,
    }
    Ok(true)
}

fn end(app: &App, run: &str, why: Option<Bilingual>) -> Answer<()> {
    let (run, now) = (run.to_owned(), app.now());
    app.store.write(move |tx| model_runs::end(tx, &run, why.as_ref(), now))
}

/// A run in progress.
struct Progress<'a> {
    app: &'a App,
    session: &'a dyn ModelSession,
    run: &'a Claimed,
    worker: &'a str,
    waiting: Mutex<VecDeque<String>>,
    /// No further task is started.
    stopped: AtomicBool,
    /// Why it cannot continue.
    ended_by: Mutex<Option<Bilingual>>,
    busy: AtomicUsize,
}

impl<'a> Progress<'a> {
    fn new(app: &'a App, session: &'a dyn ModelSession, run: &'a Claimed, worker: &'a str) -> Self {
        Self {
            app,
            session,
            run,
            worker,
            waiting: Mutex::default(),
            stopped: AtomicBool::new(false),
            ended_by: Mutex::default(),
            busy: AtomicUsize::new(0),
        }
    }

    fn work(self, at_once: usize) -> Answer<()> {
        let waiting = self.app.store.read(|tx| model_runs::waiting(tx, &self.run.id))?;
        *lock(&self.waiting) = waiting.into();
        self.busy.store(at_once, Ordering::SeqCst);
        let kept = std::thread::scope(|scope| {
            for _ in 0..at_once {
                scope.spawn(|| {
                    // The store is unavailable: the run continues when it is back.
                    if self.ask().is_err() {
                        self.stopped.store(true, Ordering::SeqCst);
                    }
                    self.busy.fetch_sub(1, Ordering::SeqCst);
                });
            }
            self.watch()
        })?;
        if !kept {
            return Ok(());
        }
        let why = lock(&self.ended_by).take();
        let left = self.app.store.read(|tx| model_runs::waiting(tx, &self.run.id))?;
        if why.is_none() && !left.is_empty() {
            // A task failed for another reason: it is tried again.
            return Err(Problem::store("tasks of a run are left"));
        }
        end(self.app, &self.run.id, why)
    }

    /// Renews the lease until all is done; false if the run does not belong to this service any more.
    fn watch(&self) -> Answer<bool> {
        let mut kept = true;
        let mut last = Instant::now();
        loop {
            let over = self.busy.load(Ordering::SeqCst) == 0;
            if over || last.elapsed() >= KEEP_EVERY {
                last = Instant::now();
                // A store that is unavailable for a moment ends nothing.
                match self.keep() {
                    Ok(is_ours) => kept = is_ours,
                    Err(why) if over => return Err(why),
                    Err(_) => {}
                }
            }
            if !kept {
                self.stopped.store(true, Ordering::SeqCst);
            }
            if over {
                return Ok(kept);
            }
            if self.app.metrics.is_stopping() && !self.stopped.swap(true, Ordering::SeqCst) {
                let (run, worker) = (self.run.id.clone(), self.worker.to_owned());
                let _ = self.keep();
                self.app.store.write(move |tx| model_runs::give_back(tx, &run, &worker))?;
                kept = false;
            }
            std::thread::sleep(WATCH_EVERY);
        }
    }

    fn keep(&self) -> Answer<bool> {
        let (run, worker) = (self.run.id.clone(), self.worker.to_owned());
        let spent: ModelSpent = self.run.spent.plus(&self.session.spent());
        let now = self.app.store.read(|tx| self.app.lease_now(tx))?;
        self.app.store.write(move |tx| model_runs::keep(tx, &run, &worker, &spent, now))
    }

    /// Asks questions until no task is left.
    fn ask(&self) -> Answer<()> {
        while !self.stopped.load(Ordering::SeqCst) {
            let task = lock(&self.waiting).pop_front();
            let Some(task) = task else { return Ok(()) };
            // Checked each time: no question is asked, and paid for, after the run was stopped.
            if !self.app.store.read(|tx| model_runs::is_of(tx, &self.run.id, self.worker))? {
                self.stopped.store(true, Ordering::SeqCst);
                return Ok(());
            }
            let made = catch_unwind(AssertUnwindSafe(|| match self.run.kind {
                ModelRunKind::Draft => draft(self.app, self.session, self.run, &task),
                ModelRunKind::Judge => judge(self.app, self.session, self.run, &task),
            }));
            let failure = match made {
                Ok(Ok(())) => continue,
                Ok(Err(Stop::Store(why))) => return Err(why),
                Ok(Err(Stop::Model(failure))) => failure,
                Err(_) => ModelFailure {
                    text: Bilingual::new("内部错误", "internal error"),
                    ends_the_run: false,
                },
            };
            if failure.ends_the_run {
                // The task was not tried: the next run takes it.
                lock(&self.ended_by).get_or_insert(failure.text);
                self.stopped.store(true, Ordering::SeqCst);
                return Ok(());
            }
            let run = self.run.id.clone();
            let outcome = Outcome::Failed(failure.text);
            self.app.store.write(move |tx| model_runs::settle(tx, &run, &task, &outcome))?;
        }
        Ok(())
    }
}

/// Why a task has no result.
enum Stop {
    Store(Problem),
    Model(ModelFailure),
}

impl From<Problem> for Stop {
    fn from(p: Problem) -> Self {
        Self::Store(p)
    }
}

impl From<ModelFailure> for Stop {
    fn from(f: ModelFailure) -> Self {
        Self::Model(f)
    }
}

/// The language of a task's texts: its own, else its project's.
fn language(app: &App, t: &TaskRow) -> Answer<Lang> {
    let word = match t.lang.as_str() {
        "" => app.store.read(|tx| projects::get(tx, &t.project))?.settings.lang,
        own => own.to_owned(),
    };
    Ok(word.parse().unwrap_or_default())
}

fn left_out(app: &App, run: &Claimed, task: &str) -> Answer<()> {
    let (run, task) = (run.id.clone(), task.to_owned());
    app.store.write(move |tx| model_runs::settle(tx, &run, &task, &Outcome::LeftOut))
}

/// Replaces the rule's draft with the model's draft.
fn draft(app: &App, session: &dyn ModelSession, run: &Claimed, task: &str) -> Result<(), Stop> {
    let t = app.store.read(|tx| tasks::get(tx, task))?;
    if !app.store.read(|tx| model_runs::is_unbegun(tx, task))? {
        return Ok(left_out(app, run, task)?);
    }
    // Its thumbnail is created with the rule's draft.
    let t = match drafting::ready(app, t.clone()) {
        Ok(t) => t,
        Err(why) if why.status < 500 => {
            return Err(ModelFailure { text: why.text, ends_the_run: false }.into());
        }
        Err(why) => return Err(why.into()),
    };
    let label = session.draft(&t.episode, language(app, &t)?)?;
    let text = json(&create::by_model(label, t.veiled)?)?;
    let (run, task, now) = (run.clone(), task.to_owned(), app.now());
    let model = app.model.as_ref().map(|m| m.name().to_owned());
    app.store.write(move |tx| {
        let mut t = tasks::get_for_change(tx, &task)?;
        if !model_runs::is_unbegun(tx, &task)? {
            return model_runs::settle(tx, &run.id, &task, &Outcome::LeftOut);
        }
        t.draft = projects::parse(&text)?;
        t.initial = t.draft.clone();
        t.version += 1;
        let (actor, from) = (Some(run.actor.as_str()), Some(t.at.state));
        let entry = Entry { action: "model_draft", actor, from, note: model.as_deref(), ..Entry::default() };
        history::record(tx, &mut t, &entry, now)?;
        tasks::update(tx, &t)?;
        tx.run("UPDATE tasks SET initial = $1, imported = 0 WHERE id = $2", values![&text, &task])?;
        model_runs::settle(tx, &run.id, &task, &Outcome::Done)
    })?;
    Ok(())
}

/// The model's answers to questions about a submitted label.
fn judge(app: &App, session: &dyn ModelSession, run: &Claimed, task: &str) -> Result<(), Stop> {
    let t = app.store.read(|tx| tasks::get(tx, task))?;
    if !judgements::HANDED_IN.contains(&t.at.state) {
        return Ok(left_out(app, run, task)?);
    }
    let label: CocLabel = serde_json::from_value(t.draft.clone()).map_err(|e| ModelFailure {
        text: Bilingual::new(format!("标注无法读取：{e}"), format!("the label cannot be read: {e}")),
        ends_the_run: false,
    })?;
    let judged = session.judge(&label, language(app, &t)?)?;
    let (run, task, now, asked) = (run.clone(), task.to_owned(), app.now(), t.version);
    app.store.write(move |tx| {
        let mut t = tasks::get_for_change(tx, &task)?;
        // The answers belong to the label at the time of the question.
        let outcome = if t.version == asked && judgements::HANDED_IN.contains(&t.at.state) {
            judgements::put(tx, &mut t, &judged, &run.actor, now)?;
            Outcome::Done
        } else {
            Outcome::LeftOut
        };
        model_runs::settle(tx, &run.id, &task, &outcome)
    })?;
    Ok(())
}
