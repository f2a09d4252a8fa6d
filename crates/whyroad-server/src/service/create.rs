//! Creates tasks from episodes. The draft has two parts: critical components from the drive cut at the keyframe, so
//! that Stage I contains nothing from the future; decision and trace from the whole drive.

use crate::app::App;
use crate::domain::project::Project;
use crate::domain::task::{CreateTasks, Created, LostEpisode};
use crate::domain::workflow::Position;
use crate::problem::{Answer, Problem};
use crate::recordings::span_of;
use crate::service::known::Unnamed;
use crate::service::sample_window::{self, FUTURE_S, HISTORY_S, Window};
use crate::service::tasks::{self, Entry, TaskRow};
use crate::service::{history, imported, projects, thumbnail, veil};
use crate::store::Tx;
use crate::{secret, values};
use serde_json::Value;
use std::cell::OnceCell;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use whyroad_framework::spec::{PackSpec, ResolvedSpec};
use whyroad_framework::{Framework, Taxonomy};
use whyroad_label::draft::is_same;
use whyroad_model::label_fields::name;
use whyroad_model::messages::{
    Cause, Causes, CocLabel, CriticalComponent, DrivingDecision, EpisodeCursor, EpisodeFilter, EpisodeRecord,
};
use whyroad_model::{Bilingual, Drive, DriveId, Lang, Nanos, ScenarioId, SignalTable};

/// Maximum number of people per episode.
const MOST_OVERLAP: u32 = 10;
/// Maximum number of episodes in one request. A mined folder, which is read page by page, may have any number.
const MOST_EPISODES: usize = 20_000;
/// Number of episodes of a mined folder that are in memory at once.
const EPISODES_PER_PAGE: usize = 500;
/// Maximum number of episodes without a drive that are reported with the reason.
const MOST_REASONS: usize = 100;
/// Number of tasks stored in one transaction: small enough that nobody's autosave waits long.
const AT_ONCE: usize = 50;

/// When the drafts of new tasks are created.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drafting {
    /// With the tasks.
    Now,
    /// In the background, by a running service ([`super::drafting`]).
    Later,
}

