//! From the texts of `schema/` and `scenarios/` to a [`Framework`].

use super::{ExpressionSource, Framework, Reading, ReadingTables, RuleSource};
use crate::calibration::{CALIBRATION_FILE, Calibration};
use crate::decision_table;
use crate::decisions::read_decisions;
use crate::spec::raw::LabelingLayer;
use crate::spec::{ReadSpec, Written, finish, overlay, read_spec};
use crate::taxonomy::{Taxonomy, read_taxonomy};
use crate::{DraftTexts, LabelWords, Lexicon, Prompts, RecordTypes, yaml_text};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, OnceLock};
use whyroad_model::yaml::Entry;
use whyroad_model::{Bilingual, Diagnostic, Location, ScenarioId};

pub(super) const TAXONOMY: &str = "schema/scenario_taxonomy.yaml";
pub(crate) const DECISIONS: &str = "schema/driving_decisions.yaml";
const LEXICON: &str = "schema/decision_lexicon.yaml";
const LABEL_WORDS: &str = "schema/label_words.yaml";
pub(crate) const DECISION_TABLE: &str = "scenarios/decisions.yaml";
pub(crate) const RECORD_TYPES: &str = "scenarios/records.yaml";
const DRAFT_TEXTS: &str = "schema/draft_texts.yaml";
const SIGNALS: &str = "schema/signals.yaml";
const PRECEDENCE: &str = "schema/precedence.yaml";

/// Files of `scenarios/` that do not belong to one class.
const TABLES: &[&str] = &[DECISION_TABLE, RECORD_TYPES];

pub(super) fn load(files: &BTreeMap<String, String>) -> (Option<Framework>, Vec<Diagnostic>) {
    let (framework, mut out) = without_reading(files);
    let framework = framework.map(|mut framework| {
        framework.reading = Reading::Read(Box::new(reading(files, &framework.taxonomy, &mut out)));
        framework
    });
    (framework, out)
}

/// The framework of this program, whose words are compiled on first use.
pub(super) fn bundled(files: &BTreeMap<String, String>) -> Option<Framework> {
    without_reading(files)
        .0
        .map(|framework| Framework { reading: Reading::Bundled(OnceLock::new()), ..framework })
}

/// The tables that read the texts of labels; problems go to `out`.
pub(super) fn reading(
    files: &BTreeMap<String, String>,
    taxonomy: &Taxonomy,
    out: &mut Vec<Diagnostic>,
) -> ReadingTables {
    let mut tables = ReadingTables::default();
    match files.get(LABEL_WORDS) {
        Some(text) => {
            let (words, found) = LabelWords::parse(LABEL_WORDS, text);
            tables.label_words = words;
            out.extend(found);
        }
        None => out.push(missing_file(LABEL_WORDS)),
    }
    match files.get(LEXICON) {
        Some(text) => {
            let (lexicon, found) = Lexicon::parse(LEXICON, text, &tables.label_words.road_users);
            tables.lexicon = lexicon;
            out.extend(found);
        }
        None => out.push(missing_file(LEXICON)),
    }
    // A framework without this table leaves out the checks that read it.
    if let Some(text) = files.get(DECISION_TABLE) {
        let (table, found) = decision_table::parse(DECISION_TABLE, text, taxonomy, &tables.label_words);
        tables.decision_table = table;
        out.extend(found);
    }
    tables
}

fn without_reading(files: &BTreeMap<String, String>) -> (Option<Framework>, Vec<Diagnostic>) {
    let mut out = Vec::new();
    let Some(text) = files.get(TAXONOMY) else {
        out.push(missing_file(TAXONOMY));
        return (None, out);
    };
    let (taxonomy, found) = read_taxonomy(TAXONOMY, text);
    out.extend(found);
    let Some(taxonomy) = taxonomy else { return (None, out) };
    let mut framework = Framework { taxonomy, ..Framework::default() };

    match files.get(DECISIONS) {
        Some(text) => {
            let (decisions, found) = read_decisions(DECISIONS, text);
            framework.decisions = decisions;
            out.extend(found);
        }
        None => out.push(missing_file(DECISIONS)),
    }
    if let Some(text) = files.get(DRAFT_TEXTS) {
        let (texts, found) = DraftTexts::parse(DRAFT_TEXTS, text, &framework.taxonomy);
        framework.draft_texts = texts;
        out.extend(found);
    }
    let (prompts, found) = Prompts::read(files, &Framework::bundled_prompts());
    framework.prompts = prompts;
    out.extend(found);
    // A framework without this table leaves out the checks that read it.
    if let Some(text) = files.get(RECORD_TYPES) {
        let (types, found) = RecordTypes::parse(RECORD_TYPES, text);
        framework.record_types = types;
        out.extend(found);
    }
    if let Some(text) = files.get(CALIBRATION_FILE) {
        let (calibration, found) = Calibration::parse(CALIBRATION_FILE, text);
        framework.calibration = calibration;
        out.extend(found);
    }
    match files.get(SIGNALS) {
        Some(text) => framework.signals_yaml.clone_from(text),
        None => out.push(missing_file(SIGNALS)),
    }
    match files.get(PRECEDENCE) {
        Some(text) => framework.precedence_yaml.clone_from(text),
        None => out.push(missing_file(PRECEDENCE)),
    }
    for file in [DECISIONS, DECISION_TABLE, RECORD_TYPES] {
        let stated = files.get(file).and_then(|text| stated_version(text));
        framework.file_versions.extend(stated.map(|version| (file.to_owned(), version)));
    }
    load_specs(files, &mut framework, &mut out);
    (Some(framework), out)
}

