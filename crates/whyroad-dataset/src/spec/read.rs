//! YAML to [`Spec`], continuing after each mistake.

use super::{
    Balance, Cut, Deduplicate, GroupKey, Images, Incomplete, Labels, Licences, Polygon, Reference, Select,
    Spec, Split, Use,
};
use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::{Error as ValueError, StrDeserializer};
use whyroad_framework::taxonomy::{Resolution, class_ambiguous, class_not_found};
use whyroad_framework::{Framework, yaml_text};
use whyroad_model::serde_text::in_chinese;
use whyroad_model::yaml::{Fields, FileReport, FormCodes, Node, Value};
use whyroad_model::{Bilingual, Diagnostic, ScenarioId, Severity};

/// Codes of a spec's diagnostics.
pub const CODES: &[&str] = &[
    "dataset.spec.yaml",
    "dataset.spec.missing",
    "dataset.spec.unknown",
    "dataset.spec.type",
    "dataset.spec.duplicate",
    "dataset.spec.empty",
    "dataset.spec.value",
];

static FORM: FormCodes = FormCodes {
    syntax: "dataset.spec.yaml",
    missing: "dataset.spec.missing",
    unknown: "dataset.spec.unknown",
    kind: "dataset.spec.type",
    duplicate: "dataset.spec.duplicate",
    empty: "dataset.spec.empty",
};

const VALUE: &str = "dataset.spec.value";

/// The spec in `text`; `file` is its name in diagnostics.
///
/// # Errors
/// All errors in it.
pub fn read(text: &str, file: &str, framework: &Framework) -> Result<Spec, Vec<Diagnostic>> {
    let mut r = FileReport::new(file, text, &FORM);
    let mut spec = Spec::default();
    if let Some(root) = yaml_text::parse(&mut r, text)
        && !matches!(root.value, Value::Null)
        && let Some(mut f) = Fields::open(&root, &mut r)
    {
        whole(&mut f, &mut spec, framework, &mut r);
        f.close(&mut r);
    }
    if r.diagnostics.iter().any(|d| d.severity == Severity::Error) { Err(r.diagnostics) } else { Ok(spec) }
}

fn whole(f: &mut Fields<'_>, spec: &mut Spec, framework: &Framework, r: &mut FileReport<'_>) {
    if let Some(n) = f.get("name") {
        match r.text(n) {
            Some(t) if is_slug(&t) => spec.name = t,
            Some(t) => refuse(
                r,
                n,
                format!("'{t}' 只能由小写字母、数字、'-' 和 '_' 组成"),
                format!("'{t}' may have only lower-case letters, digits, '-' and '_'"),
            ),
            None => {}
        }
    }
    spec.title = f.text_opt("title", r);
    text(f, "version", &mut spec.version, r);
    number(f, "seed", &mut spec.seed, r);
    section(f, "labels", r, |s, r| {
        let Labels { statuses, drafts, draft_texts } = &mut spec.labels;
        if let Some(list) = s.get("statuses") {
            *statuses = r.items(list).iter().filter_map(|n| status(n, r)).collect();
        }
        member(s, "drafts", drafts, r);
        member(s, "draft_texts", draft_texts, r);
    });
    section(f, "select", r, |s, r| {
        let Select { classes, exclude_classes, sources, places, weather, min_score } = &mut spec.select;
        ids(s, "classes", classes, framework, r);
        ids(s, "exclude_classes", exclude_classes, framework, r);
        texts(s, "sources", sources, r);
        texts(s, "places", places, r);
        texts(s, "weather", weather, r);
        optional(s, "min_score", min_score, r);
    });
    section(f, "licences", r, |s, r| {
        let Licences { purpose, allow, assume } = &mut spec.licences;
        member::<Use>(s, "purpose", purpose, r);
        texts(s, "allow", allow, r);
        *assume = s.text_opt("assume", r);
    });
    section(f, "sample", r, |s, r| cut(s, &mut spec.sample, r));
    section(f, "split", r, |s, r| split(s, &mut spec.split, r));
    section(f, "deduplicate", r, |s, r| {
        let Deduplicate { exact, near, traces } = &mut spec.deduplicate;
        member(s, "exact", exact, r);
        if let Some(e) = s.entry("near") {
            match e.node.value {
                Value::Null => *near = None,
                _ => *near = within(&e.node, 0.0, 1.0, r).or(*near),
            }
        }
        if let Some(n) = s.get("traces") {
            *traces = within(n, 0.0, 1.0, r).unwrap_or(*traces);
        }
    });
    section(f, "balance", r, |s, r| {
        let Balance { floor_l2, floor_leaf, cap_leaf, cap_cell, weight_exponent, max_weight } =
            &mut spec.balance;
        number(s, "floor_l2", floor_l2, r);
        number(s, "floor_leaf", floor_leaf, r);
        optional(s, "cap_leaf", cap_leaf, r);
        optional(s, "cap_cell", cap_cell, r);
        if let Some(n) = s.get("weight_exponent") {
            *weight_exponent = within(n, 0.0, 1.0, r).unwrap_or(*weight_exponent);
        }
        if let Some(n) = s.get("max_weight") {
            *max_weight = within(n, 1.0, 1e6, r).unwrap_or(*max_weight);
        }
    });
    if let Some(n) = f.get("samples_per_shard") {
        spec.samples_per_shard = within(n, 1.0, 1e7, r).map_or(spec.samples_per_shard, |v| v as usize);
    }
}

