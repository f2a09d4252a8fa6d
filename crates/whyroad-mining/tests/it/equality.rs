//! That the fast evaluator is the reference: the same episodes with the same scores, the same rules not observable for
//! lack of the same signals. And drives made harder: with frames missing, with signals lost.

use std::ops::Range;
use whyroad_framework::Framework;
use whyroad_mining::{DriveEpisodes, Episode, RuleSet, fast, mine_drive};
use whyroad_model::{Column, FrameRange, SignalTable, Tri};
use whyroad_signals::Catalog;

/// Every bundled rule.
pub fn rules() -> RuleSet {
    RuleSet::of_framework(Framework::bundled(), Catalog::bundled()).0
}

/// Mines with both; how many episodes there were.
pub fn assert_equal(rules: &RuleSet, table: &SignalTable) -> usize {
    let reference = mine_drive(rules, table);
    assert_same(&fast::mine_drive(rules, table), &reference);
    reference.episodes.len()
}

fn assert_same(fast: &DriveEpisodes, reference: &DriveEpisodes) {
    assert_eq!(fast.missing, reference.missing, "{}", reference.drive_id);
    assert_eq!(fast.episodes.len(), reference.episodes.len(), "{}", reference.drive_id);
    for (a, b) in fast.episodes.iter().zip(&reference.episodes) {
        assert!((a.score - b.score).abs() <= 1e-9, "{} against {}", a.score, b.score);
        assert_eq!(a, &Episode { score: a.score, ..b.clone() });
    }
}

/// The drive without some of its frames: every second one is gone for a while.
pub fn with_gaps(table: &SignalTable) -> SignalTable {
    only(table, &(0..table.times.len()).filter(|i| i % 50 < 40 || i % 2 == 0).collect::<Vec<_>>())
}

/// Some frames of the drive.
pub fn part(table: &SignalTable, frames: Range<usize>) -> SignalTable {
    only(table, &(frames.start..frames.end.min(table.times.len())).collect::<Vec<_>>())
}

/// The drive with these frames only.
fn only(table: &SignalTable, keep: &[usize]) -> SignalTable {
    let mut out = SignalTable { times: keep.iter().map(|&i| table.times[i]).collect(), ..table.clone() };
    for column in out.frame_columns.values_mut() {
        *column = taken(column, keep.iter().copied());
    }
    let mut rows = Vec::new();
    out.targets.clear();
    for span in &table.targets {
        let kept: Vec<usize> = (0..keep.len()).filter(|&k| span.frames.contains(keep[k])).collect();
        if let (Some(first), Some(last)) = (kept.first(), kept.last()) {
            let frames = FrameRange::new(*first, last + 1);
            out.targets.push(whyroad_model::signal::TargetSpan {
                first_row: rows.len(),
                frames,
                ..span.clone()
            });
            rows.extend(kept.iter().map(|&k| span.first_row + keep[k] - span.frames.start));
        }
    }
    for column in out.target_columns.values_mut() {
        *column = taken(column, rows.iter().copied());
    }
    out
}

fn taken(column: &Column, rows: impl Iterator<Item = usize>) -> Column {
    match column {
        Column::Number(v) => Column::Number(rows.map(|r| v[r]).collect()),
        Column::Flag(v) => Column::Flag(rows.map(|r| v[r]).collect()),
        Column::Category { codes, names } => {
            Column::Category { codes: rows.map(|r| codes[r]).collect(), names: names.clone() }
        }
    }
}

/// The drive with every third signal lost, and some flags unknown here and there.
pub fn with_less(table: &SignalTable) -> SignalTable {
    let mut out = table.clone();
    for columns in [&mut out.frame_columns, &mut out.target_columns] {
        let names: Vec<String> = columns.keys().cloned().collect();
        names.iter().step_by(3).for_each(|n| drop(columns.remove(n)));
        for column in columns.values_mut() {
            match column {
                Column::Flag(v) => v.iter_mut().step_by(17).for_each(|t| *t = Tri::Unknown),
                Column::Number(v) => v.iter_mut().step_by(23).for_each(|x| *x = f64::NAN),
                Column::Category { .. } => {}
            }
        }
    }
    out
}
