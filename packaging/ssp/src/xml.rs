//! Elements and their attributes, in the order in which they are stated.

use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesStart, Event};

/// The XML under way.
pub type Xml = Writer<Vec<u8>>;

/// An element that is to be written.
pub struct Element {
    start: BytesStart<'static>,
}

impl Element {
    /// An element without attributes.
    pub fn new(name: &'static str) -> Self {
        Self { start: BytesStart::new(name) }
    }

    /// Adds an attribute.
    pub fn with(mut self, name: &str, value: &str) -> Self {
        self.start.push_attribute((name, value));
        self
    }

    /// Adds an attribute that holds a number, written so that reading it gives the same bits.
    pub fn with_number(self, name: &str, value: f64) -> Self {
        self.with(name, &real(value))
    }

    /// Adds an attribute if there is a value for it.
    pub fn with_some(self, name: &str, value: Option<impl AsRef<str>>) -> Self {
        match value {
            Some(value) => self.with(name, value.as_ref()),
            None => self,
        }
    }

    /// Writes the element, empty.
    ///
    /// # Errors
    /// When the text cannot be written.
    pub fn write(self, xml: &mut Xml) -> io::Result<()> {
        xml.write_event(Event::Empty(self.start))
    }

    /// Writes the element around what `contents` writes.
    ///
    /// # Errors
    /// When the text cannot be written.
    pub fn contain(self, xml: &mut Xml, contents: impl FnOnce(&mut Xml) -> io::Result<()>) -> io::Result<()> {
        let end = self.start.to_end().into_owned();
        xml.write_event(Event::Start(self.start))?;
        contents(xml)?;
        xml.write_event(Event::End(end))
    }
}

/// The text of a file in UTF-8 with what `contents` writes.
///
/// # Errors
/// When it cannot be written.
pub fn document(contents: impl FnOnce(&mut Xml) -> io::Result<()>) -> io::Result<String> {
    let mut xml = Xml::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    contents(&mut xml)?;
    let text = String::from_utf8(xml.into_inner()).map_err(io::Error::other)?;
    Ok(text + "\n")
}

/// The shortest text that gives the same bits when read, for example `5.0` or `3.93e-9`.
pub fn real(value: f64) -> String {
    format!("{value:?}")
}
