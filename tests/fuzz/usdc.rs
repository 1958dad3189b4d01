//! Binary USD built from its tables, so that they can be damaged before they are packed: a flipped bit in a packed table only breaks the
//! packing.

use rand::Rng;
use rand_pcg::Pcg64Mcg;

use super::mutate;

const ARRAY: u64 = 1 << 63;
const INLINED: u64 = 1 << 62;
const PACKED: u64 = 1 << 61;

const INT: u64 = 3 << 48;
const FLOAT: u64 = 8 << 48;
const DOUBLE: u64 = 9 << 48;
const TOKEN: u64 = 11 << 48;
const FLOAT3: u64 = 24 << 48;
const TOKENS: u64 = 41 << 48;
const SPECIFIER: u64 = 42 << 48;
const SAMPLES: u64 = 46 << 48;
const TIMES: u64 = 48 << 48;

/// First byte behind the header.
const BODY: u64 = 88;

/// The tables of a file and the values behind them.
#[derive(Clone)]
struct Tables {
    tokens: Vec<&'static str>,
    field_names: Vec<i32>,
    field_values: Vec<u64>,
    field_sets: Vec<i32>,
    /// Index, token and jump of every path.
    paths: [Vec<i32>; 3],
    path_count: u64,
    /// Path, field set and type of every spec.
    specs: [Vec<i32>; 3],
    /// Values that stand behind the header.
    heap: Vec<u8>,
}

impl Tables {
    fn token(&mut self, text: &'static str) -> i32 {
        let known = self.tokens.iter().position(|token| *token == text);
        known.unwrap_or_else(|| {
            self.tokens.push(text);
            self.tokens.len() - 1
        }) as i32
    }

    /// Puts a value behind the header; its place in the file.
    fn put(&mut self, bytes: &[u8]) -> u64 {
        let at = BODY + self.heap.len() as u64;
        self.heap.extend_from_slice(bytes);
        at
    }

    fn floats(&mut self, values: &[f32], width: usize) -> u64 {
        let mut bytes = ((values.len() / width) as u64).to_le_bytes().to_vec();
        bytes.extend(values.iter().flat_map(|x| x.to_le_bytes()));
        self.put(&bytes)
    }