/// Creates tasks from episodes. `actor` is unset for the command line.
pub fn create(
    app: &App,
    project: &str,
    request: &CreateTasks,
    actor: Option<&str>,
    drafting: Drafting,
) -> Answer<Created> {
    let project = app.store.read(|tx| projects::get(tx, project))?;
    let mut episodes = Episodes::of(app, request)?;
    let overlap = i64::from(request.overlap.unwrap_or(1));
    if !(1..=i64::from(MOST_OVERLAP)).contains(&overlap) {
        return Err(Problem::request(
            format!("overlap 须为 1 至 {MOST_OVERLAP}"),
            format!("overlap must be 1 to {MOST_OVERLAP}"),
        ));
    }
    if request.lang.as_deref().is_some_and(|l| l.parse::<Lang>().is_err()) {
        return Err(Problem::request("lang 须为 zh 或 en", "lang must be zh or en"));
    }
    let mut out = Created::default();
    let mut by_leaf: BTreeMap<String, u32> = BTreeMap::new();
    let mut rows: Vec<TaskRow> = Vec::new();
    let mut chosen = 0;
    let mut last = LastDrive::default();
    let mut last_span = LastSpan::default();
    let mut unnamed = Unnamed::of(app)?;
    while let Some(episode) = episodes.next()? {
        let episode = &episode;
        let leaf = by_leaf.entry(episode.scenario_id.to_string()).or_default();
        if request.limit.is_some_and(|l| (chosen + 1) * overlap > i64::from(l)) {
            // The limit is reached: no further episode can be used, so none has to be read.
            episodes.put_back(episode.clone());
            let [all, known, primary] = episodes.remaining()?;
            let usable = if request.secondary { known } else { primary };
            out.over_limit += usable;
            out.secondary += known.saturating_sub(usable);
            out.no_class += all.saturating_sub(known);
            break;
        }
        let beyond = request.per_leaf.is_some_and(|l| *leaf >= l);
        // An episode without a class is for the owner of the framework, not for a label.
        let known_class = app.framework.taxonomy.contains(&episode.scenario_id);
        let reason = match (known_class, episode.is_primary || request.secondary) {
            (false, _) => Some(&mut out.no_class),
            (true, false) => Some(&mut out.secondary),
            (true, true) => beyond.then_some(&mut out.over_limit),
        };
        if let Some(count) = reason {
            *count += 1;
            continue;
        }
        unnamed.name(app, episode)?;
        if is_known(app, &project.id, &episode.episode_id)? {
            out.known += 1;
            continue;
        }
        // The drive is read for the draft and the thumbnail; if these are created later, it only needs to exist.
        let source = match drafting {
            Drafting::Now => last.of(app, episode).map(|s| (span_of(&s.drive.times).ok(), Some(s))),
            Drafting::Later => last_span.of(app, episode).map(|span| (Some(span), None)),
        };
        match source {
            Ok((span, _)) if !request.without_history && sample_window::is_first(episode, span) => {
                out.no_history += 1;
            }
            Ok((span, source)) => {
                let lang = request.lang.clone().unwrap_or_default();
                let given = match source {
                    Some(source) => Start::derived(app, &project, source, episode, &lang)?,
                    None => Start::pending(),
                };
                let first = row(app, &project, episode, lang, given)?;
                for index in 0..overlap {
                    let (id, priority) = (secret::id()?, request.priority);
                    rows.push(TaskRow {
                        id,
                        priority,
                        overlap_index: index,
                        overlap_count: overlap,
                        ..first.clone()
                    });
                }
                if span.is_some_and(|span| !Window::of(episode.keyframe.timestamp, span).is_whole()) {
                    out.short_window += 1;
                }
                *leaf += 1;
                chosen += 1;
            }
            Err(_) if out.lost.len() >= MOST_REASONS => out.more += 1,
            Err(text) => out.lost.push(LostEpisode { episode: episode.episode_id.clone(), text }),
        }
        // Stored in groups: people can start earlier, and the stored tasks remain if a later step fails.
        if rows.len() >= AT_ONCE {
            out.tasks.extend(put(app, std::mem::take(&mut rows), actor)?);
        }
    }
    out.tasks.extend(put(app, rows, actor)?);
    out.left_out = [out.secondary, out.no_class, out.no_history]
        .iter()
        .fold(out.over_limit, |a, b| a.saturating_add(*b));
    Ok(out)
}

/// Stores tasks in one transaction; returns the ids of the new ones.
fn put(app: &App, rows: Vec<TaskRow>, actor: Option<&str>) -> Answer<Vec<String>> {
    let (actor, now) = (actor.map(str::to_owned), app.now());
    app.store.write(move |tx| {
        let mut made = Vec::new();
        for t in &rows {
            if store(tx, t.clone(), actor.as_deref(), now)? {
                made.push(t.id.clone());
            }
        }
        Ok(made)
    })
}

/// Stores tasks, a few per transaction; returns the number of new ones. When the store fails in between, the stored
/// tasks remain, and a repetition creates the rest.
pub fn put_all(app: &App, rows: &[TaskRow], actor: Option<&str>) -> Answer<u32> {
    rows.chunks(AT_ONCE).try_fold(0, |made, part| Ok(made + put(app, part.to_vec(), actor)?.len() as u32))
}

/// The episodes of a request, sorted by drive and time: each drive is read once, and the queue shows nobody an earlier
/// part of a drive after a later one.
struct Episodes<'a> {
    app: &'a App,
    /// The mined folder; `None` if `ready` contains all.
    mined: Option<&'a str>,
    ready: VecDeque<EpisodeRecord>,
    /// Position of the folder's next page; `None` if there is none.
    next: Option<EpisodeCursor>,
    /// The kinds of episodes that are counted: all, those of a class of the taxonomy, and the primary ones of these.
    kinds: [EpisodeFilter; 3],
    /// How many of each kind were taken.
    taken: [u64; 3],
}

fn kinds(taxonomy: &Taxonomy) -> [EpisodeFilter; 3] {
    let classes = taxonomy.ids().iter().map(ToString::to_string).collect();
    let known = EpisodeFilter { classes: Some(classes), ..EpisodeFilter::default() };
    [EpisodeFilter::default(), known.clone(), EpisodeFilter { primary_only: true, ..known }]
}

