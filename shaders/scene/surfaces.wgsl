//@ use data/ray
//@ use data/surface
//@ use data/hit
//@ use data/primitive
//@ use choice/crossings
//@ each primitive
//@ use geometry/${name}
//@ use bind/${name}s
//@ end
//@ if mesh
//@ use bind/instances
//@ use scene/at_run_time
//@ use scene/meshes
//@ end
// The hit record of a ray that hits a primitive.
fn surface_at(hit: Hit, ray: Ray) -> Surface {
    let to_hit = ray_to_hit(hit, ray);
    let index = primitive_index(hit.code);
    switch primitive_kind(hit.code) {
        //@ each primitive
        ${case}: {
            return ${name}_surface(to_hit.ray, to_hit.t, ${name}s[index]);
        }
        //@ end
        //@ if mesh
        default: {
            return mesh_surface(ray, instances[at_run_time(hit.instance)], index);
        }
        //@ end
    }
}

// Index of the material of the primitive that was hit.
fn material_index(hit: Hit) -> u32 {
    let index = primitive_index(hit.code);
    switch primitive_kind(hit.code) {
        //@ each primitive
        ${case}: {
            return ${name}s[index].material;
        }
        //@ end
        //@ if mesh
        default: {
            return instances[at_run_time(hit.instance)].material;
        }
        //@ end
    }
}
