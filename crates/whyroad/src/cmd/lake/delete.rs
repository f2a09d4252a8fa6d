//! `whyroad lake delete`: removes drives from a lake and from everything derived from it. The lake is last, so that a
//! repeated deletion after a kill still finds the drives; each step can be repeated.

use super::audit::{self, Deleted};
use super::holders;
use crate::output::reason::{Reason, cannot_read, folders_only, reason};
use crate::output::{Print, render_text};
use crate::{Global, output, store_args};
use anyhow::{Context as _, bail};
use serde::Serialize;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{SystemTime, UNIX_EPOCH};
use whyroad_engine::output::removal;
use whyroad_engine::recordings::LakeRecordings;
use whyroad_lake::mined::Publication;
use whyroad_lake::{Lake, MinedFolder};
use whyroad_model::{DriveId, Lang, Nanos};
use whyroad_server::service::deletion;

/// Arguments of `whyroad lake delete`.
#[derive(clap::Args)]
pub(super) struct Args {
    /// Drives, by id
    #[arg(value_name = "DRIVE", required_unless_present = "older_than")]
    drives: Vec<String>,
    /// Also drives that ended before this time (2026-01-01, or an age such as 180d)
    #[arg(long, value_name = "TIME", value_parser = moment)]
    older_than: Option<Nanos>,
    /// Lake
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Mined folder, or a folder of such folders or of parts; may be repeated
    #[arg(long, value_name = "DIR")]
    mined: Vec<PathBuf>,
    /// Folder outside the lake with camera images of the drives; may be repeated
    #[arg(long, value_name = "DIR")]
    media: Vec<PathBuf>,
    /// Store of the labeling service: a SQLite file, its folder, or postgres://...; its caches are emptied
    #[arg(long, value_name = "URL", env = "WHYROAD_STORE", hide_env_values = true)]
    store: Option<String>,
    /// Folder of the service's data: with a PostgreSQL store, its key file and caches
    #[arg(long, value_name = "DIR", default_value = "whyroad-data", env = "WHYROAD_DATA_DIR")]
    data: PathBuf,
    /// Key file of the store [default: beside the SQLite file, or labels.db.key in --data]
    #[arg(long, value_name = "FILE", env = "WHYROAD_KEY_FILE")]
    key_file: Option<PathBuf>,
    /// Folder in which to look for releases that hold the drives; may be repeated
    #[arg(long, value_name = "DIR")]
    releases: Vec<PathBuf>,
    /// Backup, or folder of backups, in which to look for the drives; may be repeated
    #[arg(long, value_name = "PATH")]
    backups: Vec<PathBuf>,
    /// Audit file [default: deletions.jsonl in the lake]
    #[arg(long, value_name = "FILE")]
    audit: Option<PathBuf>,
    /// Number of the request, for the audit file; no personal data
    #[arg(long, value_name = "REF", value_parser = audit::reference)]
    request: Option<String>,
    /// Print what would be deleted, and delete nothing
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    print: Print,
}

