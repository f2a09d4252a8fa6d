//! WebDataset shards: `<split>-000000.tar`, files of one sample share their basename up to the first dot. Samples are
//! already shuffled in the release; shard sizes of a split differ by at most one.

use super::{Output, SampleWriter, images};
use crate::freeze::shards::{Shard, shards};
use crate::item::SplitName;
use crate::sample::Sample;
use crate::{DatasetError, Release};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;

/// Samples per shard.
const PER_SHARD: usize = 1000;

pub(super) struct Writer {
    /// Shards of each split.
    plan: BTreeMap<&'static str, Vec<Shard>>,
    done: BTreeMap<&'static str, usize>,
    open: Option<tar::Builder<BufWriter<File>>>,
    shards: BTreeMap<&'static str, Vec<usize>>,
}

fn put(tar: &mut tar::Builder<BufWriter<File>>, name: &str, content: &[u8]) -> std::io::Result<()> {
    let mut header = tar::Header::new_ustar();
    header.set_size(content.len() as u64);
    header.set_mode(0o644);
    // No clock: equal releases give equal shards.
    header.set_mtime(0);
    tar.append_data(&mut header, name, content)
}

impl Writer {
    pub(super) fn new(release: &Release) -> Self {
        let of = |split: SplitName| {
            let total = release.manifest.counts.by_split.get(split.name()).copied().unwrap_or(0);
            (split.name(), shards(split.name(), total, PER_SHARD))
        };
        let plan = SplitName::ALL.into_iter().map(of).collect();
        Self { plan, done: BTreeMap::new(), open: None, shards: BTreeMap::new() }
    }

    /// Counts a sample; returns the number and the size of the shard that begins with it.
    fn begins(&mut self, split: SplitName, out: &Output) -> Result<Option<(usize, usize)>, DatasetError> {
        let plan = self.plan.get(split.name()).map_or(&[][..], Vec::as_slice);
        let done = self.done.entry(split.name()).or_default();
        if plan.last().is_none_or(|last| *done >= last.range.end) {
            let fault = "the release has more samples than its manifest states";
            return Err(DatasetError::broken(&out.root, fault));
        }
        let number = plan.iter().position(|s| s.range.start == *done);
        *done += 1;
        Ok(number.map(|n| (n, plan[n].range.len())))
    }

    fn close(&mut self, out: &Output) -> Result<(), DatasetError> {
        let Some(tar) = self.open.take() else { return Ok(()) };
        tar.into_inner()
            .and_then(|file| file.into_inner().map_err(std::io::IntoInnerError::into_error))
            .map(drop)
            .map_err(DatasetError::io(&out.root))
    }
}

impl SampleWriter for Writer {
    fn add(&mut self, mut sample: Sample, split: SplitName, out: &mut Output) -> Result<(), DatasetError> {
        if let Some((number, samples)) = self.begins(split, out)? {
            self.close(out)?;
            let file = out.create(&format!("{}-{number:06}.tar", split.name()))?;
            self.open = Some(tar::Builder::new(BufWriter::new(file)));
            self.shards.entry(split.name()).or_default().push(samples);
        }
        let Some(tar) = &mut self.open else { return Ok(()) };
        let names = images::names(&sample);
        for name in names.iter().map(String::as_str).chain(["json"]) {
            out.member(&format!("{}.{name}", sample.sample_id))?;
        }
        let contents: Vec<Vec<u8>> =
            sample.images.iter_mut().map(|image| std::mem::take(&mut image.bytes)).collect();
        let text = serde_json::to_vec(&sample).map_err(|e| DatasetError::broken(&out.root, e))?;
        let mut write = || -> std::io::Result<()> {
            put(tar, &format!("{}.json", sample.sample_id), &text)?;
            for (name, content) in names.iter().zip(&contents) {
                put(tar, &format!("{}.{name}", sample.sample_id), content)?;
            }
            Ok(())
        };
        write().map_err(DatasetError::io(&out.root))?;
        out.report.records += 1;
        Ok(())
    }

    fn finish(&mut self, out: &mut Output) -> Result<(), DatasetError> {
        self.close(out)?;
        out.json("shards.json", &self.shards)
    }
}
