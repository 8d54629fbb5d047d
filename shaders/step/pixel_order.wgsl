//@ use bind/settings
// Pixels are handed out in strips of eight rows, each walked column by column, so that neighbouring slots start on
// neighbouring pixels. They are those of the part of the image that is rendered, and named by their indices in the whole image: random
// numbers, and so the samples, do not depend on the part.
const STRIP_ROWS: u32 = 8u;

fn pixel_in_order(position: u32) -> u32 {
    let strip_pixels = STRIP_ROWS * settings.film_width;
    let strip = position / strip_pixels;
    let within = position % strip_pixels;
    let first_row = strip * STRIP_ROWS;
    let rows = min(STRIP_ROWS, settings.film_height - first_row);
    let row = settings.film_top + first_row + within % rows;
    return row * settings.image_width + settings.film_left + within / rows;
}

// Where a pixel stands in that order.
fn rank_of_pixel(pixel: u32) -> u32 {
    let column = pixel % settings.image_width - settings.film_left;
    let row = pixel / settings.image_width - settings.film_top;
    let first_row = row / STRIP_ROWS * STRIP_ROWS;
    let rows = min(STRIP_ROWS, settings.film_height - first_row);
    return first_row * settings.film_width + column * rows + row - first_row;
}
