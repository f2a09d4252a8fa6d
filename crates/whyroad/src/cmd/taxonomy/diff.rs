//! `whyroad taxonomy diff`.

use crate::output::Print;
use crate::output::reason::{cannot_read, no_framework, stop};
use crate::{Global, framework_folder, output};
use anyhow::Context as _;
use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;
use whyroad_framework::diff::{
    Change, ChangeKind, FileVersion, TaxonomyDiff, VersionCheck, diff, diff_frameworks,
};
use whyroad_framework::markdown::read_markdown;
use whyroad_framework::taxonomy::read_taxonomy;
use whyroad_framework::version::Version;
use whyroad_framework::{Framework, Taxonomy};
use whyroad_model::{Diagnostic, Lang};

pub(super) fn run(global: &Global, a: &Path, b: &Path, print: Print) -> anyhow::Result<ExitCode> {
    let found = match (side(a, global.lang)?, side(b, global.lang)?) {
        (Side::Framework(a), Side::Framework(b)) => diff_frameworks(&a, &b),
        (x, y) => {
            let single = if matches!(x, Side::Classes(_)) { a } else { b };
            say!("{}", classes_only(single, global.lang));
            diff(x.classes(), y.classes())
        }
    };
    print.put(&found, || text(&found, global.lang))?;
    Ok(match found.version_check {
        VersionCheck::Consistent | VersionCheck::Unknown => output::FINE,
        VersionCheck::TooSmall | VersionCheck::Backwards => output::FINDINGS,
    })
}

/// Type of an argument.
enum Side {
    /// A framework folder, or the built-in framework: classes, labeling specs, mining rules.
    Framework(Box<Framework>),
    /// One file with classes.
    Classes(Taxonomy),
}

impl Side {
    fn classes(&self) -> &Taxonomy {
        match self {
            Side::Framework(f) => &f.taxonomy,
            Side::Classes(t) => t,
        }
    }
}

/// Reads the file or folder that an argument names. Readable parts of an input with mistakes are compared; the mistakes
/// are reported on stderr.
fn side(path: &Path, lang: Lang) -> anyhow::Result<Side> {
    if path == Path::new("bundled") {
        return Ok(Side::Framework(Box::new(Framework::bundled().clone())));
    }
    if path.is_dir() {
        let (framework, found) = framework_folder::read(path)?;
        say(&found, lang);
        let framework = framework.with_context(|| no_framework(path.display()))?;
        return Ok(Side::Framework(Box::new(framework)));
    }
    let text = std::fs::read_to_string(path).with_context(|| cannot_read(path.display()))?;
    if path.extension().is_some_and(|e| e == "md") {
        let found = read_markdown(&text).to_taxonomy();
        if found.l1.is_empty() {
            return Err(stop(
                format!("{} 没有列出任何分类", path.display()),
                format!("{} lists no classes", path.display()),
            ));
        }
        return Ok(Side::Classes(found));
    }
    let (taxonomy, found) = read_taxonomy(&path.display().to_string(), &text);
    say(&found, lang);
    Ok(Side::Classes(taxonomy.with_context(|| no_framework(path.display()))?))
}

fn say(found: &[Diagnostic], lang: Lang) {
    for d in found {
        tell!("{}", output::render_text(d, lang));
    }
}

fn classes_only(file: &Path, lang: Lang) -> String {
    let file = file.display();
    match lang {
        Lang::Zh => format!("{file} 只有类别：未比较标注规格与挖掘规则"),
        Lang::En => format!("{file} holds classes only: labeling specs and mining rules are not compared"),
    }
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
        ChangeKind::Labelling => ("标注规格变化", "labeling changed"),
        ChangeKind::Mining => ("挖掘规则变化", "mining rule changed"),
        ChangeKind::Decision => ("驾驶决策变化", "driving decision changed"),
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
        // Where the text in the reader's language did not change, or one side lacks it, the other language is shown.
        let other = if lang == Lang::Zh { Lang::En } else { Lang::Zh };
        let (x, y) = (before.get(lang), after.get(lang));
        let shown = if x == y || x.is_empty() || y.is_empty() { other } else { lang };
        let _ = writeln!(out, "    - {}\n    + {}", before.get(shown), after.get(shown));
    }
}

/// The step of all changes, then the version check of each file: the taxonomy's, and those of changed specs.
fn verdict(d: &TaxonomyDiff, lang: Lang) -> String {
    let mut out = match lang {
        Lang::Zh => format!("所需步级：{}", d.step),
        Lang::En => format!("step: {}", d.step),
    };
    for (i, file) in d.files.iter().enumerate() {
        // The taxonomy comes first and is what the command is about.
        let name = if i == 0 { String::new() } else { format!("{} ", file.file) };
        let (from, to, said) = (&file.from_version, &file.to_version, version(file, lang));
        let _ = match lang {
            Lang::Zh => write!(out, "\n{name}版本 {from} -> {to}：{said}"),
            Lang::En => write!(out, "\n{name}version {from} -> {to}: {said}"),
        };
    }
    out
}

fn version(file: &FileVersion, lang: Lang) -> String {
    let least =
        Version::parse(&file.from_version).map(|v| v.after(file.step).to_string()).unwrap_or_default();
    let (zh, en) = match file.version_check {
        VersionCheck::Consistent => ("与变化相符".to_owned(), "consistent with the changes".to_owned()),
        VersionCheck::TooSmall => (
            format!("过低：这些变化至少需要 {least}"),
            format!("too low: these changes need at least {least}"),
        ),
        VersionCheck::Backwards => ("倒退".to_owned(), "goes backwards".to_owned()),
        VersionCheck::Unknown => ("未写明，无法核对".to_owned(), "not stated, cannot be checked".to_owned()),
    };
    if lang == Lang::Zh { zh } else { en }
}
