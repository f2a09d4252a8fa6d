//! `--missing` and `--missing-list`: which drives lack what, by the data that their logs lack, by class, and as a list
//! of every drive and class for other programs.

use super::table::Results;
use crate::output::reason::{Reason, cannot_write, reason};
use crate::text_table::wrapped;
use anyhow::Context as _;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use whyroad_engine::drives::map_drives;
use whyroad_engine::inspect::unavailable;
use whyroad_lake::Lake;
use whyroad_model::messages::LeafCoverage;
use whyroad_model::{DriveId, Lang, Need, ScenarioId, counted};
use whyroad_signals::Catalog;

/// Drives named for each piece of data and each class; the list has all.
const NAMED: usize = 5;

/// Options of `mine` and `merge`.
#[derive(clap::Args, Clone, Debug, Default)]
pub(in crate::cmd) struct MissingArgs {
    /// Also list the data that drives lack, and for each class the drives that cannot show it, with the missing signals
    #[arg(long)]
    pub missing: bool,
    /// Write every drive and class that it cannot show into this file: .csv or .json
    #[arg(long, value_name = "FILE", value_parser = list_file)]
    pub missing_list: Option<PathBuf>,
}

impl MissingArgs {
    /// Writes the list, and returns the text, as far as they are asked for.
    pub fn list(&self, results: &Results<'_>, lake: Option<&Lake>) -> anyhow::Result<Option<String>> {
        if !self.missing && self.missing_list.is_none() {
            return Ok(None);
        }
        let missing = Missing::read(results, lake);
        if let Some(file) = &self.missing_list {
            missing.write(results, file)?;
        }
        Ok(self.missing.then(|| missing.text(results)))
    }
}

fn list_file(text: &str) -> Result<PathBuf, Reason> {
    let path = PathBuf::from(text);
    match path.extension().and_then(|e| e.to_str()) {
        Some("csv" | "json") => Ok(path),
        _ => Err(reason("应为 .csv 或 .json 文件", "expected a .csv or .json file")),
    }
}

/// Missing data: a need of signals, or too little of everything that a signal needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Lack {
    Data(Need),
    TooLittle,
}

impl Lack {
    fn name(self, lang: Lang) -> String {
        match (self, lang) {
            (Self::Data(need), _) => need.name().get(lang).to_owned(),
            (Self::TooLittle, Lang::Zh) => "各项都有一部分，但不足以得出信号".to_owned(),
            (Self::TooLittle, Lang::En) => "a part of the data, too little for a signal".to_owned(),
        }
    }
}

/// Drives and classes for which a piece of data is missing.
#[derive(Default)]
struct Lacking {
    drives: BTreeSet<DriveId>,
    classes: BTreeSet<ScenarioId>,
}

/// A drive that cannot show a class.
#[derive(Serialize)]
struct Row<'a> {
    drive_id: &'a DriveId,
    scenario_id: &'a ScenarioId,
    /// Signals that the rule needs.
    missing_signals: &'a [String],
    /// What the log lacks for them; absent where the lake stores no signals of the drive.
    missing_data: Option<Vec<&'static str>>,
}

/// What drives lack for the requested classes.
struct Missing {
    /// Unsupported signals of each drive with the missing data, where the lake stores its signals.
    unavailable: BTreeMap<DriveId, BTreeMap<String, Vec<Need>>>,
    by_data: Vec<(Lack, Lacking)>,
    /// Drives whose data is unknown.
    unknown: usize,
}

impl Missing {
    /// Reads what the drives lack, where there is a lake.
    fn read(results: &Results<'_>, lake: Option<&Lake>) -> Self {
        let rows = results.gaps();
        let drives: BTreeSet<DriveId> =
            rows.iter().flat_map(|l| &l.gaps).flat_map(|g| g.drives.iter().cloned()).collect();
        let ids: Vec<DriveId> = drives.into_iter().collect();
        let mut of_drives = BTreeMap::new();
        if let Some(lake) = lake {
            let one = |id: &DriveId| unavailable(lake, id).ok().flatten().map(|u| (id.clone(), u));
            let kept: Result<(), std::convert::Infallible> = map_drives(&ids, None, one, |of_drive| {
                of_drives.extend(of_drive);
                Ok(())
            });
            let Ok(()) = kept;
        }
        let mut by_data = BTreeMap::<Lack, Lacking>::new();
        for (leaf, gap) in rows.iter().flat_map(|l| l.gaps.iter().map(move |g| (l, g))) {
            for drive in &gap.drives {
                let Some(of_drive) = of_drives.get(drive) else { continue };
                for lack in lacks(of_drive, &gap.missing_signals) {
                    let lacking = by_data.entry(lack).or_default();
                    lacking.drives.insert(drive.clone());
                    lacking.classes.insert(leaf.scenario_id.clone());
                }
            }
        }
        let mut by_data: Vec<_> = by_data.into_iter().collect();
        by_data.sort_by(|(a, x), (b, y)| {
            y.drives.len().cmp(&x.drives.len()).then_with(|| x.drives.cmp(&y.drives)).then(a.cmp(b))
        });
        Self { unknown: ids.len() - of_drives.len(), unavailable: of_drives, by_data }
    }

