//! The binary form of USD, `.usdc` ("crate"), versions 0.4 to 0.13: tables of tokens, fields, paths and specs, then values by offset.
//!
//! Every count is checked against the bytes that could hold it before anything is allocated, and all decoded values together stay below
//! a multiple of the file's size.

use super::super::{GroomError, bytes::FileBytes};
use super::layer::{Attribute, Layer, MAX_DEPTH, Prim, Value, is_needed};
use super::packed::{expanded, integers};

const REMEDY: &str = "export it again, or convert it to .usda with usdcat";

/// Decoded values a byte of the file.
const MAX_VALUES_PER_BYTE: u64 = 16;

const SPEC_ATTRIBUTE: u32 = 1;
const SPEC_PRIM: u32 = 6;
const SPEC_PSEUDO_ROOT: u32 = 7;
const SPEC_VARIANT_SET: u32 = 11;

/// Reads a binary layer.
pub(super) fn parse(file: FileBytes<'_>) -> Result<Layer, GroomError> {
    let version = file.section(8, 3, "the version")?;
    let version = (version[0], version[1]);
    if !((0, 4)..=(0, 13)).contains(&version) {
        return Err(file.error(
            8,
            format!("version {}.{} is not read", version.0, version.1),
            REMEDY,
        ));
    }
    let mut reader = Reader {
        file,
        version,
        tokens: Vec::new(),
        strings: Vec::new(),
        fields: Vec::new(),
        field_sets: Vec::new(),
        budget: (file.bytes.len() as u64 * MAX_VALUES_PER_BYTE).max(1 << 16),
    };
    reader.layer()
}

/// A path: its parent and last name; a property or a prim.
#[derive(Clone, Copy)]
struct PathEntry {
    parent: u32,
    token: u32,
    property: bool,
}

const NO_PATH: u32 = u32::MAX;

struct Reader<'a> {
    file: FileBytes<'a>,
    version: (u8, u8),
    tokens: Vec<&'a [u8]>,
    strings: Vec<u32>,
    /// Token of the name, and the value.
    fields: Vec<(u32, u64)>,
    field_sets: Vec<u32>,
    /// Values that may still be decoded.
    budget: u64,
}

/// A place in the file that moves on as it is read.
#[derive(Clone, Copy)]
struct Cursor<'a> {
    file: FileBytes<'a>,
    at: u64,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, len: u64) -> Result<&'a [u8], GroomError> {
        let bytes = self.file.section(self.at, len, "a table or value")?;
        self.at += len;
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32, GroomError> {
        let b = self.take(4)?;
        Ok(u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    }

    fn u64(&mut self) -> Result<u64, GroomError> {
        Ok(u64::from(self.u32()?) | u64::from(self.u32()?) << 32)
    }

    /// `count` packed 32-bit integers behind their packed size.
    fn integers(&mut self, count: u64) -> Result<Vec<i32>, GroomError> {
        let at = self.at;
        let size = self.u64()?;
        let packed = self.take(size)?;
        integers(packed, count).ok_or_else(|| {
            self.file
                .error(at, format!("{count} packed integers do not unpack"), REMEDY)
        })
    }
}

impl<'a> Reader<'a> {
    fn error(&self, at: u64, reason: impl Into<String>) -> GroomError {
        self.file
            .error(at.min(self.file.bytes.len() as u64), reason, REMEDY)
    }

