//@ use data/hit
//@ use data/primitive
//@ each primitive
//@ use geometry/${name}
//@ end
//@ each mesh
//@ use scene/meshes
//@ end
// Texture coordinates of a place on a primitive; `point` is its image in the frame.
fn surface_uv(code: u32, instance: u32, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    switch primitive_kind(code) {
        //@ each primitive
        ${case}: {
            return ${name}_uv(point, local);
        }
        //@ end
        //@ each mesh
        ${case}: {
            return mesh_uv(instances[instance], primitive_index(code), local);
        }
        //@ end
    }
}
