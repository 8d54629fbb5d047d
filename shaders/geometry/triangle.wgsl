//@ use bind/meshes
//@ use geometry/instance
//@ use geometry/sheared_triangle
//@ use geometry/slab
// The faces of meshes: triangles whose corners lie in a buffer.

// A face where its mesh stands.
struct Triangle {
    instance: Instance,
    // The index of the face in `meshes`.
    face: u32,
    // Its index in the table of lights, if it is a light.
    light: u32,
}

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
fn face_hit(ray: Ray, corners: Corners) -> TriangleHit {
    return triangle_hit(shear_along(ray, slab_inverse(ray.direction)), corners.a, corners.b, corners.c);
}

// Distance to the face, or NO_HIT.
fn triangle_distance(ray: Ray, triangle: Triangle) -> f32 {
    return face_hit(to_mesh(triangle.instance, ray), corners_of(triangle.face)).t;
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
fn corners_in_render_space(triangle: Triangle) -> Corners {
    let instance = triangle.instance;
    let corners = corners_of(triangle.face);
    return Corners(from_mesh(instance, corners.a), from_mesh(instance, corners.b), from_mesh(instance, corners.c));
}

// The hit record of a ray that hits the face. The point is computed from the barycentric weights, so that it lies on the face.
fn triangle_surface(ray: Ray, t: f32, triangle: Triangle) -> Surface {
    let instance = triangle.instance;
    let corners = corners_of(triangle.face);
    let hit = face_hit(to_mesh(instance, ray), corners);
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

// The mesh's own texture coordinates, repeated outside 0..1.
fn triangle_uv(triangle: Triangle, point: vec3<f32>, weights: vec3<f32>) -> SurfaceUv {
    if triangle.instance.to_uvs == NO_UVS {
        return SurfaceUv(vec2<f32>(0.0), vec2<bool>(false));
    }
    return SurfaceUv(fract(interpolated_uv(triangle, weights)), vec2<bool>(true));
}

// Texture coordinates that may lie outside of 0 to 1.
fn interpolated_uv(triangle: Triangle, weights: vec3<f32>) -> vec2<f32> {
    let face = meshes[triangle.face] + triangle.instance.to_uvs;
    let a = bitcast<vec2<f32>>(meshes[face.x].xy);
    let b = bitcast<vec2<f32>>(meshes[face.y].xy);
    let c = bitcast<vec2<f32>>(meshes[face.z].xy);
    return weights.x * a + weights.y * b + weights.z * c;
}
