//@ use scene/surfaces
// The number of the material that the pixel's first sample hits.
fn material(path: ptr<function, Path>) -> f32 {
    if (*path).sample != 0u {
        return 0.0;
    }
    return f32(material_index(path_hit(path)) + 1u);
}