/// A state of a finished label. Drafts have a field of their own.
fn status(node: &Node, r: &mut FileReport<'_>) -> Option<String> {
    let t = r.text(node)?;
    if crate::labels::FINISHED.contains(&t.as_str()) || t == crate::labels::IMPORTED {
        return Some(t);
    }
    let known = format!("{}, {}", crate::labels::FINISHED.join(", "), crate::labels::IMPORTED);
    refuse(
        r,
        node,
        format!("'{t}' 不是标签状态：{known}；草稿用 labels.drafts"),
        format!("'{t}' is not one of the states {known}; drafts have labels.drafts"),
    );
    None
}

fn cut(s: &mut Fields<'_>, cut: &mut Cut, r: &mut FileReport<'_>) {
    let mut range = |key: &'static str, low: f64, high: f64, to: &mut f64, r: &mut FileReport<'_>| {
        if let Some(n) = s.get(key) {
            *to = within(n, low, high, r).unwrap_or(*to);
        }
    };
    range("rate_hz", 1.0, 100.0, &mut cut.rate_hz, r);
    range("history_s", 0.0, 60.0, &mut cut.history_s, r);
    range("future_s", 0.0, 60.0, &mut cut.future_s, r);
    range("radius_m", 1.0, 1000.0, &mut cut.radius_m, r);
    range("bev_m_per_px", 0.01, 10.0, &mut cut.bev_m_per_px, r);
    member::<Incomplete>(s, "incomplete", &mut cut.incomplete, r);
    member::<Reference>(s, "reference", &mut cut.reference, r);
    number(s, "max_objects", &mut cut.max_objects, r);
    member(s, "map", &mut cut.map, r);
    member::<Images>(s, "images", &mut cut.images, r);
    texts(s, "cameras", &mut cut.cameras, r);
    if let Some(n) = s.get("image_times_s") {
        let mut times: Vec<f64> = r.items(n).iter().filter_map(|n| within(n, -60.0, 0.0, r)).collect();
        times.sort_by(f64::total_cmp);
        cut.image_times_s = times;
    }
    if let Some(n) = s.get("bev_size_px") {
        cut.bev_size_px = within(n, 16.0, 4096.0, r).map_or(cut.bev_size_px, |v| v as u32);
    }
}

fn split(s: &mut Fields<'_>, split: &mut Split, r: &mut FileReport<'_>) {
    let shares = ["train", "val", "test"].map(|key| s.get(key));
    for (node, to) in shares.iter().zip([&mut split.train, &mut split.val, &mut split.test]) {
        if let Some(n) = node {
            *to = within(n, 0.0, 1.0, r).unwrap_or(*to);
        }
    }
    let sum = split.train + split.val + split.test;
    if (sum - 1.0).abs() > 1e-6
        && let Some(n) = shares.into_iter().flatten().next()
    {
        refuse(
            r,
            n,
            format!("train、val、test 之和应为 1，实为 {sum}"),
            format!("train, val and test must add up to 1, not {sum}"),
        );
    }
    if let Some(n) = s.get("by") {
        let mut by: Vec<GroupKey> = r.items(n).iter().filter_map(|n| word::<GroupKey>(n, r)).collect();
        by.push(GroupKey::Drive);
        by.sort();
        by.dedup();
        split.by = by;
    }
    for (key, to) in
        [("place_cell_m", &mut split.place_cell_m), ("min_distance_m", &mut split.min_distance_m)]
    {
        if let Some(n) = s.get(key) {
            *to = within(n, 0.1, 1e6, r).unwrap_or(*to);
        }
    }
    split.keep = s.text_opt("keep", r);
    split.polygons = s.list("polygons", r).iter().filter_map(|n| polygon(n, r)).collect();
}

