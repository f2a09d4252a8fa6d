//! Drafts and judgments by a language model: their visibility by time and user, runs that are stopped, fail and
//! continue. The model here is a test double; its knowledge of the future is a word that can be searched.

use crate::recorded::episode;
use crate::work::{Begin, Work, example};
use crate::world::{Person, World};
use serde_json::{Value, json};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};
use whyroad_label::judged::{JudgedLabel, Question, QuestionKind};
use whyroad_model::messages::{CocLabel, EpisodeRecord};
use whyroad_model::{Bilingual, Lang, ModelSpent};
use whyroad_server::App;
use whyroad_server::language_model::{LanguageModel, ModelFailure, ModelSession};

/// In every text of the model about the time after the keyframe.
const FUTURE: &str = "afterwards";

/// A test double of a model.
#[derive(Clone, Default)]
struct Model {
    /// Answers wait until this is true.
    open: Arc<(Mutex<bool>, Condvar)>,
    /// Received questions, answered or not.
    received: Arc<AtomicUsize>,
    asked: Arc<AtomicUsize>,
    /// Drives for which it returns nothing.
    fails: &'static [&'static str],
    /// Number of answers until the budget of a run is used up.
    budget: Option<u64>,
    begun_with: Arc<Mutex<Vec<ModelSpent>>>,
}

struct Session {
    model: Model,
    spent: Mutex<ModelSpent>,
}

impl LanguageModel for Model {
    fn name(&self) -> &str {
        "hand-model"
    }

    fn at_once(&self) -> usize {
        2
    }

    fn begin(&self, spent: &ModelSpent) -> Result<Arc<dyn ModelSession>, Bilingual> {
        self.begun_with.lock().unwrap().push(*spent);
        Ok(Arc::new(Session { model: self.clone(), spent: Mutex::default() }))
    }
}

impl Session {
    fn ask(&self) -> Result<(), ModelFailure> {
        self.model.received.fetch_add(1, Ordering::SeqCst);
        let (is_open, changed) = &*self.model.open;
        let guard = is_open.lock().unwrap();
        drop(changed.wait_while(guard, |open| !*open).unwrap());
        let mut spent = self.spent.lock().unwrap();
        if self.model.budget.is_some_and(|most| spent.requests >= most) {
            let text = Bilingual::new("预算用完", "the budget is used up");
            return Err(ModelFailure { text, ends_the_run: true });
        }
        self.model.asked.fetch_add(1, Ordering::SeqCst);
        spent.requests += 1;
        spent.input_tokens += 100;
        spent.cost = Some(spent.requests as f64 * 0.5);
        Ok(())
    }
}

impl ModelSession for Session {
    fn draft(&self, e: &EpisodeRecord, lang: Lang) -> Result<CocLabel, ModelFailure> {
        self.ask()?;
        if self.model.fails.contains(&e.drive_id.as_str()) {
            let text = Bilingual::new(format!("不安全 {FUTURE}"), format!("unsafe {FUTURE}"));
            return Err(ModelFailure { text, ends_the_run: false });
        }
        let mut label: CocLabel = serde_json::from_value(example()).unwrap();
        label.clip_id = e.clip_id.to_string();
        (label.keyframe, label.time_range) = (e.keyframe.clone(), e.time_range.clone());
        label.critical_components.truncate(1);
        label.critical_components[0].description = format!("model: a car over the line ({lang:?})");
        // A model may state any time.
        label.critical_components[0].evidence_times = vec![e.keyframe.timestamp.plus_secs(3.0)];
        label.coc_trace = format!("model: it brakes {FUTURE}");
        label.provenance = serde_json::from_value(json!({ "source": "model", "by": "hand-model" })).unwrap();
        Ok(label)
    }

    fn judge(&self, label: &CocLabel, _: Lang) -> Result<JudgedLabel, ModelFailure> {
        self.ask()?;
        let question = |id: &str, kind, answer| Question {
            id: id.to_owned(),
            kind,
            text: format!("statement {id}"),
            expected: true,
            object: None,
            answer: Some(answer),
            reason: Some(format!("because of {id}")),
        };
        let mut judged = JudgedLabel {
            clip_id: label.clip_id.clone(),
            keyframe: label.keyframe.timestamp,
            scenario: label.scenario.l2.clone(),
            judge: "hand-model".to_owned(),
            for_people: true,
            passed: None,
            questions: vec![
                question("q1", QuestionKind::Decision, true),
                question("q2", QuestionKind::Safety, false),
            ],
        };
        judged.decide();
        Ok(judged)
    }

