//! The last steps of the demo: the label drafts as a small release, and the release as files that a trainer reads.

use super::Steps;
use crate::output::reason::cannot_write;
use anyhow::Context as _;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use whyroad_dataset::export::{ExportFormat, ExportOptions, export};
use whyroad_dataset::licence::{BUNDLED, LicenceTable};
use whyroad_dataset::{DatasetError, Inputs, LabelStream, Media, Release, build, spec};
use whyroad_framework::Framework;
use whyroad_lake::Lake;
use whyroad_model::Lang;

/// The folders in the demo's folder.
pub(super) const RELEASE: &str = "release";
pub(super) const EXPORT: &str = "export-ms-swift";
/// The spec of the release.
pub(super) const SPEC: &str = "dataset.yaml";

/// Changes that the demo makes to the commented spec. Three drives give three groups: with these shares each split has
/// one.
const CHANGES: [(&str, &str); 5] = [
    ("name: release ", "name: demo    "),
    ("images: none", "images: bev "),
    ("train: 0.8", "train: 0.4"),
    ("val: 0.1", "val: 0.3"),
    ("test: 0.1", "test: 0.3"),
];

/// Builds and exports; failures are reported, and the demo continues. True when both were written.
pub(super) fn write(
    steps: &mut Steps,
    framework: &Framework,
    lake: &Lake,
    out: &Path,
) -> anyhow::Result<bool> {
    let text = CHANGES.iter().fold(spec::TEMPLATE.to_owned(), |text, (from, to)| text.replace(from, to));
    let text = match steps.lang {
        Lang::Zh => text.replace("draft_texts: en", "draft_texts: zh"),
        Lang::En => text,
    };
    let file = out.join(SPEC);
    std::fs::write(&file, &text).with_context(|| cannot_write(file.display()))?;
    let done = frozen(framework, lake, out, text, steps).and_then(|()| exported(out, steps));
    match done {
        Ok(()) => Ok(true),
        Err(e) => {
            steps.findings(&e.diagnostics());
            Ok(false)
        }
    }
}

fn frozen(
    framework: &Framework,
    lake: &Lake,
    out: &Path,
    spec_text: String,
    steps: &mut Steps,
) -> Result<(), DatasetError> {
    let folder = out.join(RELEASE);
    clear(&folder, "manifest.json")?;
    let mut spec = spec::read(&spec_text, SPEC, framework).map_err(DatasetError::Refused)?;
    // As with --drafts: the spec itself is good for labels that people accepted.
    spec.labels.drafts = true;
    let licences = LicenceTable::read(BUNDLED, "schema/licences.yaml").map_err(DatasetError::Refused)?;
    let inputs = Inputs {
        spec,
        spec_text,
        framework,
        licences: &licences,
        lake,
        recordings: None,
        media: Media::new(lake.dir(), &[]),
        spec_dir: out,
        out: &folder,
        queries: &|_, _| None,
        restart: true,
    };
    let episodes = out.join("mined").join("episodes.jsonl");
    let lines = Box::new(BufReader::new(File::open(&episodes).map_err(DatasetError::io(&episodes))?));
    let built = build(&inputs, vec![LabelStream { name: "episodes.jsonl".into(), lines }], &|_, _, _| true)?;
    let of = |split: &str| built.manifest.counts.by_split.get(split).copied().unwrap_or(0);
    let (n, train, val, test) = (built.manifest.counts.samples, of("train"), of("val"), of("test"));
    let folder = folder.display();
    steps.say(
        format!("数据集  {n} 个样本（训练 {train}，验证 {val}，测试 {test}）写入 {folder}，均为草稿，带渲染图像"),
        format!(
            "dataset {n} samples (train {train}, val {val}, test {test}) in {folder}: drafts, marked, with rendered images"
        ),
    );
    Ok(())
}

fn exported(out: &Path, steps: &mut Steps) -> Result<(), DatasetError> {
    let folder = out.join(EXPORT);
    clear(&folder, "export.json")?;
    let release = Release::open(out.join(RELEASE))?;
    let done = export(&release, ExportFormat::MsSwift, &folder, &ExportOptions::default(), &mut || ())?;
    let (records, files, folder) = (done.records, done.files, folder.display());
    steps.say(
        format!("导出  ms-swift：{records} 条记录，{files} 个文件，写入 {folder}"),
        format!("export  ms-swift: {records} records, {files} files in {folder}"),
    );
    Ok(())
}

/// Removes what an earlier demo wrote; a folder without `mark` is left alone, and rejected by the next writer.
fn clear(folder: &Path, mark: &str) -> Result<(), DatasetError> {
    if folder.join(mark).is_file() {
        std::fs::remove_dir_all(folder).map_err(DatasetError::io(folder))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_template_has_what_the_demo_changes() {
        for (from, to) in CHANGES {
            assert_eq!(spec::TEMPLATE.matches(from).count(), 1, "{from}");
            assert_eq!(from.len(), to.len(), "comments stay in their column");
        }
    }
}
