//@ alternative uv when texture.image
//@ use data/surface
//@ use data/hit
//@ use data/primitive
//@ each primitive
//@ use geometry/${name}
//@ end
//@ if mesh
//@ use scene/at_run_time
//@ use scene/meshes
//@ end
// Texture coordinates of a point on a primitive. `local` is the point in the primitive's own coordinates, and `point` is
// that point mapped by the frame.
fn surface_uv(hit: Hit, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    switch primitive_kind(hit.code) {
        //@ each primitive
        ${case}: {
            return ${name}_uv(point, local);
        }
        //@ end
        //@ if mesh
        default: {
            return mesh_uv(instances[at_run_time(hit.instance)], primitive_index(hit.code), local);
        }
        //@ end
    }
}

//@ without
//@ use data/surface
//@ use data/hit
// For scenes whose textures need no texture coordinates.
fn surface_uv(hit: Hit, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    return SurfaceUv(vec2<f32>(0.0), false);
}
