//! `whyroad taxonomy diff`.

use super::DiffFormat;
use crate::{Global, output};
use anyhow::{Context as _, bail};
use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;
use whyroad_framework::diff::{Change, ChangeKind, TaxonomyDiff, VersionCheck, diff};
use whyroad_framework::markdown::read_markdown;
use whyroad_framework::taxonomy::read_taxonomy;
use whyroad_framework::version::Version;
use whyroad_framework::{Framework, Taxonomy};
use whyroad_model::{Lang, diagnostic};

pub(super) fn run(global: &Global, a: &Path, b: &Path, format: DiffFormat) -> anyhow::Result<ExitCode> {
    let found = diff(&taxonomy(a, global.lang)?, &taxonomy(b, global.lang)?);
    match format {
        DiffFormat::Json => output::put(&format!("{:#}\n", serde_json::to_value(&found)?)),
        DiffFormat::Text => output::put(&text(&found, global.lang)),
    }
    Ok(match found.version_check {
        VersionCheck::Consistent | VersionCheck::Unknown => output::FINE,
        VersionCheck::TooSmall | VersionCheck::Backwards => output::FINDINGS,
    })
}

/// The taxonomy that an argument names. A taxonomy with mistakes is compared as far as it can be read; they are said on stderr.
fn taxonomy(path: &Path, lang: Lang) -> anyhow::Result<Taxonomy> {
    if path == Path::new("bundled") {
        return Ok(Framework::bundled().taxonomy.clone());
    }
    let file =
        if path.is_dir() { path.join("schema").join("scenario_taxonomy.yaml") } else { path.to_owned() };
    let text = std::fs::read_to_string(&file).with_context(|| format!("cannot read {}", file.display()))?;
    if file.extension().is_some_and(|e| e == "md") {
        let found = read_markdown(&text).to_taxonomy();
        if found.l1.is_empty() {
            bail!("{} lists no classes", file.display());
        }
        return Ok(found);
    }
    let (taxonomy, found) = read_taxonomy(&file.display().to_string(), &text);
    for d in &found {
        eprint!("{}", diagnostic::render_text(d, lang));
    }
    taxonomy.with_context(|| format!("{} holds no taxonomy", file.display()))
}

fn text(d: &TaxonomyDiff, lang: Lang) -> String {
    let mut out = String::new();
    let mut last = None;
    for c in &d.changes {
        if last.replace(c.kind) != Some(c.kind) {
            let count = d.changes.iter().filter(|o| o.kind == c.kind).count();
            let gap = if out.is_empty() { "" } else { "\n" };
            let _ = writeln!(out, "{gap}{} ({count})", kind(c.kind, lang));
        }
        change(c, lang, &mut out);
    }
    if d.changes.is_empty() {
        out.push_str(if lang == Lang::Zh { "没有变化\n" } else { "no changes\n" });
    }
    let _ = writeln!(out, "\n{}", verdict(d, lang));
    out
}

fn kind(k: ChangeKind, lang: Lang) -> &'static str {
    let (zh, en) = match k {
        ChangeKind::Removed => ("删除", "removed"),
        ChangeKind::Moved => ("移动或改 id", "moved or given another id"),
        ChangeKind::Added => ("新增", "added"),
        ChangeKind::Renamed => ("改名", "renamed"),
        ChangeKind::MeaningChanged => ("含义变化", "meaning changed"),
        ChangeKind::Reworded => ("措辞变化", "reworded"),
        ChangeKind::Arranged => ("顺序或引用变化", "order or reference changed"),
    };
    if lang == Lang::Zh { zh } else { en }
}

fn change(c: &Change, lang: Lang, out: &mut String) {
    let step = match c.field {
        Some(field) => format!("{field}, {}", c.step),
        None => c.step.to_string(),
    };
    let _ = match &c.from_id {
        Some(from) => writeln!(out, "  {from} -> {}  [{step}]", c.id),
        None => writeln!(out, "  {}  [{step}]", c.id),
    };
    if let (Some(before), Some(after)) = (&c.before, &c.after) {
        // Where the reader's language did not change, or one side does not have it, the other one tells.
        let other = if lang == Lang::Zh { Lang::En } else { Lang::Zh };
        let (x, y) = (before.get(lang), after.get(lang));
        let shown = if x == y || x.is_empty() || y.is_empty() { other } else { lang };
        let _ = writeln!(out, "    - {}\n    + {}", before.get(shown), after.get(shown));
    }
}

fn verdict(d: &TaxonomyDiff, lang: Lang) -> String {
    let (from, to, step) = (&d.from_version, &d.to_version, d.step);
    let least = Version::parse(from).map(|v| v.after(step).to_string()).unwrap_or_default();
    let (zh, en) = match d.version_check {
        VersionCheck::Consistent => ("与变化相符".to_owned(), "consistent with the changes".to_owned()),
        VersionCheck::TooSmall => (
            format!("过低：这些变化至少需要 {least}"),
            format!("too low: these changes need at least {least}"),
        ),
        VersionCheck::Backwards => ("倒退".to_owned(), "goes backwards".to_owned()),
        VersionCheck::Unknown => ("未写明，无法核对".to_owned(), "not stated, cannot be checked".to_owned()),
    };
    match lang {
        Lang::Zh => format!("所需步级：{step}\n版本 {from} -> {to}：{zh}"),
        Lang::En => format!("step: {step}\nversion {from} -> {to}: {en}"),
    }
}
