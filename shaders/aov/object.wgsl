//@ use scene/primitives
// The number of the object that the pixel's first sample hits: a mean of numbers means nothing.
fn object(path: ptr<function, Path>) -> f32 {
    if (*path).sample != 0u {
        return 0.0;
    }
    return f32(primitive_order(path_hit(path)) + 1u);
}
