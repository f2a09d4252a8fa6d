//! Actions on a task as a whole: the steps of the workflow with their conditions, adjudication of an overlap group, and
//! restoring an earlier draft.

use crate::app::App;
use crate::domain::gold::GoldStanding;
use crate::domain::project::Project;
use crate::domain::task::{ActionName, Finding, NewComment, TaskAction};
use crate::domain::workflow::{self, Action, Actor, Draw, Position, Role, Stage, State};
use crate::problem::{Answer, Problem};
use crate::secret;
use crate::service::tasks::{self, Entry, LabelView, TaskRow};
use crate::service::texts::{TEXT, is_long};
use crate::service::{
    audits, dashboard, disagreement, drafts, findings, gold, history, leases, other_class, safety, seen,
    texts,
};
use crate::store::Tx;
use crate::values;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use whyroad_label::merge::{self, FieldChange};
use whyroad_model::label_fields::{name, pointer};
use whyroad_model::messages::{Provenance, ProvenanceSource};
use whyroad_model::{FORMAT_VERSION, Nanos};

/// A submitted label is shown completely.
const STAGE2: LabelView =
    LabelView { stage: Stage::Stage2, hides_leaf: false, hides_drafted: false, in_hand: false };

/// Result of checking a draft before the transaction that acts on it: checking may take long, and a write transaction
/// blocks all other writers.
#[derive(Clone, Debug)]
pub struct Checked {
    /// Version of the draft that was checked.
    version: i64,
    /// The draft after the changes.
    draft: Value,
    /// The changes to it.
    changes: Vec<FieldChange>,
    /// The findings.
    found: Vec<Finding>,
}

/// Checks the draft of `t` if `request` requires it. `name` is written into the label.
pub fn check(app: &App, t: &TaskRow, name: &str, request: &TaskAction, now: i64) -> Answer<Option<Checked>> {
    let mut draft = t.draft.clone();
    let (changes, found) = match request.action.in_workflow() {
        Some(Action::LockStage1) => (vec![], findings::of(app, t, &draft, t.view())),
        Some(Action::Submit) => {
            let mut changes = made_by(app, name, now)?;
            changes.extend(stored_records(app, &draft));
            changes.iter().try_for_each(|c| merge::apply(&mut draft, c))?;
            let found = findings::of(app, t, &draft, STAGE2);
            (changes, found)
        }
        None if request.action == ActionName::Adjudicate && request.label.is_some() => {
            draft = merged(t, request.label.as_ref())?;
            let changes = made_by(app, name, now)?;
            changes.iter().try_for_each(|c| merge::apply(&mut draft, c))?;
            let found = findings::of(app, t, &draft, STAGE2);
            (changes, found)
        }
        _ => return Ok(None),
    };
    Ok(Some(Checked { version: t.version, draft, changes, found }))
}

/// Code of the refusal to act on a draft that has changed since it was checked: it must be checked again.
pub const CHANGED_SINCE: &str = "draft.changed";

/// The label that a lead merged, with the clip and the scenario of `t`.
fn merged(t: &TaskRow, label: Option<&Value>) -> Answer<Value> {
    let Some(fields) = label.and_then(Value::as_object) else {
        return Err(Problem::request("label 须为对象", "label must be an object"));
    };
    let mut draft = Value::Object(fields.clone());
    // Each task's holder has answered this for the task; a merged label takes the answer of its own task.
    if let Some(fields) = draft.as_object_mut() {
        fields.remove(name::SAFETY_FILTER);
    }
    for own in [pointer::CLIP_ID, pointer::SCENARIO, pointer::SAFETY_FILTER] {
        if let Some(value) = t.draft.pointer(own) {
            let kept = FieldChange { path: own.to_owned(), value: value.clone(), remove: false };
            merge::apply(&mut draft, &kept)?;
        }
    }
    merge::bounded(&draft)?;
    Ok(draft)
}

fn current(checked: Option<&Checked>, t: &TaskRow) -> Answer<Checked> {
    checked.filter(|c| c.version == t.version).cloned().ok_or_else(|| {
        Problem::new(409, CHANGED_SINCE, "草稿刚被修改，请重试", "the draft was changed just now: try again")
    })
}

