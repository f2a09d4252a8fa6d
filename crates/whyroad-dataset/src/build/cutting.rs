//! Stage 2 over all drives, on all cores: each drive is read once, its samples go to one file, and the data for later
//! stages stays in memory. Drives that an interrupted build finished are taken from their files.

use super::{State, Step};
use crate::DatasetError;
use crate::cut::{Candidate, Cutter};
use crate::item::{Cut, Dropped, Item, Stage, id_text};
use crate::labels::{DRAFT, LabelRecord};
use crate::records::{RecordWriter, read_record, read_value, write_value};
use crate::spec::Images;
use crate::verify::stale;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use whyroad_engine::mine::signals_of;
use whyroad_label::check::Checker;
use whyroad_model::{Bilingual, Diagnostic, DriveId, Nanos};

type Outcome = Result<Cut, Dropped>;

/// Reason: a finished label has errors when it is compared with its drive.
const CONTRADICTS: &str = "contradicts_recording";

/// Cuts every kept item. Returns the number of drives that had been cut already.
pub(super) fn cut(
    state: &mut State<'_>,
    progress: &(dyn Fn(Step, usize, usize) -> bool + Sync),
) -> Result<usize, DatasetError> {
    let mut by_drive: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (i, item) in state.labels.items.iter().enumerate().filter(|(_, i)| i.kept()) {
        by_drive.entry(item.drive).or_default().push(i);
    }
    let jobs: Vec<(u32, Vec<usize>)> = by_drive.into_iter().collect();
    let (done, resumed, stopped) = (AtomicUsize::new(0), AtomicUsize::new(0), AtomicBool::new(false));
    let shared = &*state;
    let checker = state
        .inputs
        .recordings
        .as_ref()
        .map(|recordings| Checker::new(state.inputs.framework).with_recordings(Arc::clone(recordings)));
    // One drive after the other on each core: their sizes differ, and each is work enough.
    let results: Vec<Result<Option<Vec<Outcome>>, DatasetError>> = jobs
        .par_iter()
        .with_max_len(1)
        .map(|(drive, items)| {
            if stopped.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let facts = shared.work.facts(*drive as usize);
            let outcomes = match read_value::<Vec<Outcome>>(&facts) {
                Ok(outcomes) if outcomes.len() == items.len() => {
                    resumed.fetch_add(1, Ordering::Relaxed);
                    outcomes
                }
                _ => {
                    let outcomes = cut_drive(shared, checker.as_ref(), *drive, items)?;
                    write_value(&facts, &outcomes)?;
                    outcomes
                }
            };
            let n = done.fetch_add(1, Ordering::Relaxed) + 1;
            if !progress(Step::Cut, n, jobs.len()) {
                stopped.store(true, Ordering::Relaxed);
            }
            Ok(Some(outcomes))
        })
        .collect();
    let mut unreadable = BTreeMap::new();
    for ((drive, items), result) in jobs.iter().zip(results) {
        let Some(outcomes) = result? else { return Err(DatasetError::Stopped) };
        for (i, outcome) in items.iter().zip(outcomes) {
            match outcome {
                Ok(cut) => state.labels.items[*i].cut = Some(Box::new(cut)),
                Err(dropped) => {
                    if dropped.reason == "drive_unreadable" {
                        unreadable.insert(*drive, dropped.detail.clone().unwrap_or_default());
                    }
                    state.labels.items[*i].dropped = Some(dropped);
                }
            }
        }
    }
    for (drive, why) in unreadable {
        let name = state.labels.drives.get(drive);
        state.diagnostics.push(Diagnostic::warning(
            "dataset.drive.unreadable",
            Bilingual::new(
                format!("行程 {name} 无法读取，其样本未收入：{why}"),
                format!("drive {name} cannot be read, its samples are left out: {why}"),
            ),
        ));
    }
    summary(state);
    Ok(resumed.into_inner())
}

/// The samples of one drive, appended to its file as they are made.
fn cut_drive(
    state: &State<'_>,
    checker: Option<&Checker<'_>>,
    drive: u32,
    items: &[usize],
) -> Result<Vec<Outcome>, DatasetError> {
    let inputs = state.inputs;
    let id = DriveId::from(state.labels.drives.get(drive));
    let content = match inputs.lake.read_drive(&id) {
        Ok(content) => content,
        Err(e) => {
            let dropped = Dropped::with(Stage::Sample, "drive_unreadable", e.to_string());
            return Ok(items.iter().map(|_| Err(dropped.clone())).collect());
        }
    };
    let candidates: Vec<Candidate<'_>> =
        items.iter().map(|&i| candidate(state, &state.labels.items[i])).collect::<Result<_, _>>()?;
    // Signals of the whole drive are needed only to draft unlabeled episodes.
    let signals = if candidates.iter().any(|c| c.label.is_episode) {
        let version = whyroad_engine::SIGNALS_VERSION;
        let stored = inputs.lake.signals(&id, version)?.and_then(|file| file.read_table(0).ok());
        Some(match stored {
            Some(table) => table,
            None => signals_of(inputs.lake, &id)?,
        })
    } else {
        None
    };
    let licence = state.selected.licences.get(&drive).map_or("", String::as_str);
    let cutter = Cutter::new(&inputs.spec, inputs.framework, (&content, signals), licence, &inputs.media);
    let mut out = RecordWriter::create(&state.work.samples(drive as usize))?;
    let mut outcomes = Vec::with_capacity(candidates.len());
    for candidate in &candidates {
        let cut = cutter.cut(candidate).and_then(|(sample, cut)| {
            let is_finished = sample.lineage.label_status != DRAFT;
            match checker.filter(|_| is_finished).and_then(|checker| stale(&sample, checker)) {
                Some(codes) => Err(Dropped::with(Stage::Sample, CONTRADICTS, codes)),
                None => Ok((sample, cut)),
            }
        });
        outcomes.push(match cut {
            Ok((sample, mut cut)) => {
                cut.at = out.append(&sample)?;
                Ok(cut)
            }
            Err(dropped) => Err(dropped),
        });
    }
    out.finish()?;
    Ok(outcomes)
}

