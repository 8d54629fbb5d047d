//! The bytes of a file, read from front to back with reports of progress.

use std::io::{self, BufRead, Read};

/// Bytes between two reports of progress.
const TELL_EVERY: usize = 1 << 20;

/// The rest of a file. Taking from it reports progress.
pub struct Input<'a> {
    pub rest: &'a [u8],
    total: usize,
    /// The number of bytes that are left at the next report of progress.
    tell_at: usize,
    tell: &'a mut dyn FnMut(usize),
}

impl<'a> Input<'a> {
    pub fn new(bytes: &'a [u8], tell: &'a mut dyn FnMut(usize)) -> Input<'a> {
        let total = bytes.len();
        Input { rest: bytes, total, tell_at: total.saturating_sub(TELL_EVERY), tell }
    }

    /// The next `count` bytes; none if there are fewer.
    pub fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.move_to(rest);
        Some(taken)
    }

    /// The next line, without its end (LF, CR LF, or the end of the file).
    pub fn line(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|&byte| byte == b'\n');
        let line = match end {
            Some(end) => self.take(end + 1)?.split_last()?.1,
            None => self.take(self.rest.len())?,
        };
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    fn move_to(&mut self, rest: &'a [u8]) {
        self.rest = rest;
        if rest.len() < self.tell_at {
            self.tell_at = rest.len().saturating_sub(TELL_EVERY);
            (self.tell)(self.total - rest.len());
        }
    }
}

impl Read for Input<'_> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let mut rest = self.rest;
        let count = rest.read(to)?;
        self.move_to(rest);
        Ok(count)
    }
}

impl BufRead for Input<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        Ok(self.rest)
    }

    fn consume(&mut self, count: usize) {
        self.take(count);
    }
}

/// The words of a line.
pub fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// What follows the first word of a line, such as a name with spaces.
pub fn rest_of(line: &[u8]) -> String {
    let line = line.trim_ascii();
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    String::from_utf8_lossy(line.get(end..).unwrap_or_default().trim_ascii()).into_owned()
}

/// The number that a word stands for.
pub fn number<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}
