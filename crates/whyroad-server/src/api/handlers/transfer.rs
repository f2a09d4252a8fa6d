//! Export and import of labels and tasks.

use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::api::stream::Stream;
use crate::problem::{Answer, Problem};
use crate::service::transfer::{self, ExportFormat};
use crate::service::{projects, seen};
use crate::values;

/// `GET /projects/{p}/export`
pub fn export(call: &Call<'_>) -> Answer<Reply> {
    let project = call.grant.project()?;
    let format = ExportFormat::from_words(call.query("format"), call.query("version"), call.query("state"))?;
    not_of_a_drive_in_hand(call, "SELECT 1 FROM tasks WHERE project_id = $1 AND drive_id = $2 LIMIT 1")?;
    let (name, not_chosen) = call
        .app
        .store
        .report(|tx| Ok((projects::get(tx, project)?.name, transfer::not_chosen(tx, project, &format)?)))?;
    let what = format.file_stem();
    let (store, project) = (call.app.store.clone(), project.to_owned());
    let stream = Stream::new(move |out| transfer::export_to(&store, &project, &format, out));
    Ok(Reply {
        file_name: Some(format!("{name}-{what}.jsonl")),
        stream: Some(stream),
        headers: vec![("x-whyroad-not-chosen", not_chosen.to_string())],
        ..Reply::bytes("application/x-ndjson", vec![])
    })
}

/// Refuses an export to a user who does Stage I of a drive of which it tells something: `sql` finds that.
pub(super) fn not_of_a_drive_in_hand(call: &Call<'_>, sql: &str) -> Answer<()> {
    let (store, project) = (&call.app.store, call.grant.project()?);
    seen::not_in_hand(store, &call.user()?.id, |drive| {
        store.read(|tx| Ok(tx.row(sql, values![project, drive.as_str()])?.is_some()))
    })
}

/// `POST /projects/{p}/import`
pub fn import(call: &Call<'_>) -> Answer<Reply> {
    let text = std::str::from_utf8(&call.request.body)
        .map_err(|_| Problem::request("正文不是 UTF-8", "the body is not UTF-8"))?;
    Reply::json(&transfer::import(call.app, call.grant.project()?, text, Some(&call.user()?.id))?)
}