    /// A spec with its fields.
    fn spec(&mut self, path: i32, ty: i32, fields: &[(&'static str, u64)]) {
        self.specs[0].push(path);
        self.specs[1].push(self.field_sets.len() as i32);
        self.specs[2].push(ty);
        for (name, value) in fields {
            let token = self.token(name);
            self.field_names.push(token);
            self.field_values.push(*value);
            self.field_sets.push(self.field_names.len() as i32 - 1);
        }
        self.field_sets.push(-1);
    }

    /// Two curves with a width and a painted value at every point, points that move, under a transform.
    fn hair() -> Self {
        let mut t = Self {
            tokens: vec![""],
            field_names: Vec::new(),
            field_values: Vec::new(),
            field_sets: Vec::new(),
            paths: Default::default(),
            path_count: 0,
            specs: Default::default(),
            heap: Vec::new(),
        };
        let points: Vec<f32> = (0..60).map(|i| (i % 7) as f32 + 0.5 * (i / 7) as f32).collect();
        let widths: Vec<f32> = (0..20).map(|i| 0.01 * (1 + i % 3) as f32).collect();

        // Counts packed, as a writer packs sixteen and more; widths by a table of three values.
        let counts: Vec<i32> = (0..16).map(|i| if i < 12 { 1 } else { 2 }).collect();
        let mut packed_counts = (counts.len() as u64).to_le_bytes().to_vec();
        packed_counts.extend(integers(&counts));
        let mut packed_widths = 20_u64.to_le_bytes().to_vec();
        packed_widths.push(b't');
        packed_widths.extend(3_u32.to_le_bytes());
        packed_widths.extend([0.01_f32, 0.02, 0.03].iter().flat_map(|x| x.to_le_bytes()));
        packed_widths.extend(integers(&(0..20).map(|i| i % 3).collect::<Vec<_>>()));

        // Times, then for each its value, behind jumps relative to where the jump stands.
        let first = t.floats(&points, 3);
        let second = t.floats(&points.iter().map(|x| 2.0 * x).collect::<Vec<_>>(), 3);
        let mut times = 2_u64.to_le_bytes().to_vec();
        times.extend([1.0_f64, 2.0].iter().flat_map(|x| x.to_le_bytes()));
        let times = t.put(&times);
        let mut samples = Vec::new();
        for word in [
            8,
            TIMES | times,
            8,
            2,
            ARRAY | FLOAT3 | first,
            ARRAY | FLOAT3 | second,
        ] {
            samples.extend_from_slice(&u64::to_le_bytes(word));
        }
        let samples = t.put(&samples);
        let counts = t.put(&packed_counts);
        let plain_widths = t.floats(&widths, 1);
        let widths = t.put(&packed_widths);
        let move_by = t.put(
            &[1.0_f64, 2.0, 3.0]
                .iter()
                .flat_map(|x| x.to_le_bytes())
                .collect::<Vec<_>>(),
        );
        let [linear, vertex, curves, name, translate] =
            ["linear", "vertex", "BasisCurves", "hair", "xformOp:translate"].map(|text| t.token(text) as u64);
        let children = [1_u64.to_le_bytes().to_vec(), (name as u32).to_le_bytes().to_vec()].concat();
        let children = t.put(&children);
        let order = [
            1_u64.to_le_bytes().to_vec(),
            (translate as u32).to_le_bytes().to_vec(),
        ]
        .concat();
        let order = t.put(&order);

        let unit = INLINED | DOUBLE | u64::from(0.01_f32.to_bits());
        t.spec(
            0,
            7,
            &[("metersPerUnit", unit), ("primChildren", TOKENS | children)],
        );
        let ty = ("typeName", TOKEN | INLINED | curves);
        t.spec(1, 6, &[("specifier", SPECIFIER | INLINED), ty]);
        let vertex = ("interpolation", TOKEN | INLINED | vertex);
        let attributes: [(&'static str, Vec<(&'static str, u64)>); 7] = [
            ("points", vec![("timeSamples", SAMPLES | samples)]),
            (
                "curveVertexCounts",
                vec![("default", ARRAY | PACKED | INT | counts)],
            ),
            ("type", vec![("default", TOKEN | INLINED | linear)]),
            (
                "widths",
                vec![("default", ARRAY | PACKED | FLOAT | widths), vertex],
            ),
            (
                "primvars:balayage:bleach",
                vec![("default", ARRAY | FLOAT | plain_widths), vertex],
            ),
            ("xformOp:translate", vec![("default", (23 << 48) | move_by)]),
            ("xformOpOrder", vec![("default", ARRAY | TOKEN | order)]),
        ];
        t.paths = [vec![0, 1], vec![0, name as i32], vec![-1, -1]];
        for (i, (name, fields)) in attributes.iter().enumerate() {
            let last = i + 1 == attributes.len();
            let token = t.token(name);
            t.paths[0].push(2 + i as i32);
            t.paths[1].push(-token);
            t.paths[2].push(if last { -2 } else { 0 });
            t.spec(2 + i as i32, 1, fields);
        }
        t.path_count = t.paths[0].len() as u64;
        t
    }

    fn file(&self) -> Vec<u8> {
        let mut out = b"PXR-USDC\0\x08\0\0\0\0\0\0".to_vec();
        out.resize(BODY as usize, 0);
        out.extend_from_slice(&self.heap);
        let mut sections = Vec::new();
        let mut section = |out: &mut Vec<u8>, name: &str, content: Vec<u8>| {
            let mut entry = name.as_bytes().to_vec();
            entry.resize(16, 0);
            entry.extend((out.len() as u64).to_le_bytes());
            entry.extend((content.len() as u64).to_le_bytes());
            sections.extend(entry);
            out.extend(content);
        };
        let words = |words: &[u64]| -> Vec<u8> { words.iter().flat_map(|word| word.to_le_bytes()).collect() };
        let text = self
            .tokens
            .iter()
            .flat_map(|token| [token.as_bytes(), b"\0"].concat());
        let text: Vec<u8> = text.collect();
        let names = packed(&text);
        let head = words(&[self.tokens.len() as u64, text.len() as u64, names.len() as u64]);
        section(&mut out, "TOKENS", [head, names].concat());
        section(&mut out, "STRINGS", words(&[0]));
        let values = packed(&words(&self.field_values));
        let fields = [
            words(&[self.field_names.len() as u64]),
            integers(&self.field_names),
            words(&[values.len() as u64]),
            values,
        ];
        section(&mut out, "FIELDS", fields.concat());
        let sets = [words(&[self.field_sets.len() as u64]), integers(&self.field_sets)];
        section(&mut out, "FIELDSETS", sets.concat());
        let mut paths = words(&[self.path_count, self.paths[0].len() as u64]);
        paths.extend(self.paths.iter().flat_map(|table| integers(table)));
        section(&mut out, "PATHS", paths);
        let mut specs = words(&[self.specs[0].len() as u64]);
        specs.extend(self.specs.iter().flat_map(|table| integers(table)));
        section(&mut out, "SPECS", specs);
        let toc = out.len() as u64;
        out.extend(words(&[6]));
        out.extend(sections);
        out[16..24].copy_from_slice(&toc.to_le_bytes());
        out
    }
}

/// Bytes as one LZ4 block of literals.
fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut out = vec![0];
    if bytes.len() < 15 {
        out.push((bytes.len() as u8) << 4);
    } else {
        out.push(0xf0);
        let rest = bytes.len() - 15;
        out.resize(out.len() + rest / 255, 255);
        out.push((rest % 255) as u8);
    }
    out.extend_from_slice(bytes);
    out
}

