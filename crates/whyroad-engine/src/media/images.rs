//! Names and times of images, from a folder with a rate or from a list of times; and whether a file is an image that
//! browsers can show.

use super::error::MediaError;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use whyroad_model::{Bilingual, Nanos};

/// Largest image that the service serves, bytes.
const MAX_BYTES: u64 = 32 * 1024 * 1024;

/// A named image; the file is not read yet.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NamedImage {
    pub path: PathBuf,
    /// When it was taken; an error holds the text that is not a time.
    pub time: Result<Nanos, String>,
}

/// The images of a folder in the order of their numbers, `1 / rate_hz` seconds apart from `start` on.
pub(super) fn of_folder(dir: &Path, start: Nanos, rate_hz: f64) -> Result<Vec<NamedImage>, MediaError> {
    let entries = std::fs::read_dir(dir).map_err(MediaError::io(dir))?;
    let mut names: Vec<String> = entries
        .flatten()
        .map(|e| e.file_name().to_string_lossy().into_owned())
        .filter(|name| !name.starts_with('.') && kind_by_extension(Path::new(name)).is_some())
        .collect();
    names.sort_by_cached_key(|name| (natural(name), name.clone()));
    if let Some((before, after)) = gap(&names) {
        return Err(MediaError::Gap { before: before.to_owned(), after: after.to_owned() });
    }
    let time = |i: usize| Nanos(start.0 + Nanos::from_secs_f64(i as f64 / rate_hz).0);
    let named = names.iter().enumerate();
    Ok(named.map(|(i, name)| NamedImage { path: dir.join(name), time: Ok(time(i)) }).collect())
}

/// The images of a list with the columns `name` (from the list's folder) and `time` (ISO 8601, or seconds from `zero`).
pub(super) fn of_list(list: &Path, zero: Nanos) -> Result<Vec<NamedImage>, MediaError> {
    let unreadable = |e: csv::Error| MediaError::List { path: list.to_owned(), reason: e.to_string() };
    let mut rows = csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(list).map_err(unreadable)?;
    let header = rows.headers().map_err(unreadable)?.clone();
    let column = |name: &str| {
        let found = header.iter().position(|h| h.trim_start_matches('\u{feff}') == name);
        let reason = || format!("no column '{name}'; it needs name,time");
        found.ok_or_else(|| MediaError::List { path: list.to_owned(), reason: reason() })
    };
    let (name, time) = (column("name")?, column("time")?);
    let dir = list.parent().unwrap_or(Path::new(""));
    let one = |row: Result<csv::StringRecord, csv::Error>| {
        let row = row.map_err(unreadable)?;
        let text = |i: usize| row.get(i).unwrap_or_default();
        Ok(NamedImage { path: dir.join(text(name)), time: moment(text(time), zero) })
    };
    rows.records().map(one).collect()
}

fn moment(text: &str, zero: Nanos) -> Result<Nanos, String> {
    if let Some(seconds) = text.parse::<f64>().ok().filter(|s| s.is_finite()) {
        return Ok(Nanos(zero.0.saturating_add(Nanos::from_secs_f64(seconds).0)));
    }
    Nanos::parse_iso(text).map_err(|_| text.to_owned())
}

/// The extension of an image's type, by content; an error where a browser cannot show the file.
pub(super) fn kind(path: &Path) -> Result<&'static str, Bilingual> {
    let unreadable =
        |e: std::io::Error| Bilingual::new(format!("无法读取：{e}"), format!("cannot be read: {e}"));
    let mut head = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    let size = file.metadata().map_err(unreadable)?.len();
    file.take(12).read_to_end(&mut head).map_err(unreadable)?;
    let Some(kind) = kind_by_content(&head) else {
        return Err(Bilingual::new("不是 JPEG、PNG 或 WebP 图片", "is not a JPEG, PNG or WebP file"));
    };
    if size > MAX_BYTES {
        return Err(Bilingual::new("大于 32 MiB", "is larger than 32 MiB"));
    }
    // The service states the kind by the extension.
    if kind_by_extension(path) != Some(kind) {
        return Err(Bilingual::new(
            format!("内容是 {kind}，但扩展名不符"),
            format!("is {kind} by content, but has another extension"),
        ));
    }
    Ok(kind)
}

fn kind_by_content(head: &[u8]) -> Option<&'static str> {
    match head {
        [0xff, 0xd8, 0xff, ..] => Some("jpg"),
        [0x89, b'P', b'N', b'G', 0x0d, 0x0a, 0x1a, 0x0a, ..] => Some("png"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P'] => Some("webp"),
        _ => None,
    }
}

