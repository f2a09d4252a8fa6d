//! What the SUMO adapter reports, one function per code. Texts only.

use super::net::Net;
use super::on_net::OnNet;
use crate::phrases::zh;
use std::collections::BTreeMap;
use whyroad_model::{Bilingual, Diagnostic};

/// Codes of the SUMO adapter; each has a page in `docs/diagnostics/`.
pub(crate) const CODES: &[&str] = &[
    "sumo.fcd.unreadable",
    "sumo.fcd.broken",
    "sumo.fcd.invalid",
    "sumo.fcd.lane_jump",
    "sumo.fcd.step",
    "sumo.ego.missing",
    "sumo.ego.none_drawn",
    "sumo.type.assumed",
    "sumo.type.unreadable",
    "sumo.net.missing",
    "sumo.net.unreadable",
    "sumo.net.invalid",
    "sumo.net.dangling",
    "sumo.net.ambiguous",
    "sumo.net.foreign",
    "sumo.net.off",
    "sumo.lights.unreadable",
    "sumo.lights.ambiguous",
    "sumo.shapes.unreadable",
];

fn text(zh: String, en: String) -> Bilingual {
    Bilingual::new(zh, en)
}

pub(super) fn fcd_unreadable(file: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "sumo.fcd.unreadable",
        text(
            format!("不是可读取的 FCD 文件：{reason_zh}", reason_zh = zh(reason)),
            format!("not a readable FCD file: {reason}"),
        ),
    )
    .with_hint(Bilingual::new(
        "用 `sumo --fcd-output fcd.xml.gz` 生成",
        "`sumo --fcd-output fcd.xml.gz` writes one",
    ))
    .in_file(file)
}

pub(super) fn fcd_broken(file: &str, reason: &str, rows: usize) -> Diagnostic {
    Diagnostic::error(
        "sumo.fcd.broken",
        text(
            format!("文件不完整：读出 {rows} 行，其余丢失（{reason_zh}）", reason_zh = zh(reason)),
            format!("the file breaks off: {rows} rows could be read, the rest is lost ({reason})"),
        ),
    )
    .with_hint(Bilingual::new(
        "重新运行仿真，等其结束后再导入",
        "run the simulation again and ingest after it has ended",
    ))
    .in_file(file)
}

pub(super) fn fcd_invalid(file: &str, rows: usize, example: &str) -> Diagnostic {
    Diagnostic::warning(
        "sumo.fcd.invalid",
        text(
            format!("丢弃 {rows} 行：缺少编号、位置或角度，或时间倒退、重复；例如 {example_zh}", example_zh = zh(example)),
            format!("{rows} rows dropped: no id, position or angle, backward time, or a second one at a time; for example {example}"),
        ),
    )
    .in_file(file)
}

pub(super) fn lane_jump(file: &str, jumps: usize, example: &str) -> Diagnostic {
    Diagnostic::warning(
        "sumo.fcd.lane_jump",
        text(
            format!("{jumps} 次横向瞬移（无过程的换道或传送）；跳变处不推导横向速度；例如 {example_zh}", example_zh = zh(example)),
            format!("{jumps} sideways jumps (lane changes that take no time, or teleports); no sideways speed is derived across them; for example {example}"),
        ),
    )
    .with_hint(Bilingual::new(
        "用 `--lateral-resolution 0.4` 或 `--lanechange.duration 3` 运行 SUMO，使换道有过程",
        "run SUMO with `--lateral-resolution 0.4` or `--lanechange.duration 3`, so that lane changes take time",
    ))
    .in_file(file)
}

pub(super) fn step(file: &str, step_s: f64) -> Diagnostic {
    Diagnostic::warning(
        "sumo.fcd.step",
        text(
            format!("仿真步长为 {step_s} 秒：10 Hz 的帧由线性插值得到，短于步长的事件不可见"),
            format!("the simulation's step is {step_s} s: frames at 10 Hz are interpolated linearly, and nothing shorter than the step can be seen"),
        ),
    )
    .with_hint(Bilingual::new("用 `--step-length 0.1` 运行 SUMO", "run SUMO with `--step-length 0.1`"))
    .in_file(file)
}