/// Applies `request` to the task `id`; `checked` is the result of [`check`] for it.
pub fn act(
    app: &App,
    tx: &mut dyn Tx,
    id: &str,
    actor: &Actor,
    project: &Project,
    request: &TaskAction,
    checked: Option<&Checked>,
) -> Answer<TaskRow> {
    let mut t = tasks::get_for_change(tx, id)?;
    let now = app.lease_now(tx)?;
    let reason = texts::reason(request.reason.as_deref())?;
    check_texts(&request.comments)?;
    let Some(action) = request.action.in_workflow() else {
        match request.action {
            ActionName::Restore => restore(tx, &mut t, actor, project, request, now)?,
            _ => {
                let label = request.label.as_ref().map(|_| current(checked, &t)).transpose()?;
                adjudicate(tx, &mut t, actor, reason, label, now)?;
            }
        }
        return Ok(t);
    };
    // A lead may end or reopen tasks that others hold; a user who acts as holder sends the token.
    let as_lead = actor.is(Role::Lead) && matches!(action, Action::Skip | Action::Reject | Action::Reopen);
    if t.at.state.is_held() && !(as_lead && t.at.holder.as_deref() != Some(actor.id.as_str())) {
        leases::held(&t, &actor.id, request.fence)?;
    }
    let draw = match action {
        Action::Accept if t.at.state == State::InCheck => draw(app, tx, &t, project)?,
        _ => Draw::Pass,
    };
    let next = workflow::step(&t.at, actor, action, draw)?;
    need_reason(action, reason, &request.comments)?;
    let from = t.at.state;
    let mut changes = Vec::new();
    let mut snapshot = None;
    match action {
        Action::LockStage1 => lockable(&t, current(checked, &t)?.found)?,
        Action::Submit => {
            safety::required(&t)?;
            let checked = current(checked, &t)?;
            t.findings = codes(&checked.found);
            refuse_errors(checked.found)?;
            (t.draft, changes) = (checked.draft, checked.changes);
            t.version += 1;
            // The complete draft, so that submissions can be compared without rebuilding them.
            snapshot = Some(t.draft.clone());
        }
        Action::Accept | Action::SendBack if from == State::InAudit => t.audited = true,
        Action::Reopen if next.state == State::Open => {
            t.draft = t.initial.clone();
            t.version += 1;
            snapshot = Some(t.draft.clone());
            t.audited = false;
            t.findings.clear();
            safety::forget(tx, &t.id)?;
            disagreement::reopen(tx, &mut t)?;
        }
        _ => {}
    }
    match action {
        Action::Skip => t.right_class = right_class(app, request)?,
        Action::Reopen => t.right_class = None,
        _ => {}
    }
    match action {
        // The others can stand for the episode again.
        Action::Skip | Action::Reject if t.is_chosen() => disagreement::reopen(tx, &mut t)?,
        _ => {}
    }
    t.at = next;
    if t.at.holder.is_none() {
        t.lease_until = None;
    } else {
        leases::extend(&mut t, &project.settings, now);
    }
    seen::show(tx, &t, &actor.id)?;
    let entry = Entry {
        action: action.word(),
        actor: Some(&actor.id),
        from: Some(from),
        changes: &changes,
        snapshot: snapshot.as_ref(),
        note: reason,
    };
    history::record(tx, &mut t, &entry, now)?;
    for comment in &request.comments {
        self::comment(tx, &t, &actor.id, comment, now)?;
    }
    tasks::update(tx, &t)?;
    if t.overlap_count > 1
        && matches!(action, Action::Submit | Action::Skip | Action::Reject | Action::Reopen)
    {
        disagreement::note(tx, &t.project, &t.episode.episode_id)?;
    }
    Ok(t)
}

/// The class that fits instead of the task's, as the request says.
fn right_class(app: &App, request: &TaskAction) -> Answer<Option<String>> {
    match request.right_class.as_deref() {
        Some(id) if !id.is_empty() => {
            other_class::class(app.framework, id).map(|class| Some(class.to_string()))
        }
        other => Ok(other.map(str::to_owned)),
    }
}

/// The codes of findings.
fn codes(found: &[Finding]) -> BTreeSet<String> {
    found.iter().map(|f| f.code.clone()).collect()
}

