//! `whyroad backup` and `whyroad restore`: the whole store of the labeling service as one file, from either database
//! into either.

use crate::output::reason::{cannot_read, exists};
use crate::{Global, output, store_args};
use anyhow::Context as _;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_model::Lang;
use whyroad_server::store::{backup_to, restore};

/// Arguments of `whyroad backup`.
#[derive(clap::Args)]
pub(crate) struct BackupArgs {
    #[command(flatten)]
    store: store_args::StoreArgs,
    /// File to write (JSON lines); it holds password hashes and must be protected like the store itself. Secrets in it
    /// are sealed: restoring it needs the key file, too
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

/// Arguments of `whyroad restore`.
#[derive(clap::Args)]
pub(crate) struct RestoreArgs {
    #[command(flatten)]
    store: store_args::StoreArgs,
    /// File that `whyroad backup` wrote; the target store must be empty
    #[arg(long, value_name = "FILE")]
    from: PathBuf,
}

/// Never overwrites an older one.
pub(crate) fn run_backup(global: &Global, args: BackupArgs) -> anyhow::Result<ExitCode> {
    let store = args.store.open_existing(global.lang)?;
    if args.out.exists() {
        return Err(exists(args.out.display()));
    }
    let rows = backup_to(&store, &args.out).map_err(|p| store_args::error(&p, global.lang))?;
    report_rows(rows, &args.out, global.lang);
    let key = args.store.key_file();
    match global.lang {
        Lang::Zh => say!("恢复时还需要密钥文件 {}；请与备份分开保存", key.display()),
        Lang::En => say!(
            "to restore it, the key file {} is needed, too; keep it apart from the backup",
            key.display()
        ),
    }
    Ok(output::FINE)
}

pub(crate) fn run_restore(global: &Global, args: RestoreArgs) -> anyhow::Result<ExitCode> {
    File::open(&args.from).with_context(|| cannot_read(args.from.display()))?;
    let store = args.store.open(global.lang)?;
    let from = args.from.clone();
    let rows = restore(&store, move || File::open(&from).map(BufReader::new))
        .map_err(|p| store_args::error(&p, global.lang))?;
    report_rows(rows, &args.from, global.lang);
    Ok(output::FINE)
}

fn report_rows(rows: u64, file: &Path, lang: Lang) {
    match lang {
        Lang::Zh => say!("{rows} 行；{}", file.display()),
        Lang::En => say!("{rows} rows; {}", file.display()),
    }
}
