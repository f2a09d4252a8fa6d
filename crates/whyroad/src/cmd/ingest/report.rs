//! The report of an ingest, as text and as JSON.

use whyroad_ingest::report::{Counts, counts_text};
use whyroad_ingest::{RowCount, SourceReport};
use whyroad_lake::WriteOutcome;
use whyroad_model::diagnostic::render_json;
use whyroad_model::{Bilingual, Lang, Need};

fn outcome_text(outcome: Option<WriteOutcome>, lang: Lang) -> String {
    let text = match outcome {
        Some(WriteOutcome::Written) => Bilingual::new("已写入", "written"),
        Some(WriteOutcome::Unchanged) => Bilingual::new("未变（内容相同）", "unchanged (same content)"),
        Some(WriteOutcome::Replaced) => Bilingual::new("已替换", "replaced"),
        None => Bilingual::new("未导入", "not ingested"),
    };
    text.get(lang).to_owned()
}

/// For people.
pub(super) fn text_report(reports: &[SourceReport], lang: Lang) -> String {
    let mut out = String::new();
    for r in reports {
        let name = r.drive_id.as_ref().map_or(r.source.as_str(), |id| id.as_str());
        out += &format!("{name}: {}", outcome_text(r.outcome, lang));
        if r.drive_id.is_some() {
            out += &match lang {
                Lang::Zh => format!("，{} 帧，{:.1} 秒，{} 条轨迹", r.frames, r.duration_s, r.tracks),
                Lang::En => format!(", {} frames, {:.1} s, {} tracks", r.frames, r.duration_s, r.tracks),
            };
        }
        out.push('\n');
        for t in &r.tables {
            out += &format!("  {}\n", table_line(t, lang));
        }
        if !r.missing.is_empty() {
            let label = Bilingual::new("日志中没有", "not in the log");
            out += &format!("  {}: {}\n", label.get(lang), Need::list(&r.missing, lang));
        }
    }
    let kept = reports.iter().filter(|r| r.outcome.is_some()).count();
    let dropped: usize = reports.iter().flat_map(|r| &r.tables).map(RowCount::dropped_total).sum();
    out += &match lang {
        Lang::Zh => format!("{} 个来源中 {kept} 个已在数据湖中，丢弃 {dropped} 行\n", reports.len()),
        Lang::En => format!("{kept} of {} sources are in the lake, {dropped} rows dropped\n", reports.len()),
    };
    out
}

fn table_line(t: &RowCount, lang: Lang) -> String {
    let list = |counts: &Counts| counts_text(counts, lang);
    let (read, kept, aside, dropped) = match lang {
        Lang::Zh => ("读取", "保留", "不采用", "丢弃"),
        Lang::En => ("read", "kept", "left out", "dropped"),
    };
    let mut line = format!("{:<12} {read} {:>7}   {kept} {:>7}", t.table, t.read, t.kept_total());
    if t.kept.len() > 1 {
        line += &format!(" ({})", list(&t.kept));
    }
    for (label, counts) in [(aside, &t.set_aside), (dropped, &t.dropped)] {
        if !counts.is_empty() {
            line += &format!("   {label} {} ({})", counts.values().sum::<usize>(), list(counts));
        }
    }
    line
}

/// For programs.
pub(super) fn json_report(reports: &[SourceReport], lang: Lang) -> serde_json::Value {
    let one = |r: &SourceReport| {
        let tables: Vec<_> = r
            .tables
            .iter()
            .map(|t| {
                serde_json::json!({
                    "table": t.table, "read": t.read, "kept": t.kept, "left_out": t.set_aside, "dropped": t.dropped,
                })
            })
            .collect();
        let outcome = r.outcome.map(|o| match o {
            WriteOutcome::Written => "written",
            WriteOutcome::Unchanged => "unchanged",
            WriteOutcome::Replaced => "replaced",
        });
        serde_json::json!({
            "source": r.source, "drive_id": r.drive_id, "outcome": outcome, "frames": r.frames,
            "duration_s": r.duration_s, "tracks": r.tracks, "tables": tables, "missing": r.missing,
            "diagnostics": render_json(&r.diagnostics, lang),
        })
    };
    serde_json::Value::Array(reports.iter().map(one).collect())
}
