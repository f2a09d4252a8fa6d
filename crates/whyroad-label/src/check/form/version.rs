//! The format version that a label states (DATA_FORMAT.md 1.3).

use crate::check::view::View;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_model::FORMAT_VERSION;
use whyroad_model::label_fields::pointer;

/// The newest label format that these rules support (DESIGN.md "Labels").
const NEWEST: (u32, u32) = (2, 1);

/// `major.minor.patch`, of a supported major version.
pub(in crate::check) fn version(label: &View<'_>, sink: &mut dyn Sink) {
    let Some(text) = label.version.get() else { return };
    let mut parts = text.split('.').map(|p| {
        let digits = !p.is_empty() && p.bytes().all(|b| b.is_ascii_digit());
        p.parse::<u32>().ok().filter(|_| digits)
    });
    let (major, minor) = match (parts.next(), parts.next(), parts.next(), parts.next()) {
        (Some(Some(major)), Some(Some(minor)), Some(Some(_)), None) => (major, minor),
        _ => {
            sink.report(Finding::error("label.version", pointer::VERSION), &|| {
                Words::new(
                    format!("'{text}' 不是 major.minor.patch 形式的版本号"),
                    format!("'{text}' is not a version of the form major.minor.patch"),
                )
                .hint(format!("例如 \"{FORMAT_VERSION}\""), format!("such as \"{FORMAT_VERSION}\""))
            });
            return;
        }
    };
    let (known_major, known_minor) = NEWEST;
    if major != known_major {
        sink.report(Finding::error("label.version", pointer::VERSION), &|| {
            Words::new(
                format!("格式版本 {text} 与本程序的 {known_major}.x 不兼容"),
                format!(
                    "format version {text} is not compatible with {known_major}.x, which this program reads"
                ),
            )
        });
    } else if minor > known_minor {
        sink.report(Finding::warning("label.version", pointer::VERSION), &|| {
            Words::new(
                format!("格式版本 {text} 新于本程序所知的 {known_major}.{known_minor}；新增字段不会被检查"),
                format!("format version {text} is newer than the supported {known_major}.{known_minor}; its new fields are not checked"),
            )
        });
    }
}
