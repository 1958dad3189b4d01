//! Ogawa, the container of Alembic: groups whose children are groups and data; objects and properties are laid out in them.
//!
//! | what | bytes |
//! |---|---|
//! | header | "Ogawa", 0xff once the writer has closed the file, version (2), place of the root group (u64) |
//! | group | count (u64), then a word a child: its place, the highest bit set for data; place 0 is empty |
//! | data | size (u64), then as many bytes; a sample starts with a key of 16 |
//!
//! Every size is checked against the file before it is believed; how often groups and values may be read is bounded by the file's size, so
//! that places that lead in circles end.

use super::super::{GroomError, bytes::FileBytes};

pub(super) const REMEDY: &str = "export the curves again, or as .usda";

const IS_DATA: u64 = 1 << 63;

/// Bytes of the key before a sample's values.
const KEY: usize = 16;

/// Index of metadata that stands with its header instead of in the common table.
const OWN_METADATA: u8 = 0xff;

/// A file whose header is sound.
pub(super) struct Archive<'a> {
    pub file: FileBytes<'a>,
    /// Texts that headers name by number.
    metadata: Vec<&'a [u8]>,
    /// The root object.
    pub root: Group<'a>,
    /// Words that may still be read.
    budget: u64,
}

/// A group's words, one a child.
#[derive(Clone, Copy)]
pub(super) struct Group<'a>(&'a [u8]);

impl Group<'_> {
    pub fn len(self) -> usize {
        self.0.len() / 8
    }

    fn child(self, index: usize) -> Option<u64> {
        let word = self.0.get(8 * index..8 * index + 8)?;
        Some(u64::from_le_bytes(word.try_into().ok()?))
    }
}

/// A child object.
pub(super) struct Object<'a> {
    pub name: String,
    /// `key=value` pairs with semicolons between them.
    metadata: &'a [u8],
    pub group: Group<'a>,
}

/// A property with its place.
#[derive(Clone, Copy)]
pub(super) struct Property<'a> {
    name: &'a [u8],
    metadata: &'a [u8],
    is_compound: bool,
    /// Number of the type of its values.
    pod: u32,
    /// Samples in time.
    pub samples: u32,
    group: Group<'a>,
}

impl<'a> Archive<'a> {
    pub fn open(file: FileBytes<'a>) -> Result<Self, GroomError> {
        if file.bytes.starts_with(b"\x89HDF") {
            return Err(file.error(
                0,
                "this is Alembic in its older form, HDF5, which is not read",
                "convert it with abcconvert -toOgawa, or export it anew",
            ));
        }
        let header = file.section(0, 16, "the header")?;
        if !header.starts_with(b"Ogawa") {
            return Err(file.error(0, "it does not start with \"Ogawa\"", "give an Alembic file"));
        }
        if header[5] != 0xff {
            return Err(file.error(5, "its writer did not finish it", REMEDY));
        }
        let mut archive = Self {
            file,
            metadata: vec![b""],
            root: Group(&[]),
            budget: file.bytes.len() as u64 + 64,
        };
        let place = u64::from_le_bytes(header[8..].try_into().unwrap_or_default());
        let archive_group = archive.group(place)?;
        let table = archive.data(archive_group, 5)?;
        let mut cursor = Cursor { file, bytes: table };
        while !cursor.bytes.is_empty() {
            let len = cursor.number(1)?;
            archive.metadata.push(cursor.take(len)?);
        }
        archive.root = archive.child(archive_group, 2)?;
        Ok(archive)
    }

    fn spend(&mut self, words: u64) -> Result<(), GroomError> {
        match self.budget.checked_sub(words) {
            Some(left) => {
                self.budget = left;
                Ok(())
            }
            None => Err(self.file.error(0, "its groups lead in circles", REMEDY)),
        }
    }