/// The type of an image by its extension; `None` for types that browsers do not show.
pub(crate) fn kind_by_extension(path: &Path) -> Option<&'static str> {
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "jpg" | "jpeg" => Some("jpg"),
        "png" => Some("png"),
        "webp" => Some("webp"),
        _ => None,
    }
}

/// A name as alternating text and numbers, so that 2 comes before 10.
fn natural(name: &str) -> Vec<(String, u128)> {
    let mut out = vec![(String::new(), 0_u128)];
    let mut digits = false;
    for c in name.chars() {
        if let Some(d) = c.to_digit(10) {
            digits = true;
            if let Some((_, n)) = out.last_mut() {
                *n = n.saturating_mul(10).saturating_add(u128::from(d));
            }
        } else {
            if std::mem::take(&mut digits) {
                out.push((String::new(), 0));
            }
            if let Some((text, _)) = out.last_mut() {
                text.push(c);
            }
        }
    }
    out
}

/// The neighbors between which numbered images are missing: where the step of the last number in their names changes.
fn gap(names: &[String]) -> Option<(&str, &str)> {
    let number = |name: &str| {
        let stem = Path::new(name).file_stem()?.to_str()?;
        natural(stem).last().map(|(_, n)| *n).filter(|_| stem.ends_with(|c: char| c.is_ascii_digit()))
    };
    let numbers: Vec<u128> = names.iter().map(|n| number(n)).collect::<Option<_>>()?;
    let steps = || numbers.windows(2).map(|w| w[1].abs_diff(w[0]));
    let least = steps().min()?;
    let at = steps().position(|step| step != least)?;
    Some((&names[at], &names[at + 1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_are_in_the_order_of_their_numbers_and_none_may_be_missing() {
        let dir = tempfile::tempdir().unwrap();
        let put = |name: &str| std::fs::write(dir.path().join(name), "").unwrap();
        ["8.png", "10.png", "9.png", "notes.txt", ".hidden.png"].iter().for_each(|name| put(name));
        let read = || of_folder(dir.path(), Nanos(1_000), 10.0);
        let found = read().unwrap();
        let names: Vec<_> = found.iter().map(|n| n.path.file_name().unwrap().to_str().unwrap()).collect();
        assert_eq!(names, ["8.png", "9.png", "10.png"]);
        let times: Vec<_> = found.iter().map(|n| n.time.clone().unwrap().0).collect();
        assert_eq!(times, [1_000, 100_001_000, 200_001_000]);
        put("12.png");
        assert!(read().unwrap_err().to_string().contains("between 10.png and 12.png"));
    }

    #[test]
    fn every_nth_image_is_not_a_gap() {
        let names = |all: &[&str]| all.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
        assert_eq!(gap(&names(&["a-000.jpg", "a-005.jpg", "a-010.jpg"])), None);
        assert_eq!(gap(&names(&["dawn.jpg", "noon.jpg"])), None);
        assert_eq!(gap(&names(&["0.jpg", "5.jpg", "6.jpg"])), Some(("0.jpg", "5.jpg")));
    }

    #[test]
    fn times_of_a_list_are_moments_or_seconds() {
        let dir = tempfile::tempdir().unwrap();
        let list = dir.path().join("times.csv");
        std::fs::write(&list, "\u{feff}time,name\n0.5,a.jpg\n1970-01-01T00:00:02Z, b/c.jpg\nsoon,d.jpg\n")
            .unwrap();
        let found = of_list(&list, Nanos::SECOND).unwrap();
        let times: Vec<_> = found.iter().map(|n| n.time.clone()).collect();
        assert_eq!(times, [Ok(Nanos(1_500_000_000)), Ok(Nanos(2_000_000_000)), Err("soon".to_owned())]);
        assert_eq!(found[1].path, dir.path().join("b/c.jpg"));
        std::fs::write(&list, "file,time\n").unwrap();
        assert!(of_list(&list, Nanos(0)).unwrap_err().to_string().contains("no column 'name'"));
    }

    #[test]
    fn the_kind_of_an_image_is_known_by_content() {
        // First bytes by ITU T.81 (SOI), PNG 3rd edition 5.2, RFC 9649 2.4.
        assert_eq!(kind_by_content(&[0xff, 0xd8, 0xff, 0xe0]), Some("jpg"));
        assert_eq!(kind_by_content(b"\x89PNG\r\n\x1a\n\0\0\0\r"), Some("png"));
        assert_eq!(kind_by_content(b"RIFF\x10\0\0\0WEBP"), Some("webp"));
        assert_eq!(
            (kind_by_content(b"RIFF\x10\0\0\0WAVE"), kind_by_content(b"GIF89a"), kind_by_content(b"")),
            (None, None, None)
        );
    }
}
