//! Browsing and judging mined episodes without labeling. A user who views an episode has seen its drive after the
//! keyframe, and is excluded from Stage I of its tasks like all others who have.

use crate::app::App;
use crate::domain::mined::{
    EpisodeCard, EpisodeCards, MinedEpisode, NewVerdict, SimilarEpisode, SimilarEpisodes, Verdict,
};
use crate::domain::project::Project;
use crate::domain::workflow::{Actor, Role, Seen, State};
use crate::problem::{Answer, Problem};
use crate::recordings::CameraImage;
use crate::secret;
use crate::service::tasks::TaskRow;
use crate::service::{answer, create, scene, seen, texts};
use crate::store::{Row, Store, Tx};
use crate::url::encoded;
use crate::values;
use std::collections::HashMap;
use std::io::Write;
use whyroad_model::messages::{EpisodeCursor, EpisodeFilter, EpisodeRecord, VerdictKind};
use whyroad_model::{DriveId, Nanos, ScenarioId};

/// Number of episodes on a page by default, and the maximum.
const USUAL: usize = 50;
const MOST: usize = 200;
/// Number of episodes read together while searching for one, or for those without a verdict.
const PAGE: usize = 500;
/// Episodes that are not sought further where a page has others.
const FEW: usize = 50;
/// Maximum number of episodes that are skipped for one page of those without a verdict.
const MOST_PASSED: usize = 20_000;

/// Filter of episodes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted<'a> {
    /// A class: L1, L2 or L3.
    pub scenario: Option<&'a str>,
    /// A drive.
    pub drive: Option<&'a str>,
    /// Only those without a verdict of the caller.
    pub unjudged: bool,
    /// Not those that no class explains.
    pub explained: bool,
    /// From the page before.
    pub cursor: Option<&'a str>,
    /// Page length.
    pub limit: Option<&'a str>,
}

/// Identifies one episode: its folder, drive, class and id.
#[derive(Clone, Copy, Debug)]
pub struct EpisodeName<'a> {
    /// Mined folder.
    pub mined: &'a str,
    /// Drive.
    pub drive: &'a str,
    /// Class.
    pub scenario: &'a str,
    /// Id.
    pub episode: &'a str,
}

fn class(text: &str) -> Answer<ScenarioId> {
    text.parse().map_err(|_| {
        Problem::request(format!("'{text}' 不是场景编号"), format!("'{text}' is not the id of a class"))
    })
}

/// A page of the episodes of a mined folder.
pub fn page(app: &App, project: &str, mined: &str, user: &str, wanted: &Wanted<'_>) -> Answer<EpisodeCards> {
    let limit = match wanted.limit {
        None => USUAL,
        Some(text) => text.parse().ok().filter(|n| (1..=MOST).contains(n)).ok_or_else(|| {
            Problem::request(format!("limit 须为 1 至 {MOST}"), format!("limit must be 1 to {MOST}"))
        })?,
    };
    let filter = EpisodeFilter {
        scenario: wanted.scenario.map(class).transpose()?,
        drive: wanted.drive.map(DriveId::from),
        explained_only: wanted.explained,
        ..EpisodeFilter::default()
    };
    not_in_hand(app, mined, user, filter.drive.as_ref())?;
    let bad = || Problem::request("cursor 无效", "cursor is invalid");
    let mut next = wanted.cursor.map(|c| c.parse().map(EpisodeCursor).map_err(|_| bad())).transpose()?;
    let total = match wanted.cursor {
        Some(_) => None,
        None => Some(
            app.recordings
                .episode_count(mined, &filter)
                .ok_or_else(Problem::missing)?
                .map_err(Problem::mined_unreadable)?,
        ),
    };
    let mut items = Vec::new();
    let mut passed = 0;
    loop {
        // Never more than needed is read: the folder returns the position of the next page. A page for which only a few
        // are missing stays short, since they would be sought a few at a time.
        let n = if wanted.unjudged { (limit - items.len()).min(PAGE) } else { limit };
        let page = app.recordings.episodes(mined, &filter, next, n).ok_or_else(Problem::missing)?;
        let page = page.map_err(Problem::mined_unreadable)?;
        passed += page.episodes.len();
        let cards = cards(app, project, user, &page.episodes)?;
        items.extend(cards.into_iter().filter(|c| !wanted.unjudged || c.verdict.is_none()));
        next = page.next;
        let few = !items.is_empty() && limit - items.len() < FEW;
        if next.is_none() || few || passed >= MOST_PASSED || !wanted.unjudged {
            break;
        }
    }
    Ok(EpisodeCards { items, total, next: next.map(|c| c.0.to_string()) })
}

