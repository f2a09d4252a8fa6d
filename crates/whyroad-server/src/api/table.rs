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
        "Begin to sign in at the identity provider, or to link oneself to it",
        oidc::begin,
    )
    .takes::<BeginAtProvider>()
    .gives::<ProviderAddress>(),
    Route::post(
        "/oidc/finish",
        Access::Anyone,
        "End that with what the provider sent the browser back with",
        oidc::finish,
    )
    .takes::<Returned>()
    .gives::<Session>(),
    Route::get(
        "/identities",
        Access::SignedIn,
        "Identities at the provider that one is linked to",
        oidc::list,
    )
    .query(&[("user", "of this user (id); for admins")])
    .gives::<Identities>(),
    Route::delete(
        "/identities/{id}",
        Access::SignedIn,
        "Unlink oneself, or as admin anybody; sessions that began there end",
        oidc::unlink,
    )
    .in_session_only()
    .gives::<Done>(),
    Route::get(
        "/users",
        Access::SignedIn,
        "Users: all for admins and leads, for others those of their projects",
        accounts::list,
    )
    .gives::<Users>(),
    Route::post("/users", Access::Admin, "Make a user", accounts::create)
        .takes::<NewUser>()
        .in_session_only()
        .gives::<User>(),
    Route::patch(
        "/users/{u}",
        Access::SignedIn,
        "Change a user: oneself, or as admin anybody",
        accounts::change,
    )
    .takes::<UserChange>()
    .in_session_only()
    .gives::<User>(),
    Route::get("/tokens", Access::SignedIn, "Own API tokens", accounts::tokens)
        .query(&[("user", "of this user (id); for admins")])
        .gives::<Tokens>(),
    Route::post("/tokens", Access::SignedIn, "Make an API token", accounts::make_token)
        .takes::<NewToken>()
        .in_session_only()
        .gives::<Token>(),
    Route::delete(
        "/tokens/{id}",
        Access::SignedIn,
        "Revoke an own API token, or as admin anybody's",
        accounts::revoke_token,
    )
    .gives::<Done>(),
    // Projects.
    Route::get(
        "/projects",
        Access::SignedIn,
        "Projects that one is a member of; all for admins",
        projects::list,
    )
    .gives::<Projects>(),
    Route::post(
        "/projects",
        Access::Admin,
        "Make a project; its maker gets all roles in it",
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
        "Gold tasks and how annotators did; nobody else learns which tasks these are",
        projects::gold,
    )
    .gives::<GoldReport>(),
    Route::post(
        "/projects/{p}/gold",
        Access::Lead,
        "Make gold tasks: hidden copies of accepted tasks for annotators",
        projects::make_gold,
    )
    .takes::<NewGold>()
    .gives::<MadeGold>(),
    Route::get(
        "/projects/{p}/model-runs",
        Access::Lead,
        "The language model and its runs: drafts and judgements, progress, what they spent",
        model::show,
    )
    .gives::<ModelWork>(),
    Route::post(
        "/projects/{p}/model-runs",
        Access::Lead,
        "Have the model draft tasks that nobody has begun, or judge labels that were handed in; in the background",
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
        "What the model says of the labels, and how far it agrees with people",
        model::report,
    )
    .gives::<JudgeReport>(),
    // Tasks.
    Route::get("/projects/{p}/tasks", Access::Member, "Tasks; annotators see only their own", tasks::list)
        .query(&[
            ("state", "only these states, separated by commas"),
            ("scenario", "only this class: L1, L2 or leaf"),
            ("assignee", "only those held or written by this user (name or id)"),
            ("mine", "`true`: only own tasks"),
            ("q", "part of the clip's or task's id"),
            ("asks", "`lead`: only tasks with an open question to the lead"),
            ("overlap", "`disagreeing`: only tasks of overlap groups that are still to be adjudicated; for leads"),
            (
                "sort",
                "`priority` (default), `updated`, `created`, `scenario`, `clip` or `state`; `-` in front for descending",
            ),
            ("cursor", "from the page before"),
            ("limit", "page length, 1 to 200; default 50"),
        ])
        .gives::<Tasks>(),
    Route::get("/mined", Access::SignedIn, "Folders of mining results to make tasks from", tasks::mined)
        .gives::<MinedFolders>(),
    Route::get(
        "/projects/{p}/mined/{m}/episodes",
        Access::Lead,
        "Episodes of a mined folder, to browse and judge",
        mined::list,
    )
    .query(&[
        ("scenario", "only this class: L1, L2 or leaf"),
        ("drive", "only this drive"),
        ("unjudged", "`true`: only those without a verdict of the caller's"),
        ("cursor", "from the page before"),
        ("limit", "page length, 1 to 200; default 50"),
    ])
    .gives::<EpisodeCards>(),
    Route::get(
        "/projects/{p}/mined/{m}/episode",
        Access::Lead,
        "One mined episode: scene, map, signals, what the rule found; counts as seen",
        mined::show,
    )
    .query(EPISODE)
    .gives::<MinedEpisode>(),
    Route::get(
        "/projects/{p}/mined/{m}/similar",
        Access::Lead,
        "Episodes of the folder that resemble one, of its L2",
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
        "/projects/{p}/verdicts",
        Access::Lead,
        "Say of a mined episode whether it is right, or take that back",
        mined::judge,
    )
    .empty_when("the verdict was taken back")
    .takes::<NewVerdict>()
    .gives::<Verdict>(),
    Route::get("/projects/{p}/verdicts", Access::Lead, "All verdicts, as JSON lines or CSV", mined::export)
        .query(&[("format", "`json` (default) or `csv`")])
        .gives_media(JSON_LINES),
    Route::post("/projects/{p}/tasks:create", Access::Lead, "Make tasks from episodes", tasks::create)
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
    Route::get("/tasks/{t}", Access::TaskReader, "One task as far as it may be seen", tasks::show)
        .gives::<Task>(),
    Route::post("/tasks/{t}/lease", Access::Member, "Take, keep or give back a lease", tasks::lease)
        .takes::<LeaseRequest>()
        .gives::<Lease>(),
    Route::post(
        "/tasks/{t}/assign",
        Access::TaskLead,
        "Give the task to somebody, or to the queue",
        tasks::assign,
    )
    .takes::<Assign>()
    .gives::<Task>(),
    Route::post(
        "/projects/{p}/tasks:change",
        Access::Lead,
        "Assign many tasks, or change their priority",
        tasks::change,
    )
    .takes::<BulkChange>()
    .gives::<BulkChanged>(),
    Route::get("/projects/{p}/work", Access::Member, "What there is to do, and what is one's own", tasks::work)
        .gives::<Work>(),
    Route::get("/tasks/{t}/thumbnail", Access::TaskReader, "A small picture of the keyframe", tasks::thumbnail)
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
        "Answer the questions that a model answered, of a label that was drawn for people; for who checks or audits it",
        model::answer,
    )
    .takes::<JudgementAnswers>()
    .gives::<Task>(),
    Route::post(
        "/tasks/{t}/validate",
        Access::TaskReader,
        "What the checker finds in a label",
        drafts::validate,
    )
    .takes::<Validate>()
    .gives::<Findings>(),
    Route::get("/tasks/{t}/history", Access::TaskReader, "Who did what", talk::history)
        .query(&[("cursor", "from the page before"), ("limit", "page length; default: all")])
        .gives::<History>(),
    Route::get(
        "/tasks/{t}/history/{seq}",
        Access::TaskReader,
        "The draft as it was after an entry",
        talk::draft_at,
    )
    .gives::<DraftAt>(),
    Route::get(
        "/tasks/{t}/overlap",
        Access::TaskReader,
        "The labels of the overlap group; for staff, once all are submitted",
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
    Route::get("/tasks/{t}/map", Access::TaskReader, "The road there", scenes::map).gives::<MapView>(),
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
        "Accepted labels, or all tasks with their history, as JSONL",
        transfer::export,
    )
    .query(&[
        ("format", "`labels` or `tasks`"),
        ("version", "`2.0` for labels without what format 2.1 added"),
        ("state", "labels of these states instead of the accepted ones"),
    ])
    .gives_media(JSON_LINES),
    Route::post(
        "/projects/{p}/import",
        Access::Lead,
        "Tasks or labels as JSONL; labels become drafts",
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
    Route::delete("/webhooks/{w}", Access::WebhookLead, "Remove a webhook", webhooks::remove).gives::<Done>(),
    // The service.
    Route::get("/openapi.json", Access::Anyone, "This document", session::openapi).gives::<Value>(),
    Route::get("/healthz", Access::Anyone, "Whether the service and its store answer", session::health)
        .gives::<Done>(),
];
