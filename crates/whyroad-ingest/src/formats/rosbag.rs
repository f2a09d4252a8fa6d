//! ROS 1 bags (format 2.0): the messages that [`super::mcap`] reads, in ROS 1's own serialization, by the definitions
//! that the bag carries. Mapping file, frames and rows are the same; its codes `mcap.*` hold here too.

use super::mcap::{Container, MAPPING, find_by_ending, read_container, read_in_memory};
use crate::adapter::{Adapter, DriveSink, FilesInMemory, FormatAbout, Located, Source, whole};
use crate::encodings::bag_records;
use crate::options::{LICENCE, Options};
use crate::report::SourceReport;
use std::path::Path;
use whyroad_model::{Bilingual, Diagnostic, Drive};

/// Raised when the adapter makes something else of the same files, so that drives in a lake are replaced.
const REVISION: u32 = 3;
/// Codes of this adapter beside those of MCAP; each has a page in `docs/diagnostics/`.
const CODES: &[&str] = &["rosbag.file.broken"];

/// ROS 1 bags.
pub struct RosBag;

impl Adapter for RosBag {
    fn about(&self) -> &'static FormatAbout {
        const {
            &FormatAbout {
                name: "rosbag",
                summary: "ROS 1 bags, format 2.0 (plain, bz2 and lz4 chunks)",
                example: "rosbag drive.bag --mapping topics.yaml --lake lake",
                options: &[MAPPING, LICENCE],
                codes: CODES,
            }
        }
    }

    fn find(&self, path: &Path) -> Vec<Located> {
        whole(find_by_ending(path, "bag"))
    }

    fn read(&self, source: &Source, options: &Options, drives: &mut DriveSink<'_>) {
        drives.put(read(&source.path, options));
    }

    fn read_files(&self, files: &FilesInMemory, options: &Options, drives: &mut DriveSink<'_>) {
        read_in_memory(files, &CONTAINER, options, drives);
    }
}

const CONTAINER: Container = Container {
    format: "rosbag",
    revision: REVISION,
    ending: ".bag",
    records: |input, each| bag_records::read(input, each).iter().map(ToString::to_string).collect(),
    broken,
};

/// Reads one bag. `None` when there is nothing that could be kept; the report says why.
pub fn read(path: &Path, options: &Options) -> (Option<Drive>, SourceReport) {
    read_container(path, &CONTAINER, options)
}

fn broken(file: &str, reason: &str) -> Diagnostic {
    let message = Bilingual::new(format!("部分内容丢失：{reason}"), format!("a part is lost: {reason}"));
    Diagnostic::error("rosbag.file.broken", message)
        .with_hint(Bilingual::new(
            "用 `rosbag reindex` 修复该文件，或重新复制；1.2 格式的包用 `rosbag fix` 升级",
            "repair the file with `rosbag reindex`, or copy it again; upgrade bags of format 1.2 with `rosbag fix`",
        ))
        .in_file(file)
}
