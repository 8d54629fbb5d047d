//@ use data/path
//@ use data/dimension
//@ use data/primitive
//@ use bind/settings
//@ use bind/window
//@ use bind/counters
//@ use choice/camera
//@ use choice/sampler
//@ if light
//@ use data/light
//@ end
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

// Where a pixel stands in that order.
fn place_in_order(pixel: u32) -> u32 {
    let column = pixel % settings.image_width;
    let row = pixel / settings.image_width;
    let first_row = row / STRIP_ROWS * STRIP_ROWS;
    let rows = min(STRIP_ROWS, settings.image_height - first_row);
    return first_row * settings.image_width + column * rows + row - first_row;
}

// Puts the path onto the camera ray of its sample.
fn start_sample(path: ptr<function, Path>) {
    let pixel = (*path).pixel;
    let u = random4(pixel, (*path).sample, DIMENSION_CAMERA, settings.seed);
    (*path).ray = camera_ray(pixel % settings.image_width, pixel / settings.image_width, u);
    (*path).status = RAY_READY;
    (*path).throughput = vec3<f32>(1.0);
    (*path).depth = 0u;
    //@ if light
    (*path).radiance = vec3<f32>(0.0);
    (*path).pdf = 0.0;
    (*path).light = NO_LIGHT;
    //@ end
}

// Takes the window's next run, or leaves the slot idle where there is none.
fn start_run(path: ptr<function, Path>) {
    let run = atomicAdd(&counters.next, 1u);
    if run >= window.end {
        (*path).status = SLOT_IDLE;
        atomicAdd(&counters.idle, 1u);
        return;
    }
    let block = window.first_block + run / window.pixels;
    (*path).pixel = pixel_in_order(window.first_pixel + run % window.pixels);
    (*path).sample = max(block * RUN_LENGTH, settings.first_sample);
    (*path).counts = select(0u, ODD_RUN, (block & 1u) == 1u);
    (*path).sum = Compensated();
    (*path).rays = 0u;
    (*path).spread = vec3<f32>(0.0);
    start_sample(path);
}