pub(super) fn ego_missing(file: &str, ego: &str, some: &[&str]) -> Diagnostic {
    let list = some.join(", ");
    Diagnostic::error(
        "sumo.ego.missing",
        text(format!("FCD 中没有名为“{ego}”的车辆"), format!("no vehicle of the FCD has the id '{ego}'")),
    )
    .with_hint(text(
        format!("用 `--ego ID` 指定自车；文件中的车辆例如：{list}"),
        format!("name the ego with `--ego ID`; vehicles in the file: {list}"),
    ))
    .in_file(file)
}

pub(super) fn none_drawn(file: &str) -> Diagnostic {
    Diagnostic::error(
        "sumo.ego.none_drawn",
        Bilingual::new(
            "没有抽到任何自车：份额太小，或 FCD 中没有机动车",
            "no vehicle was drawn as ego: the share is too small, or the FCD has no motor vehicle",
        ),
    )
    .with_hint(Bilingual::new(
        "提高 `--ego-share`，换一个 `--seed`，或用 `--ego ID` 指定",
        "raise `--ego-share`, take another `--seed`, or name egos with `--ego ID`",
    ))
    .in_file(file)
}

pub(super) fn type_assumed(file: &str, types: &BTreeMap<String, usize>) -> Diagnostic {
    let list: Vec<String> = types.iter().map(|(t, n)| format!("{t} ({n})")).collect();
    let list = list.join(", ");
    Diagnostic::warning(
        "sumo.type.assumed",
        text(
            format!("未给出车辆类型的定义，按 SUMO 的默认小客车或行人尺寸处理：{list}"),
            format!("vehicle types without a definition, taken as SUMO's default car or pedestrian: {list}"),
        ),
    )
    .with_hint(Bilingual::new(
        "用 `--types FILE` 给出含有 <vType> 的路线或附加文件",
        "name the route or additional file that has their <vType> with `--types FILE`",
    ))
    .in_file(file)
}

pub(super) fn type_unreadable(file: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "sumo.type.unreadable",
        text(
            format!("车辆类型文件无法完整读取：{reason_zh}", reason_zh = zh(reason)),
            format!("the file of vehicle types cannot be read to its end: {reason}"),
        ),
    )
    .with_hint(Bilingual::new("检查该文件是否为有效的 XML", "check that it is valid XML"))
    .in_file(file)
}

pub(super) fn net_missing(place: &str) -> Diagnostic {
    Diagnostic::warning(
        "sumo.net.missing",
        Bilingual::new(
            "旁边没有 .net.xml：凡需要车道、路口或人行横道的信号都将是未知",
            ".net.xml is missing beside it: signals that need lanes, junctions or crosswalks will be unknown",
        ),
    )
    .with_hint(Bilingual::new("用 `--net FILE` 指定", "name it with `--net FILE`"))
    .in_file(place)
}

/// Several files could be the log's network or light states.
pub(super) fn ambiguous(
    code: &'static str,
    option: &str,
    place: &str,
    files: &[std::path::PathBuf],
) -> Diagnostic {
    let names: Vec<String> = files.iter().map(|p| crate::source::file_label(p)).collect();
    let names = names.join(", ");
    Diagnostic::error(
        code,
        text(
            format!("无法确定属于此行程的文件，有多个候选：{names}；均未使用"),
            format!(
                "several files could belong to this drive, and their names do not decide: {names}; none is used"
            ),
        ),
    )
    .with_hint(text(format!("用 `{option} FILE` 指定"), format!("name it with `{option} FILE`")))
    .in_file(place)
}

