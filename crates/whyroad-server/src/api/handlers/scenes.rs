//! Scene, map, images, and the terms of the framework.

use super::tasks::look;
use crate::api::call::Call;
use crate::api::reply::Reply;
use crate::problem::{Answer, Problem};
use crate::recordings::{CameraImage, StoredImage};
use crate::service::tasks::TaskRow;
use crate::service::{mined, pickers, projects, scene};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Maximum size of an image that is served.
const MAX_PICTURE: u64 = 32 * 1024 * 1024;

/// `GET /tasks/{t}/scene`
pub fn scene(call: &Call<'_>) -> Answer<Reply> {
    let t = look(call)?;
    let mut view = scene::scene(call.app, &t)?;
    if let Some(corner) = corner(call, &t)? {
        Arc::make_mut(&mut view).shift(corner);
    }
    Reply::json(&*view)
}

/// `GET /tasks/{t}/map`
pub fn map(call: &Call<'_>) -> Answer<Reply> {
    let t = look(call)?;
    let mut map = scene::map(call.app, &t)?;
    if let Some(corner) = corner(call, &t)? {
        map.shift(corner);
    }
    Reply::json(&map)
}

/// Origin of the positions of `t`, m; `None` where the project uses recorded positions.
fn corner(call: &Call<'_>, t: &TaskRow) -> Answer<Option<[f64; 2]>> {
    let project = call.app.store.read(|tx| projects::get(tx, &t.project))?;
    match f64::from(project.settings.place_precision_m) {
        size if size > 0.0 => scene::corner(call.app, t, size).map(Some),
        _ => Ok(None),
    }
}

/// `GET /tasks/{t}/media/{camera}/{index}`
pub fn media(call: &Call<'_>) -> Answer<Reply> {
    let t = look(call)?;
    send(call, scene::image(call.app, &t, call.param("camera"), index(call)?)?)
}

/// `GET /projects/{p}/mined/{m}/media/{camera}/{index}`
pub fn mined_media(call: &Call<'_>) -> Answer<Reply> {
    let project = call.app.store.read(|tx| projects::get(tx, call.grant.project()?))?;
    let who = (super::mined::name(call)?, call.user()?.id.as_str());
    send(call, mined::image(call.app, &project, who, call.param("camera"), index(call)?)?)
}

fn index(call: &Call<'_>) -> Answer<usize> {
    call.param("index").parse().map_err(|_| Problem::missing())
}

/// An image as it may be shown: blurred if a program for that is configured, or an error.
fn send(call: &Call<'_>, image: CameraImage) -> Answer<Reply> {
    match image {
        CameraImage::File(file) => send_file(call, file),
        CameraImage::Stored(image) => send_stored(call, &*image),
    }
}

/// A whole video would show the future: only images are served.
fn media_type(name: &Path) -> Answer<&'static str> {
    match name.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("jpg" | "jpeg") => Ok("image/jpeg"),
        Some("png") => Ok("image/png"),
        Some("webp") => Ok("image/webp"),
        _ => Err(Problem::missing()),
    }
}

/// A link that expires soon. There is none for an image that must be blurred, because it would show the original.
fn send_stored(call: &Call<'_>, image: &dyn StoredImage) -> Answer<Reply> {
    let failed = |why: whyroad_model::Bilingual| Problem::new(502, "media.storage", why.zh, why.en);
    let media = media_type(Path::new(image.name()))?;
    let Some(blur) = &call.app.blur else {
        let link = image.link(call.app.image_links.lifetime).map_err(failed)?;
        return Ok(Reply { status: 307, location: Some(link), ..Reply::default() });
    };
    let read = || image.read().map_err(failed)?.ok_or_else(Problem::missing);
    let file = blur.stored_image(image.name(), read)?;
    Ok(Reply::bytes(media, std::fs::read(&file).map_err(|_| Problem::missing())?))
}

fn send_file(call: &Call<'_>, file: PathBuf) -> Answer<Reply> {
    let media = media_type(&file)?;
    let file = call.app.blur.as_ref().map_or(Ok(file.clone()), |blur| blur.image(&file))?;
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