fn polygon(node: &Node, r: &mut FileReport<'_>) -> Option<Polygon> {
    let mut f = Fields::open(node, r)?;
    let name = f.text("name", r);
    let place = f.text_opt("place", r);
    let list = f.need("points", r);
    f.close(r);
    let list = list?;
    let points: Vec<[f64; 2]> = r
        .items(list)
        .iter()
        .filter_map(|p| {
            let xy: Vec<f64> = r.items(p).iter().filter_map(|n| within(n, -1e8, 1e8, r)).collect();
            <[f64; 2]>::try_from(xy).ok()
        })
        .collect();
    if points.len() < 3 {
        refuse(
            r,
            list,
            "多边形至少要有三个 [x, y] 点".into(),
            "a polygon needs at least three [x, y] points".into(),
        );
        return None;
    }
    // Twice the area, by the shoelace formula from the first point.
    let [x0, y0] = points[0];
    let cross = |a: &[f64; 2], b: &[f64; 2]| (a[0] - x0) * (b[1] - y0) - (b[0] - x0) * (a[1] - y0);
    if points.windows(2).map(|w| cross(&w[0], &w[1])).sum::<f64>() == 0.0 {
        refuse(r, list, "多边形没有面积".into(), "the polygon encloses no area".into());
        return None;
    }
    Some(Polygon { name: name?, place, points })
}

fn section(
    f: &mut Fields<'_>,
    key: &'static str,
    r: &mut FileReport<'_>,
    read: impl FnOnce(&mut Fields<'_>, &mut FileReport<'_>),
) {
    if let Some(n) = f.get(key)
        && let Some(mut s) = Fields::open(n, r)
    {
        read(&mut s, r);
        s.close(r);
    }
}

fn refuse(r: &mut FileReport<'_>, node: &Node, zh: String, en: String) {
    r.error(VALUE, node, zh, en);
}

fn text(f: &mut Fields<'_>, key: &'static str, to: &mut String, r: &mut FileReport<'_>) {
    if let Some(t) = f.text_opt(key, r) {
        *to = t;
    }
}

fn texts(f: &mut Fields<'_>, key: &'static str, to: &mut Vec<String>, r: &mut FileReport<'_>) {
    if let Some(n) = f.get(key) {
        *to = r.items(n).iter().filter_map(|n| r.text(n)).collect();
    }
}

/// Scalars that `FromStr` reads: numbers without a sign.
fn parsed<T: std::str::FromStr>(node: &Node, r: &mut FileReport<'_>) -> Option<T> {
    let t = r.text(node)?;
    let value = t.parse().ok();
    if value.is_none() {
        let message =
            Bilingual::new(format!("'{t}' 不是合法的数"), format!("'{t}' is not a valid number here"));
        let hint = if std::any::type_name::<T>().starts_with('f') {
            Bilingual::new("此处应为数，例如 0.5", "write a number, such as 0.5")
        } else {
            Bilingual::new("此处应为不小于 0 的整数", "write a whole number, 0 or more")
        };
        r.error_with_hint(VALUE, node, message, hint);
    }
    value
}

fn number<T: std::str::FromStr>(f: &mut Fields<'_>, key: &'static str, to: &mut T, r: &mut FileReport<'_>) {
    if let Some(v) = f.get(key).and_then(|n| parsed(n, r)) {
        *to = v;
    }
}

fn optional<T: std::str::FromStr>(
    f: &mut Fields<'_>,
    key: &'static str,
    to: &mut Option<T>,
    r: &mut FileReport<'_>,
) {
    *to = f.get(key).and_then(|n| parsed(n, r));
}

fn within(node: &Node, low: f64, high: f64, r: &mut FileReport<'_>) -> Option<f64> {
    let v: f64 = parsed(node, r)?;
    if v >= low && v <= high {
        return Some(v);
    }
    // As written in the file: 1e300 would otherwise be 300 digits.
    let t = r.text(node)?;
    refuse(r, node, format!("{t} 应在 {low} 与 {high} 之间"), format!("{t} must be from {low} to {high}"));
    None
}

/// A member of a closed set, or `true` and `false`.
fn member<T: for<'de> Deserialize<'de>>(
    f: &mut Fields<'_>,
    key: &'static str,
    to: &mut T,
    r: &mut FileReport<'_>,
) {
    if let Some(v) = f.get(key).and_then(|n| word(n, r)) {
        *to = v;
    }
}

