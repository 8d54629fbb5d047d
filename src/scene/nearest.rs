//! "Did you mean ...?"

const LONGEST: usize = 100;

/// The candidate whose spelling is nearest to `word`, if one is near enough to be what was meant.
///
/// Letter case does not count. At most a third of the letters may differ, and one always may. What
/// is longer than a name ever is has no neighbour.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let letters = |word: &str| -> Vec<char> { word.to_lowercase().chars().collect() };
    let word = letters(word);
    if word.len() > LONGEST {
        return None;
    }
    let limit = (word.len() / 3).max(1);
    candidates
        .into_iter()
        // The length first: it costs less, and no two words are nearer than their lengths.
        .filter(|candidate| candidate.chars().count().abs_diff(word.len()) <= limit)
        .map(|candidate| (edits(&word, &letters(candidate)), candidate))
        .filter(|(edits, _)| *edits <= limit)
        .min_by_key(|(edits, _)| *edits)
        .map(|(_, candidate)| candidate)
}

/// The number of letters to insert, delete or replace, or of neighbours to exchange, to make one
/// word of the other.
fn edits(from: &[char], to: &[char]) -> usize {
    // At (i, j) stands the distance of the first i letters of `from` from the first j of `to`.
    let mut table = vec![vec![0; to.len() + 1]; from.len() + 1];
    for i in 0..=from.len() {
        for j in 0..=to.len() {
            table[i][j] = if i == 0 || j == 0 {
                i + j
            } else {
                let replaced = table[i - 1][j - 1] + usize::from(from[i - 1] != to[j - 1]);
                let shorter = table[i - 1][j].min(table[i][j - 1]) + 1;
                let is_exchange = i > 1 && j > 1 && from[i - 1] == to[j - 2] && from[i - 2] == to[j - 1];
                let exchanged = if is_exchange { table[i - 2][j - 2] + 1 } else { shorter };
                replaced.min(shorter).min(exchanged)
            };
        }
    }
    table[from.len()][to.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_word_that_was_meant() {
        let known = ["center", "radius", "material"];
        assert_eq!(nearest("radus", known), Some("radius"));
        assert_eq!(nearest("Centre", known), Some("center"));
        assert_eq!(nearest("materail", known), Some("material"));
        assert_eq!(nearest("colour", known), None);
        assert_eq!(nearest("", known), None);
        assert_eq!(nearest("Rbg", ["Image", "Rgb"]), Some("Rgb"));
    }

    #[test]
    fn counts_edits() {
        let cases = [
            ("", "", 0),
            ("a", "", 1),
            ("", "ab", 2),
            ("kitten", "sitting", 3),
            ("flaw", "lawn", 2),
            ("ab", "ba", 1),
            ("abcd", "badc", 2),
        ];
        for (from, to, distance) in cases {
            let [a, b] = [from, to].map(|word| word.chars().collect::<Vec<_>>());
            assert_eq!(edits(&a, &b), distance, "{from} {to}");
            assert_eq!(edits(&b, &a), distance, "{to} {from}");
        }
    }
}
