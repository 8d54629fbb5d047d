//! Hashes, and a filter for those that occur more than once.

/// A hash of words.
pub fn hash<const N: usize>(words: [u32; N]) -> u32 {
    let mix = |hash: u64, word: u32| (hash ^ u64::from(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    (words.into_iter().fold(0, mix) >> 32) as u32
}

/// A set of the hashes that occur more than once. By chance it also holds a few others.
pub struct Repeated {
    twice: Vec<u64>,
    shift: u32,
}

impl Repeated {
    pub fn new(hashes: impl ExactSizeIterator<Item = u32>) -> Repeated {
        let bits = (hashes.len() * 16).next_power_of_two().clamp(1 << 6, 1 << 26);
        let shift = u32::BITS - bits.trailing_zeros();
        let mut once = vec![0u64; bits / 64];
        let mut twice = vec![0u64; bits / 64];
        for hash in hashes {
            let (word, bit) = Repeated::place(hash, shift);
            twice[word] |= once[word] & bit;
            once[word] |= bit;
        }
        Repeated { twice, shift }
    }

    fn place(hash: u32, shift: u32) -> (usize, u64) {
        let place = hash >> shift;
        ((place / 64) as usize, 1 << (place % 64))
    }

    pub fn holds(&self, hash: u32) -> bool {
        let (word, bit) = Repeated::place(hash, self.shift);
        self.twice[word] & bit != 0
    }
}
