//! What is reported about a map beside a log, one function per code. Texts only.

use super::MapReading;
use crate::assemble::layers::Declared;
use crate::phrases::zh;
use whyroad_model::suggest::suggestion_or_known;
use whyroad_model::{Bilingual, Diagnostic, counted};

/// Codes of maps beside logs; each has a page in `docs/diagnostics/`.
pub(crate) const CODES: &[&str] = &[
    "map.file.unreadable",
    "map.file.broken",
    "map.feature.invalid",
    "map.link.dangling",
    "map.placement",
    "map.world",
    "map.replaced",
    "map.lights",
    "map.vehicles.off",
    "map.complete",
    "map.lanelet.untyped",
];

pub(super) fn unreadable(file: &str, reason: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("地图无法读取，行程不带此地图：{reason_zh}", reason_zh = zh(reason)),
        format!("the map cannot be read; drives are kept without it: {reason}"),
    );
    Diagnostic::error("map.file.unreadable", message)
        .with_hint(Bilingual::new(
            "--map 接受 OpenDRIVE（.xodr）与 Lanelet2（.osm）文件",
            "--map takes OpenDRIVE (.xodr) and Lanelet2 (.osm) files",
        ))
        .in_file(file)
}

/// A word of `--map-complete` that names no part of a map.
pub(super) fn unknown_part(file: &str, word: &str) -> Diagnostic {
    let known = Declared::words();
    let message = Bilingual::new(
        format!("--map-complete 的 '{word}' 不是地图内容，不起作用"),
        format!("'{word}' in --map-complete is no part of a map and has no effect"),
    );
    Diagnostic::error("map.complete", message).with_hint(suggestion_or_known(word, known)).in_file(file)
}

pub(super) fn placement(file: &str, reason: &str) -> Diagnostic {
    let message = Bilingual::new(
        format!("无法确定地图的位置，不使用此地图：{reason_zh}", reason_zh = zh(reason)),
        format!("the location of the map is unknown; it is not used: {reason}"),
    );
    Diagnostic::error("map.placement", message)
        .with_hint(Bilingual::new(
            "用 `--map-origin LAT,LON` 给出日志坐标系原点的纬度与经度；`--map-offset X,Y` 是地图的平移量（米）",
            "give latitude and longitude of the origin of the log's frame with `--map-origin LAT,LON`; `--map-offset X,Y` is \
             a shift of the map in meters",
        ))
        .in_file(file)
}

/// Everything about the map's contents.
pub(super) fn of_map(file: &str, reading: &MapReading) -> Vec<Diagnostic> {
    let mut out = Vec::new();
    if let Some(reason) = &reading.broken {
        let message = Bilingual::new(
            format!("地图不完整，其余丢失：{reason_zh}", reason_zh = zh(reason)),
            format!("the map breaks off, the rest is lost: {reason}"),
        );
        out.push(Diagnostic::error("map.file.broken", message).in_file(file));
    }
    if let Some(example) = reading.invalid.first() {
        let n = reading.invalid.len();
        let message = Bilingual::new(
            format!("{n} 个要素无法使用；例如 {example_zh}", example_zh = zh(example)),
            format!("{n} features cannot be used; for example {example}"),
        );
        out.push(Diagnostic::warning("map.feature.invalid", message).in_file(file));
    }
    if let Some(example) = reading.untyped.first() {
        let n = reading.untyped.len();
        let message = Bilingual::new(
            format!(
                "{n} 个 lanelet 没有 subtype，按机动车道处理；例如 {example_zh}",
                example_zh = zh(example)
            ),
            format!("{} without a subtype are taken for road; for example {example}", counted(n, "lanelet")),
        );
        let hint = Bilingual::new(
            "在地图中写明 subtype（road、crosswalk、walkway 等）",
            "state their subtype in the map (road, crosswalk, walkway, ...)",
        );
        out.push(Diagnostic::warning("map.lanelet.untyped", message).with_hint(hint).in_file(file));
    }
    if let Some(example) = reading.dangling.first() {
        let n = reading.dangling.len();
        let message = Bilingual::new(
            format!("{n} 个引用指向地图中没有的要素，已忽略；例如 {example_zh}", example_zh = zh(example)),
            format!(
                "{n} references name elements that the map does not have; they are left out; for example {example}"
            ),
        );
        out.push(Diagnostic::warning("map.link.dangling", message).in_file(file));
    }
    out
}

pub(super) fn no_world(file: &str) -> Diagnostic {
    let message = Bilingual::new(
        "日志没有自车位姿，位置只相对自车；地图无法使用",
        "the log has no poses of the ego, its positions are relative to the car; the map cannot be used",
    );
    Diagnostic::error("map.world", message).in_file(file)
}

pub(super) fn replaced(file: &str) -> Diagnostic {
    let message = Bilingual::new("此地图取代日志自带的地图", "this map takes the place of the log's own");
    Diagnostic::note("map.replaced", message).in_file(file)
}

pub(super) fn lights(file: &str, states: usize) -> Diagnostic {
    let message = Bilingual::new(
        format!("{states} 条信号灯状态的车道不在此地图中，已忽略"),
        format!(
            "{states} light states name lanes that this map does not have near the drive, and are left out"
        ),
    );
    Diagnostic::warning("map.lights", message)
        .with_hint(Bilingual::new(
            "docs/reference/maps.zh.md 说明地图车道的编号",
            "docs/reference/maps.md says how lanes of a map are named",
        ))
        .in_file(file)
}

pub(super) fn vehicles_off(file: &str, off: usize, all: usize) -> Diagnostic {
    let message = Bilingual::new(
        format!("{all} 辆车中有 {off} 辆距所有车道超过 15 m：日志与地图可能不在同一坐标系"),
        format!(
            "{off} of {all} vehicles are farther than 15 m from every lane: log and map may lie in different frames"
        ),
    );
    Diagnostic::warning("map.vehicles.off", message).in_file(file)
}