/// Stores a comment on a field; returns its id.
pub fn comment(tx: &mut dyn Tx, t: &TaskRow, author: &str, comment: &NewComment, now: i64) -> Answer<String> {
    check_texts(std::slice::from_ref(comment))?;
    let id = secret::id()?;
    tx.run(
        "INSERT INTO comments (id, task_id, path, author, body, at, resolved, to_lead)
         VALUES ($1, $2, $3, $4, $5, $6, 0, $7)",
        values![&id, &t.id, &comment.path, author, &comment.text, now, i64::from(comment.to_lead)],
    )?;
    Ok(id)
}

fn check_texts(comments: &[NewComment]) -> Answer<()> {
    let bad = |c: &NewComment| {
        c.text.trim().is_empty() || is_long(&c.text) || c.path.len() > 200 || !is_pointer(&c.path)
    };
    if comments.len() > 100 || comments.iter().any(bad) {
        return Err(Problem::request(
            format!("评论须为 1 至 {TEXT} 个字符，路径须为 JSON 指针"),
            format!("a comment must have 1 to {TEXT} characters, its path must be a JSON pointer"),
        ));
    }
    Ok(())
}

fn is_pointer(path: &str) -> bool {
    path.is_empty() || path.starts_with('/')
}

fn need_reason(action: Action, reason: Option<&str>, comments: &[NewComment]) -> Answer<()> {
    let given = match action {
        Action::Skip | Action::Reject | Action::Reopen => reason.is_some(),
        Action::SendBack => reason.is_some() || !comments.is_empty(),
        _ => true,
    };
    if given {
        return Ok(());
    }
    Err(Problem::new(422, "action.reason", "需要说明原因", "a reason is required"))
}

/// Stage I can only be locked with a component and without errors in the parts that cannot be changed later.
fn lockable(t: &TaskRow, found: Vec<Finding>) -> Answer<()> {
    let described = |c: &Value| c[name::DESCRIPTION].as_str().is_some_and(|d| !d.trim().is_empty());
    let any = t.draft.get(name::CRITICAL_COMPONENTS).and_then(Value::as_array);
    if !any.is_some_and(|list| list.iter().any(described)) {
        return Err(Problem::new(
            422,
            "stage1.empty",
            "阶段一至少需要一个关键要素",
            "Stage I needs at least one critical component",
        ));
    }
    refuse_errors(found)
}

fn refuse_errors(found: Vec<Finding>) -> Answer<()> {
    if !findings::has_error(&found) {
        return Ok(());
    }
    Err(Problem::new(422, "label.findings", "标注还有错误", "the label still has errors")
        .with(json!({ "findings": found })))
}

/// The author of the label, as changes of it.
fn made_by(app: &App, name: &str, now: i64) -> Answer<Vec<FieldChange>> {
    let made = Provenance {
        source: ProvenanceSource::Person,
        by: Some(name.to_owned()),
        at: Some(Nanos(now * 1_000_000)),
        tool: Some(concat!("whyroad ", env!("CARGO_PKG_VERSION")).to_owned()),
        versions: [("taxonomy".to_owned(), app.framework.taxonomy.version.clone())].into(),
    };
    let set = |path: &str, value: Value| FieldChange { path: path.to_owned(), value, remove: false };
    let made = serde_json::to_value(made).map_err(Problem::store)?;
    Ok(vec![set(pointer::PROVENANCE, made), set(pointer::VERSION, json!(FORMAT_VERSION))])
}

/// Records in their stored form, without language, as changes of the draft.
fn stored_records(app: &App, draft: &Value) -> Vec<FieldChange> {
    let records = draft.get(name::RECORDS).and_then(Value::as_object);
    let stored = records.into_iter().flatten().filter_map(|(id, value)| {
        let value = app.framework.record_types.stored(id, value)?;
        Some(FieldChange { path: pointer::records_of(id), value, remove: false })
    });
    stored.collect()
}

