// A point of an event as the camera sees it.
struct CameraView {
    // From the event to the camera.
    direction: vec3<f32>,
    distance: f32,
    // In pixels from the left upper corner of the image.
    film_point: vec2<f32>,
    // Chooses the pixel (light_path/splat).
    u: vec2<f32>,
    // The density of camera rays per pixel over an area across them at the event; 0 if the camera does not see it.
    density: f32,
}