    /// The text: data first, then classes.
    fn text(&self, results: &Results<'_>) -> String {
        let lang = results.lang;
        let zh = lang == Lang::Zh;
        let mut out = String::new();
        if !self.by_data.is_empty() {
            out += match lang {
                Lang::Zh => "行程缺少的数据（括号内为需要它的类别数）：\n",
                Lang::En => "Data that drives lack, and the classes that need it:\n",
            };
        }
        // Drives of one source mostly lack the same.
        for same in self.by_data.chunk_by(|a, b| a.1.drives == b.1.drives) {
            let drives = &same[0].1.drives;
            let drives = named(drives.iter(), drives.len(), lang);
            let data = same.iter().map(|(lack, of)| {
                let (name, classes) = (lack.name(lang), of.classes.len());
                if zh {
                    format!("{name}（{classes} 个类别）")
                } else {
                    format!("{name} ({classes} {})", if classes == 1 { "class" } else { "classes" })
                }
            });
            let data: Vec<String> = data.collect();
            let line = if zh { format!("  {drives}：") } else { format!("  {drives}:") };
            out += &wrapped(&format!("{line} {}", data.join(if zh { "、 " } else { ", " })), 4);
        }
        if self.unknown > 0 {
            let n = self.unknown;
            out += &wrapped(
                &if zh {
                    format!("  {n} 个行程没有可读的已存信号，其缺少的数据未列出，只列信号")
                } else {
                    let of = counted(n, "drive");
                    format!("  of {of} without readable stored signals only the missing signals are known")
                },
                4,
            );
        }
        out += if zh { "不可观测的类别：\n" } else { "Classes that are not observable:\n" };
        results.gaps().iter().for_each(|l| out += &class(results, l));
        out
    }

    /// Writes every drive and class.
    fn write(&self, results: &Results<'_>, file: &Path) -> anyhow::Result<()> {
        let cannot = || cannot_write(file.display());
        let gaps = results.gaps();
        let rows = gaps.iter().flat_map(|l| l.gaps.iter().map(move |g| (l, g)));
        let rows = rows.flat_map(|(l, gap)| {
            gap.drives.iter().map(move |drive_id| {
                let lacks = self.unavailable.get(drive_id).map(|of| lacks(of, &gap.missing_signals));
                let data = |lack: &Lack| match lack {
                    Lack::Data(need) => Some(need.id()),
                    Lack::TooLittle => None,
                };
                Row {
                    drive_id,
                    scenario_id: &l.scenario_id,
                    missing_signals: &gap.missing_signals,
                    missing_data: lacks.map(|lacks| lacks.iter().filter_map(data).collect()),
                }
            })
        });
        let mut rows: Vec<Row<'_>> = rows.collect();
        rows.sort_by_key(|r| r.drive_id);
        if file.extension().is_some_and(|e| e == "json") {
            return std::fs::write(file, serde_json::to_string_pretty(&rows)? + "\n").with_context(cannot);
        }
        let mut to = csv::Writer::from_path(file).with_context(cannot)?;
        to.write_record(["drive_id", "scenario_id", "missing_signals", "missing_data"])
            .with_context(cannot)?;
        for r in rows {
            let data = r.missing_data.unwrap_or_default().join("; ");
            let signals = r.missing_signals.join("; ");
            to.write_record([r.drive_id.as_str(), &r.scenario_id.to_string(), &signals, &data])
                .with_context(cannot)?;
        }
        to.flush().with_context(cannot)
    }
}

/// What a drive lacks for these signals.
fn lacks(unavailable: &BTreeMap<String, Vec<Need>>, signals: &[String]) -> BTreeSet<Lack> {
    let of = |signal: &String| match unavailable.get(signal).map(Vec::as_slice) {
        None | Some([]) => vec![Lack::TooLittle],
        Some(needs) => needs.iter().copied().map(Lack::Data).collect(),
    };
    signals.iter().flat_map(of).collect()
}

/// A class: the drives that were searched for it, then the others by what they lack.
fn class(results: &Results<'_>, l: &LeafCoverage) -> String {
    let (id, searched, all) = (results.short_id(&l.scenario_id), l.drives_searched, results.summary.drives);
    let mut out = match results.lang {
        Lang::Zh => format!("{id}：已搜索 {searched}/{all} 个行程\n"),
        Lang::En => format!("{id}: {searched} of {} searched\n", counted(all, "drive")),
    };
    for gap in &l.gaps {
        let drives = named(gap.drives.iter(), gap.drives.len(), results.lang);
        let signals = gap.missing_signals.iter().map(|id| {
            let title = Catalog::bundled().title(id);
            match results.lang {
                // The id is what rules are written with.
                Lang::Zh => format!("{}（{id}）", title.zh),
                Lang::En => format!("{} ({id})", title.en),
            }
        });
        let signals: Vec<String> = signals.collect();
        let line = match results.lang {
            Lang::Zh => format!("  {drives}： 缺少 {}", signals.join("、 ")),
            Lang::En => format!("  {drives}: missing {}", signals.join(", ")),
        };
        out += &wrapped(&line, 4);
    }
    out
}

/// The number of drives, with the first of them.
fn named<'a>(drives: impl Iterator<Item = &'a DriveId>, n: usize, lang: Lang) -> String {
    let names: Vec<&str> = drives.take(NAMED).map(DriveId::as_str).collect();
    match lang {
        Lang::Zh => {
            let more = if n > NAMED { " 等" } else { "" };
            format!("{n} 个行程（{}{more}）", names.join(", "))
        }
        Lang::En => {
            let more = if n > NAMED { ", ..." } else { "" };
            format!("{} ({}{more})", counted(n, "drive"), names.join(", "))
        }
    }
}
