//! Mined episodes and verdicts on them.

use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::api::stream::Stream;
use crate::domain::mined::NewVerdict;
use crate::problem::{Answer, Problem};
use crate::service::mined::{self, EpisodeName, VerdictFormat, Wanted};
use crate::service::projects;

/// Default number of similar episodes.
const SIMILAR: usize = 12;

/// `GET /projects/{p}/mined/{m}/episodes`
pub fn list(call: &Call<'_>) -> Answer<Reply> {
    let wanted = Wanted {
        scenario: call.query("scenario"),
        drive: call.query("drive"),
        unjudged: call.query("unjudged") == Some("true"),
        explained: call.query("explained") == Some("true"),
        cursor: call.query("cursor"),
        limit: call.query("limit"),
    };
    Reply::json(&mined::page(call.app, call.grant.project()?, call.param("m"), &call.user()?.id, &wanted)?)
}

/// The episode that the query names.
pub(super) fn name<'c>(call: &'c Call<'_>) -> Answer<EpisodeName<'c>> {
    let part = |what: &'static str| {
        call.query(what).ok_or_else(|| Problem::request(format!("缺少 {what}"), format!("{what} is missing")))
    };
    Ok(EpisodeName {
        mined: call.param("m"),
        drive: part("drive")?,
        scenario: part("scenario")?,
        episode: part("episode")?,
    })
}

/// `GET /projects/{p}/mined/{m}/episode`
pub fn show(call: &Call<'_>) -> Answer<Reply> {
    let project = call.app.store.read(|tx| projects::get(tx, call.grant.project()?))?;
    Reply::json(&mined::episode(call.app, &project, name(call)?, &call.user()?.id)?)
}

/// `GET /projects/{p}/mined/{m}/similar`
pub fn similar(call: &Call<'_>) -> Answer<Reply> {
    let limit = call.query("limit").and_then(|n| n.parse().ok()).unwrap_or(SIMILAR);
    Reply::json(&mined::similar(call.app, call.grant.project()?, name(call)?, &call.user()?.id, limit)?)
}

/// `POST /projects/{p}/verdicts`
pub fn judge(call: &Call<'_>) -> Answer<Reply> {
    let request: NewVerdict = call.body()?;
    match mined::judge(call.app, call.grant.project()?, &call.user()?.id, &request)? {
        Some(verdict) => Reply::json(&verdict),
        None => Ok(Reply::nothing()),
    }
}

/// `GET /projects/{p}/verdicts`
pub fn export(call: &Call<'_>) -> Answer<Reply> {
    let format = VerdictFormat::from_word(call.query("format"))?;
    let told = "SELECT 1 FROM verdicts WHERE project_id = $1 AND drive_id = $2 LIMIT 1";
    super::transfer::not_of_a_drive_in_hand(call, told)?;
    let (store, project) = (call.app.store.clone(), call.grant.project()?.to_owned());
    let name = store.read(|tx| projects::get(tx, &project))?.name;
    let stream = Stream::new(move |out| mined::export_to(&store, &project, format, out));
    let (end, media) = match format {
        VerdictFormat::JsonLines => ("jsonl", "application/x-ndjson"),
        VerdictFormat::Csv => ("csv", "text/csv; charset=utf-8"),
    };
    let file_name = Some(format!("{name}-verdicts.{end}"));
    Ok(Reply { file_name, stream: Some(stream), ..Reply::bytes(media, vec![]) })
}
