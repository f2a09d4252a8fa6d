//! `whyroad taxonomy migrate`: migrates labels, tasks and releases when classes are renamed, merged or split.

use crate::output::reason::{cannot_make, cannot_read, cannot_write, exists, no_framework, reason, stop};
use crate::output::{self, Print};
use crate::store_args::KeyArgs;
use crate::{Global, framework_folder};
use anyhow::Context as _;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{SystemTime, UNIX_EPOCH};
use whyroad_dataset::Release;
use whyroad_dataset::carry::{CarriedRelease, carry_release};
use whyroad_framework::Taxonomy;
use whyroad_framework::mapping::{ClassChange, ClassMapping, read_mapping};
use whyroad_label::carry::{Carried, carry, class_of};
use whyroad_model::ids::OTHER;
use whyroad_model::label_fields::name;
use whyroad_model::{Lang, ScenarioId};
use whyroad_server::service::migration::{self, MigratedStore, MigrationRun};

/// Arguments of `whyroad taxonomy migrate`.
#[derive(clap::Args)]
pub(super) struct Args {
    /// Mapping of classes (YAML)
    #[arg(value_name = "MAPPING")]
    mapping: PathBuf,
    /// Write a commented mapping to MAPPING instead
    #[arg(long, conflicts_with_all = ["from", "store", "labels", "release", "out", "dry_run"])]
    init: bool,
    /// Framework folder (or `bundled`) before the change: classes before must be in it
    #[arg(long, value_name = "DIR")]
    from: Option<PathBuf>,
    /// Store of the labeling service: labels.db, the folder with it, or postgres://...
    #[arg(long, value_name = "STORE")]
    store: Option<String>,
    #[command(flatten)]
    key: KeyArgs,
    /// Labels, or tasks of `tasks export --format tasks` (JSON Lines); may be repeated
    #[arg(long, value_name = "FILE")]
    labels: Vec<PathBuf>,
    /// Release; may be repeated
    #[arg(long, value_name = "DIR")]
    release: Vec<PathBuf>,
    /// Folder for new files and releases, with the names of the old ones; the old ones are not changed
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print what would be done, and write nothing
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    print: Print,
}

const TEMPLATE: &str = include_str!("mapping.yaml");

/// Results for a file of labels.
#[derive(Default)]
struct CarriedFile {
    lines: usize,
    moved: BTreeMap<(String, String), u64>,
    /// Lines of which only secondary classes changed.
    secondary: u64,
    /// Line, class before, classes to choose from.
    undecided: Vec<(usize, String, Vec<String>)>,
    /// Line, and a class that neither the mapping nor the taxonomy after it has.
    unknown: Vec<(usize, String)>,
    /// Lines that are not JSON.
    lost: Vec<usize>,
}

/// All results.
#[derive(Default)]
struct Done {
    store: Option<(MigratedStore, Unknown)>,
    files: Vec<(PathBuf, CarriedFile)>,
    releases: Vec<(PathBuf, CarriedRelease, Unknown)>,
}

/// Classes that neither the mapping nor the taxonomy after it has, and how many tasks or samples have them.
type Unknown = BTreeMap<String, u64>;