fn candidate<'a>(state: &'a State<'_>, item: &Item) -> Result<Candidate<'a>, DatasetError> {
    let path = state.work.labels();
    let mut label: LabelRecord = read_record(&path, item.label)?;
    if let Some(at) = item.episode {
        label = label.of_episode(read_record(&path, at)?);
    }
    let other = item.other.map(|at| read_record(&path, at)).transpose()?;
    Ok(Candidate {
        id: id_text(item.id),
        keyframe: Nanos(item.keyframe_ns),
        status: state.labels.statuses.get(item.status),
        checked: item.checked,
        label,
        other,
    })
}

/// One line for each of incomplete windows, missing images and images that were not blurred, however many samples
/// there are.
fn summary(state: &mut State<'_>) {
    let contradicting = state.labels.items.iter().filter_map(|item| item.dropped.as_ref());
    let contradicting: Vec<&Dropped> = contradicting.filter(|d| d.reason == CONTRADICTS).collect();
    if let Some(first) = contradicting.first() {
        let (n, codes) = (contradicting.len(), first.detail.as_deref().unwrap_or_default());
        let message = Bilingual::new(
            format!("{n} 个标签与其行程的记录矛盾，未收入；例如 {codes}"),
            format!(
                "{n} labels contradict the recording of their drive and are left out; the first: {codes}"
            ),
        );
        let hint = Bilingual::new(
            "stages/2-sample.parquet 列出这些标签；`whyroad validate --lake LAKE` 给出每个错误的位置",
            "stages/2-sample.parquet lists them; `whyroad validate --lake LAKE` shows where each error is",
        );
        let found = Diagnostic::warning("dataset.labels.invalid", message).with_hint(hint);
        state.diagnostics.push(found);
    }
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    let mut not_blurred = String::new();
    for item in &state.labels.items {
        if let Some(d) = &item.dropped {
            let kind = match &*d.reason {
                "history" | "future" => "window",
                "camera_missing" | "image_missing" | "image_in_video" | "image_file_missing" => "image",
                "image_before_drive" => "early",
                "image_not_rendered" => "bev",
                "image_not_blurred" => {
                    if not_blurred.is_empty() {
                        not_blurred = d.detail.as_deref().unwrap_or_default().to_owned();
                    }
                    "blur"
                }
                _ => continue,
            };
            *counts.entry(kind).or_default() += 1;
        }
    }
    let [window, image, early, bev, blur] =
        ["window", "image", "early", "bev", "blur"].map(|kind| counts.get(kind).copied());
    if let Some(n) = blur {
        state.diagnostics.push(
            Diagnostic::warning(
                "dataset.image.blur",
                Bilingual::new(
                    format!("{n} 个样本的图像未能脱敏，未收入。首个原因：{not_blurred}"),
                    format!(
                        "{n} samples are left out because an image could not be blurred. The first: {not_blurred}"
                    ),
                ),
            )
            .with_hint(Bilingual::new(
                "用其中一张图像单独运行 --blur 的程序，查看其输出，然后重新构建",
                "run the program of --blur on one of the images, check its output, and build again",
            )),
        );
    }
    if let Some(n) = window {
        state.diagnostics.push(
            Diagnostic::warning(
                "dataset.window.incomplete",
                Bilingual::new(
                    format!("{n} 个样本的窗口超出行程，或其中有缺少位姿的步，未收入"),
                    format!(
                        "{n} samples are left out because their window reaches beyond the drive or has steps \
                         without a pose"
                    ),
                ),
            )
            .with_hint(Bilingual::new(
                "缩短 sample.history_s 或 sample.future_s，或设 sample.incomplete: keep",
                "shorten sample.history_s or sample.future_s, or set sample.incomplete: keep",
            )),
        );
    }
    let mut missing = |n: Option<usize>, (zh, en): (&str, &str), (hint_zh, hint_en): (&str, &str)| {
        let Some(n) = n else { return };
        let message = Bilingual::new(
            format!("{n} 个样本{zh}，未收入"),
            format!("{n} samples are left out because {en}"),
        );
        let d = Diagnostic::warning("dataset.image.missing", message);
        state.diagnostics.push(d.with_hint(Bilingual::new(hint_zh, hint_en)));
    };
    missing(
        image,
        ("缺少图像", "an image is missing"),
        match state.inputs.spec.sample.images {
            Images::CamerasOrBev => {
                ("用 --media 指定图像文件夹", "name the folder of the images with --media")
            }
            _ => (
                "用 --media 指定图像文件夹，或设 sample.images: cameras_or_bev",
                "name the folder of the images with --media, or set sample.images: cameras_or_bev",
            ),
        },
    );
    missing(
        early,
        ("的图像时刻早于行程的起点", "a time of sample.image_times_s is before the start of their drive"),
        (
            "缩短 sample.image_times_s，或要求完整的历史（sample.incomplete: drop）",
            "shorten sample.image_times_s, or require a whole history (sample.incomplete: drop)",
        ),
    );
    missing(
        bev,
        (
            "在图像时刻没有可渲染的帧或自车位姿",
            "their drive has no frame or no pose of the ego to render at a time of sample.image_times_s",
        ),
        (
            "stages/2-sample.parquet 列出这些时刻；修改 sample.image_times_s 以避开",
            "stages/2-sample.parquet names the times; change sample.image_times_s to avoid them",
        ),
    );
}
