//! Stage 1: which labels become samples, by status, class, source, place, quality and license. Weather is checked when
//! the drive is open (stage 2), but reported here.

use crate::item::{Dropped, Item, Stage};
use crate::labels::{DRAFT, Labels};
use crate::licence::LicenceTable;
use crate::spec::Spec;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_lake::Lake;
use whyroad_model::scene::DriveMeta;
use whyroad_model::suggest::suggestion_or_known;
use whyroad_model::{Bilingual, Diagnostic, DriveId, ScenarioId, Severity};

/// The place of drives that state none, in the spec and in counts.
const UNKNOWN: &str = "unknown";

/// Results of the selection about the drives.
#[derive(Default)]
pub(crate) struct Selected {
    /// Metadata by drive index; only drives with a candidate.
    pub drives: BTreeMap<u32, DriveMeta>,
    /// License id by drive index.
    pub licences: BTreeMap<u32, String>,
    /// Drives whose license the spec assumes.
    pub assumed: BTreeSet<u32>,
    pub diagnostics: Vec<Diagnostic>,
    /// Reasons to refuse the build.
    pub refused: Vec<Diagnostic>,
}

/// Marks labels that are not selected.
pub(crate) fn select(labels: &mut Labels, spec: &Spec, lake: &Lake, table: &LicenceTable) -> Selected {
    let mut out = Selected::default();
    let present: BTreeSet<DriveId> = lake.drive_ids().into_iter().collect();
    let mut missing: BTreeSet<String> = BTreeSet::new();
    let mut unlicensed: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut items = std::mem::take(&mut labels.items);
    for item in &mut items {
        let name = labels.drives.get(item.drive);
        let reason = by_label(item, labels, spec);
        item.dropped = match reason {
            Some(dropped) => Some(dropped),
            None if !present.contains(&DriveId::from(name)) => {
                missing.insert(name.to_owned());
                Some(Dropped::with(Stage::Select, "drive_missing", name))
            }
            None => {
                let meta = out.drives.entry(item.drive).or_insert_with(|| {
                    lake.outline(&DriveId::from(name)).map(|o| o.meta).unwrap_or_default()
                });
                // What a public data set is under is not a matter of assumption.
                let of_source = || table.of_source(&meta.source).map(|l| l.id.clone());
                let own = meta.licence.clone().or_else(of_source);
                if own.is_none() && spec.licences.assume.is_some() {
                    out.assumed.insert(item.drive);
                }
                let stated = own.or_else(|| spec.licences.assume.clone());
                let licence = stated.as_deref().and_then(|s| table.find(s));
                match (by_drive(meta, spec), licence) {
                    (Some(dropped), _) => Some(dropped),
                    (None, Some(l)) if !table.is_allowed(l, &spec.licences) => {
                        Some(Dropped::with(Stage::Select, "licence", l.id.as_str()))
                    }
                    (None, Some(l)) => {
                        out.licences.insert(item.drive, l.id.clone());
                        None
                    }
                    (None, None) => {
                        unlicensed.entry(stated.unwrap_or_default()).or_default().insert(name.to_owned());
                        None
                    }
                }
            }
        };
    }
    labels.items = items;
    let (refused, warned): (Vec<_>, Vec<_>) = unknown_names(&out.drives, spec, lake, &present)
        .into_iter()
        .partition(|d| d.severity == Severity::Error);
    out.refused.extend(refused);
    out.diagnostics.extend(warned);
    // The license of a drive without remaining candidates is not checked.
    let used: BTreeSet<u32> = labels.items.iter().filter(|i| i.kept()).map(|i| i.drive).collect();
    out.drives.retain(|d, _| used.contains(d));
    let unscored =
        labels.items.iter().filter(|i| i.dropped.as_ref().is_some_and(|d| d.reason == "score_unknown"));
    let unscored = unscored.count();
    if unscored > 0 {
        out.diagnostics.push(without_score(unscored));
    }
    for name in &missing {
        let message = Bilingual::new(
            format!("标签引用的行程 {name} 不在数据湖中"),
            format!("labels name drive {name}, which is not in the lake"),
        );
        out.diagnostics.push(Diagnostic::warning("dataset.labels.drive", message));
    }
    for name in spec.licences.allow.iter().filter(|name| table.find(name).is_none()) {
        out.refused.push(unknown_in_spec(name));
    }
    for (stated, drives) in unlicensed {
        out.refused.push(unknown_licence(&stated, &drives));
    }
    let ids: BTreeSet<String> = out.licences.values().cloned().collect();
    for id in &ids {
        if let Some(licence) = table.find(id)
            && let Some(mut d) = table.objection(licence, &spec.licences)
        {
            let under = out.licences.iter().filter(|(_, l)| *l == id).map(|(d, _)| labels.drives.get(*d));
            let (first, n) = (under.clone().min().unwrap_or_default(), under.count());
            d.message.zh += &format!("：{n} 个行程，例如 {first}");
            d.message.en += &format!(": {n} drives, for example {first}");
            out.refused.push(d);
        }
    }
    if let Err(d) = table.declared(&ids, spec.licences.purpose) {
        out.refused.push(*d);
    }
    out
}

