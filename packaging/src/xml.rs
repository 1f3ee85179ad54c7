//! Elements and their attributes, in the order in which they are stated.

use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesStart, Event};

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
    pub fn write(self, xml: &mut Xml) -> io::Result<()> {
        xml.write_event(Event::Empty(self.start))
    }

    /// Writes the element around what `contents` writes.
    pub fn contain(self, xml: &mut Xml, contents: impl FnOnce(&mut Xml) -> io::Result<()>) -> io::Result<()> {
        let end = self.start.to_end().into_owned();
        xml.write_event(Event::Start(self.start))?;
        contents(xml)?;
        xml.write_event(Event::End(end))
    }
}

/// The shortest text that gives the same bits when read, for example `5.0` or `3.93e-9`.
pub fn real(value: f64) -> String {
    format!("{value:?}")
}