fn word<T: for<'de> Deserialize<'de>>(node: &Node, r: &mut FileReport<'_>) -> Option<T> {
    let t = r.text(node)?;
    let as_text = || {
        let de: StrDeserializer<'_, ValueError> = t.as_str().into_deserializer();
        T::deserialize(de).map_err(|e| e.to_string())
    };
    let read = match t.as_str() {
        "true" | "false" => serde_json::from_str(&t).or_else(|_| as_text()),
        _ => as_text(),
    };
    match read {
        Ok(v) => Some(v),
        Err(why) => {
            refuse(
                r,
                node,
                format!("'{t}' 不是合法的取值：{}", in_chinese(&why)),
                format!("'{t}' is not a valid value: {why}"),
            );
            None
        }
    }
}

fn ids(
    f: &mut Fields<'_>,
    key: &'static str,
    to: &mut Vec<ScenarioId>,
    framework: &Framework,
    r: &mut FileReport<'_>,
) {
    let Some(list) = f.get(key) else { return };
    to.clear();
    for node in r.items(list) {
        let Some(t) = r.text(node) else { continue };
        let problem = match framework.taxonomy.resolve(&t) {
            Resolution::Found(id) => {
                to.push(id);
                continue;
            }
            Resolution::Ambiguous(ids) => class_ambiguous(&t, &ids),
            Resolution::Unknown(near) => {
                class_not_found(&t, &near.iter().map(ToString::to_string).collect::<Vec<_>>())
            }
        };
        let Bilingual { zh, en } = problem.message;
        refuse(r, node, zh, en);
    }
}

fn is_slug(t: &str) -> bool {
    !t.is_empty()
        && t.len() <= 100
        && t.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || matches!(b, b'-' | b'_'))
}

#[cfg(test)]
mod tests {
    use super::super::TEMPLATE;
    use super::*;

    fn codes(text: &str) -> Vec<(&'static str, usize)> {
        let found = read(text, "spec.yaml", Framework::bundled()).unwrap_err();
        found.iter().map(|d| (d.code, d.location.line.unwrap())).collect()
    }

    #[test]
    fn the_template_shows_the_defaults() {
        let spec = read(TEMPLATE, "spec.yaml", Framework::bundled()).unwrap();
        assert_eq!(spec, Spec::default());
        assert_eq!(read("", "spec.yaml", Framework::bundled()).unwrap(), Spec::default());
    }

    #[test]
    fn every_mistake_is_reported_where_it_is() {
        let text = "name: Big Set\nsplit:\n  train: 0.5\n  by: [drive, plaze]\nsample:\n  rate_hz: 1000\n  histori_s: 2\n\
                    select:\n  classes: [reactive_agent.cutinn]\nlabels: 3\n";
        assert_eq!(
            codes(text),
            [
                ("dataset.spec.value", 1),
                ("dataset.spec.type", 10),
                ("dataset.spec.value", 9),
                ("dataset.spec.value", 6),
                ("dataset.spec.unknown", 7),
                ("dataset.spec.value", 3),
                ("dataset.spec.value", 4),
            ]
        );
        assert_eq!(codes("a: [1")[0].0, "dataset.spec.yaml");
    }

    #[test]
    fn states_that_no_label_has_and_flat_polygons_are_mistakes() {
        assert_eq!(codes("labels: {statuses: [acepted]}"), [("dataset.spec.value", 1)]);
        assert_eq!(codes("labels: {statuses: [draft]}"), [("dataset.spec.value", 1)]);
        assert!(read("labels: {statuses: [accepted, rework]}", "s", Framework::bundled()).is_ok());
        let chinese = read("labels: {draft_texts: zh}", "s", Framework::bundled()).unwrap();
        assert_eq!(chinese.labels.draft_texts, whyroad_model::Lang::Zh);
        assert_eq!(codes("labels: {draft_texts: chinese}"), [("dataset.spec.value", 1)]);
        let told = read("labels: {draft_texts: true}", "s", Framework::bundled()).unwrap_err();
        assert_eq!(told[0].message.zh, "'true' 不是合法的取值：没有取值 `true`，可用：`zh`、`en`");
        let polygon = |points| format!("split: {{polygons: [{{name: n, place: p, points: {points}}}]}}");
        assert_eq!(codes(&polygon("[[0, 0], [1, 1], [2, 2]]")), [("dataset.spec.value", 1)]);
        assert!(read(&polygon("[[9, 9], [10, 9], [10, 10]]"), "s", Framework::bundled()).is_ok());
    }

    #[test]
    fn null_switches_near_duplicates_off() {
        let spec = read("deduplicate:\n  near: null\n", "s", Framework::bundled()).unwrap();
        assert_eq!(spec.deduplicate.near, None);
    }
}
