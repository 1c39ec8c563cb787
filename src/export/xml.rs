//! Mitsuba's XML: a tree of elements, and its text.
//!
//! In: elements with attributes, children and comments. Out: the document, indented and escaped. Numbers
//! round-trip.

use std::io::{self, Write};

use glam::{Affine3A, Vec3};
use quick_xml::Writer;
use quick_xml::events::{BytesEnd, BytesStart, BytesText, Event};

/// An element with its children.
#[derive(Clone, Debug)]
pub(super) struct Element {
    tag: &'static str,
    attributes: Vec<(&'static str, String)>,
    children: Vec<Node>,
}

#[derive(Clone, Debug)]
enum Node {
    Element(Element),
    Comment(String),
}

impl Element {
    pub(super) fn new(tag: &'static str) -> Self {
        Self { tag, attributes: Vec::new(), children: Vec::new() }
    }

    /// A plugin of Mitsuba, such as `<emitter type="point">`.
    pub(super) fn plugin(tag: &'static str, kind: &str) -> Self {
        Self::new(tag).attribute("type", kind)
    }

    pub(super) fn attribute(mut self, key: &'static str, value: impl Into<String>) -> Self {
        self.attributes.push((key, value.into()));
        self
    }

    pub(super) fn child(mut self, element: Element) -> Self {
        self.children.push(Node::Element(element));
        self
    }

    pub(super) fn children(mut self, elements: impl IntoIterator<Item = Element>) -> Self {
        self.children.extend(elements.into_iter().map(Node::Element));
        self
    }

    /// A comment; separates double hyphens, which XML forbids there.
    pub(super) fn comment(mut self, text: impl AsRef<str>) -> Self {
        let mut text = text.as_ref().replace("--", "- -");
        if text.ends_with('-') {
            text.push(' ');
        }
        self.children.push(Node::Comment(text));
        self
    }

    /// A named value, such as `<integer name="width" value="8"/>`.
    pub(super) fn value(self, tag: &'static str, name: &str, value: impl Into<String>) -> Self {
        self.child(Element::new(tag).attribute("name", name).attribute("value", value))
    }

    pub(super) fn string(self, name: &str, value: &str) -> Self {
        self.value("string", name, value)
    }

    pub(super) fn integer(self, name: &str, value: impl ToString) -> Self {
        self.value("integer", name, value.to_string())
    }

    pub(super) fn boolean(self, name: &str, value: bool) -> Self {
        self.value("boolean", name, value.to_string())
    }

    pub(super) fn float(self, name: &str, value: f32) -> Self {
        self.value("float", name, number(value))
    }

    /// A linear colour.
    pub(super) fn rgb(self, name: &str, colour: Vec3) -> Self {
        self.value("rgb", name, numbers(&colour.to_array()))
    }

    /// A `point` or `vector`.
    pub(super) fn coordinates(self, tag: &'static str, name: &str, value: Vec3) -> Self {
        let [x, y, z] = value.to_array().map(number);
        let element = Element::new(tag).attribute("name", name);
        self.child(element.attribute("x", x).attribute("y", y).attribute("z", z))
    }

    /// `to_world`, unless it is the identity.
    pub(super) fn placed(self, transform: &Affine3A) -> Self {
        if *transform == Affine3A::IDENTITY {
            return self;
        }
        let (m, t) = (transform.matrix3, transform.translation);
        let rows = (0..3).flat_map(|i| [m.x_axis[i], m.y_axis[i], m.z_axis[i], t[i]]);
        let matrix: Vec<f32> = rows.chain([0.0, 0.0, 0.0, 1.0]).collect();
        let matrix = Element::new("matrix").attribute("value", numbers(&matrix));
        self.child(Element::new("transform").attribute("name", "to_world").child(matrix))
    }

    /// Writes the element as a whole document.
    pub(super) fn write(&self, output: &mut dyn Write) -> io::Result<()> {
        let mut writer = Writer::new_with_indent(output, b' ', 4);
        self.write_to(&mut writer)?;
        writeln!(writer.into_inner())
    }

    fn write_to(&self, writer: &mut Writer<&mut dyn Write>) -> io::Result<()> {
        let mut start = BytesStart::new(self.tag);
        start.extend_attributes(self.attributes.iter().map(|(key, value)| (*key, value.as_str())));
        if self.children.is_empty() {
            return writer.write_event(Event::Empty(start));
        }
        writer.write_event(Event::Start(start))?;
        for child in &self.children {
            match child {
                Node::Element(element) => element.write_to(writer)?,
                Node::Comment(text) => {
                    let text = BytesText::from_escaped(format!(" {text} "));
                    writer.write_event(Event::Comment(text))?;
                }
            }
        }
        writer.write_event(Event::End(BytesEnd::new(self.tag)))
    }
}

/// A number that round-trips.
fn number(value: f32) -> String {
    format!("{value:?}")
}

/// A list of numbers.
pub(super) fn numbers(values: &[f32]) -> String {
    values.iter().map(|&value| number(value)).collect::<Vec<_>>().join(", ")
}