/// Names of sources and places in the spec that no drive of the lake has: the selection would be empty without a word.
fn unknown_names(
    of_labels: &BTreeMap<u32, DriveMeta>,
    spec: &Spec,
    lake: &Lake,
    present: &BTreeSet<DriveId>,
) -> Vec<Diagnostic> {
    type Of = fn(&DriveMeta) -> &str;
    let select = &spec.select;
    let place: Of = |meta| meta.place.as_deref().unwrap_or(UNKNOWN);
    let fields: [(&str, &[String], Of); 2] =
        [("sources", &select.sources, |meta| &meta.source), ("places", &select.places, place)];
    let mut out = Vec::new();
    for (field, wanted, of) in fields {
        let mut known: BTreeSet<String> = of_labels.values().map(|meta| of(meta).to_owned()).collect();
        if wanted.iter().any(|name| !known.contains(name)) {
            // A name that no label has, but another drive; of one that cannot be read it is not known.
            let Ok(outlines) = present.iter().map(|id| lake.outline(id)).collect::<Result<Vec<_>, _>>()
            else {
                continue;
            };
            known.extend(outlines.iter().map(|outline| of(&outline.meta).to_owned()));
        }
        // A spec may be for several lakes: names beside a known one select nothing here.
        let any_known = wanted.iter().any(|name| known.contains(name));
        for name in wanted.iter().filter(|name| !known.contains(*name) && *name != UNKNOWN) {
            let message = Bilingual::new(
                format!("spec 的 select.{field} 中的 '{name}' 未知：数据湖中没有这样的行程"),
                format!("select.{field} in the spec names '{name}', which no drive of the lake has"),
            );
            let hint = suggestion_or_known(name, known.iter().map(String::as_str));
            let severity = if any_known { Diagnostic::warning } else { Diagnostic::error };
            out.push(severity("dataset.select.unknown", message).with_hint(hint));
        }
    }
    out
}

fn without_score(n: usize) -> Diagnostic {
    let message = Bilingual::new(
        format!("{n} 个标签没有得分，无法按 select.min_score 判断，未收入"),
        format!("{n} labels without a score are left out: select.min_score cannot judge them"),
    );
    Diagnostic::warning("dataset.score.unknown", message).with_hint(Bilingual::new(
        "再加 --labels 指定产生这些标签的挖掘结果文件夹，标签从其事件取得得分；或去掉 select.min_score",
        "name the mined folder that they come from with another --labels, so that they take the score of their \
         episodes, or unset select.min_score",
    ))
}

fn unknown_in_spec(name: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("spec 的 licences.allow 中的许可 '{name}' 未知"),
        format!("licences.allow in the spec names the unknown license '{name}'"),
    );
    Diagnostic::error("dataset.licence.unknown", message)
        .with_hint(Bilingual::new("用 schema/licences.yaml 中的编号", "use an id of schema/licences.yaml"))
}

fn unknown_licence(stated: &str, drives: &BTreeSet<String>) -> Diagnostic {
    let (first, n) = (drives.first().map_or("", String::as_str), drives.len());
    let message = if stated.is_empty() {
        Bilingual::new(
            format!("{n} 个行程没有许可信息，例如 {first}"),
            format!("{n} drives state no license, for example {first}"),
        )
    } else {
        Bilingual::new(
            format!("{n} 个行程的许可 '{stated}' 未知，例如 {first}"),
            format!("{n} drives have the unknown license '{stated}', for example {first}"),
        )
    };
    Diagnostic::error("dataset.licence.unknown", message).with_hint(Bilingual::new(
        "用 `ingest --licence` 或 `--meta` 写明许可，在 schema/licences.yaml 中登记；全部行程确属某一许可时，在 spec 中设 \
         licences.assume",
        "state it with `ingest --licence` or `--meta`, list it in schema/licences.yaml, or, where all such drives are \
         under one license, set licences.assume in the spec",
    ))
}

fn by_label(item: &Item, labels: &Labels, spec: &Spec) -> Option<Dropped> {
    let status = labels.statuses.get(item.status);
    let drop = |reason, detail: &str| Some(Dropped::with(Stage::Select, reason, detail));
    if status == DRAFT {
        if !spec.labels.drafts {
            return drop("draft", "labels.drafts is false");
        }
    } else if !spec.labels.statuses.iter().any(|s| s == status) {
        return drop("status", status);
    }
    let class = labels.classes.get(item.class);
    let id: ScenarioId = match class.parse() {
        Ok(id) => id,
        Err(e) => return drop("class", &e),
    };
    let select = &spec.select;
    let inside = |list: &[ScenarioId]| list.iter().any(|c| id.is_within(c));
    if (!select.classes.is_empty() && !inside(&select.classes)) || inside(&select.exclude_classes) {
        return drop("class", class);
    }
    match select.min_score {
        // Unknown is not enough, as for the weather.
        Some(_) if item.score.is_nan() => drop("score_unknown", "the label states no score"),
        Some(least) if f64::from(item.score) < least => drop("score", &format!("{:.2}", item.score)),
        _ => None,
    }
}

fn by_drive(meta: &DriveMeta, spec: &Spec) -> Option<Dropped> {
    let select = &spec.select;
    if !select.sources.is_empty() && !select.sources.contains(&meta.source) {
        return Some(Dropped::with(Stage::Select, "source", meta.source.as_str()));
    }
    let place = meta.place.as_deref().unwrap_or(UNKNOWN);
    if !select.places.is_empty() && !select.places.iter().any(|p| p == place) {
        return Some(Dropped::with(Stage::Select, "place", place));
    }
    None
}
