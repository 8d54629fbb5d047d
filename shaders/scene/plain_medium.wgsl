//@ alternative medium_albedo when !textured_medium
// The albedo of a medium in a scene without textures.
fn medium_albedo(medium: Medium, point: vec3<f32>) -> vec3<f32> {
    return medium.colour;
}
