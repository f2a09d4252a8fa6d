//! `whyroad dataset verify`.

use super::{licences, print, refused};
use crate::output::DataFormat;
use crate::output::render_text;
use crate::{Global, framework_folder, output};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use whyroad_dataset::verify::verify_with;
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
    let (samples, files, faults) = (found.samples, found.files, found.diagnostics.len());
    let (labels, drafts) = (found.labels, found.drafts);
    match a.format {
        DataFormat::Json => {
            let rows: Vec<_> = found.diagnostics.iter().map(|d| json_row(d, global.lang)).collect();
            let value = json!({
                "samples": samples, "files": files, "labels": labels, "drafts": drafts, "diagnostics": rows,
            });
            output::put(&format!("{value:#}\n"));
        }
        DataFormat::Text => {
            print(global, &found.diagnostics);
            output::put(&match global.lang {
                Lang::Zh => {
                    let drafts = match drafts {
                        0 => String::new(),
                        n => format!("；{n} 个草稿只检查了类别"),
                    };
                    format!(
                        "{samples} 个样本，{files} 个文件，{labels} 个标签重新校验{drafts}；{faults} 个问题\n"
                    )
                }
                Lang::En => {
                    let drafts = match drafts {
                        0 => String::new(),
                        n => format!("; of {} only the class was checked", counted(n, "draft")),
                    };
                    format!(
                        "{samples} samples, {files} files, {labels} labels checked again{drafts}; {faults} findings\n"
                    )
                }
            });
        }
    }
    Ok(if faults > 0 { output::FINDINGS } else { output::FINE })
}
