//! `drive.yaml` or `drive.json`: what is known about the drive as a whole.

use super::findings;
use super::layout::{EGO_KEYS, KEYS};
use super::reader::Reader;
use super::words::UnknownWords;
use crate::assemble::layers::Declared;
use crate::encodings::input::{Folder, Input};
use crate::phrases::zh;
use whyroad_model::yaml::{self, Node, Value};
use whyroad_model::{Bilingual, Diagnostic, Nanos};

/// Longest size of a vehicle, and greatest distance of its reference point from its middle, m.
const MOST_SIZE_M: f64 = 60.0;
const MOST_OFFSET_M: f64 = 30.0;
/// Antennas and sensors at the ends of a car, m.
const BEYOND_END_M: f64 = 1.0;

/// The file's content.
pub(super) struct Meta {
    pub drive_id: Option<String>,
    pub source: String,
    pub place: Option<String>,
    pub map_ref: Option<String>,
    pub licence: Option<String>,
    /// Time of `time_s` zero.
    pub start_time: Option<Nanos>,
    pub ego: EgoBox,
    /// Kinds of signs and facilities, and tags of lanes, of which the map has all there are, ordered.
    pub map_complete_for: Declared,
}

/// The recording vehicle.
#[derive(Clone, Copy, Debug)]
pub(super) struct EgoBox {
    /// NaN where not stated.
    pub length_m: f64,
    pub width_m: f64,
    pub height_m: f64,
    /// From the point that `ego.x_m, y_m` give forward to the middle of the box.
    pub reference_to_centre_m: f64,
}