    fn spent(&self) -> ModelSpent {
        *self.spent.lock().unwrap()
    }
}

/// The world with a model that answers at once, or waits.
fn beside(world: &World, model: Model, open: bool) -> World {
    set_open(&model.open, open);
    world.beside(|app: &mut App| app.model = Some(Arc::new(model)))
}

fn set_open(gate: &Arc<(Mutex<bool>, Condvar)>, open: bool) {
    *gate.0.lock().unwrap() = open;
    gate.1.notify_all();
}

/// The same person at another service.
fn at(person: &Person, world: &World) -> Person {
    Person { address: world.address, ..person.clone() }
}

fn runs(who: &Person, project: &str) -> Value {
    who.get(&format!("/projects/{project}/model-runs")).fine()
}

/// The newest run, as soon as `is` is true.
fn wait(who: &Person, project: &str, is: impl Fn(&Value) -> bool) -> Value {
    let began = Instant::now();
    loop {
        let run = runs(who, project)["runs"][0].clone();
        if is(&run) {
            return run;
        }
        assert!(began.elapsed() < Duration::from_secs(30), "{run}");
        std::thread::sleep(Duration::from_millis(30));
    }
}

fn ended(who: &Person, project: &str) -> Value {
    wait(who, project, |r| !r["ended"].is_null())
}

fn start(who: &Person, project: &str, body: &Value) -> crate::world::Reply {
    who.post(&format!("/projects/{project}/model-runs"), body)
}

/// Stage I shows the model's components, and nothing that it wrote about the future; Stage II shows it.
pub fn a_models_draft_shows_its_future_only_in_stage_two(world: &World) {
    let Begin { admin, project, ann, task } = Begin::on(world);
    // Without a model the service reports that.
    assert_eq!(runs(&admin, &project)["model"], Value::Null);
    assert_eq!(start(&admin, &project, &json!({ "kind": "draft" })).refusal(), (409, "model.none".into()));
    let service = beside(world, Model::default(), true);
    let (admin, ann) = (at(&admin, &service), at(&ann, &service));
    let before = runs(&admin, &project);
    assert_eq!((&before["model"], &before["to_draft"]), (&json!("hand-model"), &json!(1)));
    assert_eq!(start(&ann, &project, &json!({ "kind": "draft" })).status, 403);
    start(&admin, &project, &json!({ "kind": "draft" })).fine();
    let run = ended(&admin, &project);
    assert_eq!((&run["state"], &run["done"], &run["total"]), (&json!("done"), &json!(1), &json!(1)), "{run}");
    assert_eq!((&run["spent"]["requests"], &run["spent"]["cost"]), (&json!(1), &json!(0.5)));
    assert_eq!(runs(&admin, &project)["to_draft"], 0);
    assert_eq!(start(&admin, &project, &json!({ "kind": "draft" })).refusal(), (422, "model.nothing".into()));

    let mut work = Work::take(&ann, &task);
    let shown = work.view();
    assert_eq!((&shown["stage"], &shown["drafted_by"]), (&json!("stage1"), &json!("hand-model")));
    let component = &shown["draft"]["critical_components"][0];
    assert_eq!(component["description"], "model: a car over the line (Zh)");
    // Evidence times are in the history, whatever the model stated.
    assert_eq!(component["evidence_times"][0], shown["suggestion"]["keyframe"]["timestamp"]);
    for path in ["", "/history", "/history/1", "/scene"] {
        let text = ann.get(&work.path(path)).text();
        assert!(!text.contains(FUTURE) && !text.contains("yield_to_agent"), "{path}: {text}");
    }
    work.stage1();
    work.act("lock_stage1", &json!({})).fine();
    let shown = work.view();
    assert_eq!(shown["draft"]["coc_trace"], format!("model: it brakes {FUTURE}"));
    assert_eq!(shown["draft"]["driving_decision"]["longitudinal"], "yield_to_agent");
    assert_eq!(shown["draft"]["provenance"]["source"], "model");
    // The label is compared with the draft, and the history contains who requested it.
    assert_eq!(ann.get(&work.path("/history/1")).fine()["draft"]["coc_trace"], shown["draft"]["coc_trace"]);
    let history = ann.get(&work.path("/history")).fine();
    let entry = history["items"].as_array().unwrap().iter().find(|e| e["action"] == "model_draft").unwrap();
    assert_eq!((&entry["actor"], &entry["comment"]), (&json!("Admin"), &json!("hand-model")));
    work.stage2();
    work.act("submit", &json!({})).fine();
    let label = work.who.get(&work.path("")).fine();
    assert_eq!(label["draft"]["provenance"]["source"], "person", "a label that was handed in is a person's");
}

