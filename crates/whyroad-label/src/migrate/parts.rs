//! Converts each part of an older label to its current form.

use super::loss::lost;
use serde_json::{Map, Value, json};
use whyroad_framework::Framework;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::label_fields::name;
use whyroad_model::messages::KeyframeType;
use whyroad_model::scene::FRAME_RATE_HZ;
use whyroad_model::{Diagnostic, Nanos};

/// Conversion between frames and times: a frame whose time the document states.
pub(super) struct Times {
    anchor: Option<(Nanos, f64)>,
}

impl Times {
    pub fn of(fields: &Map<String, Value>, document: &Map<String, Value>) -> Self {
        let pair =
            |time: &Value, frame: &Value| Some((Nanos::parse_iso(time.as_str()?).ok()?, frame.as_f64()?));
        let range = fields
            .get(name::TIME_RANGE)
            .and_then(|r| pair(&r[name::START_TIMESTAMP], &r[name::START_FRAME_IDX]));
        let key = fields.get(name::KEYFRAME).and_then(|k| pair(&k[name::TIMESTAMP], &k[name::FRAME_IDX]));
        let clip = document.get("clip_start").and_then(|t| pair(t, &json!(0)));
        Self { anchor: range.or(key).or(clip) }
    }

    fn time(&self, frame: f64) -> Option<String> {
        let (time, at) = self.anchor?;
        Some(time.plus_secs((frame - at) / FRAME_RATE_HZ).to_string())
    }

    fn frame(&self, time: &str) -> Option<u64> {
        let (anchor, at) = self.anchor?;
        let frame = at + Nanos::parse_iso(time).ok()?.seconds_since(anchor) * FRAME_RATE_HZ;
        (frame >= -0.5).then_some(frame.round().max(0.0) as u64)
    }
}

/// A class: an object, a full id, or a unique part of one.
pub(super) fn scenario(framework: &Framework, value: Value, report: &mut Vec<Diagnostic>) -> Option<Value> {
    let text = match &value {
        Value::String(s) => s.clone(),
        Value::Object(o) if o.contains_key(name::L2) => return Some(value),
        Value::Object(o) => {
            ["full_id", "id", "scenario_id"].iter().find_map(|k| o.get(*k)?.as_str().map(str::to_owned))?
        }
        _ => String::new(),
    };
    let wanted = text.trim();
    let all = framework.taxonomy.ids();
    let is = |id: &str| id == wanted || id.ends_with(&format!(".{wanted}"));
    let mut found: Vec<_> = all.iter().filter(|id| id.l2.is_some() && is(&id.to_string())).collect();
    if found.is_empty() {
        let named = framework.taxonomy.l1.iter().flat_map(|a| {
            a.l2.iter().flat_map(move |b| {
                b.l3.iter()
                    .filter(move |c| c.name.zh == wanted || c.name.en.eq_ignore_ascii_case(wanted))
                    .map(move |c| whyroad_model::ScenarioId::leaf(&a.id, &b.id, &c.id))
            })
        });
        let by_name: Vec<_> = named.collect();
        found = all.iter().filter(|id| by_name.contains(id)).collect();
    }
    let [one] = found[..] else {
        report.push(lost(
            "/scenario",
            &format!("'{wanted}' 不能确定为一个类别"),
            &format!("'{wanted}' does not name one class"),
        ));
        return None;
    };
    Some(
        json!({ (name::L1): one.l1, (name::L2): one.l2, (name::L3): one.l3, (name::FULL_ID): one.to_string() }),
    )
}

/// A decision: the current object, one id, or `longitudinal/lateral/direction`.
pub(super) fn decision(value: Value, report: &mut Vec<Diagnostic>) -> Option<Value> {
    let ids: Vec<String> = match &value {
        Value::Object(o) if o.contains_key(name::LONGITUDINAL) || o.contains_key(name::LATERAL) => {
            let part = |k: &str| o.get(k).cloned().unwrap_or(Value::Null);
            let mut out = json!({
                (name::LONGITUDINAL): part(name::LONGITUDINAL), (name::LATERAL): part(name::LATERAL),
            });
            let side = o.get(name::LATERAL_DIRECTION).or_else(|| o.get("direction"));
            if let Some(side) = side.filter(|s| !s.is_null()) {
                out[name::LATERAL_DIRECTION] = side.clone();
            }
            return Some(out);
        }
        Value::String(s) => s.split(['/', '+', ',']).map(|p| p.trim().to_owned()).collect(),
        Value::Array(a) => a.iter().filter_map(|v| v.as_str().map(str::to_owned)).collect(),
        _ => Vec::new(),
    };
    let (mut along, mut across, mut side) = (None, None, None);
    for id in ids.iter().filter(|id| !matches!(id.as_str(), "" | "-" | "none" | "null")) {
        if let Some(d) = Longitudinal::from_id(id) {
            along = along.or(Some(d));
        } else if let Some(d) = Lateral::from_id(id) {
            across = across.or(Some(d));
        } else if let Some(d) = LateralDirection::from_id(id) {
            side = side.or(Some(d));
        } else {
            report.push(lost(
                "/driving_decision",
                &format!("'{id}' 不是决策"),
                &format!("'{id}' is not a decision"),
            ));
        }
    }
    let id = |d: Option<&'static str>| d.map_or(Value::Null, |d| json!(d));
    let mut out = json!({
        (name::LONGITUDINAL): id(along.map(|d| d.id())), (name::LATERAL): id(across.map(|d| d.id())),
    });
    if let Some(side) = side {
        out[name::LATERAL_DIRECTION] = json!(side.id());
    }
    Some(out)
}

