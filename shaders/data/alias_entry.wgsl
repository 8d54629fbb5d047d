// An entry of a table (src/light_distribution.rs). Where the rest of the uniform number is below the threshold, this entry is drawn, and
// otherwise its alias. A density is the probability of an entry over the size of what it stands for.
struct AliasEntry {
    threshold: f32,
    alias_index: u32,
    density: f32,
    alias_density: f32,
}
