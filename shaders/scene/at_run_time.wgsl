//@ use bind/settings
// An index into a table, in a form that no compiler knows. Mesa 22.3 notes which elements of uniform bindings decide a branch,
// where it knows their indices, in a list with room for those of three bindings: of the others it writes over what
// stands behind the list. So no index that could turn out to be constant is used without this (docs/architecture.md).
fn at_run_time(index: u32) -> u32 {
    return index + settings.zero;
}
