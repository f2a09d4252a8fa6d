//! The table that the demo ends with.

use super::release::SPEC;
use crate::text_table::{Align, aligned};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use whyroad_framework::Taxonomy;
use whyroad_lake::Lake;
use whyroad_mining::rule::other::other;
use whyroad_model::messages::{Coverage, EpisodeRecord};
use whyroad_model::{DriveId, Lang, Nanos};
use whyroad_report::coverage::{class_title, counts, rows};

/// Each class that was found, in both languages, with its count and a first example.
pub(super) fn table(
    taxonomy: &Taxonomy,
    coverage: &Coverage,
    episodes: &[EpisodeRecord],
    lake: &Lake,
    lang: Lang,
) -> String {
    let head = match lang {
        Lang::Zh => ["类别", "", "事件", "主要", "示例片段", "关键帧"],
        Lang::En => ["class", "", "episodes", "primary", "example clip", "keyframe"],
    };
    let mut lines: Vec<[String; 6]> = vec![head.map(str::to_owned)];
    let starts = starts(episodes, lake);
    for id in taxonomy.ids().into_iter().chain([other()]) {
        let of_class = || episodes.iter().filter(|e| e.scenario_id == id);
        // The first example: primary, then the best score.
        let Some(example) =
            of_class().reduce(|a, b| if (b.is_primary, b.score) > (a.is_primary, a.score) { b } else { a })
        else {
            continue;
        };
        let title = class_title(taxonomy, &id);
        let start = starts.get(&example.drive_id).copied().unwrap_or(example.keyframe.timestamp);
        lines.push([
            title.zh,
            title.en,
            of_class().count().to_string(),
            of_class().filter(|e| e.is_primary).count().to_string(),
            example.clip_id.to_string(),
            format!("{:.1} s", example.keyframe.timestamp.seconds_since(start)),
        ]);
    }
    let columns = [Align::Left, Align::Left, Align::Right, Align::Right, Align::Left, Align::Right];
    let mut out = aligned(columns, &lines);
    let c = counts(&rows(taxonomy, coverage));
    let _ = match lang {
        Lang::Zh => writeln!(
            out,
            "\n{} 个 L3 场景：已找到 {}，已搜索未找到 {}，不可观测 {}，尚无规则 {}",
            c.total(),
            c.found,
            c.not_found,
            c.not_observable,
            c.no_rule
        ),
        Lang::En => writeln!(
            out,
            "\n{} leaves: {} found, {} searched and not found, {} not observable, {} without a rule yet",
            c.total(),
            c.found,
            c.not_found,
            c.not_observable,
            c.no_rule
        ),
    };
    out
}

/// The start of each drive, from its first clip.
fn starts(episodes: &[EpisodeRecord], lake: &Lake) -> BTreeMap<DriveId, Nanos> {
    let mut out = BTreeMap::new();
    for e in episodes {
        if !out.contains_key(&e.drive_id) {
            let clips = lake.clip_summaries(&e.drive_id).unwrap_or_default();
            if let Some((_, start, _)) = clips.into_iter().min_by_key(|(_, start, _)| *start) {
                out.insert(e.drive_id.clone(), start);
            }
        }
    }
    out
}

/// Paths of the results, and the next steps.
pub(super) fn where_to_look(page: &Path, lake: &Lake, out: &Path, released: bool, lang: Lang) -> String {
    let (lake, mined) = (lake.dir().display(), out.join("mined"));
    let serve = format!("whyroad serve --lake {lake} --mined {}", mined.display());
    let build = format!(
        "whyroad dataset build --spec {} --labels whyroad-data/labels.db --lake {lake} --out my-release",
        out.join(SPEC).display()
    );
    let (page, out) = (page.display(), out.display());
    let mut text = match lang {
        Lang::Zh => format!(
            "报告：{page}（用浏览器打开）；其余结果在 {out}\n在浏览器里看这些片段并标注：{serve}，然后打开 http://127.0.0.1:8080/"
        ),
        Lang::En => format!(
            "report: {page} (open it in a browser); everything else is in {out}\nto look at the clips in the browser and label them: {serve}, then open http://127.0.0.1:8080/"
        ),
    };
    if released {
        text += &match lang {
            Lang::Zh => format!("\n用已接受的标注构建数据集：{build}"),
            Lang::En => format!("\nto build a data set from the labels that were accepted: {build}"),
        };
    }
    text
}
