//@ use data/hit
//@ use data/material
//@ use data/primitive
//@ use data/surface
//@ use bind/extensions
//@ use bind/frames
//@ use bind/materials
//@ use lib/bent_back
//@ use lib/tangents
//@ each primitive
//@ use bind/${name}s
//@ use choice/moved_${name}
//@ use tangent/${name}
//@ end
//@ if mesh
//@ use bind/instances
//@ use choice/moved_instance
//@ use scene/at_run_time
//@ use scene/mesh_tangents
//@ end
//@ if uv_tables
//@ use scene/mesh_normal_map
//@ end
// Normal maps: images of the normal that a finer surface would have.

fn tangents_at(hit: Hit, surface: Surface, frame: Frame) -> Tangents {
    let index = primitive_index(hit.code);
    switch primitive_kind(hit.code) {
        //@ each primitive
        ${case}: {
            let moved = moved_${name}(${name}s[index], surface.pose);
            return ${name}_tangents_with(${name}_tangents(${name}_unturned(surface), moved, frame), surface.pose);
        }
        //@ end
        //@ if mesh
        default: {
            return mesh_tangents(moved_instance(instances[at_run_time(hit.instance)], surface.pose), index);
        }
        //@ end
    }
}

// Returns the normal by the map of the surface's material, if it has one. `shading` is the normal without the map, on the side from which
// the ray comes, and `code` is the map's texel.
fn mapped_normal(
    hit: Hit,
    surface: Surface,
    incoming: vec3<f32>,
    shading: vec3<f32>,
    front: bool,
    code: vec3<f32>,
) -> vec3<f32> {
    let row = extensions[surface.material].normal;
    if row == NO_EXTENSION {
        return shading;
    }
    let scale = materials[row].parameter;
    let mapped = (2.0 * code - 1.0) * vec3<f32>(scale, scale, 1.0);
    let outward = select(-shading, shading, front);
    //@ if uv_tables
    if primitive_kind(hit.code) == KIND_TRIANGLE {
        let number = frames[surface.frame + materials[row].kind].phase;
        let on_mesh = normal_on_mesh(mapped, outward, hit, surface, number);
        return bent_back(select(-on_mesh, on_mesh, front), incoming, shading);
    }
    //@ end
    let bumped = normal_of_map(mapped, outward, tangents_at(hit, surface, frames[surface.frame + materials[row].kind]));
    return bent_back(select(-bumped, bumped, front), incoming, shading);
}

// Whether a direction is on the same side of the surface as of the mapped normal. A map must not let light through a closed surface.
fn keeps_its_side(direction: vec3<f32>, mapped: vec3<f32>, shading: vec3<f32>) -> bool {
    return (dot(direction, mapped) > 0.0) == (dot(direction, shading) > 0.0);
}

// Absorbs a sampled direction that is not.
fn keep_side(bsdf: Scatter, mapped: vec3<f32>, shading: vec3<f32>) -> Scatter {
    if bsdf.event == SCATTERED && !keeps_its_side(bsdf.direction, mapped, shading) {
        return absorbed();
    }
    return bsdf;
}

// Returns 0 for the response to light from such a direction.
fn response_on_side(value: vec3<f32>, direction: vec3<f32>, mapped: vec3<f32>, shading: vec3<f32>) -> vec3<f32> {
    return select(vec3<f32>(0.0), value, keeps_its_side(direction, mapped, shading));
}
