//! The whole framework as one value, from the texts of `schema/`, `scenarios/` and `prompts/`.

mod files;
mod load;

pub use files::{FrameworkFiles, utf8_text};
pub(crate) use load::{DECISION_TABLE, DECISIONS, RECORD_TYPES};

use crate::{
    Calibration, DecisionSets, DecisionTable, DraftTexts, LabelWords, Lexicon, Prompts, RecordTypes,
    ResolvedSpec, Taxonomy,
};
use include_dir::{Dir, include_dir};
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};
use whyroad_model::yaml::{Mark, Node};
use whyroad_model::{Diagnostic, ScenarioId};

/// Classes, decisions, labeling specs, rule sources, and the texts that other crates parse.
#[derive(Clone, Debug, Default)]
pub struct Framework {
    /// The classes.
    pub taxonomy: Taxonomy,
    /// Texts of the decisions.
    pub decisions: DecisionSets,
    /// One spec per leaf, inheritance applied.
    pub specs: BTreeMap<ScenarioId, ResolvedSpec>,
    /// One spec per L1 with a complete default.
    pub l1_specs: BTreeMap<ScenarioId, ResolvedSpec>,
    /// One spec per L2 that has one, for labels of that L2 without a leaf.
    pub l2_specs: BTreeMap<ScenarioId, ResolvedSpec>,
    /// One `mining:` block per L2 or leaf that has one, in taxonomy order, an L2 before its leaves.
    pub rules: Vec<RuleSource>,
    /// Every expression of the labeling specs as written, in the order of the files.
    pub expressions: Vec<ExpressionSource>,
    /// Version that each file of `scenarios/` states, by relative path.
    pub spec_versions: BTreeMap<String, String>,
    /// The same of the tables of decisions and records.
    pub file_versions: BTreeMap<String, String>,
    /// The tables that read and check the texts of labels.
    reading: Reading,
    /// Types of the required records.
    pub record_types: RecordTypes,
    /// Texts of label drafts.
    pub draft_texts: DraftTexts,
    /// Prompts for language models.
    pub prompts: Prompts,
    /// Accuracy of mined episodes; without the file, no class is calibrated.
    pub calibration: Calibration,
    /// Text of `schema/signals.yaml`, which whyroad-signals parses; empty when the file is absent.
    pub signals_yaml: String,
    /// Text of `schema/precedence.yaml`, which whyroad-mining parses; empty when the file is absent.
    pub precedence_yaml: String,
}

/// The tables that read and check the texts of labels. Compiling the words takes a fifth of a second, and most commands
/// read no label: the bundled ones, which a test keeps free of findings, are compiled on first use.
#[derive(Clone, Debug)]
enum Reading {
    Bundled(OnceLock<Box<ReadingTables>>),
    Read(Box<ReadingTables>),
}

impl Default for Reading {
    fn default() -> Self {
        Self::Read(Box::default())
    }
}

/// Tables that reading the texts of labels needs.
#[derive(Clone, Debug, Default)]
pub struct ReadingTables {
    /// Words that name decisions in a trace.
    pub lexicon: Lexicon,
    /// Words of a label's texts.
    pub label_words: LabelWords,
    /// Which decisions each leaf goes with; its causes are kinds of the words.
    pub decision_table: DecisionTable,
}

/// A mining rule as written, of a leaf or of an L2. whyroad-mining interprets it.
#[derive(Clone, Debug)]
pub struct RuleSource {
    /// The leaf or L2.
    pub leaf: ScenarioId,
    /// `scenarios/<l1>/<l2>.yaml`.
    pub file: String,
    /// The `mining:` block; every part of it knows its position.
    pub rule: Node,
    /// Position of the block's key.
    pub mark: Mark,
    /// The whole file, for error messages.
    pub text: Arc<str>,
}

/// An `expr` of a labeling spec as written: a moment of the rule language. whyroad-mining interprets it.
#[derive(Clone, Debug)]
pub struct ExpressionSource {
    /// The class whose labeling it belongs to: an L1, an L2 or a leaf.
    pub class: ScenarioId,
    /// `scenarios/<l1>.yaml` or `scenarios/<l1>/<l2>.yaml`.
    pub file: String,
    /// The expression: a scalar that knows its position and pointer.
    pub expression: Node,
    /// The whole file, for error messages.
    pub source: Arc<str>,
}

