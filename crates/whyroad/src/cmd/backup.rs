//! `whyroad backup` and `whyroad restore`: the whole store of the labelling service as one file, from either database
//! into either.

use crate::{Global, output, store_place};
use anyhow::{Context as _, bail};
use std::fs::File;
use std::io::{BufReader, BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_labeling::store::{backup, restore};
use whyroad_model::Lang;

/// Arguments of `whyroad backup`.
#[derive(clap::Args)]
pub(crate) struct BackupArgs {
    #[command(flatten)]
    store: store_place::StoreArgs,
    /// File to write (JSON lines); it holds password hashes and must be kept as the store itself
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

/// Arguments of `whyroad restore`.
#[derive(clap::Args)]
pub(crate) struct RestoreArgs {
    #[command(flatten)]
    store: store_place::StoreArgs,
    /// File that `whyroad backup` wrote; the store that it goes into must be empty
    #[arg(long, value_name = "FILE")]
    from: PathBuf,
}

/// Writes aside and renames, so that a backup is whole or not there; never over an older one.
pub(crate) fn run_backup(global: &Global, args: BackupArgs) -> anyhow::Result<ExitCode> {
    let store = args.store.open_existing(global.lang)?;
    if args.out.exists() {
        bail!("{} is there already", args.out.display());
    }
    if let Some(dir) = args.out.parent().filter(|d| !d.as_os_str().is_empty()) {
        std::fs::create_dir_all(dir).with_context(|| format!("cannot make {}", dir.display()))?;
    }
    let aside = args.out.with_added_extension("part");
    let cannot = || format!("cannot write {}", aside.display());
    let mut file = BufWriter::new(private_file(&aside).with_context(cannot)?);
    let rows = backup(&store, &mut file).map_err(|p| store_place::told(&p, global.lang))?;
    file.flush().with_context(cannot)?;
    file.get_ref().sync_all().with_context(cannot)?;
    std::fs::rename(&aside, &args.out).with_context(|| format!("cannot write {}", args.out.display()))?;
    tell_rows(rows, &args.out, global.lang);
    Ok(output::FINE)
}

/// A new file that only its owner reads, where the system knows owners.
fn private_file(path: &Path) -> std::io::Result<File> {
    let mut options = File::options();
    options.write(true).create(true).truncate(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)
}

pub(crate) fn run_restore(global: &Global, args: RestoreArgs) -> anyhow::Result<ExitCode> {
    let file = File::open(&args.from).with_context(|| format!("cannot read {}", args.from.display()))?;
    let store = args.store.open(global.lang)?;
    let rows = restore(&store, &mut BufReader::new(file)).map_err(|p| store_place::told(&p, global.lang))?;
    tell_rows(rows, &args.from, global.lang);
    Ok(output::FINE)
}

fn tell_rows(rows: u64, file: &Path, lang: Lang) {
    match lang {
        Lang::Zh => say!("{rows} 行；{}", file.display()),
        Lang::En => say!("{rows} rows; {}", file.display()),
    }
}