    fn group(&mut self, place: u64) -> Result<Group<'a>, GroomError> {
        if place == 0 {
            return Ok(Group(&[]));
        }
        let count = self.word(place)?;
        self.spend(count.saturating_add(1))?;
        let at = place.saturating_add(8);
        self.file
            .section(at, count.saturating_mul(8), "a group")
            .map(Group)
    }

    fn word(&self, place: u64) -> Result<u64, GroomError> {
        let bytes = self.file.section(place, 8, "a count")?;
        Ok(u64::from_le_bytes(bytes.try_into().unwrap_or_default()))
    }

    /// A child that is a group; empty where it is none.
    fn child(&mut self, group: Group<'_>, index: usize) -> Result<Group<'a>, GroomError> {
        match group.child(index) {
            Some(word) if word & IS_DATA == 0 => self.group(word),
            _ => Ok(Group(&[])),
        }
    }

    /// A child that is data; empty where it is none.
    fn data(&mut self, group: Group<'_>, index: usize) -> Result<&'a [u8], GroomError> {
        let Some(word) = group
            .child(index)
            .filter(|word| word & IS_DATA != 0 && *word != IS_DATA)
        else {
            return Ok(&[]);
        };
        let place = word & !IS_DATA;
        let len = self.word(place)?;
        self.spend(1)?;
        self.file.section(place.saturating_add(8), len, "data")
    }

    /// The objects below one.
    pub fn children(&mut self, object: Group<'a>) -> Result<Vec<Object<'a>>, GroomError> {
        // The last child describes the others; it ends with two hashes of 16 bytes.
        let Some(last) = object.len().checked_sub(1) else {
            return Ok(Vec::new());
        };
        let headers = self.data(object, last)?;
        let end = headers.len().saturating_sub(32);
        let mut cursor = Cursor {
            file: self.file,
            bytes: &headers[..end],
        };
        let mut objects = Vec::new();
        while !cursor.bytes.is_empty() {
            let len = cursor.number(4)?;
            let name = String::from_utf8_lossy(cursor.take(len)?).into_owned();
            let index = cursor.number(1)? as u8;
            let metadata = self.metadata(index, &mut cursor, 4)?;
            let group = self.child(object, objects.len() + 1)?;
            objects.push(Object {
                name,
                metadata,
                group,
            });
        }
        Ok(objects)
    }

    fn metadata(&self, index: u8, cursor: &mut Cursor<'a>, width: usize) -> Result<&'a [u8], GroomError> {
        if index == OWN_METADATA {
            let len = cursor.number(width)?;
            return cursor.take(len);
        }
        let known = self.metadata.get(usize::from(index));
        known
            .copied()
            .ok_or_else(|| self.file.error(0, format!("metadata {index} is missing"), REMEDY))
    }

    /// The properties of an object.
    pub fn properties(&mut self, object: Group<'a>) -> Result<Vec<Property<'a>>, GroomError> {
        let compound = self.child(object, 0)?;
        self.properties_in(compound)
    }

    /// The properties in a compound one; none in others.
    pub fn parts(&mut self, property: Option<Property<'a>>) -> Result<Vec<Property<'a>>, GroomError> {
        match property.filter(|property| property.is_compound) {
            Some(compound) => self.properties_in(compound.group),
            None => Ok(Vec::new()),
        }
    }

    fn properties_in(&mut self, compound: Group<'a>) -> Result<Vec<Property<'a>>, GroomError> {
        let Some(last) = compound.len().checked_sub(1) else {
            return Ok(Vec::new());
        };
        let headers = self.data(compound, last)?;
        let mut cursor = Cursor {
            file: self.file,
            bytes: headers,
        };
        let mut properties = Vec::new();
        while !cursor.bytes.is_empty() {
            // Bits: 0-1 kind (0 compound), 2-3 width of the numbers that follow, 4-7 type, 8 names its times, 9 names the samples that
            // change, 12-19 values an element, 20-27 metadata.
            let info = cursor.number(4)? as u32;
            let width = match info >> 2 & 3 {
                0 => 1,
                1 => 2,
                _ => 4,
            };
            let is_compound = info & 3 == 0;
            let mut samples = 0;
            if !is_compound {
                samples = cursor.number(width)? as u32;
                let more = 2 * (info >> 9 & 1) + (info >> 8 & 1);
                for _ in 0..more {
                    cursor.number(width)?;
                }
            }
            let len = cursor.number(width)?;
            let name = cursor.take(len)?;
            let metadata = self.metadata((info >> 20) as u8, &mut cursor, width)?;
            properties.push(Property {
                name,
                metadata,
                is_compound,
                pod: info >> 4 & 15,
                samples,
                group: self.child(compound, properties.len())?,
            });
        }
        Ok(properties)
    }

    /// The numbers of a property's first sample; none where it has none or no numbers.
    pub fn numbers(&mut self, property: Option<Property<'a>>) -> Result<Option<Vec<f64>>, GroomError> {
        let Some(property) = property.filter(|property| !property.is_compound && property.samples > 0) else {
            return Ok(None);
        };
        let data = self.data(property.group, 0)?;
        let bytes = data.get(KEY..).unwrap_or_default();
        self.spend(bytes.len() as u64 / 2)?;
        Ok(decoded(bytes, property.pod))
    }
}

impl Object<'_> {
    /// What the metadata say of `key`.
    pub fn about(&self, key: &str) -> Option<&str> {
        about(self.metadata, key)
    }
}

impl Property<'_> {
    /// What the metadata say of `key`.
    pub fn about(&self, key: &str) -> Option<&str> {
        about(self.metadata, key)
    }

    pub fn name(&self) -> String {
        String::from_utf8_lossy(self.name).into_owned()
    }
}

/// The property of that name.
pub(super) fn named<'a>(properties: &[Property<'a>], name: &str) -> Option<Property<'a>> {
    properties
        .iter()
        .find(|property| property.name == name.as_bytes())
        .copied()
}

fn about<'m>(metadata: &'m [u8], key: &str) -> Option<&'m str> {
    let pairs = std::str::from_utf8(metadata).ok()?.split(';');
    pairs
        .filter_map(|pair| pair.split_once('='))
        .find_map(|(name, value)| (name == key).then_some(value))
}

