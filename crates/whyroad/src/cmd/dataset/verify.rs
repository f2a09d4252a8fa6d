//! `whyroad dataset verify`.

use super::{licences, print, refused};
use crate::output::DataFormat;
use crate::output::render_text;
use crate::{Global, framework_folder, output};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use whyroad_dataset::verify::{UNCOMPARED, Verified, verify_with};
use whyroad_engine::label_drives::LabelDrives;
use whyroad_label::check::Recordings;
use whyroad_lake::Lake;
use whyroad_model::diagnostic::json_row;
use whyroad_model::{Lang, counted};

/// Arguments of `whyroad dataset verify`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// The release
    #[arg(value_name = "RELEASE")]
    release: PathBuf,
    /// Lake with the drives of the release: compares the labels with the recordings
    #[arg(long, value_name = "DIR")]
    lake: Option<PathBuf>,
    /// How to print the result
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    format: DataFormat,
}

pub(super) fn run(global: &Global, a: &Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let recordings = match &a.lake {
        Some(dir) => {
            let lake = Lake::open(dir)
                .map_err(|e| anyhow::anyhow!("{}", render_text(&e.diagnostic(), global.lang)))?;
            let drives: Arc<dyn Recordings> = Arc::new(LabelDrives::new(lake, &framework));
            Some(drives)
        }
        None => None,
    };
    let found = match verify_with(&a.release, &framework, &licences(global)?, recordings) {
        Ok(found) => found,
        Err(e) => return Ok(refused(global, &e)),
    };
    let faults = found.diagnostics.iter().filter(|d| d.code != UNCOMPARED).count();
    let (samples, files, stated) = (found.samples, found.files, found.stated);
    let (compared, uncompared) = (found.compared.map(|n| n[0]), found.compared.map(|n| n[1]));
    let (labels, drafts) = (found.labels, found.drafts);
    match a.format {
        DataFormat::Json => {
            let rows: Vec<_> = found.diagnostics.iter().map(|d| json_row(d, global.lang)).collect();
            let value = json!({
                "samples": samples, "samples_stated": stated, "files": files, "labels": labels, "drafts": drafts,
                "near_duplicates_checked": found.near_duplicates, "labels_compared": compared, "labels_not_compared": uncompared, "diagnostics": rows,
            });
            output::put(&format!("{value:#}\n"));
        }
        DataFormat::Text => {
            print(global, &found.diagnostics);
            output::put(&summary(&found, faults, global.lang));
        }
    }
    let incomplete = framework_folder::is_incomplete(global);
    Ok(match uncompared {
        _ if faults > 0 || incomplete => output::FINDINGS,
        Some(1..) => output::lost_input(),
        _ => output::FINE,
    })
}

/// The last line of the text.
fn summary(found: &Verified, faults: usize, lang: Lang) -> String {
    let Verified { samples, files, labels, drafts, stated, compared, near_duplicates, .. } = found;
    let pick = |zh: String, en: String| if lang == Lang::Zh { zh } else { en };
    let unread = match samples < stated {
        true => pick(format!("（清单写 {stated} 个）"), format!(" read of {stated}")),
        false => String::new(),
    };
    let compared = match compared {
        Some([n, 0]) => pick(format!("，{n} 个与录制数据比对"), format!(", {n} compared with a recording")),
        Some([n, not]) => pick(
            format!("，{n} 个与录制数据比对，{not} 个未能比对"),
            format!(", {n} compared with a recording, {not} not compared"),
        ),
        None => String::new(),
    };
    let drafts = match drafts {
        0 => String::new(),
        n => pick(
            format!("；{n} 个草稿只检查了类别"),
            format!("; of {} only the class was checked", counted(*n, "draft")),
        ),
    };
    let near = match near_duplicates {
        true => String::new(),
        false => pick(
            "；未检查近似重复（deduplicate.near: null）".to_owned(),
            "; near-duplicates not checked (deduplicate.near: null)".to_owned(),
        ),
    };
    pick(
        format!(
            "{samples} 个样本{unread}，{files} 个文件，{labels} 个标签重新校验{compared}{drafts}{near}；{faults} 个问题\n"
        ),
        format!(
            "{samples} samples{unread}, {files} files, {labels} labels checked again{compared}{drafts}{near}; {faults} \
             findings\n"
        ),
    )
}
