//! `whyroad taxonomy init`: writes the built-in framework as editable files.

use crate::Global;
use crate::output;
use crate::output::reason::{cannot_make, cannot_write, exists};
use anyhow::Context as _;
use std::path::Path;
use std::process::ExitCode;
use whyroad_framework::Framework;
use whyroad_model::Lang;

/// Writes the files of the built-in framework below `dir`, which is made. Nothing is overwritten: a folder that has any
/// of them is refused before anything is written.
pub(super) fn run(global: &Global, dir: &Path) -> anyhow::Result<ExitCode> {
    let files = Framework::bundled_files();
    let paths = || files.keys().map(|name| dir.join(name));
    if let Some(path) = paths().find(|path| path.exists()) {
        return Err(exists(path.display()));
    }
    for (path, text) in paths().zip(files.values()) {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).with_context(|| cannot_make(folder.display()))?;
        }
        std::fs::write(&path, text).with_context(|| cannot_write(path.display()))?;
    }
    match global.lang {
        Lang::Zh => say!(
            "内置框架的 {} 个文件写入 {}；修改后运行 whyroad --framework {} taxonomy lint",
            files.len(),
            dir.display(),
            dir.display()
        ),
        Lang::En => say!(
            "{} files of the built-in framework are in {}; after a change run: whyroad --framework {} taxonomy lint",
            files.len(),
            dir.display(),
            dir.display()
        ),
    }
    Ok(output::FINE)
}