    fn cursor(&self, at: u64) -> Cursor<'a> {
        Cursor { file: self.file, at }
    }

    /// Takes `count` values from what may still be decoded.
    fn spend(&mut self, at: u64, count: u64) -> Result<(), GroomError> {
        match self.budget.checked_sub(count) {
            Some(left) => {
                self.budget = left;
                Ok(())
            }
            None => Err(self.error(
                at,
                format!("{count} values are more than a file of this size holds"),
            )),
        }
    }

    fn section(&self, name: &str) -> Result<Cursor<'a>, GroomError> {
        let mut toc = self.cursor(16);
        let at = toc.u64()?;
        toc.at = at;
        let count = toc.u64()?;
        for _ in 0..count.min(64) {
            let found = toc.take(16)?;
            let (start, _size) = (toc.u64()?, toc.u64()?);
            if found.split(|b| *b == 0).next() == Some(name.as_bytes()) {
                return Ok(self.cursor(start));
            }
        }
        Err(self.error(at, format!("there is no section {name}")))
    }

    fn layer(&mut self) -> Result<Layer, GroomError> {
        let names = self.read_tokens()?;
        self.tokens = Vec::new();
        let names: &[u8] = &names;
        // The tokens borrow from the unpacked text, so the rest works on a reader that lives as long as it.
        let mut inner = Reader {
            file: self.file,
            version: self.version,
            tokens: names.split(|b| *b == 0).collect(),
            strings: Vec::new(),
            fields: Vec::new(),
            field_sets: Vec::new(),
            budget: self.budget,
        };
        inner.read_fields()?;
        let paths = inner.read_paths()?;
        inner.read_specs(&paths)
    }

    fn read_tokens(&mut self) -> Result<Vec<u8>, GroomError> {
        let mut at = self.section("TOKENS")?;
        let start = at.at;
        let _count = at.u64()?;
        let (plain, packed) = (at.u64()?, at.u64()?);
        self.spend(start, plain)?;
        let packed = at.take(packed)?;
        expanded(packed, plain as usize)
            .filter(|text| text.len() as u64 == plain)
            .ok_or_else(|| self.error(start, "the names do not unpack"))
    }

    fn read_fields(&mut self) -> Result<(), GroomError> {
        let mut at = self.section("STRINGS")?;
        let count = at.u64()?;
        self.strings = at
            .take(count.saturating_mul(4))?
            .chunks_exact(4)
            .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect();

        let mut at = self.section("FIELDS")?;
        let start = at.at;
        let count = at.u64()?;
        self.spend(start, count)?;
        let names = at.integers(count)?;
        let size = at.u64()?;
        let packed = at.take(size)?;
        let values = expanded(packed, 8 * names.len())
            .filter(|bytes| bytes.len() == 8 * names.len())
            .ok_or_else(|| self.error(start, "the fields do not unpack"))?;
        self.fields = names
            .iter()
            .zip(values.chunks_exact(8))
            .map(|(name, b)| {
                (
                    *name as u32,
                    u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]),
                )
            })
            .collect();

        let mut at = self.section("FIELDSETS")?;
        let start = at.at;
        let count = at.u64()?;
        self.spend(start, count)?;
        self.field_sets = at.integers(count)?.into_iter().map(|i| i as u32).collect();
        Ok(())
    }

    fn read_paths(&mut self) -> Result<Vec<Option<PathEntry>>, GroomError> {
        let mut at = self.section("PATHS")?;
        let start = at.at;
        let count = at.u64()?;
        let encoded = at.u64()?;
        self.spend(start, count)?;
        self.spend(start, encoded)?;
        let indexes = at.integers(encoded)?;
        let tokens = at.integers(encoded)?;
        let jumps = at.integers(encoded)?;
        let mut paths = vec![None; count as usize];

        // Each entry is visited once at most: a jump that leads back would otherwise never end.
        let mut seen = vec![false; indexes.len()];
        let mut pending = vec![(0_usize, NO_PATH)];
        while let Some((mut this, mut parent)) = pending.pop() {
            loop {
                if this >= indexes.len() || std::mem::replace(&mut seen[this], true) {
                    return Err(self.error(start, "the tree of paths is damaged"));
                }
                let index = indexes[this] as u32;
                let slot = paths.get_mut(index as usize);
                let Some(slot) = slot.filter(|slot| slot.is_none()) else {
                    return Err(self.error(start, "a path has no place of its own"));
                };
                *slot = Some(PathEntry {
                    parent,
                    token: tokens[this].unsigned_abs(),
                    property: tokens[this] < 0,
                });
                let jump = jumps[this];
                let (child, sibling) = (jump > 0 || jump == -1, jump >= 0);
                if child {
                    if sibling {
                        pending.push((this + jump as usize, parent));
                    }
                    parent = index;
                } else if !sibling {
                    break;
                }
                this += 1;
            }
        }
        Ok(paths)
    }

    fn read_specs(&mut self, paths: &[Option<PathEntry>]) -> Result<Layer, GroomError> {
        let mut at = self.section("SPECS")?;
        let start = at.at;
        let count = at.u64()?;
        self.spend(start, count)?;
        let path_of = at.integers(count)?;
        let set_of = at.integers(count)?;
        let types = at.integers(count)?;

        // Which spec stands at a path, and the prims below each path in the order of its children.
        let mut layer = Layer::default();
        let mut spec_at = vec![None; paths.len()];
        for spec in 0..path_of.len() {
            if let Some(slot) = spec_at.get_mut(path_of[spec] as u32 as usize) {
                *slot = Some(spec);
            }
            layer.not_followed += usize::from(types[spec] as u32 == SPEC_VARIANT_SET);
        }
        let mut children: Vec<Vec<u32>> = vec![Vec::new(); paths.len()];
        let mut root = None;
        for (path, entry) in paths.iter().enumerate() {
            let (Some(entry), Some(spec)) = (entry, spec_at[path]) else {
                continue;
            };
            match types[spec] as u32 {
                SPEC_PSEUDO_ROOT => root = Some(path),
                SPEC_PRIM | SPEC_ATTRIBUTE if entry.parent != NO_PATH => {
                    children[entry.parent as usize].push(path as u32);
                }
                _ => {}
            }
        }
        let Some(root) = root else {
            return Err(self.error(start, "there is no root"));
        };

        // Depth first, with the layer's own order of children.
        let mut stack = vec![(root, None::<usize>, 0_usize)];
        while let Some((path, parent, depth)) = stack.pop() {
            if depth > MAX_DEPTH {
                return Err(self.error(start, format!("prims are nested deeper than {MAX_DEPTH}")));
            }
            let Some(spec) = spec_at[path] else { continue };
            let fields = self.fields_of(set_of[spec] as u32);
            let this = if path == root {
                self.root_fields(&fields, &mut layer)?;
                None
            } else {
                let prim = self.prim(&fields, paths[path], parent, &mut layer)?;
                layer.prims.push(prim);
                Some(layer.prims.len() - 1)
            };
            let mut order = Vec::new();
            for &(name, rep) in &fields {
                if name == b"primChildren" {
                    order = self.token_vector(rep)?;
                }
            }
            let mut prims = Vec::new();
            for &child in &children[path] {
                let (Some(entry), Some(spec)) = (paths[child as usize], spec_at[child as usize]) else {
                    continue;
                };
                if entry.property {
                    if let Some(this) = this {
                        self.attribute(set_of[spec] as u32, entry, &mut layer.prims[this])?;
                    }
                } else {
                    let place = order.iter().position(|name| *name == entry.token);
                    prims.push((place.unwrap_or(usize::MAX), child as usize));
                }
            }
            prims.sort_by_key(|(place, _)| std::cmp::Reverse(*place));
            stack.extend(prims.into_iter().map(|(_, child)| (child, this, depth + 1)));
        }
        Ok(layer)
    }

    fn token(&self, index: u32) -> &'a [u8] {
        self.tokens.get(index as usize).copied().unwrap_or_default()
    }

    fn name(&self, index: u32) -> String {
        String::from_utf8_lossy(self.token(index)).into_owned()
    }

    /// Names and values of a spec's fields; the set ends at its mark.
    fn fields_of(&self, set: u32) -> Vec<(&'a [u8], u64)> {
        let sets = self.field_sets.get(set as usize..).unwrap_or_default();
        sets.iter()
            .take_while(|field| **field != u32::MAX)
            .take(1024)
            .filter_map(|field| self.fields.get(*field as usize))
            .map(|(name, rep)| (self.token(*name), *rep))
            .collect()
    }

    fn root_fields(&mut self, fields: &[(&[u8], u64)], layer: &mut Layer) -> Result<(), GroomError> {
        for &(name, rep) in fields {
            match name {
                b"metersPerUnit" => {
                    if let Value::Numbers(x) = self.value(rep)? {
                        layer.metres_per_unit = x.first().copied();
                    }
                }
                b"upAxis" => {
                    layer.z_up = self.value(rep)? == Value::Texts(vec!["Z".to_owned()]);
                }
                b"subLayers" => layer.not_followed += 1,
                _ => {}
            }
        }
        Ok(())
    }

    fn prim(
        &mut self,
        fields: &[(&[u8], u64)],
        entry: Option<PathEntry>,
        parent: Option<usize>,
        layer: &mut Layer,
    ) -> Result<Prim, GroomError> {
        let mut prim = Prim {
            parent,
            name: entry.map(|entry| self.name(entry.token)).unwrap_or_default(),
            visible: true,
            ..Prim::default()
        };
        for &(name, rep) in fields {
            match name {
                b"typeName" => {
                    if let Value::Texts(mut t) = self.value(rep)? {
                        prim.type_name = t.pop().unwrap_or_default();
                    }
                }
                // Specifiers are inlined: 0 def, 1 over, 2 class.
                b"specifier" => prim.visible &= rep & 0xff == 0,
                b"active" => prim.visible &= rep & 0xff != 0,
                b"references" | b"payload" | b"inheritPaths" | b"specializes" => layer.not_followed += 1,
                _ => {}
            }
        }
        Ok(prim)
    }

    fn attribute(&mut self, set: u32, entry: PathEntry, prim: &mut Prim) -> Result<(), GroomError> {
        let name = self.name(entry.token);
        if !is_needed(&name) {
            return Ok(());
        }
        let mut attribute = Attribute::default();
        for (field, rep) in self.fields_of(set) {
            match field {
                b"default" => attribute.default = Some(self.value(rep)?),
                b"timeSamples" => attribute.samples = self.samples(rep)?,
                b"interpolation" => {
                    if let Value::Texts(mut t) = self.value(rep)? {
                        attribute.interpolation = t.pop();
                    }
                }
                _ => {}
            }
        }
        prim.attributes.insert(name, attribute);
        Ok(())
    }

    fn token_vector(&mut self, rep: u64) -> Result<Vec<u32>, GroomError> {
        let start = rep & PAYLOAD;
        let mut at = self.cursor(start);
        let count = at.u64()?;
        self.spend(start, count)?;
        let bytes = at.take(count.saturating_mul(4))?;
        Ok(bytes
            .chunks_exact(4)
            .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect())
    }

    /// Times and values: each stands behind a jump relative to where the jump is written.
    fn samples(&mut self, rep: u64) -> Result<Vec<(f64, Value)>, GroomError> {
        let start = rep & PAYLOAD;
        let mut at = self.cursor(start);
        at.at = start.saturating_add(at.u64()?);
        let times_rep = at.u64()?;
        let times = match (times_rep >> 48) & 0xff {
            48 => {
                let mut times = self.cursor(times_rep & PAYLOAD);
                let count = times.u64()?;
                let bytes = times.take(count.saturating_mul(8))?;
                self.spend(start, count)?;
                decoded(bytes, Kind::Double)
            }
            _ => match self.value(times_rep)? {
                Value::Numbers(times) => times,
                _ => Vec::new(),
            },
        };
        let jump_at = at.at;
        at.at = jump_at.saturating_add(at.u64()?);
        let count = at.u64()?;
        if count != times.len() as u64 {
            return Err(self.error(jump_at, format!("{count} samples have {} times", times.len())));
        }
        times
            .into_iter()
            .map(|time| Ok((time, self.value(at.u64()?)?)))
            .collect()
    }

    /// The value that `rep` describes; types that curves do not need are nothing.
    fn value(&mut self, rep: u64) -> Result<Value, GroomError> {
        let payload = rep & PAYLOAD;
        let (array, inlined, packed) = (rep >> 63 & 1 == 1, rep >> 62 & 1 == 1, rep >> 61 & 1 == 1);
        let ty = (rep >> 48 & 0xff) as u8;

        // Texts are indices of tokens, strings by way of the strings' table.
        if matches!(ty, 10 | 11) {
            let indices = if array {
                let Some((mut at, count)) = self.array(payload)? else {
                    return Ok(Value::Texts(Vec::new()));
                };
                decoded(at.take(count.saturating_mul(4))?, Kind::Uint)
            } else {
                vec![f64::from(payload as u32)]
            };
            let texts = indices.into_iter().map(|index| {
                let index = index as u32;
                let token = if ty == 10 {
                    self.strings.get(index as usize).copied().unwrap_or(u32::MAX)
                } else {
                    index
                };
                self.name(token)
            });
            return Ok(Value::Texts(texts.collect()));
        }
        let Some((kind, width)) = layout(ty) else {
            return Ok(Value::Nothing);
        };
        let numbers = if array {
            let Some((mut at, count)) = self.array(payload)? else {
                return Ok(Value::Numbers(Vec::new()));
            };
            self.spend(payload, count.saturating_mul(width))?;
            if packed && count >= 16 && width == 1 {
                self.packed(&mut at, count, kind)?
            } else {
                let len = count.saturating_mul(width).saturating_mul(kind.bytes());
                decoded(at.take(len)?, kind)
            }
        } else if inlined {
            inline(ty, payload as u32)
        } else {
            decoded(self.cursor(payload).take(width * kind.bytes())?, kind)
        };
        Ok(Value::Numbers(real_first(ty, numbers)))
    }

    /// Where an array's elements start and how many they are; an offset of zero is the empty array.
    fn array(&mut self, offset: u64) -> Result<Option<(Cursor<'a>, u64)>, GroomError> {
        if offset == 0 {
            return Ok(None);
        }
        let mut at = self.cursor(offset);
        if self.version < (0, 5) {
            at.u32()?;
        }
        let count = if self.version < (0, 7) {
            u64::from(at.u32()?)
        } else {
            at.u64()?
        };
        Ok(Some((at, count)))
    }

    /// A packed array of numbers: integers, or floats that are integers or indices of a table.
    fn packed(&mut self, at: &mut Cursor<'a>, count: u64, kind: Kind) -> Result<Vec<f64>, GroomError> {
        let start = at.at;
        match kind {
            Kind::Int => Ok(at.integers(count)?.into_iter().map(f64::from).collect()),
            Kind::Uint => Ok(at
                .integers(count)?
                .into_iter()
                .map(|i| f64::from(i as u32))
                .collect()),
            Kind::Half | Kind::Float | Kind::Double => match at.take(1)?[0] {
                b'i' => Ok(at.integers(count)?.into_iter().map(f64::from).collect()),
                b't' => {
                    let size = u64::from(at.u32()?);
                    let table = decoded(at.take(size * kind.bytes())?, kind);
                    let indices = at.integers(count)?;
                    let values: Option<Vec<f64>> = indices
                        .into_iter()
                        .map(|i| table.get(i as u32 as usize).copied())
                        .collect();
                    values.ok_or_else(|| self.error(start, "a packed value is not in its table"))
                }
                _ => Err(self.error(start, "packed numbers of an unknown kind")),
            },
            Kind::Wide => Err(self.error(start, "packed 64-bit integers are not read")),
        }
    }
}