impl<'a> Episodes<'a> {
    fn of(app: &'a App, request: &'a CreateTasks) -> Answer<Self> {
        let mut all = Self {
            app,
            mined: request.mined.as_deref(),
            ready: [].into(),
            next: None,
            kinds: kinds(&app.framework.taxonomy),
            taken: [0; 3],
        };
        match (&request.mined, request.episodes.is_empty()) {
            // A mined folder is already in this order.
            (Some(_), true) => all.read()?,
            (None, false) if request.episodes.len() > MOST_EPISODES => {
                return Err(Problem::request(
                    format!("一次请求至多 {MOST_EPISODES} 个事件"),
                    format!("at most {MOST_EPISODES} episodes in one request"),
                ));
            }
            (None, false) => {
                let mut sent = request.episodes.clone();
                sent.sort_by(|a, b| {
                    (&a.drive_id, a.keyframe.timestamp).cmp(&(&b.drive_id, b.keyframe.timestamp))
                });
                all.ready = sent.into();
            }
            _ => {
                return Err(Problem::request(
                    "episodes 与 mined 须给出且仅给出其一",
                    "give either episodes or mined",
                ));
            }
        }
        Ok(all)
    }

    fn next(&mut self) -> Answer<Option<EpisodeRecord>> {
        if self.ready.is_empty() && self.next.is_some() {
            self.read()?;
        }
        let episode = self.ready.pop_front();
        if let Some(episode) = &episode {
            for (n, kind) in self.taken.iter_mut().zip(&self.kinds) {
                *n += u64::from(kind.accepts(episode));
            }
        }
        Ok(episode)
    }

    /// Makes an episode the next one again.
    fn put_back(&mut self, episode: EpisodeRecord) {
        for (n, kind) in self.taken.iter_mut().zip(&self.kinds) {
            *n -= u64::from(kind.accepts(&episode));
        }
        self.ready.push_front(episode);
    }

    fn read(&mut self) -> Answer<()> {
        let Some(name) = self.mined else { return Ok(()) };
        let page =
            self.app.recordings.episodes(name, &EpisodeFilter::default(), self.next, EPISODES_PER_PAGE);
        let page = page.ok_or_else(Problem::missing)?.map_err(Problem::mined_unreadable)?;
        self.ready = page.episodes.into();
        self.next = page.next;
        Ok(())
    }

    /// Numbers of episodes that were not taken, of each kind.
    fn remaining(&self) -> Answer<[u32; 3]> {
        let mut out = [0; 3];
        for ((n, kind), taken) in out.iter_mut().zip(&self.kinds).zip(self.taken) {
            let remaining = match self.mined {
                None => self.ready.iter().filter(|e| kind.accepts(e)).count() as u64,
                Some(name) => {
                    let all = self.app.recordings.episode_count(name, kind);
                    let all = all.ok_or_else(Problem::missing)?.map_err(Problem::mined_unreadable)?;
                    all.saturating_sub(taken)
                }
            };
            *n = u32::try_from(remaining).unwrap_or(u32::MAX);
        }
        Ok(out)
    }
}

fn is_known(app: &App, project: &str, episode: &str) -> Answer<bool> {
    // Also one whose tasks were finished and have been removed since.
    let sql = "SELECT 1 FROM tasks WHERE project_id = $1 AND episode_id = $2
               UNION ALL SELECT 1 FROM finished_episodes WHERE project_id = $1 AND episode_id = $2 LIMIT 1";
    app.store.read(|tx| Ok(tx.row(sql, values![project, episode])?.is_some()))
}

/// The time range of the last used drive: first and last frame.
#[derive(Default)]
struct LastSpan(Option<(DriveId, (Nanos, Nanos))>);

impl LastSpan {
    /// The time range of the drive of `episode`; an error text when it is unavailable, or the episode is outside it.
    fn of(&mut self, app: &App, episode: &EpisodeRecord) -> Result<(Nanos, Nanos), Bilingual> {
        let known = self.0.take().filter(|(id, _)| *id == episode.drive_id);
        let (_, span) = match known {
            Some(known) => self.0.insert(known),
            None => {
                let span = app.recordings.span(&episode.drive_id).map_err(unavailable)?;
                self.0.insert((episode.drive_id.clone(), span))
            }
        };
        within(episode, Some(*span)).map(|()| *span)
    }
}

