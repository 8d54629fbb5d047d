//@ alternative uv when texture.image | texture.uv_checker | truth.uv
//@ each primitive
//@ use bind/${name}s
//@ use geometry/${name}
//@ end
// Texture coordinates of a point on a primitive. `local` is the point in the primitive's own coordinates, and `point` is
// that point mapped by the frame.
fn surface_uv(hit: Hit, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    switch primitive_kind(hit.code) {
        //@ each primitive
        ${case}: {
            return ${name}_uv(${name}_at(primitive_index(hit.code), hit.instance), point, local);
        }
        //@ end
    }
}

//@ without
// For scenes whose textures need no texture coordinates.
fn surface_uv(hit: Hit, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    return SurfaceUv(vec2<f32>(0.0), vec2<bool>(false));
}
