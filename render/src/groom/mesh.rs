//! The head under the hair: a triangle mesh from a Wavefront OBJ file.
//!
//! Of the format only what a head needs is read: `v` and `f`, the latter with any polygon and with indices counted from the start or, when
//! negative, from the end. Colours, texture coordinates, normals, groups and materials are passed over; smooth normals are computed.
//! The parser is our own so that errors carry the byte and memory stays bounded.

use std::fs;
use std::path::Path;

use glam::Vec3;

use super::bytes::FileBytes;
use super::{GroomError, MAX_COORDINATE, builder};

/// Memory a mesh may take beyond once its file's size.
const MEMORY_SLACK: usize = 60 << 20;

/// Triangles with a smooth normal at every vertex. All indices are in range, all numbers finite, there is at least one triangle.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Reads an OBJ file. Positions stay in the file's unit.
    ///
    /// # Errors
    /// [`GroomError`] names file, byte, reason and remedy.
    pub fn read_obj(path: impl AsRef<Path>) -> Result<Self, GroomError> {
        let path = path.as_ref();
        let bytes = fs::read(path).map_err(|source| GroomError::Io {
            path: path.into(),
            action: "read",
            source,
        })?;
        Self::parse_obj(&bytes, &path.display().to_string())
    }

    /// Reads an OBJ file from memory; `name` is for messages.
    ///
    /// # Errors
    /// [`GroomError::Format`] for lines that break the format, for indices out of range and for files without a triangle.
    pub fn parse_obj(bytes: &[u8], name: &str) -> Result<Self, GroomError> {
        let file = FileBytes { name, bytes };

        // Count first, so that what is allocated is what the file holds.
        let (mut vertex_count, mut triangle_count) = (0_usize, 0_usize);
        for line in lines(bytes) {
            match line.keyword {
                b"v" => vertex_count += 1,
                b"f" => triangle_count += line.words().count().saturating_sub(2),
                _ => {}
            }
        }
        let needed = 24 * vertex_count + 12 * triangle_count;
        if needed > bytes.len() + MEMORY_SLACK || vertex_count > i32::MAX as usize {
            return Err(file.error(
                0,
                format!("{vertex_count} vertices and {triangle_count} triangles are too many for its size"),
                "simplify the mesh",
            ));
        }

        let mut mesh = Self {
            positions: Vec::with_capacity(vertex_count),
            normals: Vec::new(),
            triangles: Vec::with_capacity(triangle_count),
        };
        for line in lines(bytes) {
            match line.keyword {
                b"v" => mesh.positions.push(parse_vertex(&file, &line)?),
                b"f" => mesh.push_polygon(&file, &line, vertex_count)?,
                _ => {}
            }
        }
        if mesh.triangles.is_empty() {
            return Err(file.error(0, "it holds no triangle", "give an OBJ file with faces"));
        }
        mesh.normals = smooth_normals(&mesh.positions, &mesh.triangles);
        Ok(mesh)
    }

    /// Vertex positions.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Unit normals of the vertices, area-weighted means of their triangles; +y where a vertex belongs to none.
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Vertex indices of the triangles, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|vertex| self.positions[vertex as usize])
    }

    /// Smallest and largest coordinates.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        builder::bounds(&self.positions)
    }

    /// Adds the polygon of an `f` line as a fan; triangles with a repeated corner are left out.
    fn push_polygon(
        &mut self,
        file: &FileBytes<'_>,
        line: &Line<'_>,
        vertex_count: usize,
    ) -> Result<(), GroomError> {
        let defined = self.positions.len();
        let corner = |word: &[u8]| parse_index(file, line, word, defined, vertex_count);
        let mut words = line.words();
        let (Some(first), Some(second)) = (words.next(), words.next()) else {
            return Err(file.error(
                line.offset,
                "a face with fewer than three corners",
                "export the mesh again",
            ));
        };
        let (first, mut previous) = (corner(first)?, corner(second)?);
        let mut corners = 2;
        for word in words {
            let next = corner(word)?;
            if first != previous && previous != next && next != first {
                self.triangles.push([first, previous, next]);
            }
            previous = next;
            corners += 1;
        }
        if corners < 3 {
            return Err(file.error(
                line.offset,
                "a face with fewer than three corners",
                "export the mesh again",
            ));
        }
        Ok(())
    }
}

/// A line of an OBJ file.
struct Line<'a> {
    /// Byte of the file at which it starts.
    offset: u64,
    /// Its first word; empty on empty lines.
    keyword: &'a [u8],
    /// What follows the keyword.
    rest: &'a [u8],
}

impl<'a> Line<'a> {
    fn words(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        self.rest
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty())
    }
}

fn lines(bytes: &[u8]) -> impl Iterator<Item = Line<'_>> {
    let mut offset = 0;
    bytes.split(|&b| b == b'\n').map(move |line| {
        let start = offset;
        offset += line.len() as u64 + 1;
        let line = line.trim_ascii_start();
        let (keyword, rest) = line.split_at(
            line.iter()
                .position(u8::is_ascii_whitespace)
                .unwrap_or(line.len()),
        );
        Line {
            offset: start,
            keyword,
            rest,
        }
    })
}

fn parse_vertex(file: &FileBytes<'_>, line: &Line<'_>) -> Result<Vec3, GroomError> {
    let mut words = line.words();
    let mut number = || {
        let word = std::str::from_utf8(words.next()?).ok()?;
        word.parse().ok().filter(|x: &f32| x.abs() <= MAX_COORDINATE)
    };
    match (number(), number(), number()) {
        (Some(x), Some(y), Some(z)) => Ok(Vec3::new(x, y, z)),
        _ => Err(file.error(
            line.offset,
            "a vertex without three finite coordinates",
            "export the mesh again or scale it down",
        )),
    }
}

/// The vertex of one corner: what stands before the first slash, counted from 1 or, when negative, back from the last vertex so far.
fn parse_index(
    file: &FileBytes<'_>,
    line: &Line<'_>,
    word: &[u8],
    defined: usize,
    vertex_count: usize,
) -> Result<u32, GroomError> {
    let index = word.split(|&b| b == b'/').next().unwrap_or_default();
    let index = std::str::from_utf8(index)
        .ok()
        .and_then(|index| index.parse::<i64>().ok());
    index
        .and_then(|index| {
            if index < 0 {
                index.checked_add(defined as i64)
            } else {
                index.checked_sub(1)
            }
        })
        .filter(|&index| (0..vertex_count as i64).contains(&index))
        .map(|index| index as u32)
        .ok_or_else(|| {
            file.error(
                line.offset,
                format!("a face names a vertex that is not among the {vertex_count}"),
                "export the mesh again",
            )
        })
}

fn smooth_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
        let area_normal = (b - a).cross(c - a);
        for &vertex in triangle {
            normals[vertex as usize] += area_normal;
        }
    }
    for normal in &mut normals {
        *normal = normal.try_normalize().unwrap_or(Vec3::Y);
    }
    normals
}
