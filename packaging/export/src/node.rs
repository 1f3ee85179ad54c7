//! An XML document as a tree, small enough to be held: descriptions of FMUs.

use std::fmt::Display;

use pneumatic_servo_ssp::xml::{Xml, document};
use quick_xml::events::{BytesEnd, BytesStart, BytesText, Event};
use quick_xml::{Reader, XmlVersion};

use crate::Refused;

/// The deepest nesting that is read: descriptions have six levels.
const DEEPEST: usize = 64;

/// An element.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Node {
    /// Its name.
    pub name: String,
    attributes: Vec<(String, String)>,
    /// The elements in it.
    pub children: Vec<Node>,
    text: String,
}

impl Node {
    /// Reads a document.
    pub fn read(text: &str, what: &str) -> Result<Self, Refused> {
        let wrong = |reason: &dyn Display| Refused(format!("{what} is refused: {reason}"));
        let mut reader = Reader::from_str(text);
        // The last one is still open; the first one holds the root.
        let mut open = vec![Self::default()];
        loop {
            match reader.read_event().map_err(|error| wrong(&error))? {
                Event::Start(_) if open.len() > DEEPEST => return Err(wrong(&"its elements are nested too deeply")),
                Event::Start(start) => open.push(Self::of(&start).map_err(|error| wrong(&error))?),
                Event::Empty(start) => {
                    let node = Self::of(&start).map_err(|error| wrong(&error))?;
                    open.last_mut().expect("the first one stays").children.push(node);
                }
                Event::End(_) => {
                    let node = open.pop().expect("the reader matches ends");
                    open.last_mut().ok_or_else(|| wrong(&"an element ends twice"))?.children.push(node);
                }
                Event::Text(text) => {
                    open.last_mut().expect("the first one stays").text.push_str(text.trim());
                }
                Event::Eof => break,
                Event::DocType(_) => return Err(wrong(&"it has a document type, which is not read")),
                _ => {}
            }
        }
        match (open.len(), open.pop().map(|node| node.children)) {
            (1, Some(roots)) if roots.len() == 1 => Ok(roots.into_iter().next().expect("one")),
            _ => Err(wrong(&"it has no root, or one that does not end")),
        }
    }

    fn of(start: &BytesStart) -> Result<Self, quick_xml::Error> {
        let name = start.name().as_ref().to_owned();
        let attributes = start.attributes().map(|attribute| {
            let attribute = attribute?;
            let key = attribute.key.as_ref().to_owned();
            Ok((key, attribute.normalized_value(XmlVersion::Implicit1_0)?.into_owned()))
        });
        Ok(Self { name, attributes: attributes.collect::<Result<_, quick_xml::Error>>()?, ..Self::default() })
    }

    /// The document.
    pub fn text(&self) -> String {
        document(|xml| self.write(xml)).expect("memory takes every text")
    }

    fn write(&self, xml: &mut Xml) -> std::io::Result<()> {
        let mut start = BytesStart::new(&*self.name);
        self.attributes.iter().for_each(|(name, value)| start.push_attribute((&**name, &**value)));
        if self.children.is_empty() && self.text.is_empty() {
            return xml.write_event(Event::Empty(start));
        }
        xml.write_event(Event::Start(start))?;
        if !self.text.is_empty() {
            xml.write_event(Event::Text(BytesText::new(&self.text)))?;
        }
        self.children.iter().try_for_each(|child| child.write(xml))?;
        xml.write_event(Event::End(BytesEnd::new(&*self.name)))
    }

    /// The value of an attribute.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(own, _)| own == name).map(|(_, value)| value.as_str())
    }

    /// The same as another type.
    pub fn number<T: std::str::FromStr>(&self, name: &str) -> Option<T> {
        self.get(name)?.parse().ok()
    }

    /// Changes an attribute, or adds it as the last one.
    pub fn set(&mut self, name: &str, value: impl Into<String>) {
        let value = value.into();
        match self.attributes.iter_mut().find(|(own, _)| own == name) {
            Some((_, own)) => *own = value,
            None => self.attributes.push((name.to_owned(), value)),
        }
    }

    /// The first element of a name in it.
    pub fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name == name)
    }

    /// The same, to be changed.
    pub fn child_mut(&mut self, name: &str) -> Option<&mut Self> {
        self.children.iter_mut().find(|child| child.name == name)
    }

    /// The element and all elements in it.
    pub fn all(&self) -> Vec<&Self> {
        std::iter::once(self).chain(self.children.iter().flat_map(Self::all)).collect()
    }
}
