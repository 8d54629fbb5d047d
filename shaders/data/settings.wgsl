// What one render is told: constant over all its passes. The host places the members by name (src/plan.rs).
struct Settings {
    // Direction of the image's middle, and its change from one pixel to the next along x and y.
    forward: vec3<f32>,
    image_width: u32,
    pixel_x: vec3<f32>,
    image_height: u32,
    pixel_y: vec3<f32>,
    // Scattering events of a path at most.
    max_depth: u32,
    seed: u32,
    // First and one past the last sample of a pixel.
    first_sample: u32,
    end_sample: u32,
    slots: u32,
    // What the gradient starts with, the only radiance of a solid background, and what an image is multiplied by.
    background_bottom: vec3<f32>,
    // Code of the BVH's root (data/primitive).
    root: u32,
    //@ if lens
    // The lens's radius along the image's x and y, in render space.
    lens_x: vec3<f32>,
    // 1 / focus distance in render space: the lens offset times this bends the ray back to the point in focus.
    inverse_focus: f32,
    lens_y: vec3<f32>,
    //@ end
    //@ if image_background
    background_width: u32,
    background_height: u32,
    //@ end
    //@ if gradient_background
    background_top: vec3<f32>,
    //@ end
    //@ if camera_axes
    // The world's axes in render space.
    world_x: vec3<f32>,
    world_y: vec3<f32>,
    world_z: vec3<f32>,
    //@ end
    //@ if clamp
    // The most that a contribution of indirect light may be, in device radiance.
    indirect_limit: f32,
    //@ end
    //@ if brute_force
    // How many primitives there are of each kind that the scene has, in the order of the kinds.
    brute_force: vec4<u32>,
    //@ end
    //@ if several_backgrounds
    // Number of the background's kind (src/flatten).
    background: u32,
    //@ end
    // 0, which no compiler knows (lib/compensated).
    zero: u32,
}