/// Refuses what a folder states about episodes, their class, range and score, to a user who does Stage I of a drive in
/// it; of `only` this drive, if one is given.
fn not_in_hand(app: &App, mined: &str, user: &str, only: Option<&DriveId>) -> Answer<()> {
    seen::not_in_hand(&app.store, user, |drive| {
        if only.is_some_and(|only| only != drive) {
            return Ok(false);
        }
        let filter = EpisodeFilter { drive: Some(drive.clone()), ..EpisodeFilter::default() };
        let count = app.recordings.episode_count(mined, &filter).ok_or_else(Problem::missing)?;
        Ok(count.map_err(Problem::mined_unreadable)? > 0)
    })
}

fn cards(app: &App, project: &str, user: &str, episodes: &[EpisodeRecord]) -> Answer<Vec<EpisodeCard>> {
    let known = app.store.report(|tx| verdicts(tx, project, user, episodes))?;
    let mut starts: HashMap<DriveId, Option<Nanos>> = HashMap::new();
    let mut card = |e: &'_ EpisodeRecord| {
        let start = || app.recordings.span(&e.drive_id).ok().map(|(first, _)| first);
        let start = *starts.entry(e.drive_id.clone()).or_insert_with(start);
        card(e, start, known.get(&e.episode_id).copied())
    };
    Ok(episodes.iter().map(&mut card).collect())
}

/// Verdicts of `user` on these episodes, by episode.
fn verdicts(
    tx: &mut dyn Tx,
    project: &str,
    user: &str,
    episodes: &[EpisodeRecord],
) -> Answer<HashMap<String, VerdictKind>> {
    let mut known: HashMap<String, VerdictKind> = HashMap::new();
    for part in episodes.chunks(100) {
        let holes: Vec<String> = (0..part.len()).map(|i| format!("${}", i + 3)).collect();
        let mut values = vec![project.into(), user.into()];
        values.extend(part.iter().map(|e| (&e.episode_id).into()));
        let sql = format!(
            "SELECT episode_id, verdict FROM verdicts WHERE project_id = $1 AND actor = $2 AND episode_id IN ({})",
            holes.join(", ")
        );
        if part.is_empty() {
            continue;
        }
        for row in tx.rows(&sql, &values)? {
            if let Some(kind) = VerdictKind::from_word(&row.text("verdict")?) {
                known.insert(row.text("episode_id")?, kind);
            }
        }
    }
    Ok(known)
}

fn card(e: &EpisodeRecord, start: Option<Nanos>, verdict: Option<VerdictKind>) -> EpisodeCard {
    EpisodeCard {
        episode_id: e.episode_id.clone(),
        scenario_id: e.scenario_id.to_string(),
        drive_id: e.drive_id.to_string(),
        clip_id: e.clip_id.to_string(),
        keyframe: e.keyframe.timestamp.to_string(),
        keyframe_s: start.map(|start| e.keyframe.timestamp.seconds_since(start)),
        score: e.score,
        calibrated: e.calibrated == Some(true),
        is_primary: e.is_primary,
        verdict,
    }
}

