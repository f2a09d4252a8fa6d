//! XML files of SUMO, plain or compressed, read as a stream of tags. Content before a break in the file is kept.

use super::input::Input;
use crate::file_reader::FileReader;
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use std::borrow::Cow;
use std::io::BufReader;

/// A tag as it opens (also one without content) or closes.
pub(crate) enum Tag<'a> {
    Open(Element<'a>),
    Close(&'a str),
}

/// An opening tag.
pub(crate) struct Element<'a>(&'a BytesStart<'a>);

impl<'a> Element<'a> {
    pub fn name(&self) -> &'a str {
        self.0.name().into_inner()
    }

    /// The attribute's text; a broken attribute counts as absent.
    pub fn get(&self, name: &str) -> Option<Cow<'_, str>> {
        self.0.try_get_attribute(name).ok()??.normalized_value(XmlVersion::Implicit1_0).ok()
    }

    pub fn text(&self, name: &str) -> Option<String> {
        self.get(name).map(Cow::into_owned)
    }

    /// The attribute as a finite number.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.get(name)?.trim().parse().ok().filter(|v: &f64| v.is_finite())
    }
}

/// Hands every tag to `visit`. `Err` says where and why reading stopped; tags before that have been handed over.
pub(crate) fn for_each_tag<'a>(
    input: impl Into<Input<'a>>,
    mut visit: impl FnMut(Tag),
) -> Result<(), String> {
    let input = super::compressed::open(input).map_err(|e| e.to_string())?;
    let mut reader = Reader::from_reader(BufReader::with_capacity(1 << 16, input));
    let mut buffer = Vec::new();
    let mut depth = 0usize;
    let mut seen = 0usize;
    loop {
        buffer.clear();
        match reader.read_event_into(&mut buffer) {
            Ok(Event::Start(e)) => {
                depth += 1;
                seen += 1;
                visit(Tag::Open(Element(&e)));
            }
            Ok(Event::Empty(e)) => {
                seen += 1;
                visit(Tag::Open(Element(&e)));
                visit(Tag::Close(e.name().into_inner()));
            }
            Ok(Event::End(e)) => {
                depth = depth.saturating_sub(1);
                visit(Tag::Close(e.name().into_inner()));
            }
            Ok(Event::Eof) if depth > 0 => return Err("the file ends inside an element".to_owned()),
            Ok(Event::Eof) if seen == 0 => return Err("the file has no XML element".to_owned()),
            Ok(Event::Eof) => return Ok(()),
            Ok(_) => {}
            Err(e) => return Err(format!("at byte {}: {e}", reader.buffer_position())),
        }
    }
}

/// For [`crate::readers`].
pub(crate) const READER: FileReader = FileReader {
    name: "xml",
    read: |bytes| {
        let end = for_each_tag(bytes, |tag| {
            if let Tag::Open(e) = tag {
                drop((e.text("id"), e.number("x")));
            }
        });
        end.is_ok()
    },
};
