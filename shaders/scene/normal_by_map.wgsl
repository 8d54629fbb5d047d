//@ use bind/frames
//@ use bind/materials
//@ each primitive
//@ use bind/${name}s
//@ use choice/moved_${name}
//@ use tangent/${name}
//@ end
//@ use choice/mesh_normal_map
// The normal that an image has for a finer surface.

fn tangents_at(hit: Hit, surface: Surface, frame: Frame) -> Tangents {
    let index = primitive_index(hit.code);
    switch primitive_kind(hit.code) {
        //@ each primitive
        ${case}: {
            let moved = moved_${name}(${name}_at(index, hit.instance), surface.pose);
            return ${name}_tangents_with(${name}_tangents(${name}_unturned(surface), moved, frame), surface.pose);
        }
        //@ end
    }
}

// The unit vector that this row of the table of materials has in the axes of its texture coordinates and the normal `outward`.
fn vector_by_row(row: u32, mapped: vec3<f32>, outward: vec3<f32>, hit: Hit, surface: Surface) -> vec3<f32> {
    let frame = frames[surface.frame + materials[row].kind];
    if has_own_table(hit) {
        return normal_on_mesh(mapped, outward, hit, surface, frame.phase);
    }
    return normal_of_map(mapped, outward, tangents_at(hit, surface, frame));
}

// Returns the normal by the map of this row. `shading` is the normal without the map, on the side from which the ray comes, and `code` is the
// map's texel.
fn normal_by_map(
    row: u32,
    hit: Hit,
    surface: Surface,
    incoming: vec3<f32>,
    shading: vec3<f32>,
    front: bool,
    code: vec3<f32>,
) -> vec3<f32> {
    let scale = materials[row].${normal.scale};
    let mapped = (2.0 * code - 1.0) * vec3<f32>(scale, scale, 1.0);
    let bumped = vector_by_row(row, mapped, select(-shading, shading, front), hit, surface);
    return bent_back(select(-bumped, bumped, front), incoming, shading);
}
