// For each light, its probability as the start of a light path: over its area, if it has one.
@group(0) @binding(33) var<${space_of_emitters}> emitters: array<AliasEntry${size_of_emitters}>;
