//! The bytes of a file, read from front to back.

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

    pub fn position(&self) -> u64 {
        (self.bytes.len() - self.rest.len()) as u64
    }

    pub fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let missing = || format!("expected {count} more bytes, found {}: it is not complete", self.rest.len());
        let (taken, rest) = self.rest.split_at_checked(count).ok_or_else(missing)?;
        self.rest = rest;
        Ok(taken)
    }

    pub fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let taken = self.take(N)?;
        Ok(std::array::from_fn(|index| taken[index]))
    }

    pub fn words<const N: usize>(&mut self) -> Result<[u32; N]> {
        let (words, _) = self.take(4 * N)?.as_chunks();
        Ok(std::array::from_fn(|index| u32::from_le_bytes(words[index])))
    }

    pub fn doubles<const N: usize>(&mut self) -> Result<[f64; N]> {
        let (doubles, _) = self.take(8 * N)?.as_chunks();
        Ok(std::array::from_fn(|index| f64::from_le_bytes(doubles[index])))
    }

    /// The bytes behind a number that counts them.
    pub fn counted(&mut self) -> Result<&'a [u8]> {
        let [count] = self.words()?;
        self.take(count as usize)
    }

    pub fn text(&mut self) -> Result<String> {
        self.counted().map(|bytes| String::from_utf8_lossy(bytes).into_owned())
    }
}
