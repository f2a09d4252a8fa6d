//! `whyroad dataset show` and `diff`: one sample with its lineage, and the differences of two releases.

use super::refused;
use crate::cmd::tasks::state_name;
use crate::output::DataFormat;
use crate::output::reason::stop;
use crate::{Global, framework_folder, output};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use whyroad_dataset::diff::{Difference, diff as compare};
use whyroad_dataset::{Release, Sample};
use whyroad_framework::Framework;
use whyroad_model::{Lang, Nanos, ScenarioId};
use whyroad_report::coverage::class_title;

/// Arguments of `whyroad dataset show`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// The release
    #[arg(value_name = "RELEASE")]
    release: PathBuf,
    /// Sample id, or the beginning of one
    #[arg(value_name = "SAMPLE")]
    sample: String,
    /// Text, or the whole sample as JSON (images by their hash)
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    format: DataFormat,
}

/// Arguments of `whyroad dataset diff`.
#[derive(clap::Args)]
pub(crate) struct DiffArgs {
    /// The first release
    #[arg(value_name = "A")]
    first: PathBuf,
    /// The second release
    #[arg(value_name = "B")]
    second: PathBuf,
    /// How to print the difference
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    format: DataFormat,
}

pub(super) fn run(global: &Global, a: &Args) -> anyhow::Result<ExitCode> {
    let found = Release::open(&a.release).and_then(|release| release.find(&a.sample));
    let mut sample = match found {
        Ok(Some((sample, 1))) => sample,
        Ok(Some((_, n))) => {
            let sample = &a.sample;
            return Err(stop(
                format!("{n} 个样本的编号以“{sample}”开头：请多写几位"),
                format!("{n} samples have an id that begins with '{sample}': give more digits"),
            ));
        }
        Ok(None) => {
            let (sample, release) = (&a.sample, a.release.display());
            return Err(stop(
                format!("{release} 中没有样本“{sample}”"),
                format!("no sample '{sample}' in {release}"),
            ));
        }
        Err(e) => return Ok(refused(global, &e)),
    };
    match a.format {
        DataFormat::Json => {
            sample.images.iter_mut().for_each(|i| i.bytes.clear());
            output::put(&format!("{}\n", serde_json::to_string_pretty(&sample)?));
        }
        DataFormat::Text => {
            let (framework, _) = framework_folder::load(global)?;
            output::put(&text(&sample, &framework, global.lang));
        }
    }
    Ok(output::FINE)
}

fn text(s: &Sample, framework: &Framework, lang: Lang) -> String {
    let l = &s.lineage;
    let unknown = if lang == Lang::Zh { "未知" } else { "unknown" };
    let or = |v: &Option<String>| v.clone().unwrap_or_else(|| unknown.to_owned());
    let zh = lang == Lang::Zh;
    let t = |zh_text: &'static str, en: &'static str| if zh { zh_text } else { en };
    let decision = |v: &Option<String>| v.clone().unwrap_or_else(|| t("无决策变化", "no change").to_owned());
    let checked = if l.checked { t("（已质检）", " (checked)") } else { "" };
    let sizes = |trajectory: &whyroad_dataset::sample::Trajectory| {
        let known = trajectory.x.iter().filter(|x| x.is_some()).count();
        format!("{known}/{}{}", trajectory.x.len(), t(" 步", " steps"))
    };
    let name = s.scenario_id.parse::<ScenarioId>().ok().map(|id| class_title(&framework.taxonomy, &id));
    let class = name.map_or(s.scenario_id.clone(), |n| format!("{} ({})", n.get(lang), s.scenario_id));
    let rows: Vec<(&str, &str, String)> = vec![
        ("样本", "sample", s.sample_id.clone()),
        (
            "划分",
            "split",
            format!("{}{}{:.3}{}", word(&s.split, lang), t("（权重 ", " (weight "), s.weight, t("）", ")")),
        ),
        ("场景", "class", class),
        ("决策", "decision", format!("{} / {}", decision(&s.longitudinal), decision(&s.lateral))),
        ("因果描述（中文）", "trace (Chinese)", or(&s.trace_zh)),
        ("因果描述（英文）", "trace (English)", or(&s.trace_en)),
        ("历史 / 未来", "history / future", format!("{} / {}", sizes(&s.history), sizes(&s.future))),
        ("目标", "objects", s.objects.len().to_string()),
        ("图像", "images", s.images.len().to_string()),
        ("行程", "drive", format!("{} ({})", l.drive_id, l.drive_hash)),
        (
            "关键帧",
            "keyframe",
            format!(
                "{}{}{}{}",
                Nanos(l.keyframe_time_ns),
                t("（第 ", " (frame "),
                l.keyframe_frame,
                t(" 帧）", ")")
            ),
        ),
        ("片段", "clip", l.clip_id.clone()),
        ("事件", "episode", or(&l.episode_id)),
        ("任务", "task", or(&l.task_id)),
        ("标签", "label", format!("{} · sha256 {}", or(&l.label_version), l.label_sha256)),
        ("标签状态", "label state", format!("{}{checked}", word(&l.label_status, lang))),
        ("作者", "author", format!("{} {}", word(&or(&l.label_source), lang), or(&l.label_by))),
        ("分类版本", "taxonomy version", or(&l.taxonomy_version)),
        ("规则版本", "rule version", or(&l.rule_version)),
        ("来源 / 许可", "source / license", format!("{} / {}", s.groups.source, s.groups.licence)),
        (
            "会话 / 车辆",
            "session / vehicle",
            format!("{} / {}", or(&s.groups.session), or(&s.groups.vehicle)),
        ),
        ("地点", "place", format!("{} · {}", or(&s.groups.place), or(&s.groups.place_cell))),
        ("分组", "group", s.groups.component.to_string()),
    ];
    let mut out = String::new();
    for (zh, en, value) in rows {
        let _ = match lang {
            Lang::Zh => writeln!(out, "{zh}：{value}"),
            Lang::En => writeln!(out, "{en:<18}{value}"),
        };
    }
    out
}

