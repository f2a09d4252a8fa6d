//! `whyroad taxonomy docs` and `whyroad taxonomy schemas`: files generated from the framework.

use crate::{Global, framework_folder, output};
use anyhow::{Context as _, anyhow};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_framework::docs::{fill_spec_page, taxonomy_page};
use whyroad_framework::schemas::schemas as all_schemas;
use whyroad_model::{Bilingual, Diagnostic, diagnostic};

/// What to do with a generated text.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Action {
    /// Write the file.
    Write,
    /// Say whether the file is up to date.
    Check,
}

impl Action {
    /// From the `--check` flag.
    pub(super) fn from_flag(check: bool) -> Self {
        if check { Self::Check } else { Self::Write }
    }
}

/// Writes the taxonomy page, and the generated parts of the SPEC.md beside it where there is one.
pub(super) fn docs(global: &Global, action: Action, out: Option<&Path>) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let page = out.map_or_else(|| root(global).join("docs/reference/TAXONOMY.md"), Path::to_owned);
    let spec = page.with_file_name("SPEC.md");
    let mut files = vec![(page, taxonomy_page(&framework))];
    if spec.is_file() {
        let text = read(&spec)?;
        let filled = fill_spec_page(&framework, &text)
            .map_err(|marker| anyhow!("{} has no line `{marker}`", spec.display()))?;
        files.push((spec, filled));
    }
    finish(global, action, "whyroad taxonomy docs", &files)
}

pub(super) fn schemas(global: &Global, action: Action, out: Option<&Path>) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let folder = out.map_or_else(|| root(global).join("schema"), Path::to_owned);
    let files: Vec<_> =
        all_schemas(&framework).into_iter().map(|s| (folder.join(&s.name), s.text())).collect();
    finish(global, action, "whyroad taxonomy schemas", &files)
}

/// Where generated files go unless `--out` says: beside the framework that they are generated from.
fn root(global: &Global) -> PathBuf {
    global.framework.clone().unwrap_or_default()
}

/// A text file. Git may check text out with CRLF; that is not staleness.
fn read(path: &Path) -> anyhow::Result<String> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    Ok(text.replace("\r\n", "\n"))
}

fn finish(
    global: &Global,
    action: Action,
    command: &str,
    files: &[(PathBuf, String)],
) -> anyhow::Result<ExitCode> {
    let mut code = output::FINE;
    for (path, text) in files {
        let name = path.display();
        if action == Action::Write {
            if let Some(folder) = path.parent() {
                std::fs::create_dir_all(folder)
                    .with_context(|| format!("cannot create {}", folder.display()))?;
            }
            std::fs::write(path, text).with_context(|| format!("cannot write {name}"))?;
            say!("{name}");
            continue;
        }
        let current = if path.is_file() { read(path)? } else { String::new() };
        if current != *text {
            let message = Bilingual::new(format!("{name} 不是最新的"), format!("{name} is not up to date"));
            let hint = Bilingual::new(format!("运行 `{command}`"), format!("run `{command}`"));
            let d = Diagnostic::error("taxonomy.generated.stale", message)
                .with_hint(hint)
                .in_file(name.to_string());
            tell!("{}", crate::output::render_text(&d, global.lang));
            code = output::FINDINGS;
        }
    }
    Ok(code)
}
