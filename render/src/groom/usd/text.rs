//! The text form of USD, `.usda`: as much of its grammar as it takes to find every prim and attribute, the rest is skipped in balance.

use super::super::{GroomError, bytes::FileBytes};
use super::layer::{Layer, MAX_DEPTH, Prim, Value, is_needed};

const REMEDY: &str = "correct the file there or export it again";

/// Lists in lists; arrays of matrices need three.
const MAX_VALUE_DEPTH: usize = 8;

/// Reads the text of a layer; memory is bounded by the size of the text (8 bytes a number).
pub(super) fn parse(file: FileBytes<'_>) -> Result<Layer, GroomError> {
    let mut parser = Parser {
        file,
        at: 0,
        start: 0,
        peeked: None,
    };
    if !file.bytes.starts_with(b"#usda 1.") {
        return Err(file.error(0, "it does not start with \"#usda 1.\"", "give a USD text file"));
    }
    let mut layer = Layer::default();
    if parser.accept(b'(')? {
        parser.metadata(&mut |key, value| match (key, value) {
            ("metersPerUnit", Value::Numbers(x)) => layer.metres_per_unit = x.first().copied(),
            ("upAxis", Value::Texts(t)) => layer.z_up = t.first().is_some_and(|axis| axis == "Z"),
            ("subLayers", _) => layer.not_followed += 1,
            _ => {}
        })?;
    }
    parser.prims(&mut layer, None, 0, Token::End)?;
    Ok(layer)
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Token<'a> {
    Word(&'a str),
    Number(&'a str),
    Text(&'a str),
    Mark(u8),
    End,
}

struct Parser<'a> {
    file: FileBytes<'a>,
    at: usize,
    /// Where the latest token starts.
    start: usize,
    peeked: Option<Token<'a>>,
}

impl<'a> Parser<'a> {
    fn error(&self, reason: impl Into<String>) -> GroomError {
        let line = 1 + self.file.bytes[..self.start]
            .iter()
            .filter(|b| **b == b'\n')
            .count();
        self.file.error(
            self.start as u64,
            format!("line {line}: {}", reason.into()),
            REMEDY,
        )
    }

    fn peek(&mut self) -> Result<Token<'a>, GroomError> {
        if let Some(token) = self.peeked {
            return Ok(token);
        }
        let token = self.scan()?;
        self.peeked = Some(token);
        Ok(token)
    }

    fn next(&mut self) -> Result<Token<'a>, GroomError> {
        let token = self.peek()?;
        self.peeked = None;
        Ok(token)
    }

    fn accept(&mut self, mark: u8) -> Result<bool, GroomError> {
        let found = self.peek()? == Token::Mark(mark);
        if found {
            self.peeked = None;
        }
        Ok(found)
    }

    fn expect(&mut self, mark: u8) -> Result<(), GroomError> {
        if self.accept(mark)? {
            return Ok(());
        }
        Err(self.error(format!("\"{}\" is missing", mark as char)))
    }

    /// The next token; comments and white space are passed over.
    fn scan(&mut self) -> Result<Token<'a>, GroomError> {
        let bytes = self.file.bytes;
        loop {
            match bytes.get(self.at) {
                Some(b' ' | b'\t' | b'\r' | b'\n' | b';') => self.at += 1,
                Some(b'#') => {
                    self.at += bytes[self.at..]
                        .iter()
                        .position(|b| *b == b'\n')
                        .unwrap_or(bytes.len() - self.at);
                }
                _ => break,
            }
        }
        self.start = self.at;
        let Some(&first) = bytes.get(self.at) else {
            return Ok(Token::End);
        };
        let word = |b: &u8| b.is_ascii_alphanumeric() || matches!(b, b'_' | b':' | b'.') || *b >= 0x80;
        let number = |b: &u8| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'-' | b'+');
        match first {
            b'"' | b'\'' => self.quoted(&[first; 3], first),
            b'@' => self.quoted(b"@@@", b'@'),
            b'<' => self.quoted(b"<<<", b'>'),
            b'0'..=b'9' | b'-' | b'+' | b'.' => {
                let len = bytes[self.at..].iter().take_while(|b| number(b)).count();
                self.at += len;
                self.slice(self.start, self.at).map(Token::Number)
            }
            // A colon goes on a name but does not start one: it stands behind the time of a sample.
            b if b != b':' && word(&b) => {
                let len = bytes[self.at..].iter().take_while(|b| word(b)).count();
                self.at += len;
                self.slice(self.start, self.at).map(Token::Word)
            }
            mark => {
                self.at += 1;
                Ok(Token::Mark(mark))
            }
        }
    }

    /// A quoted text: `triple` opens a long one, `close` ends a short one.
    fn quoted(&mut self, triple: &[u8], close: u8) -> Result<Token<'a>, GroomError> {
        let bytes = self.file.bytes;
        let long = bytes[self.at..].starts_with(triple);
        let from = self.at + if long { 3 } else { 1 };
        let mut at = from;
        while at < bytes.len() {
            let ends = if long {
                bytes[at..].starts_with(triple)
            } else {
                bytes[at] == close
            };
            if ends {
                self.at = at + if long { 3 } else { 1 };
                return self.slice(from, at).map(Token::Text);
            }
            at += if bytes[at] == b'\\' { 2 } else { 1 };
        }
        Err(self.error("a quoted text does not end"))
    }

    fn slice(&self, from: usize, to: usize) -> Result<&'a str, GroomError> {
        std::str::from_utf8(&self.file.bytes[from..to]).map_err(|_| self.error("this is not UTF-8 text"))
    }

    /// Prims and properties up to `end`, which is the end of the text or `}`.
    fn prims(
        &mut self,
        layer: &mut Layer,
        parent: Option<usize>,
        depth: usize,
        end: Token<'a>,
    ) -> Result<(), GroomError> {
        if depth > MAX_DEPTH {
            return Err(self.error(format!("prims are nested deeper than {MAX_DEPTH}")));
        }
        loop {
            let token = self.next()?;
            if token == end {
                return Ok(());
            }
            match token {
                Token::Word(specifier @ ("def" | "over" | "class")) => {
                    self.prim(layer, parent, depth, specifier)?;
                }
                Token::Word("variantSet") => {
                    layer.not_followed += 1;
                    while !matches!(self.peek()?, Token::Mark(b'{') | Token::End) {
                        self.next()?;
                    }
                    self.skip_group()?;
                }
                Token::Word(word) => self.property(layer, parent, word)?,
                _ => return Err(self.error("a prim or a property is expected here")),
            }
        }
    }

    fn prim(
        &mut self,
        layer: &mut Layer,
        parent: Option<usize>,
        depth: usize,
        specifier: &str,
    ) -> Result<(), GroomError> {
        let mut prim = Prim {
            parent,
            visible: specifier == "def",
            ..Prim::default()
        };
        let mut token = self.next()?;
        if let Token::Word(type_name) = token {
            type_name.clone_into(&mut prim.type_name);
            token = self.next()?;
        }
        let Token::Text(name) = token else {
            return Err(self.error("the name of a prim is missing"));
        };
        name.clone_into(&mut prim.name);
        if self.accept(b'(')? {
            let mut not_followed = 0;
            self.metadata(&mut |key, value| match key {
                "active" if value == Value::Texts(vec!["false".into()]) => prim.visible = false,
                "references" | "payload" | "inherits" | "specializes" => not_followed += 1,
                _ => {}
            })?;
            layer.not_followed += not_followed;
        }
        self.expect(b'{')?;
        layer.prims.push(prim);
        let index = layer.prims.len() - 1;
        self.prims(layer, Some(index), depth + 1, Token::Mark(b'}'))
    }

    /// A property whose first word was read.
    fn property(&mut self, layer: &mut Layer, prim: Option<usize>, first: &'a str) -> Result<(), GroomError> {
        const PREFIXES: [&str; 10] = [
            "custom", "uniform", "varying", "config", "prepend", "append", "delete", "add", "reorder", "rel",
        ];
        let mut type_name = first;
        while PREFIXES.contains(&type_name) {
            // A relationship and a reordering have no type: their name follows at once.
            let untyped = matches!(type_name, "rel" | "reorder");
            let Token::Word(word) = self.next()? else {
                return Err(self.error("a type or a name is expected here"));
            };
            type_name = word;
            if untyped {
                return self.untyped_rest();
            }
        }
        if self.accept(b'[')? {
            self.expect(b']')?;
        }
        let Token::Word(name) = self.next()? else {
            return Err(self.error("the name of an attribute is missing"));
        };
        let (name, part) = name
            .strip_suffix(".timeSamples")
            .map_or((name, ""), |name| (name, "timeSamples"));
        let needed = is_needed(name) && prim.is_some();
        let double = type_name.starts_with("double") || type_name.starts_with("matrix");
        let mut value = None;
        let mut samples = Vec::new();
        if self.accept(b'=')? {
            if !needed {
                self.skip_value()?;
            } else if part == "timeSamples" {
                samples = self.samples(double)?;
            } else {
                value = Some(self.value(double, 0)?);
            }
        }
        let mut interpolation = None;
        if self.accept(b'(')? {
            self.metadata(&mut |key, value| {
                if let ("interpolation", Value::Texts(mut t)) = (key, value) {
                    interpolation = t.pop();
                }
            })?;
        }
        if let (true, Some(prim)) = (needed, prim) {
            let attribute = layer.prims[prim].attributes.entry(name.to_owned()).or_default();
            attribute.default = value.or(attribute.default.take());
            attribute.samples.append(&mut samples);
            attribute.interpolation = interpolation.or(attribute.interpolation.take());
        }
        Ok(())
    }

    fn untyped_rest(&mut self) -> Result<(), GroomError> {
        if self.accept(b'=')? {
            self.skip_value()?;
        }
        if self.accept(b'(')? {
            self.metadata(&mut |_, _| {})?;
        }
        Ok(())
    }

    /// `key = value` pairs up to the closing bracket, which the opening one has been read of.
    fn metadata(&mut self, found: &mut dyn FnMut(&str, Value)) -> Result<(), GroomError> {
        loop {
            match self.next()? {
                Token::Mark(b')') => return Ok(()),
                Token::Text(_) => {}
                Token::Word("prepend" | "append" | "delete" | "add" | "reorder") => {}
                Token::Word(key) => {
                    self.expect(b'=')?;
                    match self.peek()? {
                        Token::Mark(_) => {
                            self.skip_value()?;
                            found(key, Value::Nothing);
                        }
                        _ => found(key, self.value(true, 0)?),
                    }
                }
                _ => return Err(self.error("metadata is expected here")),
            }
        }
    }

    /// `{ time: value, ... }`.
    fn samples(&mut self, double: bool) -> Result<Vec<(f64, Value)>, GroomError> {
        let mut samples = Vec::new();
        self.expect(b'{')?;
        while !self.accept(b'}')? {
            let Token::Number(time) = self.next()? else {
                return Err(self.error("the time of a sample is expected here"));
            };
            let time = self.number(time, true)?;
            self.expect(b':')?;
            samples.push((time, self.value(double, 0)?));
            self.accept(b',')?;
        }
        Ok(samples)
    }

    /// A value with the numbers of all its lists and tuples in a row.
    fn value(&mut self, double: bool, depth: usize) -> Result<Value, GroomError> {
        let mut numbers = Vec::new();
        let mut texts = Vec::new();
        self.collect(double, depth, &mut numbers, &mut texts)?;
        Ok(match (numbers.is_empty(), texts.is_empty()) {
            (_, true) => Value::Numbers(numbers),
            (true, false) if texts != ["None"] => Value::Texts(texts),
            _ => Value::Nothing,
        })
    }

    fn collect(
        &mut self,
        double: bool,
        depth: usize,
        numbers: &mut Vec<f64>,
        texts: &mut Vec<String>,
    ) -> Result<(), GroomError> {
        if depth > MAX_VALUE_DEPTH {
            return Err(self.error(format!("lists are nested deeper than {MAX_VALUE_DEPTH}")));
        }
        match self.next()? {
            Token::Number(text) => numbers.push(self.number(text, double)?),
            Token::Word("inf") => numbers.push(f64::INFINITY),
            Token::Word("nan") => numbers.push(f64::NAN),
            Token::Word(text) | Token::Text(text) => texts.push(text.to_owned()),
            Token::Mark(open @ (b'[' | b'(')) => {
                let close = if open == b'[' { b']' } else { b')' };
                while !self.accept(close)? {
                    self.collect(double, depth + 1, numbers, texts)?;
                    self.accept(b',')?;
                }
            }
            _ => return Err(self.error("a value is expected here")),
        }
        Ok(())
    }

    /// A number in the precision of its type, so that no bit is rounded twice.
    fn number(&self, text: &str, double: bool) -> Result<f64, GroomError> {
        let value = if double {
            text.parse::<f64>().ok()
        } else {
            text.parse::<f32>().ok().map(f64::from)
        };
        value.ok_or_else(|| self.error(format!("\"{}\" is no number", text.escape_debug())))
    }

    /// Passes over one value of any kind.
    fn skip_value(&mut self) -> Result<(), GroomError> {
        match self.peek()? {
            Token::Mark(b'{' | b'(' | b'[') => self.skip_group(),
            Token::End => Err(self.error("a value is missing")),
            _ => {
                let asset = self.file.bytes.get(self.start) == Some(&b'@');
                self.next()?;
                // A reference may name a prim and an offset behind its file.
                if asset {
                    while matches!(self.peek()?, Token::Text(_)) && self.file.bytes[self.start] == b'<' {
                        self.next()?;
                    }
                    if self.peek()? == Token::Mark(b'(') {
                        self.skip_group()?;
                    }
                }
                Ok(())
            }
        }
    }

    /// Passes over a bracketed group with all that is in it.
    fn skip_group(&mut self) -> Result<(), GroomError> {
        let mut depth = 0_usize;
        loop {
            match self.next()? {
                Token::Mark(b'{' | b'(' | b'[') => depth += 1,
                Token::Mark(b'}' | b')' | b']') => {
                    depth = depth.saturating_sub(1);
                    if depth == 0 {
                        return Ok(());
                    }
                }
                Token::End => return Err(self.error("a bracket does not close")),
                _ if depth == 0 => return Err(self.error("a group is expected here")),
                _ => {}
            }
        }
    }
}
