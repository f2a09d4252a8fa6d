//! The findings for errors between the documents of a file.

use super::split::{MAX_DOCUMENT_BYTES, Origin, Problem};
use whyroad_model::{Bilingual, Diagnostic, Location};

/// The finding for something wrong between documents. The place has no file name.
pub fn problem(problem: Problem, origin: &Origin) -> Diagnostic {
    let location = Location {
        line: Some(origin.line),
        column: Some(origin.column),
        pointer: Some(origin.element.map(|i| format!("/{i}")).unwrap_or_default()),
        ..Location::default()
    };
    let b = |zh: &str, en: &str| Bilingual::new(zh, en);
    let syntax = |message| Diagnostic::error("label.json.syntax", message);
    let d = match problem {
        Problem::ByteOrderMark => Diagnostic::warning(
            "label.json.bom",
            b(
                "文件以 BOM（字节顺序标记）开头，许多程序读不了",
                "the file starts with a byte order mark, which many programs refuse",
            ),
        )
        .with_hint(b("另存为“UTF-8”（不带 BOM）", "save it as UTF-8 without BOM")),
        Problem::Utf16 => Diagnostic::error(
            "label.json.encoding",
            b("文件是 UTF-16 编码，未读取", "the file is UTF-16 and was not read"),
        )
        .with_hint(b("另存为 UTF-8", "save it as UTF-8")),
        Problem::CommaMissing => {
            syntax(b("数组的两个元素之间缺少逗号", "a comma is missing between two elements of the array"))
        }
        Problem::CommaTooMany => syntax(b("数组中多了一个逗号", "there is an extra comma in the array"))
            .with_hint(b("删除这个逗号", "delete this comma")),
        Problem::ArrayOpen => {
            syntax(b("文件在数组中间中断，缺少 ']'", "the file ends inside its array: ']' is missing"))
        }
        Problem::TooLarge => {
            let megabytes = MAX_DOCUMENT_BYTES >> 20;
            Diagnostic::error(
                "label.json.too_large",
                Bilingual::new(
                    format!("文档超过 {megabytes} MB，未检查"),
                    format!("the document is larger than {megabytes} MB and was not checked"),
                ),
            )
        }
        Problem::NotJson => syntax(b(
            "此后的内容看来不是 JSON，文件余下部分未检查",
            "this does not look like JSON; the rest of the file was not checked",
        )),
    };
    d.at(location)
}
