//! All routes of `/api/v1`. A route that is added here is served, access-checked, documented and tested for
//! authorization.

use super::handlers::{
    accounts, drafts, mined, model, oidc, projects, scenes, session, talk, tasks, transfer, webhooks,
};
use super::route::{Access, BodySize, JSON_LINES, Route};
use crate::domain::{
    gold::*, mined::*, model::*, oidc::*, people::*, project::*, safety::*, scene::*, task::*,
};
use crate::oidc::flow::Returned;
use serde_json::Value;

/// Query parameters that identify a mined episode.
const EPISODE: &[(&str, &str)] = &[
    ("drive", "drive of the episode"),
    ("scenario", "class of the episode"),
    ("episode", "id of the episode"),
];

/// The table.
pub static ROUTES: &[Route] = &[
    // Sessions and accounts.
    Route::get("/session", Access::Anyone, "Who is signed in, and the CSRF value", session::show)
        .gives::<Session>(),
    Route::post("/session", Access::Anyone, "Sign in", session::sign_in).takes::<SignIn>().gives::<Session>(),
    Route::delete("/session", Access::Anyone, "Sign out", session::sign_out).gives::<SignedOut>(),
    Route::post(
        "/setup",
        Access::Anyone,
        "Create the first admin; only while no user exists",
        session::setup,
    )
    .takes::<Setup>()
    .gives::<Session>(),
    Route::post(
        "/oidc/begin",
        Access::Anyone,
        "Start signing in at the identity provider, or linking the caller's account to it",
        oidc::begin,
    )
    .takes::<BeginAtProvider>()
    .gives::<ProviderAddress>(),
    Route::post(
        "/oidc/finish",
        Access::Anyone,
        "Complete it with the parameters with which the provider redirected the browser back",
        oidc::finish,
    )
    .takes::<Returned>()
    .gives::<Session>(),
    Route::get(
        "/identities",
        Access::SignedIn,
        "Identities at the provider that are linked to the caller",
        oidc::list,
    )
    .query(&[("user", "of this user (id); for admins")])
    .gives::<Identities>(),
    Route::delete(
        "/identities/{id}",
        Access::SignedIn,
        "Unlink an identity of the caller, or of any user for admins; sessions that began there end",
        oidc::unlink,
    )
    .in_session_only()
    .gives::<Done>(),
    Route::get(
        "/users",
        Access::SignedIn,
        "Users: all for admins and leads, for others the members of their projects",
        accounts::list,
    )
    .gives::<Users>(),
    Route::post("/users", Access::Admin, "Create a user", accounts::create)
        .takes::<NewUser>()
        .in_session_only()
        .gives::<User>(),
    Route::patch(
        "/users/{u}",
        Access::SignedIn,
        "Change a user: the caller, or any user for admins",
        accounts::change,
    )
    .takes::<UserChange>()
    .in_session_only()
    .gives::<User>(),
    Route::get("/tokens", Access::SignedIn, "Own API tokens", accounts::tokens)
        .query(&[("user", "of this user (id); for admins")])
        .gives::<Tokens>(),
    Route::post("/tokens", Access::SignedIn, "Create an API token", accounts::make_token)
        .takes::<NewToken>()
        .in_session_only()
        .gives::<Token>(),
    Route::delete(
        "/tokens/{id}",
        Access::SignedIn,
        "Revoke an API token of the caller, or of any user for admins",
        accounts::revoke_token,
    )
    .gives::<Done>(),
    // Projects.
    Route::get(
        "/projects",
        Access::SignedIn,
        "Projects of which the caller is a member; all for admins",
        projects::list,
    )
    .gives::<Projects>(),
    Route::post(
        "/projects",
        Access::Admin,
        "Create a project; its creator gets all roles in it",
        projects::create,
    )
    .takes::<NewProject>()
    .gives::<Project>(),
    Route::get("/projects/{p}", Access::Member, "One project", projects::show).gives::<Project>(),
    Route::patch("/projects/{p}", Access::Lead, "Change a project", projects::change)
        .takes::<ProjectChange>()
        .gives::<Project>(),
    Route::get("/projects/{p}/members", Access::Staff, "Members", projects::members).gives::<Members>(),
    Route::post(
        "/projects/{p}/members",
        Access::Lead,
        "Add, change or (without roles) remove a member",
        projects::set_member,
    )
    .takes::<MemberChange>()
    .gives::<Members>(),
    Route::get(
        "/projects/{p}/dashboard",
        Access::Staff,
        "Progress and quality of the project",
        projects::dashboard,
    )
    .gives::<Dashboard>(),
    Route::get(
        "/projects/{p}/analytics",
        Access::Lead,
        "Classes by stage, what is missing, corrections, forecast: the page of `whyroad report`",
        projects::analytics,
    )
    .query(&[("utc_offset", "shift of hours of the day from UTC, whole hours; default 0")])
    .gives::<AnalyticsPage>(),
    Route::get(
        "/projects/{p}/gold",
        Access::Lead,
        "Gold tasks and the results of annotators; hidden from everybody else",
        projects::gold,
    )
    .gives::<GoldReport>(),
    Route::post(
        "/projects/{p}/gold",
        Access::Lead,
        "Create gold tasks: hidden copies of accepted tasks for annotators",
        projects::make_gold,
    )
    .takes::<NewGold>()
    .gives::<MadeGold>(),
    Route::get(
        "/projects/{p}/model-runs",
        Access::Lead,
        "The language model and its runs: drafts and judgments, progress, cost",
        model::show,
    )
    .gives::<ModelWork>(),
    Route::post(
        "/projects/{p}/model-runs",
        Access::Lead,
        "Let the model draft tasks that nobody has started, or judge submitted labels, in the background",
        model::start,
    )
    .takes::<NewModelRun>()
    .gives::<ModelRun>(),
    Route::post("/projects/{p}/model-runs:stop", Access::Lead, "Stop a run", model::stop)
        .takes::<StopModelRun>()
        .gives::<ModelRun>(),
    Route::get(
        "/projects/{p}/judge",
        Access::Staff,
        "The model's judgments of the labels, and its agreement with people",
        model::report,
    )
    .gives::<JudgeReport>(),
    // Tasks.
    Route::get("/projects/{p}/tasks", Access::Member, "Tasks; annotators see only their own", tasks::list)
        .query(&[
            ("state", "only these states, separated by commas"),
            ("scenario", "only this class: L1, L2 or L3"),
            ("assignee", "only tasks held by, assigned to or written by this user (name or id)"),
            ("mine", "`true`: only own tasks"),
            ("q", "part of the clip's or task's id"),
            (
                "asks",
                "`lead`: only tasks with an open question to the lead; for leads `class`: only those whose class does \
                 not fit, as their annotators say, and that no other task replaces",
            ),
            ("finding", "only tasks submitted with a finding of this code; `any` for every code"),
            (
                "overlap",
                "only tasks of overlap groups of which no label was chosen; for leads: `to_choose` all that are handed \
                 in, `disagreeing` those of them whose labels disagree",
            ),
            (
                "sort",
                "`priority` (default), `updated`, `created`, `scenario`, `clip`, `state` or `keyframe` (drive and time in \
                 it); `-` in front for descending",
            ),
            ("cursor", "from the previous page"),
            ("limit", "page length, 1 to 200; default 50"),
        ])
        .gives::<Tasks>(),
    Route::get("/mined", Access::SignedIn, "Folders of mining results from which tasks can be created", tasks::mined)
        .gives::<MinedFolders>(),
    Route::get(
        "/projects/{p}/mined/{m}/episodes",
        Access::Lead,
        "Episodes of a mined folder, to browse and judge",
        mined::list,
    )
    .query(&[
        ("scenario", "only this class: L1, L2 or L3"),
        ("drive", "only this drive"),
        ("unjudged", "`true`: only those without a verdict of the caller"),
        ("explained", "`true`: not those that no class explains (`other`)"),
        ("cursor", "from the previous page"),
        ("limit", "page length, 1 to 200; default 50"),
    ])
    .gives::<EpisodeCards>(),
    Route::get(
        "/projects/{p}/mined/{m}/episode",
        Access::Lead,
        "One mined episode: scene, map, signals, result of the rule; counts as seen",
        mined::show,
    )
    .query(EPISODE)
    .gives::<MinedEpisode>(),
    Route::get(
        "/projects/{p}/mined/{m}/similar",
        Access::Lead,
        "Episodes of the folder that are similar to one, of its L2",
        mined::similar,
    )
    .query(&[
        ("drive", "drive of the episode"),
        ("scenario", "class of the episode"),
        ("episode", "id of the episode"),
        ("limit", "how many; default 12"),
    ])
    .gives::<SimilarEpisodes>(),
    Route::get(
        "/projects/{p}/mined/{m}/media/{camera}/{index}",
        Access::Lead,
        "A camera frame of a mined episode",
        scenes::mined_media,
    )
    .query(EPISODE)
    .gives_media("image/*"),
    Route::post(
        "/projects/{p}/mined/{m}/tasks",
        Access::Lead,
        "Create a task from one mined episode, also of another class than the mined one",
        tasks::from_episode,
    )
    .takes::<EpisodeTask>()
    .gives::<Created>(),
    Route::post(
        "/projects/{p}/verdicts",
        Access::Lead,
        "Record a verdict on a mined episode, or remove it",
        mined::judge,
    )
    .empty_when("the verdict was removed")
    .takes::<NewVerdict>()
    .gives::<Verdict>(),
    Route::get("/projects/{p}/verdicts", Access::Lead, "All verdicts, as JSON lines or CSV", mined::export)
        .query(&[("format", "`json` (default) or `csv`")])
        .gives_media(JSON_LINES),
    Route::post("/projects/{p}/tasks:create", Access::Lead, "Create tasks from episodes", tasks::create)
        .takes::<CreateTasks>()
        .takes_up_to(BodySize::Bulk)
        .gives::<Created>(),
    Route::post(
        "/projects/{p}/tasks:next",
        Access::Member,
        "Take the next task of the queue; 204 when the queue is empty",
        tasks::next,
    )
    .empty_when("the queue has nothing for the caller")
    .takes::<NextTask>()
    .gives::<Task>(),
    Route::get(
        "/projects/{p}/queue",
        Access::Member,
        "Why `tasks:next` has nothing for the caller",
        tasks::queue,
    )
    .query(&[("kind", "`label` (default), `check` or `audit`")])
    .gives::<QueueState>(),
    Route::get("/tasks/{t}", Access::TaskReader, "One task, as far as the caller may see it", tasks::show)
        .gives::<Task>(),
    Route::post("/tasks/{t}/lease", Access::Member, "Take, renew or release a lease", tasks::lease)
        .takes::<LeaseRequest>()
        .gives::<Lease>(),
    Route::post(
        "/tasks/{t}/assign",
        Access::TaskLead,
        "Assign the task to a user, or return it to the queue",
        tasks::assign,
    )
    .takes::<Assign>()
    .gives::<Task>(),
    Route::post(
        "/tasks/{t}/reclass",
        Access::TaskLead,
        "Create a task of another class in place of this one, which is closed",
        tasks::reclass,
    )
    .takes::<OtherClass>()
    .gives::<Created>(),
    Route::post(
        "/projects/{p}/tasks:change",
        Access::Lead,
        "Assign many tasks, or change their priority",
        tasks::change,
    )
    .takes::<BulkChange>()
    .gives::<BulkChanged>(),
    Route::get("/projects/{p}/work", Access::Member, "Pending work in the project and of the caller", tasks::work)
        .gives::<Work>(),
    Route::get("/tasks/{t}/thumbnail", Access::TaskReader, "A thumbnail of the keyframe", tasks::thumbnail)
        .gives_media("image/svg+xml"),
    Route::patch("/tasks/{t}/draft", Access::TaskWorker, "Save changed fields of the draft", drafts::save)
        .takes::<DraftChange>()
        .gives::<DraftSaved>(),
    Route::post(
        "/tasks/{t}/actions",
        Access::TaskWorker,
        "Lock, submit, accept, send back, skip, reject, reopen, adjudicate, restore",
        drafts::act,
    )
    .takes::<TaskAction>()
    .gives::<Task>(),
    Route::post(
        "/tasks/{t}/safety",
        Access::TaskWorker,
        "Answer the safety filter of Stage II: decisions are saved after it; `unsafe` rejects the task",
        drafts::safety,
    )
    .takes::<SafetyRequest>()
    .gives::<Task>(),
    Route::post(
        "/tasks/{t}/judgement",
        Access::TaskWorker,
        "Answer the questions that a model answered about a label drawn for people; for its checker or auditor",
        model::answer,
    )
    .takes::<JudgementAnswers>()
    .gives::<Task>(),
    Route::post(
        "/tasks/{t}/validate",
        Access::TaskReader,
        "Findings of the checker in a label",
        drafts::validate,
    )
    .takes::<Validate>()
    .gives::<Findings>(),
    Route::get("/tasks/{t}/history", Access::TaskReader, "History of the task", talk::history)
        .query(&[("cursor", "from the previous page"), ("limit", "page length; default: all")])
        .gives::<History>(),
    Route::get(
        "/tasks/{t}/history/{seq}",
        Access::TaskReader,
        "The draft after an entry of the history",
        talk::draft_at,
    )
    .gives::<DraftAt>(),
    Route::get(
        "/tasks/{t}/overlap",
        Access::TaskReader,
        "The labels of the overlap group; for leads, once all are submitted",
        talk::overlap,
    )
    .gives::<Overlap>(),
    Route::post("/tasks/{t}/comments", Access::TaskWorker, "Comment on a field", talk::comment)
        .takes::<NewComment>()
        .gives::<Comment>(),
    Route::post("/comments/{c}/resolve", Access::CommentReader, "Resolve a comment", talk::resolve)
        .gives::<Comment>(),
    // Scenes and images.
    Route::get(
        "/tasks/{t}/scene",
        Access::TaskReader,
        "The drive around the keyframe, in Stage I only up to it",
        scenes::scene,
    )
    .gives::<SceneView>(),
    Route::get("/tasks/{t}/map", Access::TaskReader, "The map around the keyframe", scenes::map).gives::<MapView>(),
    Route::get("/tasks/{t}/media/{camera}/{index}", Access::TaskReader, "A camera frame", scenes::media)
        .gives_media("image/*"),
    Route::get(
        "/framework",
        Access::SignedIn,
        "Classes, decisions, categories and records for pickers",
        scenes::framework,
    )
    .gives::<FrameworkView>(),
    // Export and import.
    Route::get(
        "/projects/{p}/export",
        Access::Lead,
        "Accepted labels, or all tasks with their history, as JSON lines",
        transfer::export,
    )
    .query(&[
        ("format", "`labels` or `tasks`"),
        ("version", "`2.0` for labels without the additions of format 2.1"),
        ("state", "labels in these states instead of the accepted ones"),
    ])
    .gives_media(JSON_LINES),
    Route::post(
        "/projects/{p}/import",
        Access::Lead,
        "Import tasks or labels as JSON lines; labels become drafts",
        transfer::import,
    )
    .takes::<Value>()
    .takes_media(JSON_LINES)
    .takes_up_to(BodySize::Bulk)
    .gives::<Imported>(),
    Route::get("/projects/{p}/webhooks", Access::Lead, "Webhooks", webhooks::list).gives::<Webhooks>(),
    Route::post("/projects/{p}/webhooks", Access::Lead, "Add a webhook", webhooks::create)
        .takes::<NewWebhook>()
        .gives::<Webhook>(),
    Route::get(
        "/webhooks/paused",
        Access::Admin,
        "Webhooks of all projects that are paused because the account of their owner is disabled",
        webhooks::paused,
    )
    .gives::<Webhooks>(),
    Route::delete("/webhooks/{w}", Access::WebhookLead, "Remove a webhook", webhooks::remove).gives::<Done>(),
    // The service.
    Route::get("/openapi.json", Access::Anyone, "This document", session::openapi).gives::<Value>(),
    Route::get("/healthz", Access::Anyone, "Whether the service and its store are available", session::health)
        .as_probe()
        .gives::<Done>(),
];
