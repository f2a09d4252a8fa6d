//! `whyroad tasks`: labeling tasks from episodes, and tasks and labels out of and into the service's store, without
//! the service running (or beside it: the store supports both).

use crate::output::Print;
use crate::output::reason::{cannot_read, no_project, stop};
use crate::recordings::ServiceRecordings;
use crate::store_args::error;
use crate::text_table::width;
use crate::{Global, output, store_args};
use anyhow::Context as _;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use whyroad_lake::Lake;
use whyroad_model::{Bilingual, Lang};
use whyroad_server::App;
use whyroad_server::domain::task::{CreateTasks, Imported, TaskSummary};
use whyroad_server::domain::workflow::State;
use whyroad_server::service::create::Drafting;
use whyroad_server::service::transfer::{self, ExportFormat};
use whyroad_server::service::{by_state, create, projects, sample_window, tasks};
use whyroad_server::store::Store;

/// Arguments of `whyroad tasks`.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// Create tasks from the episodes of a mined folder, and the project if it does not exist
    Create(Create),
    /// List tasks; without --project, the projects with their tasks by state
    List(List),
    /// Write labels or tasks as JSON lines to stdout
    Export(Export),
    /// Read tasks, episodes or labels as JSON lines; labels become drafts
    Import(Import),
}

#[derive(clap::Args)]
struct Create {
    /// Folder that `whyroad mine` wrote
    #[arg(long, value_name = "DIR")]
    from: PathBuf,
    /// Project
    #[arg(long, value_name = "NAME")]
    project: String,
    /// Lake that was mined [default: the folder `lake` beside the mined folder]
    #[arg(long, value_name = "DIR")]
    lake: Option<PathBuf>,
    /// Maximum number of tasks
    #[arg(long, value_name = "N")]
    limit: Option<u32>,
    /// Maximum number of episodes per leaf
    #[arg(long, value_name = "N")]
    per_leaf: Option<u32>,
    /// Annotators per episode (independent)
    #[arg(long, value_name = "N")]
    overlap: Option<u32>,
    /// Priority: greater is sooner
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    priority: i64,
    /// Include secondary episodes
    #[arg(long)]
    secondary: bool,
    /// Include episodes whose keyframe is the first frame of their drive: without any history
    #[arg(long)]
    without_history: bool,
    /// Language of the labels: the queue gives these tasks only to annotators of this language
    #[arg(long, value_name = "LANG", value_parser = ["zh", "en"])]
    label_lang: Option<String>,
    #[command(flatten)]
    print: Print,
    #[command(flatten)]
    store: store_args::StoreArgs,
}

#[derive(clap::Args)]
struct List {
    /// Project
    #[arg(long, value_name = "NAME")]
    project: Option<String>,
    /// Only tasks in this state
    #[arg(long, value_name = "STATE")]
    state: Option<String>,
    #[command(flatten)]
    print: Print,
    #[command(flatten)]
    store: store_args::StoreArgs,
}

#[derive(clap::Args)]
struct Export {
    /// Project
    #[arg(long, value_name = "NAME")]
    project: String,
    /// Labels, or whole tasks with their history
    #[arg(long, alias = "format", default_value = "labels", value_parser = ["labels", "tasks"])]
    content: String,
    /// Format of the labels: 2.1, or 2.0 without what 2.1 added
    #[arg(long, default_value = "2.1", value_parser = ["2.0", "2.1"])]
    format_version: String,
    /// Labels of tasks in these states (separated by commas) instead of the accepted ones
    #[arg(long, value_name = "STATES")]
    state: Option<String>,
    #[command(flatten)]
    store: store_args::StoreArgs,
}