/// An error text when the keyframe of `episode` is outside `span`; `None` is a drive without frames.
fn within(episode: &EpisodeRecord, span: Option<(Nanos, Nanos)>) -> Result<(), Bilingual> {
    let at = episode.keyframe.timestamp;
    if span.is_some_and(|(first, last)| first <= at && at <= last) {
        return Ok(());
    }
    Err(Bilingual::new(format!("关键帧 {at} 不在行程内"), format!("its keyframe {at} is outside the drive")))
}

fn unavailable(why: Bilingual) -> Bilingual {
    Bilingual { zh: format!("行程不可用：{}", why.zh), ..why }
}

/// The last used drive: episodes are sorted by drive, so each drive is read and its signals are derived once.
#[derive(Default)]
pub struct LastDrive(Option<Source>);

/// A drive, and its signals once they were requested.
struct Source {
    drive: Arc<Drive>,
    signals: OnceCell<SignalTable>,
}

impl LastDrive {
    /// The drive of `episode`; an error text when it is unavailable, or when the episode is outside it.
    fn of(&mut self, app: &App, episode: &EpisodeRecord) -> Result<&Source, Bilingual> {
        let source = match self.0.take().filter(|s| s.drive.meta.drive_id == episode.drive_id) {
            Some(source) => source,
            None => {
                let drive = app.recordings.drive(&episode.drive_id).map_err(unavailable)?;
                Source { drive, signals: OnceCell::new() }
            }
        };
        let source = self.0.insert(source);
        within(episode, span_of(&source.drive.times).ok())?;
        Ok(source)
    }
}

impl Source {
    fn signals(&self, app: &App) -> &SignalTable {
        self.signals.get_or_init(|| app.recordings.whole_signals(&self.drive))
    }

    /// The drive as it was known at the keyframe: at that moment itself, positions and classes of objects may rest on
    /// later measurements.
    fn picture(&self, episode: &EpisodeRecord) -> String {
        let at = episode.keyframe.timestamp;
        thumbnail::draw(&self.drive.until(at), at, episode.target_id.as_ref())
    }
}

/// A task for an episode, not yet stored; with `draft` instead of the rule's draft, if there is one.
pub fn prepare(
    app: &App,
    project: &Project,
    episode: &EpisodeRecord,
    draft: Option<Value>,
    last: &mut LastDrive,
) -> Answer<TaskRow> {
    let source = last.of(app, episode).map_err(missing)?;
    let imported = draft.is_some();
    let start = match draft {
        // Nothing is derived that would be discarded.
        Some(draft) => Start::drafted(source, episode, imported::known_then(draft, &episode.keyframe)),
        None => Start::derived(app, project, source, episode, "")?,
    };
    Ok(TaskRow { imported, ..row(app, project, episode, String::new(), start)? })
}

fn missing(why: Bilingual) -> Problem {
    Problem::new(422, "drive.missing", why.zh, why.en)
}

/// A task for an episode, not yet stored, without decision, components and text: for a class of which no rule found it.
pub fn undrafted(app: &App, project: &Project, episode: &EpisodeRecord, lang: &str) -> Answer<TaskRow> {
    let mut last = LastDrive::default();
    let source = last.of(app, episode).map_err(missing)?;
    let words = if lang.is_empty() { &project.settings.lang } else { lang };
    let words = words.parse().unwrap_or_default();
    let whole = app.recordings.draft(&source.drive, source.signals(app), episode, words, None);
    let bare = CocLabel {
        critical_components: vec![],
        causes: None,
        driving_decision: DrivingDecision { longitudinal: None, lateral: None, lateral_direction: None },
        coc_trace: String::new(),
        second_keyframe: None,
        ..whole
    };
    let draft = serde_json::to_value(bare).map_err(Problem::store)?;
    row(app, project, episode, lang.to_owned(), Start::drafted(source, episode, draft))
}

/// A task for an episode, not yet stored, with the rule's draft.
pub fn drafted(app: &App, project: &Project, episode: &EpisodeRecord) -> Answer<TaskRow> {
    let start = start_of(app, project, episode, "", &mut LastDrive::default())?;
    row(app, project, episode, String::new(), start)
}