pub(super) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let lang = global.lang;
    let lake = match Lake::open(&args.lake) {
        Ok(lake) => lake,
        Err(e) => {
            tell!("{}", render_text(&e.diagnostic(), lang));
            return Ok(output::FINDINGS);
        }
    };
    folders_only(args.mined.iter().chain(&args.media).chain(&args.releases).chain(&args.backups))?;
    let (drives, undated) = selected(&lake, &args);
    let folders = mined_folders(&args.mined)?;
    let open = |s| store_args::open_store_with(s, &args.data, args.key_file.clone(), lang);
    let store = args.store.as_deref().map(open).transpose()?;
    let service = args.store.as_deref().and_then(|store| service_folder(store, &args.data));

    let mut counts = Deleted { drives: drives.len(), unsearched: undated, ..Deleted::default() };
    let mut backups = args.backups.clone();
    backups.extend(service.iter().flat_map(|dir| kept_stores(dir)));
    let mut take = |holders: holders::Holders| {
        counts.unsearched.extend(holders.unsearched);
        holders.found
    };
    let releases = take(holders::releases(&args.releases, &drives));
    let backups = take(holders::backups(&backups, &drives));
    let parts = take(holders::parts(&args.mined, &drives));
    (counts.releases, counts.backups, counts.parts) = (releases, backups, parts);

    let images = outside_images(&lake, &args.media, &drives)?;
    counts.images = (!args.media.is_empty()).then_some(images.len());
    if store.is_some() {
        (counts.tasks, counts.store_rows) = (Some(0), Some(0));
    }
    if !args.mined.is_empty() {
        (counts.mined_folders, counts.episodes) = (Some(0), Some(0));
    }
    let mut unknown = Vec::new();
    for id in &drives {
        let in_lake = lake.holds(id);
        let rows = match &store {
            Some(store) => deletion::held(store, id).map_err(|p| store_args::error(&p, lang))?,
            None => deletion::DriveRows::default(),
        };
        counts.lake_drives += usize::from(in_lake);
        counts.tasks = counts.tasks.map(|n| n + rows.tasks);
        counts.store_rows = counts.store_rows.map(|n| n + rows.other);
        if !in_lake && rows == deletion::DriveRows::default() {
            unknown.push(id);
        }
    }
    let mut mined = BTreeSet::new();
    for folder in &folders {
        let held = removal::held(folder, &drives)?;
        if held.drives > 0 {
            counts.mined_folders = counts.mined_folders.map(|n| n + 1);
            counts.episodes = counts.episodes.map(|n| n + held.episodes);
            mined.extend(folder.coverage().map(|c| c.drives).unwrap_or_default());
        }
    }
    unknown.retain(|id| !mined.contains(*id));
    let file = args.audit.clone().unwrap_or_else(|| lake.dir().join("deletions.jsonl"));
    // After a kill, those that it had deleted completely are not found any more.
    if audit::unfinished(&file) {
        unknown.clear();
    }
    let not_found: Vec<String> = unknown.iter().map(ToString::to_string).collect();
    // What was nowhere was not deleted: the audit file counts drives of which something was found.
    counts.drives = drives.len() - not_found.len();
    if !not_found.is_empty() && not_found.len() == drives.len() {
        bail!(nothing_of(&not_found.join(", "), lang));
    }
    let ids: Vec<&DriveId> = drives.iter().filter(|id| !not_found.contains(&id.0)).collect();
    if args.dry_run {
        let report = Report { counts: &counts, drive_ids: &ids, not_found: &not_found };
        args.print.put(&report, || text(&counts, &not_found, true, lang) + &listed(&ids, lang))?;
        return Ok(outcome(&counts, &not_found));
    }

    audit::put(&file, "begun", args.request.as_deref(), &counts)?;
    lake.publish()?;
    let mut purged = true;
    if let Some(store) = &store {
        for id in &drives {
            deletion::delete_drive(store, id).map_err(|p| store_args::error(&p, lang))?;
        }
        purged = store.purge().map_err(|p| store_args::error(&p, lang))?;
        if !purged {
            counts.unsearched.push(store_in_use(lang));
        }
    }
    for folder in &folders {
        // A killed run may have left the previous version of the folder beside it.
        Publication::sweep(folder.dir())?;
        removal::remove(folder, &drives)?;
    }
    if let Some(dir) = &service {
        empty(&dir.join("blurred"))?;
    }
    for image in &images {
        std::fs::remove_file(image).with_context(|| {
            reason(format!("无法删除 {}", image.display()), format!("cannot remove {}", image.display()))
        })?;
    }
    lake.remove_drives(&drives)?;
    lake.publish_removal()?;
    // Otherwise the same command, run again, would continue with it.
    if purged {
        audit::put(&file, "done", args.request.as_deref(), &counts)?;
    }
    lake.publish()?;
    let report = Report { counts: &counts, drive_ids: &ids, not_found: &not_found };
    args.print.put(&report, || text(&counts, &not_found, false, lang))?;
    Ok(outcome(&counts, &not_found))
}

/// What is printed; unlike the audit file it names drives.
#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    counts: &'a Deleted,
    /// The drives.
    drive_ids: &'a [&'a DriveId],
    /// Drives of which nothing was found in the places given.
    not_found: &'a [String],
}

