//! The table of a label's fields, generated from `schema/label_fields.yaml` by the build script: pointers, presence,
//! the format version that added each, and names for people. The types themselves are in [`crate::messages`].

/// A field of a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LabelField {
    /// JSON pointer (RFC 6901) with `*` for a position in a list: `/critical_components/*/id`.
    pub pointer: &'static str,
    /// Whether it must be there.
    pub presence: FieldPresence,
    /// Format version that added it: `2.0` or `2.1`.
    pub since: &'static str,
    /// Name on the page, Chinese and English; `None` if it is not shown there.
    pub names: Option<(&'static str, &'static str)>,
}

/// Whether a field must be there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldPresence {
    /// Must be there, and not null.
    Required,
    /// May be absent; null is the same.
    Optional,
    /// Must be there, and may be null.
    Nullable,
}

include!(concat!(env!("OUT_DIR"), "/label_fields.rs"));

mod page;
pub use page::page_module;

impl LabelField {
    /// The field at a pointer of a document, such as `/critical_components/3/id`.
    pub fn at(pointer: &str) -> Option<&'static LabelField> {
        LABEL_FIELDS.iter().find(|f| {
            let (mut a, mut b) = (f.pointer.split('/'), pointer.split('/'));
            loop {
                match (a.next(), b.next()) {
                    (None, None) => break true,
                    (Some("*"), Some(step)) if step.parse::<usize>().is_ok() => {}
                    (Some(x), Some(y)) if x == y => {}
                    _ => break false,
                }
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pointer_of_a_document_finds_its_field() {
        let field = LabelField::at("/critical_components/3/id").unwrap();
        assert_eq!((field.pointer, field.since), ("/critical_components/*/id", "2.1"));
        assert_eq!(
            pointer::critical_components_item_evidence_times_item(1, 2),
            "/critical_components/1/evidence_times/2"
        );
        assert_eq!(pointer::records_of("a/b"), "/records/a~1b");
        assert_eq!(LabelField::at("/keyframe/3"), None);
        assert_eq!(
            LabelField::at(pointer::DRIVING_DECISION_LATERAL).unwrap().presence,
            FieldPresence::Nullable
        );
    }
}