/// A user who starts while the model is asked keeps their draft; a stopped run asks no further question; failures have
/// a reason, which is hidden from users who may still do Stage I.
pub fn begun_tasks_are_left_alone_and_runs_are_stopped(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let lead = world.person(&admin, &project, "lea", &["lead", "annotator"]);
    let leo = world.person(&admin, &project, "leo", &["lead"]);
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let drives = ["drive1", "drive2", "drive3", "drive4", "drive5"];
    let tasks = world.tasks(&admin, &project, &drives, 1);
    let model = Model { fails: &["drive2"], ..Model::default() };
    let (gate, received, asked) =
        (Arc::clone(&model.open), Arc::clone(&model.received), Arc::clone(&model.asked));
    let service = beside(world, model, false);
    let (admin, ann, lead) = (at(&admin, &service), at(&ann, &service), at(&lead, &service));
    let run = start(&admin, &project, &json!({ "kind": "draft" })).fine();
    wait(&admin, &project, |r| r["state"] == "running" && received.load(Ordering::SeqCst) == 2);
    assert_eq!(start(&lead, &project, &json!({ "kind": "draft" })).refusal(), (409, "model.running".into()));
    // The first two tasks that the model is asked about: one is started in the meantime.
    let mut work = Work::take(&ann, &tasks[0]);
    let rules = work.view()["draft"]["critical_components"].clone();
    // During the run its own tasks are counted; afterwards those that nobody has started.
    assert_eq!(runs(&admin, &project)["to_draft"], 5);
    admin.post(&format!("/projects/{project}/model-runs:stop"), &json!({ "run": run["id"] })).fine();
    assert_eq!(runs(&admin, &project)["to_draft"], 4);
    set_open(&gate, true);
    let run = wait(&admin, &project, |r| {
        r["done"].as_i64().unwrap() + r["failed"].as_i64().unwrap() + r["left_out"].as_i64().unwrap() == 2
    });
    assert_eq!((&run["state"], &run["total"]), (&json!("stopped"), &json!(5)));
    assert_eq!((&run["left_out"], &run["failed"]), (&json!(1), &json!(1)), "{run}");
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(asked.load(Ordering::SeqCst), 2, "no further question");
    assert_eq!(work.view()["draft"]["critical_components"], rules);
    work.stage1();
    // The reason of a failure may reveal the future: it is hidden from a lead who labels.
    let told = runs(&at(&leo, &service), &project)["runs"][0]["failures"][0]["text"]["en"].clone();
    assert_eq!(told, format!("unsafe {FUTURE}"));
    assert!(!runs(&lead, &project).to_string().contains(FUTURE));
    // The next run, newer by the clock, takes the rest: a started task is left out, even if it is named.
    world.wait(1);
    start(&admin, &project, &json!({ "kind": "draft", "tasks": [tasks[0], tasks[2]] })).fine();
    let run = wait(&admin, &project, |r| r["total"] == 1 && !r["ended"].is_null());
    assert_eq!(run["done"], 1);
    let named = start(&admin, &project, &json!({ "kind": "draft", "tasks": [tasks[0]] }));
    assert_eq!(named.refusal(), (422, "model.nothing".into()));
}

/// A run continues after its service was killed, without asking again for tasks with a draft; a used-up budget ends it.
pub fn a_run_goes_on_after_a_restart_and_ends_with_its_budget(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    world.tasks(&admin, &project, &["drive1", "drive2", "drive3"], 1);
    // The state after a service was killed: claimed, with one task done and a cost.
    let service = beside(world, Model { budget: Some(1), ..Model::default() }, true);
    start(&at(&admin, &service), &project, &json!({ "kind": "draft" })).fine();
    let run = ended(&at(&admin, &service), &project);
    assert_eq!((&run["state"], &run["done"]), (&json!("failed"), &json!(1)), "{run}");
    assert_eq!(run["note"]["en"], "the budget is used up");
    drop(service);
    let id = run["id"].as_str().unwrap().to_owned();
    let now = world.app.now();
    world
        .app
        .store
        .write(move |tx| {
            let sql = "UPDATE model_runs SET state = 'running', ended = NULL, worker = 'killed', alive = $1 WHERE id = $2";
            tx.run(sql, &[now.into(), id.clone().into()]).map(drop)
        })
        .unwrap();
    let model = Model::default();
    let (asked, begun_with) = (Arc::clone(&model.asked), Arc::clone(&model.begun_with));
    let service = beside(world, model, true);
    std::thread::sleep(Duration::from_millis(1500));
    assert_eq!(asked.load(Ordering::SeqCst), 0, "its lease is another's");
    world.wait(30);
    let run = ended(&at(&admin, &service), &project);
    assert_eq!((&run["state"], &run["done"]), (&json!("done"), &json!(3)), "{run}");
    assert_eq!(asked.load(Ordering::SeqCst), 2);
    assert_eq!(begun_with.lock().unwrap()[0].requests, 1, "what was spent before counts");
    assert_eq!((&run["spent"]["requests"], &run["spent"]["cost"]), (&json!(3), &json!(1.5)));
}