/// The drives that would be deleted, one per line.
fn listed(ids: &[&DriveId], lang: Lang) -> String {
    let head = if lang == Lang::Zh { "将删除的行程" } else { "drives that would be deleted" };
    ids.iter().fold(format!("{head}:\n"), |out, id| out + &format!("  {id}\n"))
}

/// The named drives, and those that ended before a time; also the drives without a time.
fn selected(lake: &Lake, args: &Args) -> (BTreeSet<DriveId>, Vec<String>) {
    let mut drives: BTreeSet<DriveId> = args.drives.iter().map(|d| DriveId::from(d.as_str())).collect();
    let mut undated = Vec::new();
    if let Some(before) = args.older_than {
        for (id, entry) in lake.entries() {
            match entry.and_then(|e| Ok((lake.is_dated(&e)?, e.end))) {
                Ok((true, end)) if end < before => {
                    drives.insert(id);
                }
                Ok((true, _)) => {}
                // Times of such a drive count from an invented start.
                Ok((false, _)) => undated.push(format!("{id}: date unknown")),
                Err(_) => undated.push(format!("{id}: end unknown")),
            }
        }
    }
    (drives, undated)
}

/// The mined folders at or directly below each folder; parts are searched separately.
fn mined_folders(dirs: &[PathBuf]) -> anyhow::Result<Vec<MinedFolder>> {
    let mut out = Vec::new();
    for dir in dirs {
        let found = MinedFolder::find(dir).with_context(|| cannot_read(dir.display()))?;
        out.extend(found.into_values());
    }
    Ok(out)
}

/// The folder in which a service keeps its caches: that of its SQLite file, or `data`.
fn service_folder(store: &str, data: &Path) -> Option<PathBuf> {
    use whyroad_server::store::StoreLocation;
    match StoreLocation::parse(store) {
        StoreLocation::File(path) if path.is_dir() => Some(path),
        StoreLocation::File(path) => path.parent().map(Path::to_path_buf),
        StoreLocation::Server(_) => Some(data.to_owned()),
    }
}

/// Copies of the previous store that an upgrade kept.
fn kept_stores(dir: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(dir).into_iter().flatten().flatten();
    entries.filter(|e| e.file_name().to_string_lossy().contains(".before-")).map(|e| e.path()).collect()
}

/// Images that the drives' media tables name and that are in these folders.
fn outside_images(
    lake: &Lake,
    media: &[PathBuf],
    drives: &BTreeSet<DriveId>,
) -> anyhow::Result<Vec<PathBuf>> {
    if media.is_empty() {
        return Ok(vec![]);
    }
    let recordings = LakeRecordings::open(lake.clone(), &[], media)?;
    let own = lake.media_dir().canonicalize().ok();
    let mut out = BTreeSet::new();
    for id in drives {
        for frame in lake.media(id).unwrap_or_default() {
            let path = recordings.media(id, &frame);
            out.extend(path.filter(|p| own.as_ref().is_none_or(|own| !p.starts_with(own))));
        }
    }
    Ok(out.into_iter().collect())
}

/// Removes the files of a cache: the key of an image cannot be derived from the drive.
fn empty(cache: &Path) -> anyhow::Result<()> {
    for entry in std::fs::read_dir(cache).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_file() {
            std::fs::remove_file(&path).with_context(|| {
                reason(format!("无法删除 {}", path.display()), format!("cannot remove {}", path.display()))
            })?;
        }
    }
    Ok(())
}

/// Copies of a drive remain, or it is unknown whether they do, or a name was not found: exit code 1, so that scripts
/// can detect it.
fn outcome(counts: &Deleted, not_found: &[String]) -> ExitCode {
    let rest = [&counts.releases, &counts.backups, &counts.parts, &counts.unsearched];
    let is_all = rest.iter().all(|list| list.is_empty()) && not_found.is_empty();
    if is_all { output::FINE } else { output::FINDINGS }
}

