//! Required records (TAXONOMY.md last column) that a signal measures. The others are left null, so that the
//! label checker names them.

use std::collections::BTreeMap;
use whyroad_framework::spec::RecordSpec;
use whyroad_model::{Bilingual, SignalTable};

/// Record id and the frame signal that is that quantity, in the record's unit.
const MEASURED: &[(&str, &str)] = &[("curvature", "map.curvature_ahead")];

pub(super) fn known(
    signals: &SignalTable,
    keyframe: usize,
    specs: &[RecordSpec],
    notes: &mut Vec<Bilingual>,
) -> BTreeMap<String, serde_json::Value> {
    let mut out = BTreeMap::new();
    for spec in specs {
        let measured = MEASURED.iter().find(|(id, _)| *id == spec.id).and_then(|(_, signal)| {
            let value = signals.frame_columns.get(*signal)?.number(keyframe)?;
            // Three significant places are more than a map is good for.
            serde_json::Number::from_f64((value * 1e4).round() / 1e4)
        });
        match measured {
            Some(value) => {
                out.insert(spec.id.clone(), serde_json::Value::Number(value));
            }
            None => {
                notes.push(Bilingual::new(
                    format!("须记录：{}", spec.name.zh),
                    format!("to be recorded: {}", spec.name.en),
                ));
                out.insert(spec.id.clone(), serde_json::Value::Null);
            }
        }
    }
    out
}