/// Low bits of a value's description: an offset or the value itself.
const PAYLOAD: u64 = (1 << 48) - 1;

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Int,
    Uint,
    Wide,
    Half,
    Float,
    Double,
}

impl Kind {
    fn bytes(self) -> u64 {
        match self {
            Self::Half => 2,
            Self::Int | Self::Uint | Self::Float => 4,
            Self::Wide | Self::Double => 8,
        }
    }
}

/// Component and number of components of a type.
fn layout(ty: u8) -> Option<(Kind, u64)> {
    Some(match ty {
        3 => (Kind::Int, 1),
        4 => (Kind::Uint, 1),
        5 | 6 => (Kind::Wide, 1),
        7 => (Kind::Half, 1),
        8 => (Kind::Float, 1),
        9 => (Kind::Double, 1),
        15 => (Kind::Double, 16),
        16 | 27 => (Kind::Double, 4),
        17 | 28 => (Kind::Float, 4),
        18 | 29 => (Kind::Half, 4),
        19 => (Kind::Double, 2),
        20 => (Kind::Float, 2),
        21 => (Kind::Half, 2),
        23 => (Kind::Double, 3),
        24 => (Kind::Float, 3),
        25 => (Kind::Half, 3),
        26 => (Kind::Int, 3),
        _ => return None,
    })
}

