//! `whyroad taxonomy docs` and `whyroad taxonomy schemas`: files generated from the framework.

use super::reference;
use crate::output::reason::{cannot_make, cannot_read, cannot_write};
use crate::{Global, framework_folder, output};
use anyhow::{Context as _, anyhow};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_framework::Framework;
use whyroad_framework::docs::{fill_spec_page, taxonomy_page};
use whyroad_framework::schemas::schemas as all_schemas;
use whyroad_model::{Bilingual, Diagnostic, Lang};
use whyroad_signals::Catalog;

/// What to do with a generated text.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Action {
    /// Write the file.
    Write,
    /// Report whether the file is up to date.
    Check,
}

impl Action {
    /// From the `--check` flag.
    pub(super) fn from_flag(check: bool) -> Self {
        if check { Self::Check } else { Self::Write }
    }
}

/// Writes the taxonomy page and the generated parts of the SPEC.md beside it where there is one. Without `out` also the
/// pages of signals and leaves, and, where the folder has diagnostics pages and a book, their index and the summary.
pub(super) fn docs(global: &Global, action: Action, out: Option<&Path>) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let docs = root(global).join("docs");
    let page = out.map_or_else(|| docs.join("reference/TAXONOMY.md"), Path::to_owned);
    let spec = page.with_file_name("SPEC.md");
    let mut files = vec![(page, taxonomy_page(&framework))];
    if spec.is_file() {
        let text = read(&spec)?;
        let filled = fill_spec_page(&framework, &text)
            .map_err(|marker| anyhow!("{} has no line `{marker}`", spec.display()))?;
        files.push((spec, filled));
    }
    let mut extra = Vec::new();
    if out.is_none() {
        files.extend(reference_pages(global, &framework, &docs)?);
        let generated: BTreeSet<&Path> = files.iter().map(|(path, _)| path.as_path()).collect();
        let old = list(&docs.join("reference/leaves"))?;
        extra.extend(old.into_iter().filter(|path| !generated.contains(path.as_path())));
    }
    let code = finish(global, action, DOCS, &files)?;
    Ok(if remove(global, action, &extra)? { output::FINDINGS } else { code })
}

const DOCS: &str = "whyroad taxonomy docs";

/// The pages of signals and leaves, the index of diagnostics, and the book's summary.
fn reference_pages(
    global: &Global,
    framework: &Framework,
    docs: &Path,
) -> anyhow::Result<Vec<(PathBuf, String)>> {
    let texts = match &global.framework {
        Some(dir) => framework_folder::read_folder(dir)?.texts,
        None => Framework::bundled_files(),
    };
    let (catalog, _) = Catalog::parse(&framework.signals_yaml);
    let leaves = reference::leaf_pages(framework, &catalog, &texts)
        .map_err(|reason| anyhow!("{}", reason.get(global.lang)))?;
    let mut files = vec![(docs.join("reference/signals.md"), catalog.page())];
    files.extend(leaves.into_iter().map(|(path, text)| (docs.join("reference").join(path), text)));
    let pages = by_name(&docs.join("diagnostics"))?;
    if !pages.is_empty() {
        let index = reference::diagnostics_index(&pages).map_err(|code| {
            anyhow!("docs/diagnostics/{code}.md does not have the form of the other pages")
        })?;
        files.push((docs.join("reference/diagnostics.md"), index));
    }
    let formats = by_name(&docs.join("formats"))?;
    let wrong = |path: &Path, reason: String| match reason.starts_with("<!--") {
        true => anyhow!("{} has no line `{reason}`", path.display()),
        false => anyhow!("{reason}"),
    };
    for (name, lang) in [("reference/formats.md", Lang::En), ("reference/formats.zh.md", Lang::Zh)] {
        let path = docs.join(name);
        if !formats.is_empty() && path.is_file() {
            let filled =
                reference::fill_formats(&read(&path)?, &formats, lang).map_err(|e| wrong(&path, e))?;
            files.push((path, filled));
        }
    }
    let summary = docs.join("SUMMARY.md");
    if summary.is_file() {
        let filled = reference::fill_summary(&read(&summary)?, framework, &pages, &formats)
            .map_err(|e| wrong(&summary, e))?;
        files.push((summary, filled));
    }
    Ok(files)
}