fn draw(app: &App, tx: &mut dyn Tx, t: &TaskRow, project: &Project) -> Answer<Draw> {
    let (audited, failed) = dashboard::audit_record(tx, &project.id, t.at.author().unwrap_or_default())?;
    // An author who is not qualified yet, or has failed, counts as unknown.
    let share = match gold::standing(tx, project, t.at.author().unwrap_or_default())? {
        GoldStanding::Open | GoldStanding::Failed => f64::from(project.settings.audit_max_percent),
        GoldStanding::NotAsked | GoldStanding::Qualified => {
            dashboard::audit_share(&project.settings, audited, failed)
        }
    };
    Ok(audits::draw(&app.csrf_key, t, share))
}

fn restore(
    tx: &mut dyn Tx,
    t: &mut TaskRow,
    actor: &Actor,
    project: &Project,
    request: &TaskAction,
    now: i64,
) -> Answer<()> {
    leases::may_edit(t, actor, request.fence)?;
    if safety::applies(t.at.state) {
        safety::required(t)?;
    }
    let seq = request.seq.ok_or_else(|| Problem::request("缺少 seq", "seq is missing"))?;
    // Only a draft that the user may see can be restored.
    drafts::at_for(tx, t, &actor.id, seq)?;
    let old = drafts::at(tx, t, seq)?;
    t.draft = drafts::restored(t, &old);
    t.version += 1;
    leases::extend(t, &project.settings, now);
    let snapshot = t.draft.clone();
    let note = seq.to_string();
    let entry = Entry {
        action: "restore",
        actor: Some(&actor.id),
        from: Some(t.at.state),
        snapshot: Some(&snapshot),
        note: Some(&note),
        ..Entry::default()
    };
    history::record(tx, t, &entry, now)?;
    tasks::update(tx, t)
}

/// True when every label of the group has been submitted: before that nobody sees the label of another.
pub fn group_is_ready(tx: &mut dyn Tx, t: &TaskRow) -> Answer<bool> {
    Ok(disagreement::is_ready(&tasks::group(tx, &t.project, &t.episode.episode_id)?))
}

/// Chooses this label for its overlap group, or `merged` instead. The author of one of them cannot choose.
fn adjudicate(
    tx: &mut dyn Tx,
    t: &mut TaskRow,
    actor: &Actor,
    reason: Option<&str>,
    merged: Option<Checked>,
    now: i64,
) -> Answer<()> {
    if !actor.is(Role::Lead) {
        return Err(Problem::forbidden());
    }
    let group = tasks::group(tx, &t.project, &t.episode.episode_id)?;
    // The other labels may have been removed since.
    if t.overlap_count < 2 || !disagreement::is_ready(&group) || !t.at.state.shows_future() {
        return Err(Problem::new(
            409,
            "overlap.not_ready",
            "重叠标注尚未全部提交",
            "not all labels of the overlap group are submitted",
        ));
    }
    if group.iter().any(|o| o.at.authors.contains(&actor.id)) {
        return Err(Problem::new(
            403,
            "task.own_work",
            "不能裁决自己参与标注的事件",
            "you cannot adjudicate a group with your own label",
        ));
    }
    // The answer shows the chosen label.
    seen::show(tx, t, &actor.id)?;
    let mut snapshot = None;
    let before = t.at.state;
    if let Some(merged) = merged {
        t.findings = codes(&merged.found);
        refuse_errors(merged.found)?;
        t.draft = merged.draft;
        t.version += 1;
        snapshot = Some(t.draft.clone());
        // Nobody has checked this label: it is submitted, with the person who merged it as an author.
        t.at = Position {
            state: State::Submitted,
            checker: None,
            auditor: None,
            holder: None,
            checked: false,
            ..t.at.clone()
        };
        t.lease_until = None;
        t.at.authors.insert(0, actor.id.clone());
    }
    for other in group {
        let mut o = if other.id == t.id { t.clone() } else { tasks::get_for_change(tx, &other.id)? };
        o.adjudication = Some(if o.id == t.id { "chosen" } else { "superseded" }.to_owned());
        let from = Some(if o.id == t.id { before } else { o.at.state });
        let snapshot = snapshot.as_ref().filter(|_| o.id == t.id);
        let actor = Some(actor.id.as_str());
        let entry = Entry { action: "adjudicate", actor, from, snapshot, note: reason, ..Entry::default() };
        history::record(tx, &mut o, &entry, now)?;
        tasks::update(tx, &o)?;
        if o.id == t.id {
            *t = o;
        }
    }
    Ok(())
}
