//@ use data/alias_entry
@group(0) @binding(19) var<storage, read> sky: array<AliasEntry>;