impl ExpressionSource {
    /// The expression's text.
    pub fn text(&self) -> &str {
        self.expression.text().unwrap_or_default().trim()
    }
}

static SCHEMA: Dir<'static> = include_dir!("$CARGO_MANIFEST_DIR/../../schema");
static PROMPTS: Dir<'static> = include_dir!("$CARGO_MANIFEST_DIR/../../prompts");
static SCENARIOS: Dir<'static> = include_dir!("$CARGO_MANIFEST_DIR/../../scenarios");

impl Framework {
    /// The file with the specs and rules of an L2, relative to the framework's folder.
    pub fn spec_path(l1: &str, l2: &str) -> String {
        format!("scenarios/{l1}/{l2}.yaml")
    }

    /// The framework that is built into this program. A test keeps it free of findings.
    pub fn bundled() -> &'static Framework {
        static BUNDLED: OnceLock<Framework> = OnceLock::new();
        BUNDLED.get_or_init(|| load::bundled(&Framework::bundled_files()).unwrap_or_default())
    }

    /// Words that name decisions in a trace.
    pub fn lexicon(&self) -> &Lexicon {
        &self.reading().lexicon
    }

    /// Words of a label's texts.
    pub fn label_words(&self) -> &LabelWords {
        &self.reading().label_words
    }

    /// Which decisions each leaf goes with.
    pub fn decision_table(&self) -> &DecisionTable {
        &self.reading().decision_table
    }

    /// With other tables to read texts.
    pub fn with_reading(self, change: impl FnOnce(&mut ReadingTables)) -> Self {
        let mut tables = self.reading().clone();
        change(&mut tables);
        Self { reading: Reading::Read(Box::new(tables)), ..self }
    }

    fn reading(&self) -> &ReadingTables {
        match &self.reading {
            Reading::Read(tables) => tables,
            Reading::Bundled(tables) => tables.get_or_init(|| {
                Box::new(load::reading(&Self::bundled_files(), &self.taxonomy, &mut Vec::new()))
            }),
        }
    }

    /// The texts of [`Framework::bundled`], by relative path.
    pub fn bundled_files() -> BTreeMap<String, String> {
        let mut out = BTreeMap::new();
        collect(&SCHEMA, "schema", &mut out);
        collect(&SCENARIOS, "scenarios", &mut out);
        out.extend(Self::bundled_prompts());
        out
    }

    /// The built-in framework has the file with this relative path.
    pub(crate) fn is_bundled_file(path: &str) -> bool {
        path.strip_prefix("scenarios/").is_some_and(|of| SCENARIOS.get_file(of).is_some())
            || path.strip_prefix("schema/").is_some_and(|of| SCHEMA.get_file(of).is_some())
    }

    /// The texts of `prompts/`.
    fn bundled_prompts() -> BTreeMap<String, String> {
        let mut out = BTreeMap::new();
        collect(&PROMPTS, "prompts", &mut out);
        out
    }

    /// A framework from the texts of its files by relative path (`schema/...yaml`, `scenarios/...yaml`,
    /// `prompts/...yaml`).
    ///
    /// `None` only when there is no usable taxonomy; otherwise the readable parts, with all errors.
    pub fn from_files(files: &BTreeMap<String, String>) -> (Option<Framework>, Vec<Diagnostic>) {
        load::load(files)
    }

    /// The rule of this leaf, where there is one.
    pub fn rule(&self, leaf: &ScenarioId) -> Option<&RuleSource> {
        self.rules.iter().find(|r| r.leaf == *leaf)
    }
}

fn collect(dir: &Dir<'_>, root: &str, out: &mut BTreeMap<String, String>) {
    for file in dir.files() {
        if let (Some(text), Some(path)) = (file.contents_utf8(), file.path().to_str()) {
            out.insert(format!("{root}/{}", path.replace('\\', "/")), text.to_owned());
        }
    }
    for sub in dir.dirs() {
        collect(sub, root, out);
    }
}
