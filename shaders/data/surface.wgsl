// The hit record: the surface at the point where a ray hit it.
struct Surface {
    // The hit point in render space. `error` bounds its distance from the surface, plus the rounding error of the next distance
    // to this surface that is computed from the point.
    point: vec3<f32>,
    error: f32,
    // Unit normal on the surface's front: outwards, or u x v for a quad.
    normal: vec3<f32>,
    material: u32,
    // The point in the primitive's own coordinates. Sphere: its normal. Large sphere: its offset from the point nearest to the camera, in
    // radii. Quad, and the square around a disk: (a, b, 0). Cuboid: 0..1 along each axis from its low corner. Triangle: the weights of its vertices.
    local: vec3<f32>,
    // Index of the frame that maps `local` to the point at which a texture is evaluated.
    frame: u32,
    // The pose of the object, which has the point and the normal in it.
    pose: Pose,
}

// Returns the surface with the pose of its object.
fn in_pose(surface: Surface, pose: Pose) -> Surface {
    var posed = surface;
    posed.pose = pose;
    return posed;
}

const NO_HIT: f32 = -1.0;

// Texture coordinates, and whether the texture continues from u = 1 to u = 0.
struct SurfaceUv {
    uv: vec2<f32>,
    wraps: vec2<bool>,
}

// Where a ray meets a surface.
struct ShadingFrame {
    // Whether the ray comes from the side to which the surface's own normal points.
    front: bool,
    // The surface's own normal and the shading normal, on the side from which the ray comes.
    facing: vec3<f32>,
    shading: vec3<f32>,
    // The point of the event, from which lights are chosen and sampled.
    point: vec3<f32>,
}