#[derive(clap::Args)]
struct Import {
    /// File of JSON lines
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Project; created if it does not exist
    #[arg(long, value_name = "NAME")]
    project: String,
    /// Lake that has the drives
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Folder that `whyroad mine` wrote: labels of its episodes become drafts of these
    #[arg(long, value_name = "DIR")]
    from: Option<PathBuf>,
    #[command(flatten)]
    print: Print,
    #[command(flatten)]
    store: store_args::StoreArgs,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    match args.what {
        What::Create(a) => create_tasks(global, &a),
        What::List(a) => list(global, &a),
        What::Export(a) => export(global, &a),
        What::Import(a) => import(global, &a),
    }
}

/// The service on `lake`, and the project of this name.
fn service(
    global: &Global,
    store: &store_args::StoreArgs,
    lake: &Path,
    mined: &[PathBuf],
    project: &str,
) -> anyhow::Result<(App, String)> {
    let framework = store_args::framework(global)?;
    let recordings = ServiceRecordings::open(Lake::open(lake)?, framework, mined, &[])?;
    let store = store.open(global.lang)?;
    let app = App::new(store, framework, Arc::new(recordings)).map_err(|p| error(&p, global.lang))?;
    let project = find_or_make(&app, project, global.lang)?;
    Ok((app, project))
}

fn find_or_make(app: &App, name: &str, lang: Lang) -> anyhow::Result<String> {
    let project = store_args::new_project(name, lang)?;
    let now = app.now();
    let found = app.store.write(move |tx| match projects::find(tx, &project.name)? {
        Some(found) => Ok(found.id),
        None => projects::create(tx, &project, now).map(|()| project.id.clone()),
    });
    found.map_err(|p| error(&p, lang))
}

pub(super) fn find(store: &Store, name: &str, lang: Lang) -> anyhow::Result<String> {
    let all = store.read(projects::all).map_err(|p| error(&p, lang))?;
    let names: Vec<&str> = all.iter().map(|p| p.name.as_str()).collect();
    let found = all.iter().find(|p| p.name == name || p.id == name);
    found.map(|p| p.id.clone()).ok_or_else(|| no_project(name, &names))
}

fn create_tasks(global: &Global, a: &Create) -> anyhow::Result<ExitCode> {
    let beside = a.from.parent().map(|d| d.join("lake"));
    let Some(lake) = a.lake.clone().or(beside.filter(|d| d.is_dir())) else {
        return Err(stop(
            format!("{} 旁没有数据湖；请用 --lake 指定", a.from.display()),
            format!("no lake beside {}; name it with --lake", a.from.display()),
        ));
    };
    let (app, project) = service(global, &a.store, &lake, std::slice::from_ref(&a.from), &a.project)?;
    let request = CreateTasks {
        mined: app.recordings.mined().into_iter().next(),
        limit: a.limit,
        per_leaf: a.per_leaf,
        overlap: a.overlap,
        priority: a.priority,
        secondary: a.secondary,
        without_history: a.without_history,
        lang: a.label_lang.clone(),
        ..CreateTasks::default()
    };
    let made =
        create::create(&app, &project, &request, None, Drafting::Now).map_err(|p| error(&p, global.lang))?;
    made.lost.iter().for_each(|l| say!("{}: {}", l.episode, l.text.get(global.lang)));
    let (new, known, left_out) = (made.tasks.len(), made.known, made.left_out);
    let (limit, secondary, no_class) = (made.over_limit, made.secondary, made.no_class);
    let (no_history, short) = (made.no_history, made.short_window);
    let lost = made.lost.len() + made.more as usize;
    let counts = json!({
        "created": new, "already_present": known, "not_selected": left_out, "without_drive": lost,
        "over_limit": limit, "secondary": secondary, "no_class": no_class, "no_history": no_history,
        "short_window": short,
    });
    a.print.put(&counts, || match global.lang {
        Lang::Zh => format!(
            "新建 {new} 个任务；已有 {known}，未选 {left_out}（超出上限 {limit}，次场景 {secondary}，\
             无场景或场景不在分类中 {no_class}，关键帧为行程首帧 {no_history}），行程缺失 {lost}\n"
        ),
        Lang::En => format!(
            "{new} tasks created; {known} already present, {left_out} not selected ({limit} over a limit, \
             {secondary} secondary, {no_class} of no or an unknown class, {no_history} with the first frame of the \
             drive as keyframe), {lost} without a drive\n"
        ),
    })?;
    if short > 0 {
        let (before, after) = (sample_window::HISTORY_S, sample_window::FUTURE_S);
        let text = Bilingual::new(
            format!(
                "其中 {short} 个事件的样本窗口（关键帧前 {before} s、后 {after} s）超出行程：按默认规格（dataset init），\
                 其标注不能成为样本"
            ),
            format!(
                "{short} of these episodes have a sample window ({before} s before the keyframe, {after} s after it) \
                 that reaches beyond the drive: with the default spec (dataset init) their labels cannot become samples"
            ),
        );
        say!("{}", text.get(global.lang));
    }
    Ok(if lost > 0 { output::lost_input() } else { output::FINE })
}

