//! Little-endian views of a file's bytes whose bounds are checked before anything is allocated.

use super::GroomError;

/// A named file in memory.
#[derive(Clone, Copy)]
pub(crate) struct FileBytes<'a> {
    /// Name for messages.
    pub name: &'a str,
    /// The whole file.
    pub bytes: &'a [u8],
}

impl<'a> FileBytes<'a> {
    /// An error at byte `offset`.
    pub fn error(&self, offset: u64, reason: impl Into<String>, remedy: impl Into<String>) -> GroomError {
        GroomError::Format {
            file: self.name.into(),
            offset,
            reason: reason.into(),
            remedy: remedy.into(),
        }
    }

    /// `len` bytes from `offset`, or an error that says that `what` is cut off.
    pub fn section(&self, offset: u64, len: u64, what: &str) -> Result<&'a [u8], GroomError> {
        let present = self.bytes.len() as u64;
        let end = offset.checked_add(len).filter(|&end| end <= present);
        let Some(end) = end else {
            return Err(self.error(
                offset.min(present),
                format!("{what} needs {len} bytes from byte {offset}, but the file has {present}"),
                "the file is cut off or its counts are wrong: export it again",
            ));
        };
        // Both ends are at most the length of a slice, so they fit into usize.
        Ok(&self.bytes[offset as usize..end as usize])
    }

    /// The u32 at `offset` of the header.
    pub fn u32(&self, offset: u64) -> Result<u32, GroomError> {
        let b = self.section(offset, 4, "a header field")?;
        Ok(u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    }

    /// The f32 at `offset` of the header.
    pub fn f32(&self, offset: u64) -> Result<f32, GroomError> {
        Ok(f32::from_bits(self.u32(offset)?))
    }
}

/// The `index`-th f32 of an array of little-endian f32.
pub(crate) fn f32_at(array: &[u8], index: usize) -> f32 {
    let b = &array[4 * index..4 * index + 4];
    f32::from_le_bytes([b[0], b[1], b[2], b[3]])
}

/// The `index`-th point of an array of points of `stride` little-endian f32 each, of which the first three are used.
pub(crate) fn point_at(array: &[u8], index: usize, stride: usize) -> glam::Vec3 {
    let at = index * stride;
    glam::Vec3::new(f32_at(array, at), f32_at(array, at + 1), f32_at(array, at + 2))
}
