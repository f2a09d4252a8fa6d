//! From a message, as JSON, to rows: poses of the ego, objects, bus signals.

use super::fields::{Field, FieldCounts, at};
use super::mapping::{Frame, Role, Rule};
use super::values::{flag, gear, id, number, rotation, text, time, turn_signal, vector};
use crate::assemble::se3::Se3;
use serde_json::Value;
use whyroad_model::scene::TurnSignal;

/// When a row was measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stamp {
    /// ns
    pub time: i64,
    /// The message has a stamp and it is 0: `time` is then the log's.
    pub is_zero: bool,
}

pub(super) struct EgoRow {
    pub stamp: Stamp,
    pub pose: Se3,
    /// Forward and left, m/s.
    pub velocity: Option<[f64; 2]>,
    pub frame_id: String,
    pub child_frame_id: String,
}

pub(super) struct ObjectRow {
    pub stamp: Stamp,
    pub id: String,
    pub class: String,
    /// The height is NaN where the message has none.
    pub pose: Se3,
    pub size: [f64; 3],
    pub velocity: Option<[f64; 2]>,
    pub frame_id: String,
    pub frame: Option<Frame>,
}

pub(super) struct BusRow {
    pub stamp: Stamp,
    /// Name of the signal, as in the rule.
    pub signal: &'static str,
    pub value: BusValue,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BusValue {
    Unknown,
    Number(f64),
    Flag(bool),
    Gear(char),
    TurnSignal(TurnSignal),
}

/// Rows of one message, and how many could not be used, with the reason.
#[derive(Default)]
pub(super) struct Rows {
    pub ego: Vec<EgoRow>,
    pub objects: Vec<ObjectRow>,
    pub bus: Vec<BusRow>,
    pub dropped: Vec<&'static str>,
    /// When the objects were observed, also where there are none; not of a message of which no row can be used.
    pub observed: Option<Stamp>,
}

/// A message, or an element of its list, by a rule.
struct Reader<'a> {
    rule: &'a Rule,
    log_time: i64,
    fields: &'a mut FieldCounts,
}

/// The rows of a message; what became of each field is counted in `fields`.
pub(super) fn of(message: &Value, rule: &Rule, log_time: i64, fields: &mut FieldCounts) -> Rows {
    let mut reader = Reader { rule, log_time, fields };
    match rule.role {
        Role::Ignore => Rows::default(),
        Role::Ego => match reader.ego(message) {
            Ok(row) => Rows { ego: vec![row], ..Rows::default() },
            Err(reason) => Rows { dropped: vec![reason], ..Rows::default() },
        },
        Role::Objects => reader.objects(message),
        Role::Bus => reader.bus(message),
    }
}

