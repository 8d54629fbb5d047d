//@ use data/ray
//@ use data/surface
//@ use data/hit
//@ use data/primitive
//@ use choice/crossings
//@ use choice/pose
//@ each primitive
//@ use geometry/${name}
//@ use bind/${name}s
//@ use choice/moved_${name}
//@ end
//@ if mesh
//@ use bind/instances
//@ use choice/moved_instance
//@ use scene/at_run_time
//@ use scene/meshes
//@ end
// The hit record of a ray that hits a primitive.
fn surface_at(hit: Hit, ray: Ray) -> Surface {
    let pose = pose_at(hit.code, hit.instance);
    let to_hit = ray_to_hit(hit, pose, ray);
    let index = primitive_index(hit.code);
    switch primitive_kind(hit.code) {
        //@ each primitive
        ${case}: {
            return ${name}_at_rest(in_pose(${name}_surface(to_hit.ray, to_hit.t, moved_${name}(${name}s[index], pose)), pose), ${name}s[index]);
        }
        //@ end
        //@ if mesh
        default: {
            return in_pose(mesh_surface(ray, moved_instance(instances[at_run_time(hit.instance)], pose), index), pose);
        }
        //@ end
    }
}

// Returns the hit with its side, if it is on a body (scene/crossings).
fn sided_hit(hit: Hit, ray: Ray) -> Hit {
    return with_side(hit, pose_at(hit.code, hit.instance), ray);
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