/// An episode as a task that is not stored: for showing it.
pub fn shown(app: &App, project: &Project, episode: &EpisodeRecord) -> Answer<TaskRow> {
    let mut last = LastDrive::default();
    let source = last.of(app, episode).map_err(missing)?;
    let draft = serde_json::json!({
        (name::KEYFRAME): episode.keyframe, (name::TIME_RANGE): episode.time_range,
    });
    row(app, project, episode, String::new(), Start::drafted(source, episode, draft))
}

/// Initial content of a pending task, in the language of its task or else of its project.
pub fn start_of(
    app: &App,
    project: &Project,
    episode: &EpisodeRecord,
    lang: &str,
    last: &mut LastDrive,
) -> Answer<Start> {
    let source = last.of(app, episode).map_err(missing)?;
    Start::derived(app, project, source, episode, lang)
}

/// The labeling spec of an L3 class, or of an L2 for its tasks of unknown variant.
pub fn spec_of<'f>(framework: &'f Framework, class: &ScenarioId) -> Option<&'f ResolvedSpec> {
    framework.specs.get(class).or_else(|| framework.l2_specs.get(class))
}

/// True if Stage I of `project` does not show the L3 class of `episode`.
fn hides_leaf(app: &App, project: &Project, episode: &EpisodeRecord) -> bool {
    veil::classes(app.framework, &project.settings).contains(veil::l2(&episode.scenario_id.to_string()))
}

/// Initial content of a new task, computed from its drive.
pub struct Start {
    /// The draft of its label.
    pub draft: Value,
    /// A thumbnail of its keyframe; empty if there is none.
    pub thumbnail: String,
    /// Both are still to be created, in the background.
    pub pending: bool,
}

impl Start {
    fn pending() -> Self {
        Self { draft: Value::Object(serde_json::Map::new()), thumbnail: String::new(), pending: true }
    }

    fn drafted(source: &Source, episode: &EpisodeRecord, draft: Value) -> Self {
        Self { draft: unanswered(draft), thumbnail: source.picture(episode), pending: false }
    }

    /// With the rule's draft, in `lang` or else the language of `project`.
    fn derived(
        app: &App,
        project: &Project,
        source: &Source,
        episode: &EpisodeRecord,
        lang: &str,
    ) -> Answer<Self> {
        let words = if lang.is_empty() { &project.settings.lang } else { lang };
        let hides = hides_leaf(app, project, episode);
        let draft = draft(app, source, episode, words.parse().unwrap_or_default(), hides)?;
        Ok(Self { draft, thumbnail: source.picture(episode), pending: false })
    }
}

fn row(app: &App, project: &Project, episode: &EpisodeRecord, lang: String, start: Start) -> Answer<TaskRow> {
    let veiled = hides_leaf(app, project, episode);
    let Start { draft: initial, thumbnail, pending } = start;
    let keyframe = episode.keyframe.timestamp;
    let pack = spec_of(app.framework, &episode.scenario_id).map(|s| s.pack.clone());
    let PackSpec { before_s, after_s, .. } = pack.unwrap_or_default();
    let range = &episode.time_range;
    let from = range.start_timestamp.plus_secs(-before_s).min(keyframe.plus_secs(-HISTORY_S));
    let to = range.end_timestamp.plus_secs(after_s).max(keyframe.plus_secs(FUTURE_S));
    let now = app.now();
    Ok(TaskRow {
        id: secret::id()?,
        project: project.id.clone(),
        overlap_index: 0,
        overlap_count: 1,
        drive_id: episode.drive_id.to_string(),
        clip_id: episode.clip_id.to_string(),
        scenario_id: episode.scenario_id.to_string(),
        keyframe_ns: keyframe.0,
        from_ns: from.0,
        to_ns: to.0,
        episode: episode.clone(),
        draft: initial.clone(),
        initial,
        version: 1,
        priority: 0,
        at: Position::open(),
        audited: false,
        adjudication: None,
        assigned: None,
        fence: 0,
        lease_until: None,
        seq: 0,
        created: now,
        updated: now,
        lang,
        asks_lead: false,
        disagrees: false,
        to_choose: false,
        pictured: false,
        imported: false,
        pending,
        veiled,
        right_class: None,
        replaced_by: None,
        replaces: None,
        findings: Default::default(),
        thumbnail,
    })
}