pub(super) fn run(global: &Global, args: &Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    if args.init {
        return init(&args.mapping, &framework.taxonomy.version, global.lang);
    }
    let before = args.from.as_deref().map(taxonomy).transpose()?;
    let name = args.mapping.display().to_string();
    let text = std::fs::read_to_string(&args.mapping).with_context(|| cannot_read(&name))?;
    let mapping = match read_mapping(&name, &text, before.as_ref(), &framework.taxonomy) {
        Ok(mapping) => mapping.requiring(&framework),
        Err(found) => {
            for d in &found {
                tell!("{}", output::render_text(d, global.lang));
            }
            return Ok(output::FINDINGS);
        }
    };
    if args.store.is_none() && args.labels.is_empty() && args.release.is_empty() {
        return Err(stop(
            "请指定要迁移的内容：--store、--labels 或 --release",
            "state what to migrate: --store, --labels or --release",
        ));
    }
    if args.out.is_none() && !args.dry_run && !(args.labels.is_empty() && args.release.is_empty()) {
        return Err(stop(
            "请用 --out 指定新文件的文件夹，或使用 --dry-run",
            "name a folder for the new files with --out, or use --dry-run",
        ));
    }
    let mut done = Done::default();
    let target = |path: &Path| -> Option<PathBuf> {
        args.out.as_ref().filter(|_| !args.dry_run).map(|out| out.join(path.file_name().unwrap_or_default()))
    };
    for file in &args.labels {
        let after = (&mapping, &framework.taxonomy);
        done.files.push((file.clone(), labels(file, after, target(file).as_deref())?));
    }
    for dir in &args.release {
        let release = Release::open(dir).with_context(|| cannot_read(dir.display()))?;
        if let Some(out) = args.out.as_ref().filter(|_| !args.dry_run) {
            std::fs::create_dir_all(out).with_context(|| cannot_make(out.display()))?;
        }
        let carried = carry_release(&release, &mapping, target(dir).as_deref());
        let carried = carried.with_context(|| {
            reason(format!("无法迁移 {}", dir.display()), format!("cannot migrate {}", dir.display()))
        })?;
        let counts = &release.manifest.counts.by_class;
        let classes =
            counts.iter().map(|(class, by)| (class.clone(), by.values().sum::<usize>() as u64)).collect();
        done.releases.push((dir.clone(), carried, forgotten(classes, &mapping, &framework.taxonomy)));
    }
    if let Some(source) = &args.store {
        let store = args.key.open(source, global.lang)?;
        let run = if args.dry_run { MigrationRun::Dry } else { MigrationRun::Write };
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_millis() as i64);
        let problem = |p| crate::store_args::error(&p, global.lang);
        let classes = migration::classes(&store).map_err(problem)?;
        let migrated = migration::migrate(&store, &mapping, run, now).map_err(problem)?;
        done.store = Some((migrated, forgotten(classes, &mapping, &framework.taxonomy)));
    }
    let lost = done.files.iter().any(|(_, f)| !f.lost.is_empty());
    let unknown = done.files.iter().any(|(_, f)| !f.unknown.is_empty())
        || done.releases.iter().any(|(_, _, unknown)| !unknown.is_empty())
        || done.store.as_ref().is_some_and(|(_, unknown)| !unknown.is_empty());
    let (data, lang) = (json_of(&done, args.dry_run), global.lang);
    args.print.put(&data, || text_of(&done, args.dry_run, lang))?;
    Ok(match (unknown, lost) {
        (true, _) => output::FINDINGS,
        (_, true) => output::lost_input(),
        _ => output::FINE,
    })
}

fn init(path: &Path, version: &str, lang: Lang) -> anyhow::Result<ExitCode> {
    if path.exists() {
        return Err(exists(path.display()));
    }
    std::fs::write(path, TEMPLATE.replace("$VERSION", version))
        .with_context(|| cannot_write(path.display()))?;
    match lang {
        Lang::Zh => say!("映射模板写入 {}", path.display()),
        Lang::En => say!("a commented mapping is in {}", path.display()),
    }
    Ok(output::FINE)
}

fn taxonomy(path: &Path) -> anyhow::Result<Taxonomy> {
    if path == Path::new("bundled") && !path.exists() {
        return Ok(whyroad_framework::Framework::bundled().taxonomy.clone());
    }
    let (framework, _) = framework_folder::read(path)?;
    Ok(framework.with_context(|| no_framework(path.display()))?.taxonomy)
}