/// A split, a state of a label or a kind of author for people; a word that has no name is as it is.
fn word(word: &str, lang: Lang) -> String {
    let zh = match word {
        "train" => "训练",
        "val" => "验证",
        "test" => "测试",
        "draft" => "草稿",
        "imported" => "导入",
        "rule" => "规则",
        "model" => "模型",
        "person" => "人工",
        other => return state_name(other, lang),
    };
    if lang == Lang::Zh { zh } else { word }.to_owned()
}

pub(super) fn diff(global: &Global, a: &DiffArgs) -> anyhow::Result<ExitCode> {
    let both = Release::open(&a.first).and_then(|x| Release::open(&a.second).and_then(|y| compare(&x, &y)));
    match both {
        Ok(d) => {
            output::put(&match a.format {
                DataFormat::Json => format!("{}\n", serde_json::to_string_pretty(&d)?),
                DataFormat::Text => difference(&d, global.lang),
            });
            Ok(if d == Difference::default() { output::FINE } else { output::FINDINGS })
        }
        Err(e) => Ok(refused(global, &e)),
    }
}

fn difference(d: &Difference, lang: Lang) -> String {
    let zh = lang == Lang::Zh;
    let mut out = String::new();
    let counts = [
        ("新增", "added", d.added.len()),
        ("移除", "removed", d.removed.len()),
        ("换划分", "moved between splits", d.moved.len()),
        ("标签改变", "relabelled", d.relabelled.len()),
        ("标签状态改变", "label state changed", d.restated.len()),
        ("行程内容改变", "changed drives", d.changed_drives.len()),
    ];
    for (name_zh, name_en, n) in counts {
        let _ = if zh { writeln!(out, "{name_zh}：{n}") } else { writeln!(out, "{name_en:<22}{n}") };
    }
    let mut states: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for (_, x, y) in &d.restated {
        *states.entry((x, y)).or_default() += 1;
    }
    for ((x, y), n) in states {
        let _ = writeln!(out, "  label_status: {} -> {}: {n}", word(x, lang), word(y, lang));
    }
    for (fact, n) in &d.facts {
        let _ = if zh {
            writeln!(out, "  {fact}：{n} 个样本不同")
        } else {
            writeln!(out, "  {fact}: differs in {n} samples")
        };
    }
    for (class, (x, y)) in &d.by_class {
        let _ = writeln!(out, "  {class}: {x} -> {y}");
    }
    for (path, x, y) in d.spec.iter().chain(&d.versions) {
        let _ = writeln!(out, "  {path}: {x} -> {y}");
    }
    out
}