/// Components: objects, or texts.
pub(super) fn factors(value: Value, report: &mut Vec<Diagnostic>) -> Option<Value> {
    let Value::Array(items) = value else {
        report.push(lost("/critical_components", "关键要素不是列表", "the components are not a list"));
        return None;
    };
    let mut out = Vec::new();
    for (i, item) in items.into_iter().enumerate() {
        let at = format!("/critical_components/{i}");
        match item {
            Value::String(s) => out.push(json!({ (name::DESCRIPTION): s })),
            Value::Object(mut o) => {
                let text = [name::DESCRIPTION, "factor", "text", "content", "name"]
                    .iter()
                    .find_map(|k| o.remove(*k));
                let Some(text) = text.filter(Value::is_string) else {
                    report.push(lost(
                        &at,
                        "该要素没有描述，未保留",
                        "this component has no description and is removed",
                    ));
                    continue;
                };
                if let Some(kind) = o.remove("type") {
                    o.entry(name::CATEGORY).or_insert(kind);
                }
                let known =
                    [name::CATEGORY, name::UNCERTAINTY, name::ID, name::EVIDENCE_TIMES, name::LINKED_OBJECTS];
                let unknown: Vec<String> =
                    o.keys().filter(|k| !known.contains(&k.as_str())).cloned().collect();
                for key in unknown {
                    o.remove(&key);
                    report.push(lost(
                        &format!("{at}/{key}"),
                        &format!("要素的 '{key}' 没有对应字段，未保留"),
                        &format!("'{key}' of a component has no equivalent and is removed"),
                    ));
                }
                o.insert(name::DESCRIPTION.to_owned(), text);
                out.push(Value::Object(o));
            }
            _ => report.push(lost(
                &at,
                "该要素不是文字或对象，未保留",
                "this component is neither text nor object and is removed",
            )),
        }
    }
    Some(Value::Array(out))
}

/// A time range: the current object, or two times or frames.
pub(super) fn range(value: Value, times: &Times, report: &mut Vec<Diagnostic>) -> Option<Value> {
    let (start, end) = match &value {
        Value::Object(o) if o.contains_key(name::START_TIMESTAMP) => return Some(value),
        Value::Object(o) => {
            let either = |a: &str, b: &str| o.get(a).or_else(|| o.get(b)).cloned().unwrap_or(Value::Null);
            (either("start", "start_time"), either("end", "end_time"))
        }
        Value::Array(a) if a.len() == 2 => (a[0].clone(), a[1].clone()),
        _ => (Value::Null, Value::Null),
    };
    let (Some((start, first)), Some((end, last))) = (instant(&start, times), instant(&end, times)) else {
        report.push(lost(
            "/time_range",
            "时间范围没有可用的时间戳",
            "the time range has no usable timestamps",
        ));
        return None;
    };
    let mut out = json!({ (name::START_TIMESTAMP): start, (name::END_TIMESTAMP): end });
    if let (Some(first), Some(last)) = (first, last) {
        out[name::START_FRAME_IDX] = json!(first);
        out[name::END_FRAME_IDX] = json!(last);
    }
    Some(out)
}

/// A keyframe: the current object, a time, or a frame.
pub(super) fn moment(
    value: Value,
    times: &Times,
    kind: Option<KeyframeType>,
    report: &mut Vec<Diagnostic>,
) -> Option<Value> {
    let mut fields = match &value {
        Value::Object(o) => o.clone(),
        _ => Map::new(),
    };
    let stated = match &value {
        Value::Object(o) => {
            [name::TIMESTAMP, "time", name::FRAME_IDX, "frame"].iter().find_map(|k| o.get(*k)).cloned()
        }
        other => Some(other.clone()),
    };
    let Some((time, frame)) = stated.and_then(|v| instant(&v, times)) else {
        report.push(lost("/keyframe", "关键帧没有可用的时间戳", "the keyframe has no usable timestamp"));
        return None;
    };
    let Some(frame) = fields.get(name::FRAME_IDX).and_then(Value::as_u64).or(frame) else {
        report.push(lost("/keyframe", "关键帧没有帧号", "the keyframe has no frame"));
        return None;
    };
    for old in ["time", "frame"] {
        fields.remove(old);
    }
    fields.insert(name::TIMESTAMP.to_owned(), json!(time));
    fields.insert(name::FRAME_IDX.to_owned(), json!(frame));
    if let (Some(kind), None) = (kind, fields.get(name::TYPE)) {
        fields.insert(name::TYPE.to_owned(), json!(kind.id()));
    }
    Some(Value::Object(fields))
}

/// A time with its frame, from either of them.
fn instant(value: &Value, times: &Times) -> Option<(String, Option<u64>)> {
    match value {
        Value::String(s) if Nanos::parse_iso(s).is_ok() => Some((s.clone(), times.frame(s))),
        Value::Number(n) => {
            let frame = n.as_u64()?;
            Some((times.time(frame as f64)?, Some(frame)))
        }
        _ => None,
    }
}

/// The type of keyframe that the class prescribes.
pub(super) fn keyframe_type(framework: &Framework, scenario: Option<&Value>) -> Option<KeyframeType> {
    let s = scenario?;
    let text = |k: &str| s.get(k).and_then(Value::as_str);
    let id = whyroad_model::ScenarioId {
        l1: text(name::L1)?.to_owned(),
        l2: text(name::L2).map(str::to_owned),
        l3: text(name::L3).map(str::to_owned),
    };
    framework.specs.get(&id).or_else(|| framework.l2_specs.get(&id)).map(|s| s.keyframe.kind)
}