/// The `version` at the head of a file, whatever else is wrong with it.
fn stated_version(text: &str) -> Option<String> {
    let stated = text.lines().find_map(|line| line.strip_prefix("version:"))?;
    let stated = stated.split('#').next()?.trim().trim_matches(['"', '\'']);
    (!stated.is_empty()).then(|| stated.to_owned())
}

fn load_specs(files: &BTreeMap<String, String>, framework: &mut Framework, out: &mut Vec<Diagnostic>) {
    let mut read: BTreeMap<String, ReadSpec> = BTreeMap::new();
    for (path, text) in files {
        // Cases beside the rules belong to whyroad-mining.
        if !path.starts_with("scenarios/")
            || !path.ends_with(".yaml")
            || path.ends_with(".cases.yaml")
            || TABLES.contains(&path.as_str())
        {
            continue;
        }
        let (spec, found) = read_spec(path, text, &framework.taxonomy);
        out.extend(found);
        if let Some(spec) = spec {
            framework.expressions.extend(expressions(path, text, &spec));
            framework.spec_versions.insert(path.clone(), spec.spec.version.clone());
            read.insert(path.clone(), spec);
        }
    }
    let taxonomy: &Taxonomy = &framework.taxonomy;
    for l1 in &taxonomy.l1 {
        let l1_file = format!("scenarios/{}.yaml", l1.id);
        if !files.contains_key(&l1_file) {
            out.push(missing_file(&l1_file));
        }
        let nothing = LabelingLayer::default();
        let default = read.get(&l1_file).and_then(|r| r.spec.labeling.as_ref()).unwrap_or(&nothing);
        let l1_id = ScenarioId { l1: l1.id.clone(), l2: None, l3: None };
        if let Ok(resolved) = finish(l1_id.clone(), default) {
            framework.l1_specs.insert(l1_id, resolved);
        }
        for l2 in &l1.l2 {
            let file = Framework::spec_path(&l1.id, &l2.id);
            let Some(spec) = read.get(&file) else {
                // A file that exists but is unreadable has already been reported.
                if !files.contains_key(&file) {
                    out.push(missing_file(&file));
                }
                continue;
            };
            let l2_layer = overlay(default, spec.spec.labeling.as_ref().unwrap_or(&nothing));
            let text: Arc<str> = files.get(&file).map(String::as_str).unwrap_or_default().into();
            let l2_id = ScenarioId { l1: l1.id.clone(), l2: Some(l2.id.clone()), l3: None };
            // Fields that an L2 leaves to its leaves are reported there.
            if let Ok(resolved) = finish(l2_id.clone(), &l2_layer) {
                framework.l2_specs.insert(l2_id.clone(), resolved);
            }
            let source = |leaf: ScenarioId, entry: &Entry| RuleSource {
                leaf,
                file: file.clone(),
                rule: entry.node.clone(),
                mark: entry.mark,
                text: text.clone(),
            };
            framework.rules.extend(spec.l2_mining.as_ref().map(|entry| source(l2_id, entry)));
            for l3 in &l2.l3 {
                let Some(leaf) = spec.spec.leaves.as_ref().and_then(|l| l.get(&l3.id)) else { continue };
                let id = ScenarioId::leaf(&l1.id, &l2.id, &l3.id);
                let layer = overlay(&l2_layer, leaf.labeling.as_ref().unwrap_or(&nothing));
                let mark = spec.leaf_marks.get(&l3.id);
                match finish(id.clone(), &layer) {
                    Ok(resolved) => {
                        framework.specs.insert(id.clone(), resolved);
                    }
                    Err(missing) => {
                        out.push(incomplete(&id, &missing, &file, mark.map(|m| (m.line, m.column))))
                    }
                }
                framework.rules.extend(spec.mining.get(&l3.id).map(|entry| source(id, entry)));
            }
        }
    }
    // A table that is absent or cannot be read says nothing about any record.
    if !framework.record_types.records.is_empty() {
        record_types(files, &read, framework, out);
    }
    framework.record_types.complete(framework.specs.values().flat_map(|spec| &spec.records));
}