/// Little-endian values of type `pod`: 0 bool, 1 to 8 integers of growing width, unsigned first, 9 to 11 floats; texts are no numbers.
fn decoded(bytes: &[u8], pod: u32) -> Option<Vec<f64>> {
    fn each<const N: usize>(bytes: &[u8], of: impl Fn([u8; N]) -> f64) -> Vec<f64> {
        let (chunks, _) = bytes.as_chunks::<N>();
        chunks.iter().map(|chunk| of(*chunk)).collect()
    }
    Some(match pod {
        0 | 1 => each(bytes, |[b]| f64::from(b)),
        2 => each(bytes, |[b]| f64::from(b as i8)),
        3 => each(bytes, |b| f64::from(u16::from_le_bytes(b))),
        4 => each(bytes, |b| f64::from(i16::from_le_bytes(b))),
        5 => each(bytes, |b| f64::from(u32::from_le_bytes(b))),
        6 => each(bytes, |b| f64::from(i32::from_le_bytes(b))),
        7 => each(bytes, |b| u64::from_le_bytes(b) as f64),
        8 => each(bytes, |b| i64::from_le_bytes(b) as f64),
        9 => each(bytes, |b| f64::from(half::f16::from_le_bytes(b))),
        10 => each(bytes, |b| f64::from(f32::from_le_bytes(b))),
        11 => each(bytes, f64::from_le_bytes),
        _ => return None,
    })
}

/// Headers that are read from front to back.
struct Cursor<'a> {
    file: FileBytes<'a>,
    bytes: &'a [u8],
}

impl<'a> Cursor<'a> {
    fn take(&mut self, len: usize) -> Result<&'a [u8], GroomError> {
        let Some((taken, rest)) = self.bytes.split_at_checked(len) else {
            // Where the bytes stand in the file.
            let at = self.bytes.as_ptr() as u64 - self.file.bytes.as_ptr() as u64;
            return Err(self.file.error(at, "a header is cut off", REMEDY));
        };
        self.bytes = rest;
        Ok(taken)
    }

    /// An unsigned number of `width` bytes.
    fn number(&mut self, width: usize) -> Result<usize, GroomError> {
        let bytes = self.take(width)?;
        Ok(bytes
            .iter()
            .rev()
            .fold(0, |number, byte| number << 8 | usize::from(*byte)))
    }
}
