//@ use bind/settings
//@ use bind/window
//@ use bind/counters
//@ use slots/state
//@ use choice/camera
//@ use lib/rng
//@ use data/dimension
//@ use data/primitive
// Starting a sample, and a run.

// Pixels are handed out in strips of eight rows, each walked column by column, so that neighbouring slots start on
// neighbouring pixels.
const STRIP_ROWS: u32 = 8u;

fn pixel_in_order(position: u32) -> u32 {
    let strip_pixels = STRIP_ROWS * settings.image_width;
    let strip = position / strip_pixels;
    let within = position % strip_pixels;
    let first_row = strip * STRIP_ROWS;
    let rows = min(STRIP_ROWS, settings.image_height - first_row);
    return (first_row + within % rows) * settings.image_width + within / rows;
}

// Puts the camera ray of the sample into the slot.
fn start_sample(slot: u32, pixel: u32, sample: u32) {
    let u = random4(pixel, sample, DIMENSION_CAMERA, settings.seed);
    let column = pixel % settings.image_width;
    let row = pixel / settings.image_width;
    write_ray(slot, camera_ray(column, row, u));
    paths[place(PLANE_THROUGHPUT, slot)] = word_of(vec3<f32>(1.0), 0u);
}

// Takes the window's next run into the slot, or leaves the slot idle where there is none.
fn start_run(slot: u32) {
    let run = atomicAdd(&counters.next, 1u);
    if run >= window.end {
        paths[place(PLANE_DIRECTION, slot)].w = SLOT_IDLE;
        atomicAdd(&counters.idle, 1u);
        return;
    }
    let pixels = settings.image_width * settings.image_height;
    let block = window.first_block + run / pixels;
    let pixel = pixel_in_order(run % pixels);
    let sample = max(block * RUN_LENGTH, settings.first_sample);
    let end = min((block + 1u) * RUN_LENGTH, settings.end_sample);
    paths[place(PLANE_SAMPLE, slot)] = vec4<u32>(pixel, sample, end, 0u);
    paths[place(PLANE_SUM, slot)] = vec4<u32>(0u);
    start_sample(slot, pixel, sample);
}
