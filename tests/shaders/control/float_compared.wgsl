// Wrong on purpose: a NaN is sought by comparing it with itself, which a compiler may assume to be equal.
fn is_nan(x: f32) -> bool {
    return x != x;
}
