//! The current framework: the built-in one, or the folder that `--framework` names.

use crate::Global;
use crate::output::reason::{cannot_read, no_framework, stop};
use anyhow::Context as _;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use whyroad_framework::{Framework, FrameworkFiles};
use whyroad_model::{Diagnostic, Lang, Severity};
use whyroad_signals::Catalog;

/// Whether the framework that was loaded has errors.
static IS_FAULTY: AtomicBool = AtomicBool::new(false);

/// Number of errors in its rules and moments that [`load`] found and did not print: commands that use the rules print
/// them.
static FAULTS_OF_RULES: AtomicUsize = AtomicUsize::new(0);

/// Warnings that are printed; of more, only their number.
const MOST_WARNINGS: usize = 3;

/// True where a file of the framework was left out: what the command did or found is then incomplete, and "no findings"
/// is not to be relied on.
pub(crate) fn is_faulty() -> bool {
    IS_FAULTY.load(Ordering::Relaxed)
}

/// The current framework; its errors, including those of its signal catalog, are reported on stderr. An error when it
/// has no usable taxonomy.
pub(crate) fn load(global: &Global) -> anyhow::Result<(Framework, Vec<Diagnostic>)> {
    let Some(dir) = &global.framework else { return Ok((Framework::bundled().clone(), Vec::new())) };
    let (framework, mut found) = read(dir)?;
    if let Some(framework) = &framework {
        found.extend(placed(Some(dir), Catalog::parse(&framework.signals_yaml).1));
    }
    let (warnings, errors): (Vec<_>, Vec<_>) = found.iter().partition(|d| d.severity == Severity::Warning);
    // Many warnings would bury what the command itself has to say.
    let shown = if warnings.len() > MOST_WARNINGS { &[][..] } else { &warnings[..] };
    for d in errors.iter().chain(shown) {
        tell!("{}", crate::output::render_text(d, global.lang));
    }
    if shown.len() < warnings.len() {
        let (n, dir) = (warnings.len(), dir.display());
        match global.lang {
            Lang::Zh => say!("框架有 {n} 个警告：`whyroad --framework {dir} taxonomy lint` 列出"),
            Lang::En => {
                say!("the framework has {n} warnings: `whyroad --framework {dir} taxonomy lint` lists them")
            }
        }
    }
    let of_rules = framework.as_ref().map_or(0, |framework| faults_of_rules(framework).len());
    FAULTS_OF_RULES.store(of_rules, Ordering::Relaxed);
    if of_rules > 0 || found.iter().any(|d| d.severity == Severity::Error) {
        IS_FAULTY.store(true, Ordering::Relaxed);
    }
    match framework {
        Some(framework) => Ok((framework, found)),
        None => Err(anyhow::anyhow!(no_framework(dir.display()))),
    }
}

/// Errors in what a framework states in the rule language: what it does not apply.
pub(crate) fn faults_of_rules(framework: &Framework) -> Vec<Diagnostic> {
    let (catalog, _) = Catalog::parse(&framework.signals_yaml);
    let found = whyroad_mining::rule::lint::lint(framework, &catalog);
    found.into_iter().filter(|d| d.severity == Severity::Error).collect()
}

/// Says that rules were not applied, where a command that does not use them would otherwise end as if all were well.
pub(crate) fn tell_faults_of_rules(lang: Lang) {
    let n = FAULTS_OF_RULES.load(Ordering::Relaxed);
    if n > 0 {
        match lang {
            Lang::Zh => say!("框架的规则有 {n} 个错误，有关的规则未使用：`whyroad taxonomy lint` 列出"),
            Lang::En => say!(
                "{} in the rules of the framework, which are not used: `whyroad taxonomy lint` lists them",
                whyroad_model::counted(n, "error")
            ),
        }
    }
}

/// [`is_faulty`], and says so: labels cannot be checked completely, since what the unreadable files require is not
/// known.
pub(crate) fn is_incomplete(global: &Global) -> bool {
    let broken = is_faulty();
    if broken {
        say!(
            "{}",
            match global.lang {
                Lang::Zh =>
                    "框架有错误：其中的要求未知，标签未能按它完整校验；先改正框架（whyroad taxonomy lint）",
                Lang::En =>
                    "the framework has errors: what it requires there is unknown, and labels are not checked against \
                     it; correct the framework first (whyroad taxonomy lint)",
            }
        );
    }
    broken
}

/// The framework of a folder and its errors. Every file is named by the user's path, including `dir`.
pub(crate) fn read(dir: &Path) -> anyhow::Result<(Option<Framework>, Vec<Diagnostic>)> {
    let (mut framework, found) = read_folder(dir)?.load();
    let named = |file: &str| dir.join(file).display().to_string();
    if let Some(f) = &mut framework {
        for rule in &mut f.rules {
            rule.file = named(&rule.file);
        }
        for expression in &mut f.expressions {
            expression.file = named(&expression.file);
        }
    }
    Ok((framework, placed(Some(dir), found)))
}

/// The same findings with the framework's folder in front of its files that are still named relative to it.
pub(crate) fn placed(dir: Option<&Path>, mut found: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let Some(dir) = dir else { return found };
    for d in &mut found {
        let Some(file) = &d.location.file else { continue };
        if ["schema/", "scenarios/", "prompts/"].iter().any(|root| file.starts_with(root))
            && !Path::new(file).starts_with(dir)
        {
            d.location.file = Some(dir.join(file).display().to_string());
        }
    }
    found
}

/// All files below `schema/`, `scenarios/` and `prompts/` of `dir`, and findings about those that are not UTF-8.
pub(crate) fn read_folder(dir: &Path) -> anyhow::Result<FrameworkFiles> {
    let mut out = FrameworkFiles::default();
    for root in ["schema", "scenarios", "prompts"] {
        let folder = dir.join(root);
        if folder.is_dir() {
            collect(&folder, root, &mut out)?;
        }
    }
    if out.texts.is_empty() && out.not_text.is_empty() {
        return Err(stop(
            format!("{} 中没有含文件的 schema/ 或 scenarios/ 文件夹", dir.display()),
            format!("{} has no schema/ or scenarios/ folder with files", dir.display()),
        ));
    }
    Ok(out)
}

fn collect(folder: &Path, prefix: &str, out: &mut FrameworkFiles) -> anyhow::Result<()> {
    let entries = std::fs::read_dir(folder).with_context(|| cannot_read(folder.display()))?;
    for entry in entries {
        let entry = entry.with_context(|| cannot_read(folder.display()))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let (path, inner) = (entry.path(), format!("{prefix}/{name}"));
        if path.is_dir() {
            collect(&path, &inner, out)?;
        } else if name.ends_with(".yaml") || name.ends_with(".json") {
            out.add(inner, std::fs::read(&path).with_context(|| cannot_read(path.display()))?);
        }
    }
    Ok(())
}