impl Reader<'_> {
    /// In the first of the places that has one. Where the rule names a stamp, the log's time does not stand in for one
    /// that is not understood: the two may be of different clocks.
    fn stamp(&mut self, places: &[&Value]) -> Result<Stamp, &'static str> {
        let logged = |is_zero| Ok(Stamp { time: self.log_time, is_zero });
        let Some(path) = self.rule.time.as_deref() else { return logged(false) };
        match self.fields.read("time", Some(path), places, time) {
            Field::Known(0) => logged(true),
            Field::Known(time) => Ok(Stamp { time, is_zero: false }),
            // A message type whose meaning is fixed has a stamp; protobuf leaves out one that is not set.
            Field::Absent if self.rule.is_standard => logged(true),
            _ => Err("no_time"),
        }
    }

    fn pose(&mut self, v: &Value) -> Result<Se3, &'static str> {
        let rule = self.rule;
        let t = match self.fields.read("position", rule.position.as_deref(), &[v], vector) {
            Field::Known(t) => t,
            Field::Unknown => return Err("invalid"),
            _ => return Err("no_position"),
        };
        let heading = self.fields.read("heading", rule.heading.as_deref(), &[v], number);
        if let Field::Known(heading) = heading {
            return Ok(Se3 { q: [(heading / 2.0).cos(), 0.0, 0.0, (heading / 2.0).sin()], t });
        }
        match self.fields.read("orientation", rule.orientation.as_deref(), &[v], rotation) {
            Field::Known(q) => Ok(Se3 { q, t }),
            Field::Unknown => Err("invalid"),
            _ if heading == Field::Unknown => Err("invalid"),
            _ => Err("no_heading"),
        }
    }

    fn velocity(&mut self, v: &Value) -> Option<[f64; 2]> {
        let path = self.rule.velocity.as_deref();
        self.fields.read("velocity", path, &[v], vector).known().map(|v| [v[0], v[1]])
    }

    fn frame_id(&mut self, places: &[&Value]) -> String {
        let path = self.rule.frame_id.as_deref();
        self.fields.read("frame_id", path, places, text).known().unwrap_or_default()
    }

    fn ego(&mut self, message: &Value) -> Result<EgoRow, &'static str> {
        let (stamp, pose) = (self.stamp(&[message])?, self.pose(message)?);
        Ok(EgoRow {
            stamp,
            pose,
            velocity: self.velocity(message),
            frame_id: self.frame_id(&[message]),
            child_frame_id: message.get("child_frame_id").and_then(|v| text(v).ok()?).unwrap_or_default(),
        })
    }

    fn objects(&mut self, message: &Value) -> Rows {
        let mut out = Rows::default();
        let list = match &self.rule.list {
            None => Ok(message),
            Some(path) => at(message, path),
        };
        let Some(list) = list.ok().and_then(Value::as_array) else {
            out.dropped.push("no_list");
            return out;
        };
        for item in list {
            match self.object(item, message) {
                Ok(row) => out.objects.push(row),
                Err(reason) => out.dropped.push(reason),
            }
        }
        out.observed = match out.objects.first() {
            Some(row) => Some(row.stamp),
            None => out.dropped.is_empty().then(|| self.stamp_of_nothing(message)),
        };
        out
    }

    /// Of a message without objects, whose stamp may be one that only objects have.
    fn stamp_of_nothing(&self, message: &Value) -> Stamp {
        let stated = self.rule.time.as_deref().and_then(|path| at(message, path).ok());
        match stated.map(time) {
            Some(Ok(Some(time))) if time != 0 => Stamp { time, is_zero: false },
            Some(Ok(Some(_))) => Stamp { time: self.log_time, is_zero: true },
            _ => Stamp { time: self.log_time, is_zero: false },
        }
    }

    fn object(&mut self, item: &Value, message: &Value) -> Result<ObjectRow, &'static str> {
        let rule = self.rule;
        let id = self.fields.read("id", rule.id.as_deref(), &[item], id).known().ok_or("no_id")?;
        let (pose, stamp) = (self.pose(item)?, self.stamp(&[item, message])?);
        Ok(ObjectRow {
            stamp,
            id,
            class: self
                .fields
                .read("class", rule.class.as_deref(), &[item], text)
                .known()
                .unwrap_or_default(),
            pose,
            size: self
                .fields
                .read("size", rule.size.as_deref(), &[item], vector)
                .known()
                .unwrap_or([f64::NAN; 3]),
            velocity: self.velocity(item),
            frame_id: self.frame_id(&[item, message]),
            frame: rule.frame,
        })
    }

    /// A value that is not understood is unknown from then on: the one before no longer holds.
    fn bus(&mut self, message: &Value) -> Rows {
        let mut out = Rows::default();
        let stamp = match self.stamp(&[message]) {
            Ok(stamp) => stamp,
            Err(reason) => {
                out.dropped.push(reason);
                return out;
            }
        };
        let rule = self.rule;
        let numbers = [
            ("speed_mps", &rule.speed_mps),
            ("steering", &rule.steering),
            ("vertical_accel_mps2", &rule.vertical_accel_mps2),
            ("throttle", &rule.throttle),
        ];
        let mut values: Vec<(&'static str, Field<BusValue>)> = Vec::new();
        let mut read = |name: &'static str, path: &Option<String>, form: &dyn Fn(&Value) -> _| {
            values.push((name, self.fields.read(name, path.as_deref(), &[message], form)));
        };
        for (name, path) in numbers {
            read(name, path, &|v| Ok(number(v)?.map(BusValue::Number)));
        }
        for (name, path) in [("brake", &rule.brake), ("wipers", &rule.wipers)] {
            read(name, path, &|v| Ok(flag(v)?.map(BusValue::Flag)));
        }
        read("gear", &rule.gear, &|v| Ok(gear(v)?.map(BusValue::Gear)));
        read("turn_signal", &rule.turn_signal, &|v| Ok(turn_signal(v)?.map(BusValue::TurnSignal)));
        for (signal, field) in values {
            let value = match field {
                Field::Known(value) => value,
                Field::Unknown => BusValue::Unknown,
                Field::Foreign => BusValue::Unknown,
                Field::Absent => continue,
            };
            out.bus.push(BusRow { stamp, signal, value });
        }
        if out.bus.is_empty() {
            out.dropped.push("invalid");
        }
        out
    }
}
