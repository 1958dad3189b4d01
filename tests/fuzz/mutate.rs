//! Mutations: of bytes, of the tokens of a text, of the tree of a JSON value.

use rand::Rng;
use rand_pcg::Pcg64Mcg;
use serde_json::{Map, Value};

/// Inputs do not grow beyond this.
const MAX_LEN: usize = 1 << 17;

/// Words that readers trip over: counts, sizes, floats.
const WORDS: [u64; 20] = [
    0,
    1,
    2,
    7,
    0x7f,
    0xff,
    0x7fff,
    0xffff,
    0x0001_0000,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fffe,
    0xffff_ffff,
    0x7f80_0000,
    0x7fc0_0000,
    0xff80_0000,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    0x7ff0_0000_0000_0000,
    u64::MAX,
];

/// Numbers as text, and what is taken for one.
const NUMBERS: [&str; 22] = [
    "0",
    "-0",
    "1",
    "-1",
    "0.5",
    "1e-45",
    "1e-400",
    "1e7",
    "1e39",
    "1e400",
    "-1e39",
    "nan",
    "inf",
    "-inf",
    "65536",
    "2147483648",
    "4294967295",
    "18446744073709551616",
    "1.5e",
    "--1",
    "0x10",
    "None",
];

/// One to eight changes of a file's bytes.
pub fn bytes(random: &mut Pcg64Mcg, pool: &[Vec<u8>], chosen: usize) -> Vec<u8> {
    let mut out = pool[chosen].clone();
    for _ in 0..1 << random.random_range(0..4) {
        change_bytes(random, pool, &mut out);
    }
    out.truncate(MAX_LEN);
    out
}

fn change_bytes(random: &mut Pcg64Mcg, pool: &[Vec<u8>], out: &mut Vec<u8>) {
    if out.is_empty() {
        out.push(random.random());
    }
    let at = random.random_range(0..out.len());
    let len = random.random_range(0..=(out.len() - at).min(64));
    match random.random_range(0..10) {
        0 => out[at] ^= 1 << random.random_range(0..8),
        1 => out[at] = random.random(),
        // A word of a header is likelier to matter, and words are aligned.
        2..=5 => {
            let size = [1, 2, 4, 4, 8][random.random_range(0..5)];
            let near = if random.random() {
                out.len()
            } else {
                out.len().min(160)
            };
            let at = random.random_range(0..near) / size * size;
            let end = (at + size).min(out.len());
            let old = out[at..end]
                .iter()
                .rev()
                .fold(0_u64, |word, byte| word << 8 | u64::from(*byte));
            let word = match random.random_range(0..4) {
                0 => old.wrapping_add(random.random_range(0..5)).wrapping_sub(2),
                1 => old.wrapping_mul(2),
                _ => WORDS[random.random_range(0..WORDS.len())],
            };
            out[at..end].copy_from_slice(&word.to_le_bytes()[..end - at]);
        }
        6 => drop(out.drain(at..at + len)),
        7 => {
            let copy = out[at..at + len].to_vec();
            let to = random.random_range(0..=out.len());
            out.splice(to..to, copy);
        }
        8 => out.truncate(at),
        // The end of another file behind the start of this one.
        _ => {
            let other = &pool[random.random_range(0..pool.len())];
            let from = at.min(other.len());
            out.truncate(at);
            out.extend_from_slice(&other[from..]);
        }
    }
}

/// One to four changes of a text's tokens; every eighth text is changed as bytes.
pub fn text(random: &mut Pcg64Mcg, pool: &[Vec<u8>], chosen: usize) -> Vec<u8> {
    if random.random_range(0..8) == 0 {
        return bytes(random, pool, chosen);
    }
    let mut tokens = tokens(&pool[chosen]);
    for _ in 0..1 << random.random_range(0..3) {
        change_tokens(random, pool, &mut tokens);
    }
    let mut out = tokens.concat();
    out.truncate(MAX_LEN);
    out
}

/// Words, numbers, spaces and single marks.
fn tokens(text: &[u8]) -> Vec<Vec<u8>> {
    let class = |byte: &u8| match byte {
        b' ' | b'\n' | b'\t' | b'\r' => 0,
        b'0'..=b'9' | b'-' | b'+' | b'.' => 1,
        b'a'..=b'z' | b'A'..=b'Z' | b'_' | b':' => 2,
        _ => 3,
    };
    let joined = text.chunk_by(|a, b| class(a) == class(b) && class(a) < 3);
    joined.map(<[u8]>::to_vec).collect()
}