/// Migrates a file of JSON lines. Lines of other kinds, and lines that cannot be read, are written unchanged.
fn labels(
    file: &Path,
    (mapping, after): (&ClassMapping, &Taxonomy),
    out: Option<&Path>,
) -> anyhow::Result<CarriedFile> {
    let text = std::fs::read_to_string(file).with_context(|| cannot_read(file.display()))?;
    let is_json = |text: &str| serde_json::from_str::<Value>(text).is_ok();
    if text.lines().find(|l| !l.trim().is_empty()).is_some_and(|first| !is_json(first)) && is_json(&text) {
        let name = file.display();
        return Err(stop(
            format!("{name} 是跨多行的一个 JSON 文档；需要 JSON Lines，每行一个标签（`jq -c . {name}`）"),
            format!(
                "{name} is one JSON document over several lines; JSON Lines are needed, one label per line (`jq -c . {name}`)"
            ),
        ));
    }
    let mut done = CarriedFile::default();
    let mut written = String::with_capacity(text.len());
    for (i, line) in text.lines().enumerate() {
        if line.trim().is_empty() {
            continue;
        }
        done.lines += 1;
        let Ok(mut value) = serde_json::from_str::<Value>(line) else {
            done.lost.push(i + 1);
            written += line;
            written.push('\n');
            continue;
        };
        let carried = one(&mut value, mapping);
        match carried {
            Carried::Same => written += line,
            Carried::Secondary { .. } => {
                done.secondary += 1;
                written += &value.to_string();
            }
            Carried::Moved { from, to } => {
                *done.moved.entry((from.to_string(), to.to_string())).or_default() += 1;
                written += &value.to_string();
            }
            Carried::Undecided { from, parts, .. } => {
                let parts = parts.iter().map(ToString::to_string).collect();
                done.undecided.push((i + 1, from.to_string(), parts));
                written += &value.to_string();
            }
        }
        written.push('\n');
        done.unknown.extend(unknown(&value, after).into_iter().map(|class| (i + 1, class)));
    }
    if let Some(out) = out {
        if let Some(dir) = out.parent() {
            std::fs::create_dir_all(dir).with_context(|| cannot_make(dir.display()))?;
        }
        if out.canonicalize().ok().is_some_and(|o| file.canonicalize().ok() == Some(o)) {
            return Err(stop(
                format!("会覆盖 {}；请用 --out 选择其他文件夹", file.display()),
                format!("{} would be overwritten; choose another folder with --out", file.display()),
            ));
        }
        std::fs::write(out, written).with_context(|| cannot_write(out.display()))?;
    }
    Ok(done)
}

/// Classes of a label, or of a task's draft, that the taxonomy does not have: the mapping forgot them.
fn unknown(value: &Value, after: &Taxonomy) -> Vec<String> {
    let label = value.pointer("/task/draft").unwrap_or(value);
    let listed = label.get(name::SECONDARY_SCENARIOS).and_then(Value::as_array).into_iter().flatten();
    let listed = listed.filter_map(|id| id.as_str()?.parse::<ScenarioId>().ok());
    let all = class_of(label).into_iter().chain(listed);
    all.filter(|id| is_unknown(id, after)).map(|id| id.to_string()).collect()
}

fn is_unknown(id: &ScenarioId, after: &Taxonomy) -> bool {
    // `other` is a class of every level.
    let above = match (id.l2.as_deref(), id.l3.as_deref()) {
        _ if id.l1 == OTHER => return false,
        (Some(OTHER), _) => ScenarioId { l2: None, l3: None, ..id.clone() },
        (_, Some(OTHER)) => ScenarioId { l3: None, ..id.clone() },
        _ => id.clone(),
    };
    !after.contains(&above)
}

/// Of the classes before, those that the mapping forgot: it does not name them, and the taxonomy after does not have
/// them.
fn forgotten(classes: Unknown, mapping: &ClassMapping, after: &Taxonomy) -> Unknown {
    let mut classes = classes;
    classes.retain(|class, _| {
        let id: Option<ScenarioId> = class.parse().ok();
        id.is_some_and(|id| mapping.change(&id).is_none() && is_unknown(&id, after))
    });
    classes
}

