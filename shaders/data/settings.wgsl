// The settings of a render, the same for all its dispatches. The host writes the members by name (src/plan.rs).
struct Settings {
    // The direction through the image's middle, and the change of direction from one pixel to the next along x and y.
    forward: vec3<f32>,
    image_width: u32,
    pixel_x: vec3<f32>,
    image_height: u32,
    pixel_y: vec3<f32>,
    // The most scattering events of a path.
    max_depth: u32,
    seed: u32,
    // The first sample of each pixel, and one past the last.
    first_sample: u32,
    end_sample: u32,
    slots: u32,
    // Solid background: its radiance. Gradient: its radiance at the bottom. Image: the factor that its texels are multiplied by.
    background_bottom: vec3<f32>,
    // Code of the root of the scene's BVH (data/primitive).
    root: u32,
    // The part of the image that is rendered, in pixels: all of it, or what --crop says.
    film_left: u32,
    film_top: u32,
    film_width: u32,
    film_height: u32,
    //@ if placed
    // The place of the camera in render space.
    camera_place: vec3<f32>,
    //@ end
    //@ if lens
    // The image's x and y directions in render space, times the lens's radius.
    lens_x: vec3<f32>,
    // 1 / focus distance in render space. The ray from a point on the lens to the point in focus has this direction: the
    // pinhole's direction minus the point on the lens times this value.
    inverse_focus: f32,
    lens_y: vec3<f32>,
    //@ end
    //@ if projection & !projection.orthographic
    // The numbers of the projection: shaders/camera says what they are there.
    film: vec4<f32>,
    //@ end
    //@ if projection.calibrated | projection.calibrated_fisheye
    distortion: vec4<f32>,
    tangential: vec2<f32>,
    // The angle at which the distance from the middle stops growing, in radians.
    fold: f32,
    //@ end
    //@ if background.image | background.octahedral
    background_width: u32,
    background_texel: u32,
    background_format: u32,
    //@ end
    //@ if background.image
    background_height: u32,
    //@ end
    //@ if background.gradient
    background_top: vec3<f32>,
    //@ end
    //@ if camera_axes
    // The world's axes in render space.
    world_x: vec3<f32>,
    world_y: vec3<f32>,
    world_z: vec3<f32>,
    //@ end
    //@ if clamp & event
    // The limit on a contribution of indirect light, in device radiance.
    indirect_limit: f32,
    //@ end
    //@ if brute_force
    // The number of primitives of each kind that the scene has, in the order of the kinds.
    brute_force: vec4<u32>,
    //@ end
    //@ if several_backgrounds
    // The kind of the background (src/flatten).
    background: u32,
    //@ end
    //@ if light_paths
    // The light paths of a run.
    light_paths: u32,
    //@ end
    // 0. No compiler knows its value (lib/compensated).
    zero: u32,
}
