//! The bytes of a file, read from front to back.

use bytemuck::AnyBitPattern;

use super::Result;

pub struct Input<'a> {
    pub bytes: &'a [u8],
    pub rest: &'a [u8],
}

impl<'a> Input<'a> {
    /// Goes to a byte, counted from the first.
    pub fn seek(&mut self, position: u64) -> Result<()> {
        let missing = || format!("expected at least {position} bytes, found {}: it is not complete", self.bytes.len());
        self.rest = usize::try_from(position).ok().and_then(|start| self.bytes.get(start..)).ok_or_else(missing)?;
        Ok(())
    }

    pub fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let missing = || format!("expected {count} more bytes, found {}: it is not complete", self.rest.len());
        let (taken, rest) = self.rest.split_at_checked(count).ok_or_else(missing)?;
        self.rest = rest;
        Ok(taken)
    }

    /// The next number, or the next numbers. A file has them in the order of bytes of all machines that this program runs on.
    pub fn read<T: AnyBitPattern>(&mut self) -> Result<T> {
        self.take(size_of::<T>()).map(bytemuck::pod_read_unaligned)
    }

    /// The bytes behind a number that counts them.
    pub fn counted(&mut self) -> Result<&'a [u8]> {
        let count: u32 = self.read()?;
        self.take(count as usize)
    }

    pub fn text(&mut self) -> Result<String> {
        self.counted().map(|bytes| String::from_utf8_lossy(bytes).into_owned())
    }
}