/// A label, or a task with its draft and its episode.
fn one(value: &mut Value, mapping: &ClassMapping) -> Carried {
    let Some(task) = value.get_mut("task") else { return carry(mapping, value) };
    let carried = task.get_mut("draft").map_or(Carried::Same, |d| carry(mapping, d));
    if let Some(initial) = task.get_mut("initial") {
        carry(mapping, initial);
    }
    let class = task.pointer("/episode/scenario_id").and_then(Value::as_str).map(str::parse::<ScenarioId>);
    if let Some(Ok(class)) = class {
        let to = match (mapping.change(&class), &carried) {
            (Some(ClassChange::To(to)), _) => Some(to),
            (
                Some(ClassChange::Split(_)),
                Carried::Moved { to, .. } | Carried::Undecided { to, .. } | Carried::Secondary { class: to },
            ) => Some(to.clone()),
            _ => None,
        };
        if let Some(to) = to {
            task["episode"]["scenario_id"] = json!(to.to_string());
        }
    }
    carried
}

fn text_of(done: &Done, dry: bool, lang: Lang) -> String {
    let t = |zh: &'static str, en: &'static str| if lang == Lang::Zh { zh } else { en };
    let mut out = String::new();
    if dry {
        out += t("试运行：没有写入任何内容\n", "dry run: nothing was written\n");
    }
    let moved = |out: &mut String, of: &BTreeMap<(String, String), u64>| {
        for ((from, to), n) in of {
            let _ = writeln!(out, "  {from} -> {to}: {n}");
        }
    };
    let person = t("须由人决定", "for a person to decide");
    let only_secondary = |out: &mut String, n: u64| {
        if n > 0 {
            let _ = writeln!(out, "  {}: {n}", t("仅次要类别变化", "only secondary classes changed"));
        }
    };
    let not_known = t("映射和分类体系中都没有的类别", "in neither the mapping nor the taxonomy");
    let unknown = |out: &mut String, of: &Unknown| {
        for (class, n) in of {
            let _ = writeln!(out, "  {not_known}: {class}: {n}");
        }
    };
    if let Some((s, forgotten)) = &done.store {
        let _ = writeln!(out, "{}", t("标注服务的存储", "store of the labeling service"));
        moved(&mut out, &s.moved);
        unknown(&mut out, forgotten);
        only_secondary(&mut out, s.secondary);
        if s.settings > 0 {
            let _ = writeln!(out, "  {}: {}", t("项目设置", "project settings"), s.settings);
        }
        for (project, what, class) in &s.left {
            let _ = writeln!(out, "  {project}: {what} {class}: {person}");
        }
        let _ = writeln!(out, "  {person}: {}", s.undecided.len());
        for u in &s.undecided {
            let rework = if u.rework { t("，已退回返工", ", returned to its author") } else { "" };
            let _ =
                writeln!(out, "    {} ({}){rework}: {} -> {}", u.task, u.clip, u.from, u.parts.join(" | "));
        }
    }
    for (file, f) in &done.files {
        let _ = writeln!(out, "{} ({} {})", file.display(), f.lines, t("行", "lines"));
        moved(&mut out, &f.moved);
        only_secondary(&mut out, f.secondary);
        for (line, class) in &f.unknown {
            let _ = writeln!(out, "    {}:{line}: {not_known}: {class}", file.display());
        }
        let _ = writeln!(out, "  {person}: {}", f.undecided.len());
        for (line, from, parts) in &f.undecided {
            let _ = writeln!(out, "    {}:{line}: {from} -> {}", file.display(), parts.join(" | "));
        }
        for line in &f.lost {
            let what = t("不是 JSON，原样保留", "not JSON, kept unchanged");
            let _ = writeln!(out, "    {}:{line}: {what}", file.display());
        }
    }
    for (dir, r, forgotten) in &done.releases {
        let _ = writeln!(out, "{} ({} {})", dir.display(), r.samples, t("个样本", "samples"));
        for (from, to) in &r.moved {
            for (to, n) in to {
                let _ = writeln!(out, "  {from} -> {to}: {n}");
            }
        }
        unknown(&mut out, forgotten);
        only_secondary(&mut out, r.secondary);
        let _ = writeln!(out, "  {person}: {}", r.undecided.len());
        for u in &r.undecided {
            let _ =
                writeln!(out, "    {} ({}): {} -> {}", u.sample_id, u.clip_id, u.from, u.parts.join(" | "));
        }
        if !r.repeated.is_empty() {
            let what = t("与另一样本重复，已去除", "now a duplicate of another sample, left out");
            let _ = writeln!(out, "  {what}: {}", r.repeated.len());
        }
    }
    out
}