/// Records whose type in `scenarios/records.yaml` is missing or differs from the spec: once where each is written.
fn record_types(
    files: &BTreeMap<String, String>,
    read: &BTreeMap<String, ReadSpec>,
    framework: &Framework,
    out: &mut Vec<Diagnostic>,
) {
    let specs = framework.specs.values().flat_map(|spec| spec.records.iter().map(move |r| (&spec.leaf, r)));
    let mut seen: BTreeSet<(&str, usize, usize)> = BTreeSet::new();
    let mut found = Vec::new();
    for (leaf, record) in specs {
        let Some(message) = framework.record_types.disagrees(record) else { continue };
        let of_l2 = Framework::spec_path(&leaf.l1, leaf.l2.as_deref().unwrap_or_default());
        let of_l1 = format!("scenarios/{}.yaml", leaf.l1);
        let written = [of_l2, of_l1].into_iter().find_map(|file| {
            let (file, spec) = read.get_key_value(&file)?;
            let (_, mark, pointer) = spec.records.iter().find(|(id, ..)| *id == record.id)?;
            Some((file, *mark, pointer))
        });
        let Some((file, mark, pointer)) = written else { continue };
        let place = (file.as_str(), mark.line, mark.column);
        if seen.insert(place) {
            let hint = Bilingual::new(
                "在 scenarios/records.yaml 中写明相同的类型：number 的范围、choice 的取值与用词",
                "state the same type in scenarios/records.yaml: the range of a number, the values of a choice and their words",
            );
            let text = files.get(file).map(String::as_str).unwrap_or_default();
            let at = Location { pointer: Some(pointer.clone()), ..yaml_text::location(file, text, mark) };
            found.push((place, Diagnostic::warning("spec.record.type", message).with_hint(hint).at(at)));
        }
    }
    found.sort_by_key(|(at, _)| *at);
    out.extend(found.into_iter().map(|(_, d)| d));
}

fn expressions(file: &str, text: &str, read: &ReadSpec) -> Vec<ExpressionSource> {
    let text: Arc<str> = text.into();
    let source = |w: &Written| ExpressionSource {
        class: ScenarioId { l1: read.spec.l1.clone(), l2: read.spec.l2.clone(), l3: w.leaf.clone() },
        file: file.to_owned(),
        expression: w.node.clone(),
        source: text.clone(),
    };
    read.expressions.iter().map(source).collect()
}

fn missing_file(path: &str) -> Diagnostic {
    let code = if path.starts_with("scenarios/") { "spec.file.missing" } else { "taxonomy.file.missing" };
    let message = Bilingual::new(format!("缺少文件 '{path}'"), format!("file '{path}' is missing"));
    let bundled = || {
        Bilingual::new(
            "`whyroad taxonomy init` 写出内置框架的全部文件，从中取用",
            "`whyroad taxonomy init` writes all files of the built-in framework: take it from there",
        )
    };
    // A class of a framework folder is in no built-in file.
    let parts: Vec<&str> =
        path.trim_start_matches("scenarios/").trim_end_matches(".yaml").split('/').collect();
    let hint = match parts[..] {
        _ if code == "taxonomy.file.missing" || Framework::is_bundled_file(path) => bundled(),
        [l1, l2] => Bilingual::new(
            format!(
                "新建该文件：version、l1: {l1}、l2: {l2}、labeling（与 L1 不同之处）、leaves（每个 L3 一项，`{{}}` 表示与 L2 相同）"
            ),
            format!(
                "write it with version, l1: {l1}, l2: {l2}, labeling (what differs from the L1) and leaves (one entry \
                 per leaf, `{{}}` where it is labeled as the L2)"
            ),
        ),
        [l1] => Bilingual::new(
            format!("新建该文件：version、l1: {l1}、labeling（keyframe、start、end、pack）"),
            format!("write it with version, l1: {l1} and labeling (keyframe, start, end, pack)"),
        ),
        _ => bundled(),
    };
    Diagnostic::error(code, message).with_hint(hint).in_file(path)
}

fn incomplete(leaf: &ScenarioId, missing: &[&str], file: &str, at: Option<(usize, usize)>) -> Diagnostic {
    let fields = missing.join(", ");
    let message = Bilingual::new(
        format!("L3 场景 '{leaf}' 及其上级都没有规定：{fields}"),
        format!("neither leaf '{leaf}' nor its L2 or L1 states: {fields}"),
    );
    Diagnostic::error("spec.incomplete", message).at(Location {
        file: Some(file.to_owned()),
        line: at.map(|a| a.0),
        column: at.map(|a| a.1),
        ..Location::default()
    })
}
