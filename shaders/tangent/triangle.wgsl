//@ use geometry/instance
//@ use geometry/triangle
// The tangents of a face of a mesh.

// Returns dp/du and dp/dv in render space, both times the absolute value of the determinant: the edges of the face are
// p = u (dp/du) + v (dp/dv), with the texture coordinates of its corners.
fn triangle_tangents(surface: Surface, triangle: Triangle, frame: Frame) -> Tangents {
    let instance = triangle.instance;
    if instance.to_uvs == NO_UVS {
        return Tangents(vec3<f32>(0.0), vec3<f32>(0.0));
    }
    let face = meshes[triangle.face] + instance.to_uvs;
    let a = bitcast<vec2<f32>>(meshes[face.x].xy);
    let ab = bitcast<vec2<f32>>(meshes[face.y].xy) - a;
    let ac = bitcast<vec2<f32>>(meshes[face.z].xy) - a;
    let corners = corners_of(triangle.face);
    let b = corners.b - corners.a;
    let c = corners.c - corners.a;
    let side = sign(ab.x * ac.y - ac.x * ab.y);
    let u = side * (ac.y * b - ab.y * c);
    let v = side * (ab.x * c - ac.x * b);
    return Tangents(rotated_from_mesh(instance, u), rotated_from_mesh(instance, v));
}