fn json_of(done: &Done, dry: bool) -> Value {
    let moved = |of: &BTreeMap<(String, String), u64>| -> Vec<Value> {
        of.iter().map(|((from, to), n)| json!({ "from": from, "to": to, "count": n })).collect()
    };
    let unknown = |of: &Unknown| -> Vec<Value> {
        of.iter().map(|(class, n)| json!({ "class": class, "count": n })).collect()
    };
    json!({
        "dry_run": dry,
        "store": done.store.as_ref().map(|(s, forgotten)| json!({
            "moved": moved(&s.moved),
            "unknown": unknown(forgotten),
            "secondary": s.secondary,
            "settings": s.settings,
            "left": s.left.iter().map(|(p, what, class)| json!({ "project": p, "what": what, "class": class }))
                .collect::<Vec<_>>(),
            "undecided": s.undecided.iter().map(|u| json!({
                "task": u.task, "project": u.project, "clip": u.clip, "from": u.from, "parts": u.parts,
                "rework": u.rework,
            })).collect::<Vec<_>>(),
        })),
        "labels": done.files.iter().map(|(file, f)| json!({
            "file": file.display().to_string(), "lines": f.lines, "moved": moved(&f.moved), "lost": f.lost,
            "secondary": f.secondary,
            "unknown": f.unknown.iter().map(|(line, class)| json!({ "line": line, "class": class }))
                .collect::<Vec<_>>(),
            "undecided": f.undecided.iter()
                .map(|(line, from, parts)| json!({ "line": line, "from": from, "parts": parts }))
                .collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "releases": done.releases.iter().map(|(dir, r, forgotten)| json!({
            "release": dir.display().to_string(), "samples": r.samples, "moved": r.moved,
            "secondary": r.secondary,
            "unknown": unknown(forgotten),
            "undecided": r.undecided, "repeated": r.repeated,
        })).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A class that was retired without an entry in the mapping is named; those that are there, and `other`, are not.
    #[test]
    fn classes_that_the_mapping_forgot_are_named() {
        let taxonomy = &whyroad_framework::Framework::bundled().taxonomy;
        let text = TEMPLATE
            .replace("$VERSION", &taxonomy.version)
            .replace("changes: []", "changes: [{ rename: old.cutin.slow, to: reactive_agent.cutin.slow }]");
        let mapping = read_mapping("m.yaml", &text, None, taxonomy).unwrap();
        let classes = [
            ("reactive_agent.cutin.slow", 2),
            ("old.cutin.slow", 5),
            ("reactive_agent.cutin.retired", 3),
            ("reactive_agent.cutin.other", 1),
            ("other", 4),
        ];
        let classes = classes.map(|(id, n)| (id.to_owned(), n)).into();
        let expected: Unknown = [("reactive_agent.cutin.retired".to_owned(), 3)].into();
        assert_eq!(forgotten(classes, &mapping, taxonomy), expected);
    }
}
