//! The card: the contents of the release, with charts; its front matter is what the Hugging Face hub and `datasets`
//! read.

use super::CHARTS;
use super::manifest::Manifest;
use crate::item::SplitName;
use std::fmt::Write;
use whyroad_render::bars::bars;

/// Maximum number of rows of a chart.
const ROWS: usize = 40;

/// Charts by file name.
pub(crate) fn charts(m: &Manifest) -> Vec<(&'static str, String)> {
    let total = |by: &std::collections::BTreeMap<String, usize>| by.values().sum::<usize>() as f64;
    let of = |by: &std::collections::BTreeMap<String, usize>| {
        by.iter().map(|(k, v)| (k.clone(), *v as f64)).collect()
    };
    let classes = m.counts.by_class.iter().map(|(class, by)| (class.clone(), total(by))).collect();
    let curve = m.deduplicate.curve.iter();
    let curve = curve.map(|t| (format!(">= {}", t.similarity), (t.within + t.across) as f64)).collect();
    vec![
        ("classes.svg", bars("Samples by class / 各场景样本数", &largest(classes))),
        ("decisions.svg", bars("Samples by decision / 各决策样本数", &largest(of(&m.counts.by_decision)))),
        ("places.svg", bars("Samples by place / 各地点样本数", &largest(of(&m.counts.by_place)))),
        (
            "similarity.svg",
            bars(
                "Samples dropped by similarity threshold / 各相似度阈值下去除的样本数",
                &Vec::from_iter::<Vec<_>>(curve),
            ),
        ),
    ]
}

