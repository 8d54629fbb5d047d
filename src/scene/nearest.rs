//! "Did you mean ...?"

const LONGEST: usize = 100;

/// The candidate whose spelling is nearest to `word`, if it is near enough to be a misspelling.
///
/// Letter case does not count. Up to a third of the letters may differ, and at least one. A word longer than any name
/// has no candidate.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    let length = word.chars().count();
    if length > LONGEST {
        return None;
    }
    // The edit distance: insertions, deletions, replacements, and swaps of neighbouring letters.
    let edits = |candidate: &'a str| (strsim::osa_distance(&word, &candidate.to_lowercase()), candidate);
    let near = candidates.into_iter().map(edits).filter(|(edits, _)| *edits <= (length / 3).max(1));
    near.min_by_key(|(edits, _)| *edits).map(|(_, candidate)| candidate)
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
}
