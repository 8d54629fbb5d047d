//@ use data/ray
//@ use data/hit
//@ use data/primitive
//@ each primitive
//@ use geometry/${name}
//@ use bind/${name}s
//@ end
//@ each mesh
//@ use bind/instances
//@ use scene/meshes
//@ end
// The hit record of a ray that meets the primitive at distance t; `instance` is the mesh that a triangle is part of.
fn surface_at(code: u32, instance: u32, ray: Ray, t: f32) -> Surface {
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each primitive
        ${case}: {
            return ${name}_surface(ray, t, ${name}s[index]);
        }
        //@ end
        //@ each mesh
        ${case}: {
            return mesh_surface(ray, instances[instance], index);
        }
        //@ end
    }
}

// Index of the primitive's material.
fn material_index(code: u32, instance: u32) -> u32 {
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each primitive
        ${case}: {
            return ${name}s[index].material;
        }
        //@ end
        //@ each mesh
        ${case}: {
            return instances[instance].material;
        }
        //@ end
    }
}
