//! Values of a mapping file, with which users describe their own logs (`--mapping FILE`): numbers and words of a closed
//! list, reported where they stand. What a mapping says is defined by each adapter.

use whyroad_model::suggest::{did_you_mean, suggestion};
use whyroad_model::yaml::{FileReport, FormCodes, Node};
use whyroad_model::{Bilingual, Diagnostic, ObjectClass};

/// Reads the text of a mapping file with `mapping`; with an error there is no mapping.
pub(crate) fn read<T>(
    (file, text): (&str, &str),
    form: &'static FormCodes,
    mapping: impl FnOnce(&Node, &mut FileReport) -> Option<T>,
) -> (Option<T>, Vec<Diagnostic>) {
    let mut report = FileReport::new(file, text, form);
    let mapping = report.parse(text).and_then(|root| mapping(&root, &mut report));
    let sound = report.diagnostics.is_empty();
    (mapping.filter(|_| sound), report.diagnostics)
}

/// A finite number.
pub(crate) fn number(node: &Node, report: &mut FileReport) -> Option<f64> {
    let text = report.text(node)?;
    let number = text.parse().ok().filter(|v: &f64| v.is_finite());
    if number.is_none() {
        report.error(
            report.codes.kind,
            node,
            format!("此处应为数值，实为 '{text}'"),
            format!("expected a number, found '{text}'"),
        );
    }
    number
}

/// A word of a closed list.
pub(crate) fn one_of<T>(
    node: &Node,
    report: &mut FileReport,
    known: impl Fn(&str) -> Option<T>,
    ids: &[&str],
) -> Option<T> {
    let text = report.text(node)?;
    let value = known(&text);
    if value.is_none() {
        unknown_word(node, report, &text, ids);
    }
    value
}

/// Reports a word that is not in its list.
pub(crate) fn unknown_word(node: &Node, report: &mut FileReport, text: &str, ids: &[&str]) {
    let list = ids.join(", ");
    let message = Bilingual::new(
        format!("'{text}' 未知；可用的值：{list}"),
        format!("'{text}' is unknown; the values are {list}"),
    );
    let mut d = Diagnostic::error(report.codes.kind, message);
    if let Some(near) = did_you_mean(text, ids.iter().copied()) {
        d = d.with_hint(suggestion(near));
    }
    report.push(d, node.mark, &node.pointer);
}

/// A class of objects.
pub(crate) fn class(node: &Node, report: &mut FileReport) -> Option<ObjectClass> {
    let ids: Vec<&str> = ObjectClass::ALL.iter().map(|c| c.id()).collect();
    one_of(node, report, ObjectClass::from_id, &ids)
}