fn text(c: &Deleted, not_found: &[String], dry_run: bool, lang: Lang) -> String {
    let mut out = match (lang, dry_run) {
        (Lang::Zh, true) => "将删除（未作改动）：\n".to_owned(),
        (Lang::Zh, false) => "已删除：\n".to_owned(),
        (Lang::En, true) => "would be deleted (nothing was changed):\n".to_owned(),
        (Lang::En, false) => "deleted:\n".to_owned(),
    };
    let (drives, lake) = (c.drives, c.lake_drives);
    let pick = |zh: String, en: String| if lang == Lang::Zh { zh } else { en };
    let not_given = |zh: &str, en: &str, option: &str| {
        pick(
            format!("{zh}：未检查（未给出 {option}）"),
            format!("{en}: not searched ({option} was not given)"),
        )
    };
    let lines = [
        pick(
            format!("{drives} 个行程，其中数据湖中 {lake} 个"),
            format!("{drives} drives, {lake} of them in the lake"),
        ),
        match (c.mined_folders, c.episodes) {
            (Some(folders), Some(episodes)) => pick(
                format!("{folders} 个挖掘结果文件夹中的 {episodes} 个事件"),
                format!("{episodes} episodes in {folders} mined folders"),
            ),
            _ => not_given("挖掘结果", "mined folders", "--mined"),
        },
        match (c.tasks, c.store_rows) {
            (Some(tasks), Some(rows)) => pick(
                format!("{tasks} 个任务，存储中其他 {rows} 行"),
                format!("{tasks} tasks and {rows} other rows of the store"),
            ),
            _ => not_given("标注服务的存储", "store of the labeling service", "--store"),
        },
        match c.images {
            Some(images) => {
                pick(format!("数据湖以外的 {images} 张图片"), format!("{images} images outside the lake"))
            }
            None => not_given("数据湖以外的图片", "images outside the lake", "--media"),
        },
    ];
    for line in lines {
        let _ = writeln!(out, "  {line}");
    }
    let heads = match lang {
        Lang::Zh => [
            "仍包含这些行程的数据集（未改动）",
            "仍包含的备份（未改动）",
            "仍包含的分片（未改动）",
            "无法检查",
            "所给之处均没有的行程（请核对编号）",
        ],
        Lang::En => [
            "releases that hold them (not changed)",
            "backups that hold them (not changed)",
            "parts that hold them (not changed)",
            "could not be searched",
            "drives of which nothing was found in the places given (check their ids)",
        ],
    };
    let lists: [&[String]; 5] = [&c.releases, &c.backups, &c.parts, &c.unsearched, not_found];
    for (head, list) in heads.iter().zip(lists) {
        if !list.is_empty() {
            let _ = writeln!(out, "{head}:");
            list.iter().for_each(|line| {
                let _ = writeln!(out, "  {line}");
            });
        }
    }
    out
}

fn store_in_use(lang: Lang) -> String {
    match lang {
        Lang::Zh => "存储正被另一进程使用，其文件仍可能含已删除的行；请停止服务后再次运行".to_owned(),
        Lang::En => {
            "the store is in use by another process, and its files may still have the deleted rows; stop the \
                     service and run the command again"
                .to_owned()
        }
    }
}

fn nothing_of(names: &str, lang: Lang) -> String {
    match lang {
        Lang::Zh => format!("所给之处均没有行程 {names}"),
        Lang::En => format!("nothing of {names} was found in the places given"),
    }
}

/// A date, a time, or an age in days.
pub(super) fn moment(text: &str) -> Result<Nanos, Reason> {
    let expected = || {
        reason(
            "应为日期（2026-01-01）、时间或距今的天数（180d）",
            "expected a date (2026-01-01), a time, or an age (180d)",
        )
    };
    if let Some(days) = text.strip_suffix('d').and_then(|n| n.parse::<u32>().ok()) {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_err(|_| expected())?;
        let age = u128::from(days) * 86_400 * 1_000_000_000;
        let then = now.as_nanos().saturating_sub(age);
        return i64::try_from(then).map(Nanos).map_err(|_| expected());
    }
    let full = if text.len() == 10 { format!("{text}T00:00:00Z") } else { text.to_owned() };
    Nanos::parse_iso(&full).map_err(|_| expected())
}