/// A model's draft as the initial draft of a task. Components are evident by the keyframe, whatever the model states;
/// if Stage I does not show the L3 class, the draft starts without components, as for every such task.
pub fn by_model(mut label: CocLabel, veiled: bool) -> Answer<Value> {
    let keyframe = label.keyframe.timestamp;
    for c in &mut label.critical_components {
        c.evidence_times.iter_mut().for_each(|at| *at = (*at).min(keyframe));
    }
    if veiled {
        label.critical_components.clear();
        label.causes = None;
    }
    serde_json::to_value(label).map(unanswered).map_err(Problem::store)
}

/// A draft without the safety filter's answer that somebody gave elsewhere.
fn unanswered(mut draft: Value) -> Value {
    if let Some(fields) = draft.as_object_mut() {
        fields.remove(name::SAFETY_FILTER);
    }
    draft
}

fn draft(app: &App, source: &Source, episode: &EpisodeRecord, lang: Lang, hides_leaf: bool) -> Answer<Value> {
    let whole = |listed: Option<&[_]>| {
        app.recordings.draft(&source.drive, source.signals(app), episode, lang, listed)
    };
    let keyframe = episode.keyframe.timestamp;
    let label = if hides_leaf {
        // The rule's components were created for the L3 class; causes refer to them.
        CocLabel { critical_components: vec![], causes: None, ..whole(None) }
    } else {
        // Also for a draft that is rejected because of a later event: Stage I must not reveal that.
        let history = source.drive.until(keyframe);
        let listed = app.recordings.components(&history, &until(episode, keyframe), lang);
        join(whole(Some(&listed)), listed, keyframe)
    };
    serde_json::to_value(label).map_err(Problem::store)
}

/// The episode with the data known at the keyframe.
fn until(episode: &EpisodeRecord, keyframe: Nanos) -> EpisodeRecord {
    let mut e = episode.clone();
    e.time_range.end_timestamp = keyframe;
    e.time_range.end_frame_idx = None;
    e.keyframe.range_end = None;
    e.second_keyframe = None;
    e.ego_response = None;
    e.conditions_matched.clear();
    e
}

/// `whole` with the components that Stage I lists. Causes refer to these; one that refers to something else is removed.
fn join(mut whole: CocLabel, listed: Vec<CriticalComponent>, keyframe: Nanos) -> CocLabel {
    let drafted = std::mem::replace(&mut whole.critical_components, listed);
    let listed = &whole.critical_components;
    let renamed = |id: &String| {
        let of = drafted.iter().find(|c| c.id.as_ref() == Some(id))?;
        let said_alike = listed.iter().find(|c| is_same(c, of) && c.description == of.description);
        said_alike.or_else(|| listed.iter().find(|c| is_same(c, of)))?.id.clone()
    };
    let cause = |c: Cause| {
        let components = c.components.iter().map(renamed).collect::<Option<Vec<_>>>()?;
        Some(Cause { components, ..c })
    };
    whole.causes = whole
        .causes
        .map(|c| Causes { longitudinal: c.longitudinal.and_then(cause), lateral: c.lateral.and_then(cause) });
    for c in &mut whole.critical_components {
        for at in &mut c.evidence_times {
            *at = (*at).min(keyframe);
        }
    }
    whole
}

/// Stores a task and the first entry of its history; false when its episode already has a task.
pub fn store(tx: &mut dyn Tx, mut t: TaskRow, actor: Option<&str>, now: i64) -> Answer<bool> {
    if !tasks::insert(tx, &t)? {
        return Ok(false);
    }
    if t.overlap_count > 1
        && tasks::group(tx, &t.project, &t.episode.episode_id)?.iter().any(TaskRow::is_chosen)
    {
        // A label was chosen before this copy came: it is closed, as the other ones are.
        t.adjudication = Some("superseded".to_owned());
    }
    let entry = Entry { action: "create", actor, ..Entry::default() };
    history::record(tx, &mut t, &entry, now)?;
    tasks::update(tx, &t)?;
    Ok(true)
}

#[cfg(test)]
mod tests;