fn list(global: &Global, a: &List) -> anyhow::Result<ExitCode> {
    let problem = |p| error(&p, global.lang);
    let store = a.store.open_existing(global.lang)?;
    let Some(name) = &a.project else {
        let mut all = Vec::new();
        for project in store.read(projects::all).map_err(problem)? {
            let counts = store.read(|tx| by_state::of(tx, &project.id)).map_err(problem)?;
            all.push((project.name, counts));
        }
        let rows: Vec<Value> =
            all.iter().map(|(name, tasks)| json!({ "project": name, "tasks": tasks })).collect();
        a.print.put(&rows, || {
            all.iter().map(|(name, counts)| format!("{name}  {}\n", words(counts, global.lang))).collect()
        })?;
        return Ok(output::FINE);
    };
    let project = find(&store, name, global.lang)?;
    let (rows, names) = store
        .read(|tx| Ok((transfer::tasks_of(tx, &project, a.state.as_deref())?, tasks::names(tx)?)))
        .map_err(problem)?;
    // Whoever reads the store sees what leads see.
    let summary = |t: &tasks::TaskRow| TaskSummary {
        disagrees: t.disagrees,
        to_choose: t.to_choose,
        ..tasks::summary(t, &names)
    };
    let summaries: Vec<_> = rows.iter().map(summary).collect();
    a.print.put(&summaries, || {
        let mut out = String::new();
        for s in &summaries {
            let who = s.assigned_to.as_ref().or(s.author.as_ref()).map_or("-", String::as_str);
            let (state, class, clip) = (listed_as(s, global.lang), &s.scenario_id, &s.clip_id);
            let state = format!("{state}{}", " ".repeat(13_usize.saturating_sub(width(&state))));
            let _ = writeln!(out, "{}  {state}  {class:<44}  {clip:<28}  {who}", s.id);
        }
        out
    })?;
    Ok(output::FINE)
}

/// The state of a task in a list; of a label of an overlap group, what became of it in the choice of a lead.
fn listed_as(s: &TaskSummary, lang: Lang) -> String {
    let choice = match (s.adjudication.as_deref(), s.to_choose, lang) {
        (Some("superseded"), _, Lang::Zh) => "未采用",
        (Some("superseded"), _, Lang::En) => "not chosen",
        (_, true, Lang::Zh) => "待采用",
        (_, true, Lang::En) => "to choose",
        _ => return state_name(s.state.word(), lang),
    };
    choice.to_owned()
}

/// A state of a task for people, as the labeling page names it in Chinese; a word that is no state is as it is.
pub(super) fn state_name(word: &str, lang: Lang) -> String {
    let state = State::from_word(word).filter(|_| lang == Lang::Zh);
    state.map_or_else(|| word.to_owned(), |state| state.name().zh)
}

