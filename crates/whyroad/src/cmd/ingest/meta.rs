//! `ingest --meta`: facts about drives that their logs do not have.

use crate::output::reason::{cannot_read, stop};
use anyhow::Context as _;
use std::path::{Path, PathBuf};
use whyroad_ingest::Datum;
use whyroad_lake::{DriveFacts, Lake};
use whyroad_model::scene::GeoPosition;
use whyroad_model::{Bilingual, Diagnostic, DriveId};

const COLUMNS: [&str; 8] =
    ["drive_id", "session", "vehicle", "latitude", "longitude", "datum", "place", "licence"];

/// Facts by drive, and errors in the file.
pub(super) struct Facts {
    file: PathBuf,
    drives: Vec<(DriveId, DriveFacts)>,
    found: Vec<Diagnostic>,
}

/// Reads the CSV. An unusable line is reported and does not stop the rest.
pub(super) fn read(file: &Path) -> anyhow::Result<Facts> {
    let mut reader = csv::Reader::from_path(file).with_context(|| cannot_read(file.display()))?;
    let headers = reader.headers().with_context(|| cannot_read(file.display()))?.clone();
    if let Some(unknown) = headers.iter().find(|h| !COLUMNS.contains(&h.trim())) {
        return Err(stop(
            format!("{} 有未知的列“{unknown}”；可用的列：{}", file.display(), COLUMNS.join("、")),
            format!("{} has the unknown column '{unknown}'; known: {}", file.display(), COLUMNS.join(", ")),
        ));
    }
    if !headers.iter().any(|h| h.trim() == "drive_id") {
        return Err(stop(
            format!("{} 没有列“drive_id”", file.display()),
            format!("{} has no column 'drive_id'", file.display()),
        ));
    }
    let mut out = Facts { file: file.to_owned(), drives: Vec::new(), found: Vec::new() };
    for (i, row) in reader.records().enumerate() {
        let fault = |zh: String, en: String| {
            let place = format!("{}:{}", file.display(), i + 2);
            Diagnostic::error("ingest.meta.line", Bilingual::new(zh, en)).in_file(place)
        };
        let row = match row {
            Ok(row) => row,
            Err(e) => {
                out.found.push(fault(format!("该行无法读取：{e}"), format!("the line cannot be read: {e}")));
                continue;
            }
        };
        let cell = |name: &str| {
            let value = headers.iter().position(|h| h.trim() == name).and_then(|i| row.get(i))?.trim();
            (!value.is_empty()).then(|| value.to_owned())
        };
        let Some(id) = cell("drive_id") else {
            out.found.push(fault("缺少 drive_id".into(), "drive_id is empty".into()));
            continue;
        };
        let position = match position(cell("latitude"), cell("longitude")) {
            Ok(position) => position,
            Err(en) => {
                out.found.push(fault("纬度或经度无效".into(), en));
                continue;
            }
        };
        let datum = cell("datum");
        let known = datum.as_deref().map_or(Some(Datum::Wgs84), Datum::parse);
        if known.is_none() {
            let place = format!("{}:{}", file.display(), i + 2);
            out.found.push(datum_unknown(datum.as_deref().unwrap_or_default()).in_file(place));
        }
        // An unknown datum is not guessed: the position is used as given.
        let position = position.map(|p| known.map_or(p, |datum| in_wgs84(p, datum)));
        let facts = DriveFacts {
            session: cell("session"),
            vehicle: cell("vehicle"),
            position,
            place: cell("place"),
            licence: cell("licence"),
        };
        out.drives.push((DriveId(id), facts));
    }
    Ok(out)
}

fn in_wgs84(p: GeoPosition, datum: Datum) -> GeoPosition {
    let (latitude_deg, longitude_deg) = datum.to_wgs84(p.latitude_deg, p.longitude_deg);
    GeoPosition { latitude_deg, longitude_deg }
}

fn datum_unknown(name: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("未知的基准 '{name}'；位置按原值保留"),
        format!("the datum '{name}' is not known; the position is used as given"),
    );
    Diagnostic::warning("ingest.meta.datum", message)
        .with_hint(Bilingual::new("可用 wgs84 与 gcj02", "the known ones are wgs84 and gcj02"))
}

fn position(latitude: Option<String>, longitude: Option<String>) -> Result<Option<GeoPosition>, String> {
    let number = |text: &str, most: f64| {
        let value: Option<f64> = text.parse().ok();
        value
            .filter(|v| v.abs() <= most)
            .ok_or_else(|| format!("'{text}' is not a number of degrees up to {most}"))
    };
    match (latitude, longitude) {
        (None, None) => Ok(None),
        (Some(a), Some(b)) => {
            Ok(Some(GeoPosition { latitude_deg: number(&a, 90.0)?, longitude_deg: number(&b, 180.0)? }))
        }
        _ => Err("latitude and longitude must be given together".to_owned()),
    }
}

/// States the facts; returns the errors.
pub(super) fn state(lake: &Lake, facts: Facts) -> anyhow::Result<Vec<Diagnostic>> {
    let mut found = facts.found;
    let present = lake.drive_ids();
    for (id, facts_of_drive) in facts.drives {
        if present.binary_search(&id).is_err() {
            let message =
                Bilingual::new(format!("数据湖中没有行程 {id}"), format!("the lake has no drive {id}"));
            found.push(
                Diagnostic::warning("ingest.meta.drive", message).in_file(facts.file.display().to_string()),
            );
            continue;
        }
        lake.state_facts(&id, facts_of_drive)?;
    }
    Ok(found)
}
