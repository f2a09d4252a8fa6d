//! `export`: a release written as WebDataset shards and as Hugging Face Parquet, and as a floor the same bytes written
//! plainly: the entries of the shards as tar, the record batches as Parquet. Reading the release is part of an export
//! and not of the floor.
//!
//! `cargo bench -p whyroad-dataset --bench export -- RELEASE [--work FOLDER]`
#![allow(clippy::print_stdout)] // a bench prints

use arrow_array::RecordBatch;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;
use std::fs::File;
use std::io::{BufWriter, Read};
use std::path::{Path, PathBuf};
use std::time::Instant;
use whyroad_dataset::Release;
use whyroad_dataset::export::{ExportFormat, ExportOptions, export};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let Some(path) = arguments.first() else {
        println!("export: not run; give a release");
        return Ok(());
    };
    let work = arguments.iter().position(|a| a == "--work").and_then(|i| arguments.get(i + 1));
    let work = work.map_or_else(std::env::temp_dir, PathBuf::from);
    let work = work.join(format!("whyroad-export-{}", std::process::id()));
    std::fs::create_dir_all(&work)?;
    let release = Release::open(path)?;
    println!("{:<22}{:>10}{:>14}{:>10}", "bench", "s", "bytes", "MB/s");
    for format in
        [ExportFormat::WebDataset, ExportFormat::HuggingFace, ExportFormat::MsSwift, ExportFormat::Jsonl]
    {
        let out = work.join(format.name());
        let started = Instant::now();
        export(&release, format, &out, &ExportOptions::default(), &mut || ())?;
        line(&format!("export/{}", format.name()), started, size(&out));
    }
    let entries = entries(&work.join("webdataset"))?;
    let started = Instant::now();
    let plain = work.join("plain.tar");
    let mut tar = tar::Builder::new(BufWriter::new(File::create(&plain)?));
    for (name, content) in &entries {
        let mut header = tar::Header::new_ustar();
        header.set_size(content.len() as u64);
        header.set_mode(0o644);
        tar.append_data(&mut header, name, content.as_slice())?;
    }
    tar.into_inner()?.into_inner().map_err(std::io::IntoInnerError::into_error)?;
    line("floor/tar", started, size(&plain));
    drop(entries);

    let batches = batches(&work.join("huggingface/data"))?;
    let started = Instant::now();
    let plain = work.join("plain.parquet");
    if let Some(first) = batches.first() {
        let rows = first.num_rows();
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_max_row_group_row_count(Some(rows))
            .build();
        let mut writer = ArrowWriter::try_new(File::create(&plain)?, first.schema(), Some(properties))?;
        batches.iter().try_for_each(|b| writer.write(b))?;
        writer.close()?;
    }
    line("floor/parquet", started, size(&plain));
    std::fs::remove_dir_all(&work)?;
    Ok(())
}

fn line(name: &str, started: Instant, bytes: u64) {
    let s = started.elapsed().as_secs_f64();
    println!("{name:<22}{s:>10.2}{bytes:>14}{:>10.0}", bytes as f64 / 1e6 / s);
}

/// Bytes of a file, or below a folder.
fn size(path: &Path) -> u64 {
    match path.read_dir() {
        Ok(all) => all.flatten().map(|e| size(&e.path())).sum(),
        Err(_) => path.metadata().map_or(0, |m| m.len()),
    }
}

fn files(dir: &Path, extension: &str) -> Result<Vec<PathBuf>, Failure> {
    let mut out: Vec<PathBuf> = dir.read_dir()?.flatten().map(|e| e.path()).collect();
    out.retain(|p| p.extension().is_some_and(|e| e == extension));
    out.sort();
    Ok(out)
}

fn entries(dir: &Path) -> Result<Vec<(PathBuf, Vec<u8>)>, Failure> {
    let mut out = Vec::new();
    for file in files(dir, "tar")? {
        for entry in tar::Archive::new(File::open(file)?).entries()? {
            let mut entry = entry?;
            let mut content = Vec::new();
            entry.read_to_end(&mut content)?;
            out.push((entry.path()?.into_owned(), content));
        }
    }
    Ok(out)
}

fn batches(dir: &Path) -> Result<Vec<RecordBatch>, Failure> {
    let mut out = Vec::new();
    for file in files(dir, "parquet")? {
        let builder = ParquetRecordBatchReaderBuilder::try_new(File::open(file)?)?;
        let rows = builder.metadata().row_group(0).num_rows();
        for batch in builder.with_batch_size(usize::try_from(rows)?).build()? {
            out.push(batch?);
        }
    }
    Ok(out)
}
