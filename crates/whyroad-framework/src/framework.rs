//! The whole framework as one value, from the texts of `schema/` and `scenarios/`.

mod load;

use crate::{DecisionSets, Lexicon, ResolvedSpec, Taxonomy};
use include_dir::{Dir, include_dir};
use std::collections::BTreeMap;
use std::sync::OnceLock;
use whyroad_model::{Diagnostic, ScenarioId};

/// Classes, decisions, labelling specs, rule sources, and the texts that other crates parse.
#[derive(Clone, Debug, Default)]
pub struct Framework {
    /// The classes.
    pub taxonomy: Taxonomy,
    /// The decisions in words.
    pub decisions: DecisionSets,
    /// One spec a leaf, inheritance applied.
    pub specs: BTreeMap<ScenarioId, ResolvedSpec>,
    /// One `mining:` block a leaf that has one, in taxonomy order.
    pub rules: Vec<RuleSource>,
    /// Words that name decisions in a trace.
    pub lexicon: Lexicon,
    /// Text of `schema/signals.yaml`, which whyroad-signals parses; empty when the file is absent.
    pub signals_yaml: String,
}

/// A leaf's mining rule as written. whyroad-mining gives it meaning.
#[derive(Clone, Debug, PartialEq)]
pub struct RuleSource {
    /// Which leaf.
    pub leaf: ScenarioId,
    /// `scenarios/<l1>/<l2>.yaml`.
    pub file: String,
    /// The `mining:` block.
    pub rule: serde_yaml_ng::Value,
    /// Line of the block in the file, from 1.
    pub line: usize,
}

static SCHEMA: Dir<'static> = include_dir!("$CARGO_MANIFEST_DIR/../../schema");
static SCENARIOS: Dir<'static> = include_dir!("$CARGO_MANIFEST_DIR/../../scenarios");

impl Framework {
    /// The framework that is built into this program. A test holds it free of findings.
    pub fn bundled() -> &'static Framework {
        static BUNDLED: OnceLock<Framework> = OnceLock::new();
        BUNDLED.get_or_init(|| Framework::from_files(&Framework::bundled_files()).0.unwrap_or_default())
    }

    /// The texts that [`Framework::bundled`] is made of, by relative path.
    pub fn bundled_files() -> BTreeMap<String, String> {
        let mut out = BTreeMap::new();
        collect(&SCHEMA, "schema", &mut out);
        collect(&SCENARIOS, "scenarios", &mut out);
        out
    }

    /// A framework from the texts of its files by relative path (`schema/...yaml`, `scenarios/...yaml`).
    ///
    /// `None` only when there is no usable taxonomy; otherwise what could be read, with everything that is
    /// wrong in it.
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
