//! The stable codes of this crate's findings in taxonomies and labeling specs. Each has a page in
//! `docs/diagnostics/`; tests compare this list with the pages and show that each code is emitted.
//! Codes of labels are in `validate`.

/// Codes of taxonomy files, decision files, TAXONOMY.md pages and of looking up a class.
pub const TAXONOMY: &[&str] = &[
    "taxonomy.against.self",
    "taxonomy.against.unknown",
    "taxonomy.children.none",
    "taxonomy.class.ambiguous",
    "taxonomy.class.unknown",
    "taxonomy.conditions.unpaired",
    "taxonomy.decision.unknown",
    "taxonomy.decides.differs",
    "taxonomy.decisions.set",
    "taxonomy.definition.none",
    "taxonomy.field.duplicate",
    "taxonomy.field.missing",
    "taxonomy.field.type",
    "taxonomy.field.unknown",
    "taxonomy.file.missing",
    "taxonomy.generated.stale",
    "taxonomy.id.duplicate",
    "taxonomy.id.malformed",
    "taxonomy.md.class",
    "taxonomy.md.count",
    "taxonomy.md.name",
    "taxonomy.md.structure",
    "taxonomy.md.tree",
    "taxonomy.parent.unknown",
    "taxonomy.text.class",
    "taxonomy.text.empty",
    "taxonomy.text.untranslated",
    "taxonomy.version",
    "taxonomy.yaml",
];

/// Codes of any file of a framework.
pub const FILES: &[&str] = &["framework.encoding"];

/// Codes of labeling specs.
pub const SPEC: &[&str] = &[
    "spec.class.missing",
    "spec.class.unknown",
    "spec.decisions",
    "spec.field.duplicate",
    "spec.field.missing",
    "spec.field.type",
    "spec.field.unknown",
    "spec.file.missing",
    "spec.incomplete",
    "spec.keyframe.type",
    "spec.lateral.unknown",
    "spec.order",
    "spec.path",
    "spec.record.id",
    "spec.record.type",
    "spec.record_types",
    "spec.seconds",
    "spec.text.empty",
    "spec.uncertainty.unknown",
    "spec.version",
    "spec.yaml",
];