fn largest(mut rows: Vec<(String, f64)>) -> Vec<(String, f64)> {
    rows.sort_by(|a, b| b.1.total_cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    if rows.len() > ROWS {
        let rest: f64 = rows[ROWS..].iter().map(|r| r.1).sum();
        let n = rows.len() - ROWS;
        rows.truncate(ROWS);
        rows.push((format!("{n} others / 其余 {n} 项"), rest));
    }
    rows
}

/// The license as the hub's front matter writes it.
pub(crate) fn hub_license(id: &str) -> String {
    if id.starts_with("LicenseRef-") { "other".to_owned() } else { id.to_lowercase() }
}

/// The text of `README.md`.
pub(crate) fn card(m: &Manifest) -> String {
    let mut t = String::new();
    let title = m.title.as_deref().unwrap_or(&m.name);
    let _ = writeln!(t, "---\nlicense: {}", hub_license(&m.licence));
    if m.licence.starts_with("LicenseRef-") {
        let _ = writeln!(t, "license_name: {}", m.licence.to_lowercase());
    }
    let _ = writeln!(t, "pretty_name: {}", serde_json::Value::from(title));
    let _ = writeln!(t, "language: [zh, en]\ntags: [autonomous-driving, chain-of-causation, whyroad]");
    let _ = writeln!(t, "configs:\n  - config_name: default\n    data_files:");
    for split in SplitName::ALL.map(SplitName::name) {
        if m.counts.by_split.get(split).is_some_and(|n| *n > 0) {
            let hub = if split == "val" { "validation" } else { split };
            let _ = writeln!(t, "      - split: {hub}\n        path: data/{split}-*.parquet");
        }
    }
    let _ = writeln!(t, "---\n\n# {title}\n");
    let _ = writeln!(
        t,
        "Chain-of-Causation driving data, version {}, made by {}. Each sample is a keyframe of a drive: history,\nobjects up to t0, map and images that a model may see, and the decision, its causes, the trace and the future (of the\nego, and of the objects: their rows with `t_s` > 0) that it should learn.\n",
        m.version, m.created_by
    );
    let _ = writeln!(
        t,
        "因果链驾驶数据集，版本 {}。每个样本是行程中的一个关键帧：模型可以看到的历史、目标物、地图和\n图像，以及应当学会的决策、原因、因果描述和未来。\n",
        m.version
    );
    samples(&mut t, m);
    labels(&mut t, m);
    splits(&mut t, m);
    let _ = writeln!(t, "## Duplicates · 去重\n");
    let d = &m.deduplicate;
    let _ = writeln!(
        t,
        "Dropped: {} exact, {} near inside a split, {} near across splits.\n\n![similarity]({CHARTS}/similarity.svg)\n",
        d.exact, d.near_within, d.near_across
    );
    let spec = &m.spec.deduplicate;
    for (kept, en, zh) in [
        (!spec.exact, "Exact duplicates were kept (`deduplicate.exact: false`).", "完全重复的样本未去除。"),
        (
            spec.near.is_none(),
            "Near-duplicates were kept, within and across splits (`deduplicate.near: null`).",
            "近似重复的样本未去除，划分之间也是。",
        ),
    ] {
        if kept {
            let _ = writeln!(t, "**{en}** {zh}\n");
        }
    }
    let [groups, traces] = m.counts.alike_traces;
    let _ =
        writeln!(t, "Near-identical traces: {traces} in {groups} groups (`stages/traces.parquet`); kept.\n");
    let b = &m.balance;
    let _ = writeln!(
        t,
        "## Balance · 均衡\n\n{} samples over a cap were dropped; {} cells of class x decisions x place.",
        b.capped, b.cells
    );
    if b.shortfalls.is_empty() {
        let _ = writeln!(t, "No class is below its floor.\n");
    } else {
        let migrated = m.versions.contains_key("class_mapping");
        let about = if migrated {
            "queries of the build are not part of a migrated release"
        } else {
            "for `whyroad mine --query`; `–`: no mining rule finds the class"
        };
        let _ = writeln!(t, "Classes below their floor, with their query ({about}):\n");
        let _ = writeln!(t, "| class | present | floor | query |\n|---|---|---|---|");
        for s in &b.shortfalls {
            let query = s.query.as_ref().map_or_else(|| "–".to_owned(), |q| format!("`{q}`"));
            let _ = writeln!(t, "| `{}` | {} | {} | {query} |", s.scenario_id, s.present, s.wanted);
        }
        t.push('\n');
    }
    licences(&mut t, m);
    let _ = writeln!(
        t,
        "## Use · 使用\n\n```python\nfrom datasets import load_dataset\nds = load_dataset(\"parquet\", data_dir=\"data\")\n```\n\nCheck it with `whyroad dataset verify .` or `sha256sum -c checksums.sha256`."
    );
    t
}

fn samples(t: &mut String, m: &Manifest) {
    let _ = writeln!(t, "## Samples · 样本\n\n| split | samples | share |\n|---|---|---|");
    for split in SplitName::ALL.map(SplitName::name) {
        let n = m.counts.by_split.get(split).copied().unwrap_or(0);
        let share = 100.0 * n as f64 / m.counts.samples.max(1) as f64;
        let _ = writeln!(t, "| {split} | {n} | {share:.1} % |");
    }
    let s = &m.spec.sample;
    let _ = writeln!(
        t,
        "\nHistory {} s, future {} s, {} Hz; {} images.\n",
        s.history_s, s.future_s, s.rate_hz, m.counts.images
    );
    for (name, file) in [("classes", "classes.svg"), ("decisions", "decisions.svg"), ("places", "places.svg")]
    {
        let _ = writeln!(t, "![{name}]({CHARTS}/{file})\n");
    }
}

pub(crate) fn labels(t: &mut String, m: &Manifest) {
    let _ = writeln!(t, "## Labels · 标签\n\n| state | samples |\n|---|---|");
    for (status, n) in &m.counts.by_status {
        let _ = writeln!(t, "| {status} | {n} |");
    }
    if m.counts.by_status.contains_key(crate::labels::DRAFT) {
        let _ = writeln!(
            t,
            "\n**Samples with the state `draft` were not checked by a person** (`lineage.label_status`, `lineage.checked`).\n标为 `draft` 的样本未经人工质检。"
        );
    }
    t.push('\n');
}

fn splits(t: &mut String, m: &Manifest) {
    let s = &m.split;
    let by: Vec<&str> = s.by.iter().map(|k| crate::split::key_name(*k)).collect();
    let _ = writeln!(
        t,
        "## Splits · 划分\n\nBy {}: {} groups that are never separated, the largest with {} samples.\n",
        by.join(", "),
        s.components,
        s.largest_component
    );
    if let Some(k) = &s.kept {
        let _ = writeln!(
            t,
            "Splits kept from the release {} {} (SHA-256 of its manifest: `{}`): {} samples are in the split of their sample, drive or place there; {} between two of its splits were left out.\n",
            k.name, k.version, k.manifest_sha256, k.samples, k.between
        );
    }
    for (key, n) in &s.unknown {
        let _ = writeln!(t, "- {n} samples have no known {key} and are grouped by drive.");
    }
    let _ = writeln!(t, "\n| samples of | near a sample of | within | share |\n|---|---|---|---|");
    for d in &s.distances {
        let share = d.share.map_or_else(
            || "unknown".to_owned(),
            |v| format!("{:.1} % ({} of {})", v * 100.0, d.near, d.samples),
        );
        let _ = writeln!(t, "| {} | {} | {} m | {share} |", d.of.name(), d.to.name(), d.within_m);
    }
    t.push('\n');
}

fn licences(t: &mut String, m: &Manifest) {
    let _ = writeln!(
        t,
        "## License · 许可\n\nDeclared: **{}**.\n\n| license | drives | samples | obliges to |\n|---|---|---|---|",
        m.licence
    );
    for l in &m.licences {
        let _ = writeln!(
            t,
            "| {} | {} | {} | {} |",
            l.id,
            l.drives,
            l.samples,
            l.attribution.as_deref().unwrap_or("–")
        );
    }
    for l in m.licences.iter().filter(|l| l.assumed > 0) {
        let _ = writeln!(
            t,
            "\n**Of {} drives under {} the license is assumed** (`licences.assume` in the spec): they state none.\n其中 {} 个行程没有写明许可，{} 是 spec 的假定。",
            l.assumed, l.id, l.assumed, l.id
        );
    }
    t.push('\n');
}