pub(super) fn net_unreadable(file: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "sumo.net.unreadable",
        text(
            format!("路网无法完整读取：{reason_zh}", reason_zh = zh(reason)),
            format!("the network cannot be read to its end: {reason}"),
        ),
    )
    .with_hint(Bilingual::new("用 netconvert 重新生成路网", "make the network again with netconvert"))
    .in_file(file)
}

/// Everything about the network's contents.
pub(super) fn of_net(file: &str, net: &Net) -> Vec<Diagnostic> {
    let mut out = Vec::new();
    if let Some(reason) = &net.broken {
        out.push(net_unreadable(file, reason));
    }
    if let Some(example) = &net.invalid_example {
        let n = net.count.dropped_total();
        out.push(
            Diagnostic::warning(
                "sumo.net.invalid",
                text(
                    format!("丢弃 {n} 条无效车道；例如 {example_zh}", example_zh = zh(example)),
                    format!("{n} lanes dropped; for example {example}"),
                ),
            )
            .in_file(file),
        );
    }
    if let Some(first) = net.dangling.first() {
        let n = net.dangling.len();
        out.push(
            Diagnostic::warning(
                "sumo.net.dangling",
                text(
                    format!("{n} 个连接指向不存在的车道，已忽略；例如 {first_zh}", first_zh = zh(first)),
                    format!("{n} connections name lanes that the network does not have, and are left out; for example {first}"),
                ),
            )
            .with_hint(Bilingual::new("用 netconvert 重新生成路网", "make the network again with netconvert"))
            .in_file(file),
        );
    }
    out
}

/// Vehicles of the log that are not on the network.
pub(super) fn off_net(file: &str, net: &str, found: &OnNet) -> Option<Diagnostic> {
    let OnNet { probes, on_lane, example } = found;
    let example = example.as_deref().unwrap_or_default();
    let off = probes - on_lane;
    if found.is_foreign() {
        return Some(
            Diagnostic::error(
                "sumo.net.foreign",
                text(
                    format!("路网“{net}”不属于此日志：抽查 {probes} 个车辆位置，{off} 个不在其车道上，例如 {example_zh}；不使用该路网及信号灯状态", example_zh = zh(example)),
                    format!(
                        "network '{net}' is not that of this log: of {probes} positions of vehicles {off} are not on its \
                         lanes, for example {example}; the network and the light states are not used"
                    ),
                ),
            )
            .with_hint(Bilingual::new(
                "用 `--net FILE` 给出该仿真自己的路网",
                "give the network of this simulation with `--net FILE`",
            ))
            .in_file(file),
        );
    }
    found.is_partial().then(|| {
        Diagnostic::warning(
            "sumo.net.off",
            text(
                format!("抽查 {probes} 个车辆位置，{off} 个不在路网“{net}”的车道上，例如 {example_zh}", example_zh = zh(example)),
                format!(
                    "of {probes} positions of vehicles {off} are not on lanes of network '{net}', for example {example}"
                ),
            ),
        )
        .with_hint(Bilingual::new(
            "确认路网在仿真之后没有被修改",
            "check that the network was not changed after the simulation",
        ))
        .in_file(file)
    })
}

pub(super) fn lights_unreadable(file: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "sumo.lights.unreadable",
        text(
            format!("信号灯状态无法读取，行程不带信号灯保留：{reason_zh}", reason_zh = zh(reason)),
            format!("the light states cannot be read; the drive is kept without them: {reason}"),
        ),
    )
    .with_hint(Bilingual::new("重新运行仿真", "run the simulation again"))
    .in_file(file)
}

pub(super) fn shapes_unreadable(file: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "sumo.shapes.unreadable",
        text(
            format!("附加文件无法完整读取，其余的多边形和标志丢失：{reason_zh}", reason_zh = zh(reason)),
            format!(
                "the additional file cannot be read to its end, further polygons and signs are lost: {reason}"
            ),
        ),
    )
    .in_file(file)
}
