//@ use data/hit
//@ use data/material
//@ use data/primitive
//@ use data/surface
//@ use bind/details
//@ use bind/frames
//@ use bind/materials
//@ use lib/bent_back
//@ use lib/tangents
//@ each primitive
//@ use bind/${name}s
//@ use tangent/${name}
//@ end
//@ if mesh
//@ use bind/instances
//@ use scene/at_run_time
//@ use scene/meshes
//@ end
// Normal maps: images of the normal that a finer surface would have.

fn tangents_at(hit: Hit, surface: Surface, frame: Frame) -> Tangents {
    let index = primitive_index(hit.code);
    switch primitive_kind(hit.code) {
        //@ each primitive
        ${case}: {
            return ${name}_tangents(surface, ${name}s[index], frame);
        }
        //@ end
        //@ if mesh
        default: {
            return mesh_tangents(instances[at_run_time(hit.instance)], index);
        }
        //@ end
    }
}

//@ if mesh
// From the texture coordinates of the face's corners: the edges are p = u (dp/du) + v (dp/dv). Both are multiplied by the determinant,
// whose sign is that of the image: it is mirrored or not.
fn mesh_tangents(instance: Instance, index: u32) -> Tangents {
    if instance.to_uvs == NO_UVS {
        return Tangents(vec3<f32>(0.0), vec3<f32>(0.0));
    }
    let face = meshes[index] + instance.to_uvs;
    let a = bitcast<vec2<f32>>(meshes[face.x].xy);
    let ab = bitcast<vec2<f32>>(meshes[face.y].xy) - a;
    let ac = bitcast<vec2<f32>>(meshes[face.z].xy) - a;
    let corners = corners_of(index);
    let b = corners.b - corners.a;
    let c = corners.c - corners.a;
    let side = sign(ab.x * ac.y - ac.x * ab.y);
    let u = side * (ac.y * b - ab.y * c);
    let v = side * (ab.x * c - ac.x * b);
    return Tangents(from_mesh_turned(instance, u), from_mesh_turned(instance, v));
}

//@ end
// The normal by the map of the surface's material, if it has one. `shading` is the normal without it, on the side from which the ray
// comes, and `code` is the map's texel.
fn mapped_normal(
    hit: Hit,
    surface: Surface,
    incoming: vec3<f32>,
    shading: vec3<f32>,
    front: bool,
    code: vec3<f32>,
) -> vec3<f32> {
    let row = details[surface.material].normal;
    if row == NO_DETAIL {
        return shading;
    }
    let bumps = materials[row].parameter;
    let mapped = (2.0 * code - 1.0) * vec3<f32>(bumps, bumps, 1.0);
    let outward = select(-shading, shading, front);
    let turned = normal_of_map(mapped, outward, tangents_at(hit, surface, frames[surface.frame + materials[row].kind]));
    return bent_back(select(-turned, turned, front), incoming, shading);
}

// Whether a direction is on the same side of the surface as of the mapped normal. Light cannot pass a closed surface because of its map.
fn keeps_its_side(direction: vec3<f32>, mapped: vec3<f32>, shading: vec3<f32>) -> bool {
    return (dot(direction, mapped) > 0.0) == (dot(direction, shading) > 0.0);
}
