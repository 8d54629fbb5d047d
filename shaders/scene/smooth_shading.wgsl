//@ use data/surface
//@ use data/hit
//@ use data/ray
//@ use data/primitive
//@ use choice/offset
//@ use scene/at_run_time
//@ use scene/meshes
//@ use lib/octahedral
// Meshes with vertex normals look smooth: light scatters about the interpolated normal, and rays leave from the smooth
// surface that it belongs to.

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

// The normal that the material sees; `facing` is the surface's own, on the side that the ray came from. Near a silhouette the
// interpolated normal can face away from the ray, and would send a mirrored one into the surface: it is bent back until
// the ray grazes it.
fn shading_normal(hit: Hit, surface: Surface, incoming: vec3<f32>, facing: vec3<f32>) -> vec3<f32> {
    if !is_smooth(hit.code) {
        return facing;
    }
    let normals = normals_of(hit.code);
    let turned = from_mesh_turned(instances[at_run_time(hit.instance)], blend(surface.local, normals));
    let sided = select(-turned, turned, dot(facing, surface.normal) > 0.0);
    let bent = sided - max(dot(sided, incoming), 0.0) * incoming;
    // Opposite normals can cancel.
    if !(dot(bent, bent) > 1e-12) {
        return facing;
    }
    return normalize(bent);
}

// The point of an event on the side of `facing`: light is chosen and aimed at from here, and rays to that side leave here. Two points would give
// two densities for one direction. Facets shadow each other where the smooth surface would not, which shows as a jagged shadow terminator. So
// the point is lifted to the smooth surface: the mean of its projections onto the tangent planes of the vertices, weighted as the normals are
// (Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, ch. 4).
fn event_point(hit: Hit, surface: Surface, facing: vec3<f32>) -> vec3<f32> {
    if !is_smooth(hit.code) {
        return surface.point;
    }
    let corners = corners_of(primitive_index(hit.code));
    let normals = normals_of(hit.code);
    let weights = surface.local;
    let point = blend(weights, corners);
    // Seen from behind, the tangent planes are approached from their other side.
    let side = select(-1.0, 1.0, dot(facing, surface.normal) > 0.0);
    let below = side * vec3<f32>(
        dot(corners.a - point, normals.a),
        dot(corners.b - point, normals.b),
        dot(corners.c - point, normals.c),
    );
    let by = side * weights * max(below, vec3<f32>(0.0));
    let placed = instances[at_run_time(hit.instance)];
    let lift = placed.scale * from_mesh_turned(placed, blend(by, normals));
    return leave_surface(surface.point + lift, surface.error, facing, facing);
}

// A ray in a direction, from where it leaves the surface. Below the shading normal it leaves from the facet.
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