/// Integers as differences of four bytes each, packed, behind their packed size.
fn integers(values: &[i32]) -> Vec<u8> {
    let mut bytes = 0_i32.to_le_bytes().to_vec();
    bytes.resize(4 + (2 * values.len()).div_ceil(8), 0xff);
    let mut before = 0_i32;
    for value in values {
        bytes.extend(value.wrapping_sub(before).to_le_bytes());
        before = *value;
    }
    let packed = packed(&bytes);
    [(packed.len() as u64).to_le_bytes().to_vec(), packed].concat()
}

/// The undamaged file.
pub fn valid() -> Vec<u8> {
    Tables::hair().file()
}

/// Files from damaged tables; every second input is changed as bytes.
pub fn damaged(random: &mut Pcg64Mcg, pool: &[Vec<u8>], chosen: usize) -> Vec<u8> {
    if random.random() {
        return mutate::bytes(random, pool, chosen);
    }
    let mut t = Tables::hair();
    for _ in 0..1 << random.random_range(0..4) {
        let which = random.random_range(0..11);
        let Tables {
            field_names,
            field_values,
            field_sets,
            paths: [a, b, c],
            specs: [d, e, f],
            heap,
            ..
        } = &mut t;
        let mut integer = |table: &mut Vec<i32>| {
            let at = random.random_range(0..table.len());
            match random.random_range(0..6) {
                0 => table[at] = random.random(),
                1 => table[at] = table[at].wrapping_add(random.random_range(-2..3)),
                2 => table[at] = table[random.random_range(0..table.len())],
                3 => drop(table.remove(at)),
                4 => table.insert(at, table[at]),
                _ => table[at] = -table[at],
            }
            if table.is_empty() {
                table.push(0);
            }
        };
        match which {
            0 => integer(field_names),
            1 => integer(field_sets),
            2 => integer(a),
            3 => integer(b),
            4 => integer(c),
            5 => integer(d),
            6 => integer(e),
            7 => integer(f),
            8 => {
                let at = random.random_range(0..field_values.len());
                field_values[at] ^= 1 << random.random_range(0..64);
            }
            9 => {
                let at = random.random_range(0..field_values.len());
                field_values[at] = field_values[random.random_range(0..field_values.len())];
            }
            _ => *heap = mutate::bytes(random, &[std::mem::take(heap)], 0),
        }
    }
    t.file()
}
