//@ alternative shading when smooth
//@ use geometry/offset
//@ use scene/at_run_time
//@ use geometry/triangle
//@ use choice/moved_triangle
// Meshes with vertex normals look smooth: light scatters around the interpolated normal, and rays leave from the smooth
// surface that this normal describes.

fn is_smooth(code: u32) -> bool {
    return primitive_kind(code) == KIND_TRIANGLE && meshes[meshes[primitive_index(code)].x].w != NO_NORMAL;
}

fn normals_of(code: u32) -> Corners {
    let face = meshes[primitive_index(code)];
    return Corners(
        unit_from_octahedral(meshes[face.x].w),
        unit_from_octahedral(meshes[face.y].w),
        unit_from_octahedral(meshes[face.z].w),
    );
}

// The normal for the material. `facing` is the surface's own normal, on the side from which the ray comes. Near a silhouette
// the interpolated normal can face away from the ray. Such a normal is bent back.
fn shading_normal(hit: Hit, surface: Surface, incoming: vec3<f32>, facing: vec3<f32>) -> vec3<f32> {
    if !is_smooth(hit.code) {
        return facing;
    }
    let normals = normals_of(hit.code);
    let interpolated = rotated_from_mesh(moved_instance(instances[at_run_time(hit.instance)], surface.pose), blend(surface.local, normals));
    let sided = select(-interpolated, interpolated, dot(facing, surface.normal) > 0.0);
    // Vertex normals in opposite directions can cancel.
    return bent_back(sided, incoming, facing);
}

// The point of an event, on the side of `facing`. Lights are chosen and sampled from this point, and rays to that side start
// here. With two different points, one direction would have two densities. Facets shadow each other where the smooth surface
// would not, which shows as a jagged shadow terminator. So the point is lifted to the smooth surface: the mean of its
// projections onto the tangent planes of the vertices, with the same weights as the normals (Hanika, "Hacking the Shadow
// Terminator", Ray Tracing Gems II, ch. 4).
fn event_point(hit: Hit, surface: Surface, facing: vec3<f32>) -> vec3<f32> {
    if !is_smooth(hit.code) {
        return surface.point;
    }
    let corners = corners_of(primitive_index(hit.code));
    let normals = normals_of(hit.code);
    let weights = surface.local;
    let point = blend(weights, corners);
    // From behind, the point lies on the other side of the tangent planes.
    let side = select(-1.0, 1.0, dot(facing, surface.normal) > 0.0);
    let below = side * vec3<f32>(
        dot(corners.a - point, normals.a),
        dot(corners.b - point, normals.b),
        dot(corners.c - point, normals.c),
    );
    let by = side * weights * max(below, vec3<f32>(0.0));
    let instance = moved_instance(instances[at_run_time(hit.instance)], surface.pose);
    let lift = instance.scale * rotated_from_mesh(instance, blend(by, normals));
    return leave_surface(surface.point + lift, surface.error, facing, facing);
}

// A ray in a direction, starting where it leaves the surface. A direction below the shading normal leaves from the facet.
fn spawn_ray(
    hit: Hit,
    surface: Surface,
    facing: vec3<f32>,
    shading: vec3<f32>,
    point: vec3<f32>,
    direction: vec3<f32>,
) -> Ray {
    let below = dot(direction, shading) < 0.0;
    let side = select(facing, -facing, below);
    let leaving = leave_surface(surface.point, surface.error, side, side);
    return Ray(select(leaving, point, is_smooth(hit.code) && !below), direction);
}