/// Texts of the pages in a folder, by their names without `.md`.
fn by_name(folder: &Path) -> anyhow::Result<BTreeMap<String, String>> {
    let mut pages = BTreeMap::new();
    for path in list(folder)? {
        if let Some(name) = path.file_name().and_then(|n| n.to_str()).and_then(|n| n.strip_suffix(".md")) {
            pages.insert(name.to_owned(), read(&path)?);
        }
    }
    Ok(pages)
}

/// The files of a folder, sorted; none where it does not exist.
fn list(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut out = Vec::new();
    if folder.is_dir() {
        for entry in std::fs::read_dir(folder).with_context(|| cannot_read(folder.display()))? {
            out.push(entry?.path());
        }
    }
    out.sort();
    Ok(out)
}

/// Deletes generated pages of classes that no longer exist; with `Check` reports them and returns true.
fn remove(global: &Global, action: Action, files: &[PathBuf]) -> anyhow::Result<bool> {
    for path in files {
        let name = path.display();
        match action {
            Action::Write => {
                std::fs::remove_file(path).with_context(|| format!("cannot delete {name}"))?;
            }
            Action::Check => stale(global, path, DOCS),
        }
    }
    Ok(action == Action::Check && !files.is_empty())
}

/// Reports a file that differs from what the framework generates.
fn stale(global: &Global, path: &Path, command: &str) {
    let name = path.display();
    let message = Bilingual::new(format!("{name} 不是最新的"), format!("{name} is not up to date"));
    report_stale(global, message, &name.to_string(), command);
}

fn report_stale(global: &Global, message: Bilingual, file: &str, command: &str) {
    let hint = Bilingual::new(format!("运行 `{command}`"), format!("run `{command}`"));
    let d = Diagnostic::error("taxonomy.generated.stale", message).with_hint(hint).in_file(file);
    tell!("{}", output::render_text(&d, global.lang));
}

pub(super) fn schemas(global: &Global, action: Action, out: Option<&Path>) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let folder = out.map_or_else(|| root(global).join("schema"), Path::to_owned);
    let files: Vec<_> =
        all_schemas(&framework).into_iter().map(|s| (folder.join(&s.name), s.text())).collect();
    finish(global, action, "whyroad taxonomy schemas", &files)
}

/// Default folder of generated files without `--out`: beside the framework that they are generated from.
fn root(global: &Global) -> PathBuf {
    global.framework.clone().unwrap_or_default()
}

/// A text file. Git may check text out with CRLF; that does not count as outdated.
fn read(path: &Path) -> anyhow::Result<String> {
    let text = std::fs::read_to_string(path).with_context(|| cannot_read(path.display()))?;
    Ok(text.replace("\r\n", "\n"))
}

fn finish(
    global: &Global,
    action: Action,
    command: &str,
    files: &[(PathBuf, String)],
) -> anyhow::Result<ExitCode> {
    let mut code = output::FINE;
    if action == Action::Check
        && files.len() > 1
        && let Some((first, _)) = files.first()
        && files.iter().all(|(path, _)| !path.is_file())
    {
        let (n, first) = (files.len(), first.display());
        let message = Bilingual::new(
            format!("{n} 个生成的文件都不存在，例如 {first}"),
            format!("none of the {n} generated files exists, for example {first}"),
        );
        report_stale(global, message, &first.to_string(), command);
        return Ok(output::FINDINGS);
    }
    for (path, text) in files {
        let name = path.display();
        let current = if path.is_file() { read(path)? } else { String::new() };
        if current == *text {
            continue;
        }
        if action == Action::Write {
            if let Some(folder) = path.parent() {
                std::fs::create_dir_all(folder).with_context(|| cannot_make(folder.display()))?;
            }
            std::fs::write(path, text).with_context(|| cannot_write(&name))?;
            say!("{name}");
            continue;
        }
        stale(global, path, command);
        code = output::FINDINGS;
    }
    Ok(code)
}