/// Answers are for checkers, auditors and leads; for a label that was drawn for people they are shown after the
/// person's own answers, and agreement is counted. Nothing waits for them.
pub fn judgements_are_shown_to_checkers_after_their_own(world: &World) {
    let Begin { admin, project, ann, task } = Begin::on(world);
    let checker = world.person(&admin, &project, "chen", &["checker"]);
    let lead = world.person(&admin, &project, "lea", &["lead"]);
    let service = beside(world, Model::default(), true);
    let (admin, ann, checker) = (at(&lead, &service), at(&ann, &service), at(&checker, &service));
    assert_eq!(start(&admin, &project, &json!({ "kind": "judge" })).refusal(), (422, "model.nothing".into()));
    let work = Work::label(&ann, &task);
    start(&admin, &project, &json!({ "kind": "judge" })).fine();
    assert_eq!(ended(&admin, &project)["done"], 1);
    assert!(work.view().get("judgement").is_none(), "not for the author");
    // A lead who does not check sees it at once.
    let lead = admin.get(&work.path("")).fine();
    assert_eq!(lead["judgement"]["questions"][1]["answer"], false);

    let check = Work::next(&checker, &project, "check").unwrap();
    let asked = check.view()["judgement"].clone();
    assert_eq!(
        (&asked["asks"], &asked["withheld"], &asked["model"]),
        (&json!(true), &json!(true), &json!("hand-model"))
    );
    assert_eq!(asked["questions"][0]["text"], "statement q1");
    assert!(
        !asked.to_string().contains("because of") && asked["questions"][0]["answer"].is_null(),
        "{asked}"
    );
    let answer = |who: &Person, fence: i64, answers: Value| {
        who.post(&check.path("/judgement"), &json!({ "fence": fence, "answers": answers }))
    };
    assert_eq!(answer(&ann, check.fence, json!({ "q1": true })).status, 409, "not theirs");
    assert_eq!(answer(&checker, check.fence, json!({ "q9": true })).refusal().0, 400);
    let shown = answer(&checker, check.fence, json!({ "q1": true, "q2": true })).fine();
    let judgement = &shown["judgement"];
    assert_eq!(
        (&judgement["withheld"], &judgement["own"]),
        (&json!(false), &json!({ "q1": true, "q2": true }))
    );
    assert_eq!(judgement["questions"][1]["reason"], "because of q2");
    let report = checker.get(&format!("/projects/{project}/judge")).fine();
    assert_eq!(
        (&report["judged"], &report["passed"], &report["answered"]),
        (&json!(1), &json!(0), &json!(1))
    );
    // q1 agrees, q2 does not: only the judge finds an error.
    let all = report["kinds"].as_array().unwrap().last().unwrap().clone();
    assert_eq!((&all["kind"], &all["answers"], &all["same"]), (&json!("all"), &json!(2), &json!(0.5)));
    assert_eq!((&all["only_judge"], &all["only_people"]), (&json!(1), &json!(0)));
    assert_eq!(ann.get(&format!("/projects/{project}/judge")).status, 403);

    // Information only: the label is returned or accepted as before, and a changed label has no valid answers.
    let mut check = check;
    check.act("send_back", &json!({ "reason": "more" })).fine();
    let again = Work::take(&ann, &task);
    let mut again = Work { who: &ann, task: task.clone(), ..again };
    again.set(&[("/coc_trace", example()["coc_trace"].clone())]);
    again.act("submit", &json!({})).fine();
    let outdated = admin.get(&again.path("")).fine()["judgement"]["outdated"].clone();
    assert_eq!(outdated, true);
    assert_eq!(runs(&admin, &project)["to_judge"], 1);
    let e = episode("drive1", 1, world.future);
    let removed = whyroad_server::service::deletion::delete_drive(&world.app.store, &e.drive_id).unwrap();
    assert_eq!(removed.tasks, 1);
    assert_eq!(admin.get(&format!("/projects/{project}/judge")).fine()["judged"], 0);
}