/// Tasks by state; in Chinese with the words that `--state` takes.
fn words(counts: &BTreeMap<String, i64>, lang: Lang) -> String {
    let of = |(state, n): (&String, &i64)| match lang {
        Lang::Zh => format!("{}（{state}）{n}", state_name(state, lang)),
        Lang::En => format!("{state} {n}"),
    };
    counts.iter().map(of).collect::<Vec<_>>().join(if lang == Lang::Zh { "，" } else { ", " })
}

fn export(global: &Global, a: &Export) -> anyhow::Result<ExitCode> {
    let problem = |p| error(&p, global.lang);
    let store = a.store.open_existing(global.lang)?;
    let project = find(&store, &a.project, global.lang)?;
    let format = ExportFormat::from_words(Some(&a.content), Some(&a.format_version), a.state.as_deref())
        .map_err(problem)?;
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    transfer::export_to(&store, &project, &format, &mut out).map_err(problem)?;
    std::io::Write::flush(&mut out)?;
    if let ExportFormat::Labels(_, transfer::LabelVersion::V2_0) = format {
        say!("{}", transfer::left_out_of_2_0().get(global.lang));
    }
    let episodes = store.report(|tx| transfer::not_chosen(tx, &project, &format)).map_err(problem)?;
    if episodes > 0 {
        tell!("{}", output::render_text(&transfer::report_not_chosen(episodes), global.lang));
    }
    Ok(output::FINE)
}

/// Tasks from lines of tasks, episodes or labels; labels become drafts, of episodes of `mined` where they are about
/// one.
pub(crate) fn import_lines(
    global: &Global,
    store: &store_args::StoreArgs,
    (lake, mined): (&Path, Option<&PathBuf>),
    project: &str,
    lines: &str,
) -> anyhow::Result<Imported> {
    let (app, project) =
        service(global, store, lake, mined.map(std::slice::from_ref).unwrap_or_default(), project)?;
    transfer::import(&app, &project, lines, None).map_err(|p| error(&p, global.lang))
}

fn import(global: &Global, a: &Import) -> anyhow::Result<ExitCode> {
    let text = std::fs::read_to_string(&a.file).with_context(|| cannot_read(a.file.display()))?;
    let made = import_lines(global, &a.store, (&a.lake, a.from.as_ref()), &a.project, &text)?;
    for lost in &made.lost {
        say!("{}:{}: {}", a.file.display(), lost.line, lost.text.get(global.lang));
    }
    let (new, known, lost) = (made.tasks, made.known, made.lost.len() + made.more as usize);
    let counts = json!({ "created": new, "already_present": known, "unreadable_lines": lost });
    a.print.put(&counts, || match global.lang {
        Lang::Zh => format!("新建 {new} 个任务；已有 {known}；无法读取 {lost} 行\n"),
        Lang::En => format!("{new} tasks created; {known} already present; {lost} lines not readable\n"),
    })?;
    Ok(if lost > 0 { output::lost_input() } else { output::FINE })
}

#[cfg(test)]
mod tests {
    use super::{state_name, words};
    use whyroad_dataset::spec::Spec;
    use whyroad_model::Lang;
    use whyroad_server::domain::workflow::State;
    use whyroad_server::service::sample_window::{FUTURE_S, HISTORY_S};

    /// Every state has a Chinese name; in a list of counts the word that `--state` takes is beside it.
    #[test]
    fn states_have_chinese_names() {
        for state in State::ALL {
            let name = state_name(state.word(), Lang::Zh);
            assert!(!name.is_ascii(), "{name}");
            assert_eq!(state_name(state.word(), Lang::En), state.word());
        }
        let counts = [("open".to_owned(), 3), ("submitted".to_owned(), 2)].into();
        assert_eq!(words(&counts, Lang::Zh), "待标注（open）3，待质检（submitted）2");
        assert_eq!(words(&counts, Lang::En), "open 3, submitted 2");
    }

    #[test]
    fn the_window_of_tasks_is_that_of_the_default_spec() {
        let cut = Spec::default().sample;
        assert_eq!((HISTORY_S, FUTURE_S), (cut.history_s, cut.future_s));
    }
}
