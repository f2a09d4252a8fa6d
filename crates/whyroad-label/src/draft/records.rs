//! Required records (last column in TAXONOMY.md) that a signal measures. The others are left null, so that the label
//! checker reports them.

use std::collections::BTreeMap;
use whyroad_framework::spec::RecordSpec;
use whyroad_model::units::Unit;
use whyroad_model::{Bilingual, Column, SignalTable, TrackId, Tri};

pub(super) fn known(
    signals: &SignalTable,
    keyframe: usize,
    target: Option<&TrackId>,
    specs: &[RecordSpec],
    notes: &mut Vec<Bilingual>,
) -> BTreeMap<String, serde_json::Value> {
    let mut out = BTreeMap::new();
    for spec in specs {
        match measured(signals, keyframe, target, spec) {
            Some(value) => {
                out.insert(spec.id.clone(), value);
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

/// The target, or the value of the record's signal at the keyframe, in the record's unit or among its choices.
fn measured(
    signals: &SignalTable,
    keyframe: usize,
    target: Option<&TrackId>,
    spec: &RecordSpec,
) -> Option<serde_json::Value> {
    if spec.target {
        return target.map(|id| id.as_str().into());
    }
    let name = spec.signal.as_deref()?;
    let (column, row): (&Column, usize) = match signals.frame_columns.get(name) {
        Some(column) => (column, keyframe),
        None => (signals.target_columns.get(name)?, signals.target(target?)?.row(keyframe)?),
    };
    if spec.choices.is_empty() {
        let base = column.number(row).filter(|v| v.is_finite())?;
        let unit = spec.unit.as_deref().and_then(Unit::parse);
        let value = unit.map_or(base, |u| u.of_base(base));
        return serde_json::Number::from_f64(significant(value)).map(serde_json::Value::Number);
    }
    let Some(word) = column.category(row) else {
        // Flags are stored without language (`scenarios/records.yaml`).
        return match column.flag(row) {
            Tri::True => Some(true.into()),
            Tri::False => Some(false.into()),
            Tri::Unknown => None,
        };
    };
    let choice = spec.choices.iter().find(|c| c.id == word || c.measured.iter().any(|m| m == word))?;
    Some(choice.id.as_str().into())
}

/// Three significant digits: maps and estimates are not more accurate.
fn significant(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
