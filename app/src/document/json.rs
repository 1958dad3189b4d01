//! JSON that a person can read: numbers of a vector on one line, a dab on one line, everything else indented.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::ser::{Formatter, Serializer};

/// Objects inside that many arrays are written on one line: a dab is in `operations` and in `dabs`.
const INLINE_ARRAYS: usize = 2;

/// The text of `value`, with a line break at its end.
///
/// # Errors
/// What serde says when a value has no JSON form; floats that are not finite become null.
pub fn to_text(value: &impl Serialize) -> Result<String, serde_json::Error> {
    let mut bytes = Vec::new();
    value.serialize(&mut Serializer::with_formatter(&mut bytes, Layout::default()))?;
    bytes.push(b'\n');
    String::from_utf8(bytes).map_err(|e| serde::ser::Error::custom(e.to_string()))
}

/// An open array or object.
struct Level {
    is_array: bool,
    /// No line breaks inside.
    inline: bool,
    /// Something in it stands on a line of its own.
    broken: bool,
}

#[derive(Default)]
struct Layout {
    levels: Vec<Level>,
    /// The next thing written is the element of an array.
    at_element: bool,
}

impl Layout {
    fn new_line<W: ?Sized + Write>(&self, writer: &mut W, depth: usize) -> io::Result<()> {
        writer.write_all(b"\n")?;
        (0..depth).try_for_each(|_| writer.write_all(b"  "))
    }

    fn is_inline(&self) -> bool {
        self.levels.last().is_some_and(|level| level.inline)
    }

    /// Opens an array or object; as the element of an array it starts a new line.
    fn open<W: ?Sized + Write>(&mut self, writer: &mut W, is_array: bool) -> io::Result<()> {
        if self.at_element && !self.is_inline() {
            self.new_line(writer, self.levels.len())?;
            if let Some(level) = self.levels.last_mut() {
                level.broken = true;
            }
        }
        self.at_element = false;
        let arrays = self.levels.iter().filter(|level| level.is_array).count();
        let inline = self.is_inline() || (!is_array && arrays >= INLINE_ARRAYS);
        self.levels.push(Level {
            is_array,
            inline,
            broken: false,
        });
        writer.write_all(if is_array { b"[" } else { b"{" })
    }

    fn close<W: ?Sized + Write>(&mut self, writer: &mut W, bracket: &[u8]) -> io::Result<()> {
        let level = self.levels.pop();
        if level.is_some_and(|level| level.broken) {
            self.new_line(writer, self.levels.len())?;
        }
        writer.write_all(bracket)
    }
}

impl Formatter for Layout {
    fn begin_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.open(writer, true)
    }

    fn end_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.close(writer, b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        self.at_element = true;
        if first { Ok(()) } else { writer.write_all(b",") }
    }

    fn end_array_value<W: ?Sized + Write>(&mut self, _writer: &mut W) -> io::Result<()> {
        self.at_element = false;
        Ok(())
    }

    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.open(writer, false)
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.close(writer, b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        if !first {
            writer.write_all(b",")?;
        }
        if self.is_inline() {
            return if first { Ok(()) } else { writer.write_all(b" ") };
        }
        if let Some(level) = self.levels.last_mut() {
            level.broken = true;
        }
        self.new_line(writer, self.levels.len())
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.at_element = false;
        writer.write_all(b": ")
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn vectors_and_dabs_take_one_line() {
        let value = serde_json::json!({"a": [1, 2], "b": [{"c": [{"d": [3, 4], "e": {}}, {"d": []}]}], "f": [[1], [2]]});
        let text = super::to_text(&value).unwrap();
        let lines = [
            "{",
            "  \"a\": [1,2],",
            "  \"b\": [",
            "    {",
            "      \"c\": [",
            "        {\"d\": [3,4], \"e\": {}},",
            "        {\"d\": []}",
            "      ]",
            "    }",
            "  ],",
            "  \"f\": [",
            "    [1],",
            "    [2]",
            "  ]",
            "}",
            "",
        ];
        assert_eq!(text, lines.join("\n"));
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).unwrap(), value);
    }
}
