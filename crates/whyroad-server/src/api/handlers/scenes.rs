//! Scene, map, images, and the terms of the framework.

use super::tasks::look;
use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::problem::{Answer, Problem};
use crate::service::{pickers, scene};

/// Largest image that is served.
const MAX_PICTURE: u64 = 32 * 1024 * 1024;

/// `GET /tasks/{t}/scene`
pub fn scene(call: &Call<'_>) -> Answer<Reply> {
    Reply::json(&*scene::scene(call.app, &look(call)?)?)
}

/// `GET /tasks/{t}/map`
pub fn map(call: &Call<'_>) -> Answer<Reply> {
    Reply::json(&scene::map(call.app, &look(call)?)?)
}

/// `GET /tasks/{t}/media/{camera}/{index}`
pub fn media(call: &Call<'_>) -> Answer<Reply> {
    let t = look(call)?;
    let index = call.param("index").parse().map_err(|_| Problem::missing())?;
    let file = scene::image(call.app, &t, call.param("camera"), index)?;
    // A whole video would show what comes after: only images are served.
    let media = match file.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("jpg" | "jpeg") => "image/jpeg",
        Some("png") => "image/png",
        Some("webp") => "image/webp",
        _ => return Err(Problem::missing()),
    };
    let size = std::fs::metadata(&file).map_err(|_| Problem::missing())?.len();
    if size > MAX_PICTURE {
        return Err(Problem::missing());
    }
    Ok(Reply::bytes(media, std::fs::read(&file).map_err(|_| Problem::missing())?))
}

/// `GET /framework`
pub fn framework(call: &Call<'_>) -> Answer<Reply> {
    Reply::json(&pickers::of(call.app.framework))
}