/// Little-endian numbers.
fn decoded(bytes: &[u8], kind: Kind) -> Vec<f64> {
    let wide = |b: &[u8]| u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]);
    let word = |b: &[u8]| u32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let chunks = bytes.chunks_exact(kind.bytes() as usize);
    chunks
        .map(|b| match kind {
            Kind::Int => f64::from(word(b) as i32),
            Kind::Uint => f64::from(word(b)),
            Kind::Wide => wide(b) as i64 as f64,
            Kind::Half => f64::from(half::f16::from_le_bytes([b[0], b[1]])),
            Kind::Float => f64::from(f32::from_bits(word(b))),
            Kind::Double => f64::from_bits(wide(b)),
        })
        .collect()
}

/// A value that stands in its own description: 32 bits, vectors and diagonals of matrices in signed bytes.
fn inline(ty: u8, bits: u32) -> Vec<f64> {
    let bytes = bits.to_le_bytes().map(|b| f64::from(b as i8));
    match ty {
        3 | 5 => vec![f64::from(bits as i32)],
        4 | 6 => vec![f64::from(bits)],
        7 => vec![f64::from(half::f16::from_bits(bits as u16))],
        8 | 9 => vec![f64::from(f32::from_bits(bits))],
        15 => {
            let mut matrix = vec![0.0; 16];
            for (i, diagonal) in bytes.into_iter().enumerate() {
                matrix[5 * i] = diagonal;
            }
            matrix
        }
        19..=21 => bytes[..2].to_vec(),
        23..=26 => bytes[..3].to_vec(),
        _ => bytes.to_vec(),
    }
}

/// Quaternions stand as x, y, z, w in the file.
fn real_first(ty: u8, mut numbers: Vec<f64>) -> Vec<f64> {
    if matches!(ty, 16..=18) {
        for quaternion in numbers.chunks_exact_mut(4) {
            quaternion.rotate_right(1);
        }
    }
    numbers
}