pub(super) fn drive_file(dir: Folder<'_>) -> Option<&'static str> {
    ["drive.yaml", "drive.yml", "drive.json"].into_iter().find(|name| dir.has(name))
}

impl Meta {
    /// Reads the file; problems go into the report, and without the two values that cannot be guessed there is no
    /// drive.
    pub fn read(reader: &mut Reader) -> Option<Self> {
        let folder = reader.dir.own_label();
        let shared = reader.mapping.and_then(|(name, mapping)| Some((name, mapping.drive.as_ref()?)));
        let found = drive_file(reader.dir).and_then(|name| Some((name, reader.dir.file(name)?)));
        let (label, root) = match (found, shared) {
            (Some((name, file)), _) => {
                let label = reader.dir.label(name);
                let root = parse(&file, &label, reader)?;
                (label, shared.map_or(root.clone(), |(_, shared)| completed(root, shared)))
            }
            (None, Some((name, shared))) => (name.to_owned(), shared.clone()),
            (None, None) => {
                let en = "drive.yaml is missing; it states the reference point of the ego's pose".to_owned();
                let out = &mut reader.report.diagnostics;
                out.push(findings::bad_meta(&folder, "没有 drive.yaml，无法知道自车位姿的参考点".into(), en));
                return None;
            }
        };
        let out = &mut reader.report.diagnostics;
        unknown_keys(&root, KEYS, &label, out);
        let ego = root.get("ego");
        if let Some(ego) = ego {
            unknown_keys(ego, EGO_KEYS, &label, out);
        }
        let text = |key: &str| root.get(key).and_then(Node::text).map(str::to_owned);
        let start_time = match root.get("start_time").and_then(Node::text).map(Nanos::parse_iso) {
            Some(Err(e)) => {
                let e = e.text();
                let (zh, en) = (format!("start_time：{}", e.zh), format!("start_time: {}", e.en));
                return fail(out, &label, &zh, &en);
            }
            Some(Ok(t)) => Some(t),
            None => None,
        };
        let Some(source) = text("source") else {
            return fail(
                out,
                &label,
                "缺少 'source'（采集的车辆或车队）",
                "'source' is missing: the vehicle or fleet that recorded",
            );
        };
        let number = |key: &str| {
            let text = ego?.get(key)?.text()?;
            text.parse().ok().filter(|v: &f64| v.is_finite())
        };
        for key in EGO_KEYS {
            let Some(text) = ego.and_then(|ego| ego.get(key)).and_then(Node::text) else { continue };
            let most = if *key == "reference_to_centre_m" { MOST_OFFSET_M } else { MOST_SIZE_M };
            let least = if *key == "reference_to_centre_m" { -MOST_OFFSET_M } else { f64::MIN_POSITIVE };
            if !text.parse().is_ok_and(|v: f64| (least..=most).contains(&v)) {
                return fail(
                    out,
                    &label,
                    &format!("'ego.{key}' 的值 '{text}' 不可能：应为以米为单位的数"),
                    &format!("'ego.{key}' cannot be '{text}': a number in meters is expected"),
                );
            }
        }
        let size = |key: &str| number(key).unwrap_or(f64::NAN);
        let Some(reference_to_centre_m) = number("reference_to_centre_m") else {
            return fail(
                out,
                &label,
                "缺少 'ego.reference_to_centre_m'：从位姿参考点向前到车身中心的距离（位姿即中心时为 0）",
                "'ego.reference_to_centre_m' is missing: from the point of the pose forward to the middle of the car (0 when that is the point)",
            );
        };
        let half_length = 0.5 * size("length_m");
        if reference_to_centre_m.abs() > half_length + BEYOND_END_M {
            return fail(
                out,
                &label,
                &format!("'ego.reference_to_centre_m' 为 {reference_to_centre_m} m，参考点落在车外"),
                &format!(
                    "'ego.reference_to_centre_m' is {reference_to_centre_m} m: that point is not on the car"
                ),
            );
        }
        let map_complete_for = complete_for(root.get("map_complete_for"), &label, out);
        Some(Self {
            map_complete_for,
            drive_id: text("drive_id"),
            source,
            place: text("place"),
            map_ref: text("map_ref"),
            licence: text("licence"),
            start_time,
            ego: EgoBox {
                length_m: size("length_m"),
                width_m: size("width_m"),
                height_m: size("height_m"),
                reference_to_centre_m,
            },
        })
    }
}

/// The file as a table of keys; what is wrong with it goes into the report.
fn parse(file: &Input<'_>, label: &str, reader: &mut Reader) -> Option<Node> {
    let text = file.text().map_err(|e| Bilingual::new(zh(&e.to_string()), e.to_string()));
    let parsed = text.and_then(|text| {
        reader.hash.add("drive", text.as_bytes());
        // YAML reads JSON too.
        yaml::parse(&text).map_err(|e| {
            let (message, at) = (e.message(), format!("{}:{}", e.mark.line, e.mark.column));
            Bilingual::new(format!("{at}：{}", message.zh), format!("{at}: {}", message.en))
        })
    });
    let out = &mut reader.report.diagnostics;
    match parsed {
        Ok(root) if matches!(root.value, Value::Map(_)) => Some(root),
        Ok(_) => fail(out, label, "不是键值表", "the file is not a table of keys"),
        Err(e) => {
            let (zh, en) = (format!("无法读取：{}", e.zh), format!("it cannot be read: {}", e.en));
            fail(out, label, &zh, &en)
        }
    }
}

/// The drive's own keys, and those of `shared` that it does not have.
fn completed(mut own: Node, shared: &Node) -> Node {
    let Value::Map(entries) = &mut own.value else { return own };
    for entry in shared.entries() {
        match entries.iter_mut().find(|e| e.key == entry.key) {
            None => entries.push(entry.clone()),
            Some(e) if matches!(e.node.value, Value::Map(_)) => {
                e.node = completed(e.node.clone(), &entry.node);
            }
            Some(_) => {}
        }
    }
    own
}

fn complete_for(list: Option<&Node>, file: &str, out: &mut Vec<Diagnostic>) -> Declared {
    let known = Declared::words();
    let mut words = UnknownWords::default();
    let mut declared = Declared::default();
    let items = list.map_or(&[][..], |node| match &node.value {
        Value::List(items) => items,
        _ => std::slice::from_ref(node),
    });
    for item in items {
        let word = item.text().map_or_else(|| item.value.description().en, str::to_owned);
        if let Some(word) = words.check("map_complete_for", &word, &known) {
            declared.add(&word);
        }
    }
    out.extend(words.diagnostics(file));
    declared
}

fn fail<T>(out: &mut Vec<Diagnostic>, file: &str, zh: &str, en: &str) -> Option<T> {
    out.push(findings::bad_meta(file, zh.to_owned(), en.to_owned()));
    None
}

fn unknown_keys(table: &Node, known: &[&str], file: &str, out: &mut Vec<Diagnostic>) {
    let keys = table.entries().iter().map(|e| e.key.as_str());
    out.extend(keys.filter(|k| !known.contains(k)).map(|k| findings::unknown_key(file, k, known)));
}
