//! Setup of a new machine: the bundled drives, an initial project, and a way to create the first account that is nobody
//! else's.

use crate::cmd::demo;
use crate::output::reason::Reason;
use crate::{Global, store_args};
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use whyroad_framework::Framework;
use whyroad_lake::{Lake, MinedFolder};
use whyroad_model::Lang;
use whyroad_model::messages::EpisodeFilter;
use whyroad_server::App;
use whyroad_server::domain::project::HistoryRule;
use whyroad_server::domain::task::CreateTasks;
use whyroad_server::service::create::Drafting;
use whyroad_server::service::{create, first_account, people, projects};
use whyroad_server::store::private;

/// How the first account is created.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum FirstAccount {
    /// There are accounts.
    Made,
    /// The first visitor of the page creates it: only this machine can reach it.
    Open,
    /// Anyone with this token creates it, at any service on the store.
    ByToken(String),
}

/// The bundled drives as a lake below `data`, with their mined folder; created when missing.
pub(super) fn bundled(
    global: &Global,
    framework: &Framework,
    data: &Path,
) -> anyhow::Result<(Lake, Vec<PathBuf>)> {
    // The store is created in it later: from the beginning only its owner has access.
    private::folder(data)?;
    let dir = data.join("demo");
    let mined = dir.join("mined");
    let lake = match Lake::open(dir.join("lake")) {
        Ok(lake) if MinedFolder::open(&mined).is_some_and(|folder| folder.index().is_ok()) => lake,
        _ => {
            match global.lang {
                Lang::Zh => say!("没有指定数据湖：准备内置的示例行程（只需一次）"),
                Lang::En => say!("no lake given: preparing the bundled drives (only once)"),
            }
            demo::lake_and_episodes(global, framework, &dir)?
        }
    };
    Ok((lake, vec![mined]))
}

/// Maximum number of episodes for which tasks are made before the service answers.
const MAX_OFFERED: u64 = 500;

/// Gives a store without any project one, with tasks from the bundled drives, so that there is something to open. Only
/// for a service without a user's lake: users with a lake make their own projects.
pub(super) fn offer_project(app: &App, lang: Lang) -> anyhow::Result<()> {
    let problem = |p| store_args::error(&p, lang);
    let Some(mined) = app.recordings.mined().into_iter().next() else { return Ok(()) };
    if !app.store.read(projects::all).map_err(problem)?.is_empty() {
        return Ok(());
    }
    let episodes = app.recordings.episode_count(&mined, &EpisodeFilter::default());
    let episodes = episodes.unwrap_or(Ok(0)).map_err(|why| anyhow::anyhow!(Reason::from(why)))?;
    if episodes > MAX_OFFERED {
        match lang {
            Lang::Zh => {
                say!("{mined} 有 {episodes} 个事件：用 `whyroad tasks create` 或在页面中选取并创建任务")
            }
            Lang::En => say!(
                "{mined} has {episodes} episodes: make tasks from the ones you need with `whyroad tasks create` or in the page"
            ),
        }
        return Ok(());
    }
    let mut project = store_args::new_project("demo", lang)?;
    // A single person labels a few short drives here: with the usual limit per drive the queue would soon be empty.
    project.settings.history = HistoryRule::Episode;
    let (id, now) = (project.id.clone(), app.now());
    app.store.write(move |tx| projects::create(tx, &project, now)).map_err(problem)?;
    let request = CreateTasks { mined: Some(mined), ..CreateTasks::default() };
    let made = create::create(app, &id, &request, None, Drafting::Later).map_err(problem)?;
    match lang {
        Lang::Zh => say!("项目 demo：{} 个任务", made.tasks.len()),
        Lang::En => say!("project demo: {} tasks", made.tasks.len()),
    }
    Ok(())
}

/// Says how a store without any project gets one: users with a lake make their own.
pub(super) fn say_how_to_begin(app: &App, mined: &[PathBuf], lang: Lang) -> anyhow::Result<()> {
    let none = app.store.read(projects::all).map_err(|p| store_args::error(&p, lang))?.is_empty();
    let Some(mined) = mined.first().filter(|_| none) else { return Ok(()) };
    let from = mined.display();
    match lang {
        Lang::Zh => say!(
            "还没有项目：在页面上新建项目并从挖掘结果创建任务，或用 `whyroad tasks create --from {from} --project 名称`"
        ),
        Lang::En => say!(
            "no project yet: create one on the page, with tasks from mined episodes, or use `whyroad tasks create --from {from} --project NAME`"
        ),
    }
    Ok(())
}

/// How the first account is created on a service that is reached at `ip`.
pub(super) fn first_account(app: &mut App, ip: IpAddr, lang: Lang) -> anyhow::Result<FirstAccount> {
    let problem = |p| store_args::error(&p, lang);
    if ip.is_loopback() {
        let is_first = app.store.read(people::is_first_run).map_err(problem)?;
        return Ok(if is_first { FirstAccount::Open } else { FirstAccount::Made });
    }
    let Some(token) = first_account::token(&app.store).map_err(problem)? else {
        return Ok(FirstAccount::Made);
    };
    app.setup_token = Some(token.clone());
    Ok(FirstAccount::ByToken(token))
}
