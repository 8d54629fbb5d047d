//@ use data/ray
//@ use data/surface
//@ use data/primitive
//@ use bind/meshes
//@ use bind/instances
//@ use geometry/instance
//@ use geometry/triangle
//@ use geometry/slab
// The faces of meshes.

// A vector for each corner of a face.
struct Corners {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
}

// The positions of a face's corners in the mesh's space.
fn corners_of(index: u32) -> Corners {
    let face = meshes[index];
    let a = bitcast<vec3<f32>>(meshes[face.x].xyz);
    let b = bitcast<vec3<f32>>(meshes[face.y].xyz);
    let c = bitcast<vec3<f32>>(meshes[face.z].xyz);
    return Corners(a, b, c);
}

// Where a ray in the mesh's space hits a face.
fn face_hit(ray: Ray, inverse: vec3<f32>, index: u32) -> TriangleHit {
    let corners = corners_of(index);
    return triangle_hit(shear_along(ray, inverse), corners.a, corners.b, corners.c);
}

// A face's number in its file. It breaks ties between faces of one mesh.
fn face_number(index: u32) -> u32 {
    return meshes[index].w;
}

fn blend(weights: vec3<f32>, corners: Corners) -> vec3<f32> {
    return weights.x * corners.a + weights.y * corners.b + weights.z * corners.c;
}

// The point of a face with these weights, in the mesh's space.
fn mesh_point(index: u32, weights: vec3<f32>) -> vec3<f32> {
    return blend(weights, corners_of(index));
}

// Unit normal on the side from which the corners run counter-clockwise.
fn face_normal(corners: Corners) -> vec3<f32> {
    return normalize(triangle_cross(corners.a, corners.b, corners.c));
}

// The positions of a face's corners in render space.
fn corners_in_render_space(instance: Instance, index: u32) -> Corners {
    let corners = corners_of(index);
    return Corners(from_mesh(instance, corners.a), from_mesh(instance, corners.b), from_mesh(instance, corners.c));
}

// The hit record of a ray that hits the face. The point is computed from the barycentric weights, so that it lies on the face.
fn mesh_surface(ray: Ray, instance: Instance, index: u32) -> Surface {
    let corners = corners_of(index);
    let here = to_mesh(instance, ray);
    let hit = triangle_hit(shear_along(here, slab_inverse(here.direction)), corners.a, corners.b, corners.c);
    let point = blend(hit.barycentric, corners);
    var surface: Surface;
    surface.point = from_mesh(instance, point);
    surface.normal = rotated_from_mesh(instance, face_normal(corners));
    surface.error = instance_error(instance, point, triangle_error(corners.a, corners.b, corners.c));
    surface.material = instance.material;
    surface.frame = instance.frame;
    surface.local = hit.barycentric;
    return surface;
}

fn colour_of_vertex(index: u32) -> vec3<f32> {
    let words = meshes[index].zw;
    // A product with a rounded step is the same on all devices. A quotient is not.
    return (1.0 / 65535.0) * vec3<f32>(vec3<u32>(words.x & 0xffffu, words.x >> 16u, words.y & 0xffffu));
}

// The colour of the vertices at a point of a face.
fn mesh_colour(instance: Instance, index: u32, weights: vec3<f32>) -> vec3<f32> {
    if instance.to_uvs == NO_UVS {
        return vec3<f32>(1.0);
    }
    let face = meshes[index] + instance.to_uvs;
    return blend(weights, Corners(colour_of_vertex(face.x), colour_of_vertex(face.y), colour_of_vertex(face.z)));
}

// Stored as 1 - alpha, so that colours without alpha have the words of those with an alpha of 1.
fn alpha_of_vertex(index: u32) -> f32 {
    return (1.0 / 65535.0) * f32(65535u - (meshes[index].w >> 16u));
}

// The alpha of the vertices at a point of a face.
fn mesh_alpha(instance: Instance, index: u32, weights: vec3<f32>) -> f32 {
    if instance.to_uvs == NO_UVS {
        return 1.0;
    }
    let face = meshes[index] + instance.to_uvs;
    let corners = vec3<f32>(alpha_of_vertex(face.x), alpha_of_vertex(face.y), alpha_of_vertex(face.z));
    return weights.x * corners.x + weights.y * corners.y + weights.z * corners.z;
}

// The mesh's own texture coordinates, repeated outside 0..1.
fn mesh_uv(instance: Instance, index: u32, weights: vec3<f32>) -> SurfaceUv {
    if instance.to_uvs == NO_UVS {
        return SurfaceUv(vec2<f32>(0.0), false);
    }
    let face = meshes[index] + instance.to_uvs;
    let a = bitcast<vec2<f32>>(meshes[face.x].xy);
    let b = bitcast<vec2<f32>>(meshes[face.y].xy);
    let c = bitcast<vec2<f32>>(meshes[face.z].xy);
    return SurfaceUv(fract(weights.x * a + weights.y * b + weights.z * c), true);
}