/// The episode with these identifiers.
pub fn find(app: &App, name: EpisodeName<'_>) -> Answer<EpisodeRecord> {
    let filter = EpisodeFilter {
        scenario: Some(class(name.scenario)?),
        drive: Some(name.drive.into()),
        ..EpisodeFilter::default()
    };
    let mut next = None;
    loop {
        let page = app.recordings.episodes(name.mined, &filter, next, PAGE).ok_or_else(Problem::missing)?;
        let page = page.map_err(Problem::mined_unreadable)?;
        if let Some(found) = page.episodes.into_iter().find(|e| e.episode_id == name.episode) {
            return Ok(found);
        }
        next = page.next;
        if next.is_none() {
            return Err(Problem::missing());
        }
    }
}

/// An episode as a task that nobody holds and that is shown completely.
fn as_task(app: &App, project: &Project, episode: &EpisodeRecord) -> Answer<TaskRow> {
    let mut t = create::shown(app, project, episode)?;
    t.id = seen::of_episode(&episode.episode_id);
    t.at.state = State::Submitted;
    Ok(t)
}

/// An episode with its scene; records that `user` has seen it.
pub fn episode(app: &App, project: &Project, name: EpisodeName<'_>, user: &str) -> Answer<MinedEpisode> {
    let found = find(app, name)?;
    let t = as_task(app, project, &found)?;
    let (row, who) = (t.clone(), user.to_owned());
    app.store.write(move |tx| seen::show(tx, &row, &who))?;
    let mut view = (*scene::scene(app, &t)?).clone();
    let mut map = scene::map(app, &t)?;
    // Images of a task have addresses of the task; those of an episode contain its identifiers.
    for camera in &mut view.cameras {
        for frame in &mut camera.frames {
            frame.url = image_url(&project.id, name, &camera.camera, frame.index);
        }
    }
    let precision = f64::from(project.settings.place_precision_m);
    if precision > 0.0 {
        let corner = scene::corner(app, &t, precision)?;
        view.shift(corner);
        map.shift(corner);
    }
    let actor = Actor { id: user.to_owned(), roles: vec![Role::Lead], has_seen: Seen::Future };
    let (task, verdict) = app.store.read(|tx| {
        let mut task = answer::task(app, tx, &t, &actor, vec![])?;
        task.permissions.clear();
        task.take_refused = None;
        task.changed_from_suggestion.clear();
        Ok((task, own(tx, &project.id, &found.episode_id, user)?))
    })?;
    Ok(MinedEpisode { task, keyframe_rule: found.keyframe_rule, scene: view, map, verdict })
}

fn image_url(project: &str, name: EpisodeName<'_>, camera: &str, index: usize) -> String {
    let [mined, camera, drive, scenario, episode] =
        [name.mined, camera, name.drive, name.scenario, name.episode].map(encoded);
    format!(
        "/api/v1/projects/{project}/mined/{mined}/media/{camera}/{index}?drive={drive}&scenario={scenario}&episode={episode}"
    )
}