fn change_tokens(random: &mut Pcg64Mcg, pool: &[Vec<u8>], out: &mut Vec<Vec<u8>>) {
    if out.is_empty() {
        out.push(b"0".to_vec());
    }
    let at = random.random_range(0..out.len());
    let number = |out: &[Vec<u8>]| {
        let is_number = |token: &Vec<u8>| token[0].is_ascii_digit() || matches!(token[0], b'-' | b'.');
        (at..out.len()).find(|i| !out[*i].is_empty() && is_number(&out[*i]))
    };
    match random.random_range(0..10) {
        0..=2 => {
            let at = number(out).unwrap_or(at);
            out[at] = NUMBERS[random.random_range(0..NUMBERS.len())].into();
        }
        3 => drop(out.remove(at)),
        4 => {
            let other = random.random_range(0..out.len());
            out.swap(at, other);
        }
        5 => {
            let end = (at + random.random_range(1..40)).min(out.len());
            let copy = out[at..end].to_vec();
            let to = random.random_range(0..=out.len());
            out.splice(to..to, copy);
        }
        6 => {
            let end = (at + random.random_range(1..40)).min(out.len());
            out.drain(at..end);
        }
        7 => {
            let other = tokens(&pool[random.random_range(0..pool.len())]);
            if !other.is_empty() {
                out[at].clone_from(&other[random.random_range(0..other.len())]);
            }
        }
        // Many of one token: long lists, deep nests.
        8 => {
            let times = 1 << random.random_range(0..16);
            out[at] = out[at].repeat(times).into_iter().take(MAX_LEN).collect();
        }
        _ => {
            let mark = b"[](){}\"',:;=#<>@\\\0\xff"[random.random_range(0..19)];
            out.insert(at, vec![mark]);
        }
    }
}

/// One to four changes of a JSON tree; every fourth input is changed as text.
pub fn json(random: &mut Pcg64Mcg, pool: &[Vec<u8>], chosen: usize) -> Vec<u8> {
    let tree = serde_json::from_slice::<Value>(&pool[chosen]);
    let (Ok(mut tree), true) = (tree, random.random_ratio(3, 4)) else {
        return text(random, pool, chosen);
    };
    for _ in 0..1 << random.random_range(0..3) {
        let count = size(&tree);
        let mut at = random.random_range(0..count);
        let mut from = random.random_range(0..count);
        let other = node(&mut tree, &mut from).map(|node| node.clone());
        if let Some(node) = node(&mut tree, &mut at) {
            change_node(random, node, other);
        }
    }
    let mut out = tree.to_string().into_bytes();
    out.truncate(MAX_LEN);
    out
}

/// Nodes of a tree.
fn size(tree: &Value) -> usize {
    1 + match tree {
        Value::Array(list) => list.iter().map(size).sum(),
        Value::Object(map) => map.values().map(size).sum(),
        _ => 0,
    }
}

/// The node with that number, depth first; the number counts down.
fn node<'a>(tree: &'a mut Value, number: &mut usize) -> Option<&'a mut Value> {
    if *number == 0 {
        return Some(tree);
    }
    *number -= 1;
    match tree {
        Value::Array(list) => list.iter_mut().find_map(|child| node(child, number)),
        Value::Object(map) => map.values_mut().find_map(|child| node(child, number)),
        _ => None,
    }
}

fn change_node(random: &mut Pcg64Mcg, node: &mut Value, other: Option<Value>) {
    let poison = |random: &mut Pcg64Mcg| {
        let number = NUMBERS[random.random_range(0..NUMBERS.len())];
        serde_json::from_str(number).unwrap_or_else(|_| Value::String(number.into()))
    };
    match (random.random_range(0..8), node) {
        (0, Value::Array(list)) => {
            let copy = list.clone();
            list.extend(copy);
        }
        (0 | 1, Value::Object(map)) => {
            let keys: Vec<String> = map.keys().cloned().collect();
            if !keys.is_empty() {
                map.remove(&keys[random.random_range(0..keys.len())]);
            }
        }
        (1, Value::Array(list)) => {
            list.pop();
        }
        (2, Value::Object(map)) => {
            map.insert("unknown".into(), other.unwrap_or_default());
        }
        (3, node) => *node = other.unwrap_or_default(),
        (4, node) => {
            let empty = [Value::Null, Value::Array(Vec::new()), Value::Object(Map::new())];
            *node = empty[random.random_range(0..3)].clone();
        }
        (5, node) => *node = Value::Array(vec![node.take(); random.random_range(0..64)]),
        (_, node) => *node = poison(random),
    }
}