/// Image `index` of `camera` of an episode. Refused, like the episode, for users who do Stage I of it.
pub fn image(
    app: &App,
    project: &Project,
    (name, user): (EpisodeName<'_>, &str),
    camera: &str,
    index: usize,
) -> Answer<CameraImage> {
    let t = as_task(app, project, &find(app, name)?)?;
    // Images are requested in large numbers: a write only for users who have not opened the episode.
    seen::note(&app.store, &t, user)?;
    scene::image(app, &t, camera, index)
}

/// Records a verdict, or removes it.
pub fn judge(app: &App, project: &str, user: &str, request: &NewVerdict) -> Answer<Option<Verdict>> {
    let name = EpisodeName {
        mined: &request.mined,
        drive: &request.drive,
        scenario: &request.scenario,
        episode: &request.episode,
    };
    not_in_hand(app, name.mined, user, Some(&name.drive.into()))?;
    let e = find(app, name)?;
    let note = texts::reason(request.note.as_deref())?.map(str::to_owned);
    let moved = match (request.verdict, &request.keyframe) {
        (Some(VerdictKind::KeyframeMoved), Some(text)) => Some(Nanos::parse_iso(text).map_err(|_| {
            Problem::request(format!("'{text}' 不是时刻"), format!("'{text}' is not a moment"))
        })?),
        (Some(VerdictKind::KeyframeMoved), None) => {
            return Err(Problem::request("缺少正确的关键帧", "the correct keyframe is missing"));
        }
        _ => None,
    };
    let leaf = request.leaf.as_ref().filter(|_| request.verdict == Some(VerdictKind::WrongLeaf));
    if let Some(leaf) = leaf
        && !app.framework.taxonomy.contains(&class(leaf)?)
    {
        return Err(Problem::request(
            format!("'{leaf}' 不是场景分类"),
            format!("'{leaf}' is not a class of the taxonomy"),
        ));
    }
    let id = secret::hash(&format!("{project}\n{}\n{user}", e.episode_id));
    let (project, user, leaf, request, now) =
        (project.to_owned(), user.to_owned(), leaf.cloned(), request.clone(), app.now());
    app.store.write(move |tx| {
        tx.run("DELETE FROM verdicts WHERE id = $1", values![&id])?;
        let Some(verdict) = request.verdict else { return Ok(None) };
        tx.run(
            "INSERT INTO verdicts (id, project_id, mined, episode_id, drive_id, scenario_id, target_id, start_ns,
               keyframe_ns, end_ns, score, verdict, leaf, moved_ns, note, actor, at)
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17)",
            values![
                &id, &project, &request.mined, &e.episode_id, e.drive_id.as_str(), e.scenario_id.to_string(),
                e.target_id.as_ref().map(ToString::to_string), e.time_range.start_timestamp.0, e.keyframe.timestamp.0,
                e.time_range.end_timestamp.0, e.score.to_string(), verdict.word(), leaf.as_ref(), moved.map(|t| t.0),
                note.as_ref(), &user, now,
            ],
        )?;
        own(tx, &project, &e.episode_id, &user)
    })
}

const COLUMNS: &str = "v.mined, v.episode_id, v.drive_id, v.scenario_id, v.target_id, v.start_ns, v.keyframe_ns, v.end_ns, \
    v.score, v.verdict, v.leaf, v.moved_ns, v.note, u.name AS person, v.at";

fn verdict(row: &Row) -> Answer<Verdict> {
    let word = row.text("verdict")?;
    Ok(Verdict {
        verdict: VerdictKind::from_word(&word).ok_or_else(|| Problem::store(format!("verdict '{word}'")))?,
        mined: row.text("mined")?,
        episode_id: row.text("episode_id")?,
        drive_id: row.text("drive_id")?,
        scenario_id: row.text("scenario_id")?,
        target_id: row.maybe_text("target_id")?,
        start_ns: row.int("start_ns")?,
        keyframe_ns: row.int("keyframe_ns")?,
        end_ns: row.int("end_ns")?,
        score: row.text("score")?.parse().map_err(Problem::store)?,
        right_scenario_id: row.maybe_text("leaf")?,
        right_keyframe_ns: row.maybe_int("moved_ns")?,
        note: row.maybe_text("note")?,
        by: row.text("person")?,
        at: row.int("at")?,
    })
}

fn own(tx: &mut dyn Tx, project: &str, episode: &str, user: &str) -> Answer<Option<Verdict>> {
    let sql = format!(
        "SELECT {COLUMNS} FROM verdicts v JOIN users u ON u.id = v.actor
         WHERE v.project_id = $1 AND v.episode_id = $2 AND v.actor = $3"
    );
    tx.row(&sql, values![project, episode, user])?.as_ref().map(verdict).transpose()
}

/// Format of exported verdicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VerdictFormat {
    /// One JSON object per line: the input of the command line.
    JsonLines,
    /// A table with the same columns.
    Csv,
}

impl VerdictFormat {
    /// From the value in a request.
    pub fn from_word(word: Option<&str>) -> Answer<Self> {
        match word {
            None | Some("json" | "jsonl") => Ok(Self::JsonLines),
            Some("csv") => Ok(Self::Csv),
            Some(other) => Err(Problem::request(
                format!("'{other}' 不是导出格式：json 或 csv"),
                format!("'{other}' is not an export format (json or csv)"),
            )),
        }
    }
}

/// Columns of the table, in the order of the JSON object.
const CSV_COLUMNS: [&str; 15] = [
    "verdict",
    "mined",
    "episode_id",
    "drive_id",
    "scenario_id",
    "target_id",
    "start_ns",
    "keyframe_ns",
    "end_ns",
    "score",
    "right_scenario_id",
    "right_keyframe_ns",
    "note",
    "by",
    "at",
];

/// Writes all verdicts of a project, by drive and keyframe.
pub fn export_to(store: &Store, project: &str, format: VerdictFormat, out: &mut dyn Write) -> Answer<()> {
    if format == VerdictFormat::Csv {
        writeln!(out, "{}", CSV_COLUMNS.join(",")).map_err(Problem::store)?;
    }
    let mut after: Option<(String, i64, String)> = None;
    loop {
        let (drive, keyframe, id) = after.clone().unwrap_or_default();
        let sql = format!(
            "SELECT v.id, {COLUMNS} FROM verdicts v JOIN users u ON u.id = v.actor
             WHERE v.project_id = $1 AND (v.drive_id, v.keyframe_ns, v.id) > ($2, $3, $4)
             ORDER BY v.drive_id, v.keyframe_ns, v.id LIMIT {PAGE}"
        );
        let keyframe = if after.is_none() { i64::MIN } else { keyframe };
        let rows = store.report(|tx| tx.rows(&sql, values![project, &drive, keyframe, &id]))?;
        let Some(last) = rows.last() else { return Ok(()) };
        after = Some((last.text("drive_id")?, last.int("keyframe_ns")?, last.text("id")?));
        for row in &rows {
            let value = serde_json::to_value(verdict(row)?).map_err(Problem::store)?;
            match format {
                VerdictFormat::JsonLines => writeln!(out, "{value}"),
                VerdictFormat::Csv => {
                    let cells: Vec<String> = CSV_COLUMNS.iter().map(|c| cell(&value[*c])).collect();
                    writeln!(out, "{}", cells.join(","))
                }
            }
            .map_err(Problem::store)?;
        }
    }
}

/// A cell of a table: unknown is empty; a text that a spreadsheet would read as a formula is escaped.
fn cell(value: &serde_json::Value) -> String {
    let text = match value {
        serde_json::Value::Null => return String::new(),
        serde_json::Value::String(s) if s.starts_with(['=', '+', '-', '@', '\t', '\r']) => format!("'{s}"),
        serde_json::Value::String(s) => s.clone(),
        other => other.to_string(),
    };
    if text.contains(['"', ',', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
}

/// Episodes of the same folder that are similar to one.
pub fn similar(
    app: &App,
    project: &str,
    name: EpisodeName<'_>,
    user: &str,
    limit: usize,
) -> Answer<SimilarEpisodes> {
    not_in_hand(app, name.mined, user, None)?;
    let e = find(app, name)?;
    let found = app.recordings.similar(name.mined, &e, limit.clamp(1, MOST)).ok_or_else(Problem::missing)?;
    let found = found.map_err(Problem::mined_unreadable)?;
    let episodes: Vec<EpisodeRecord> = found.nearest.iter().map(|(e, _)| e.clone()).collect();
    let items = cards(app, project, user, &episodes)?
        .into_iter()
        .zip(&found.nearest)
        .map(|(episode, (_, similarity))| SimilarEpisode { episode, similarity: *similarity });
    Ok(SimilarEpisodes { items: items.collect(), compared: found.compared })
}
