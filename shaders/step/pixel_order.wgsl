//@ use bind/settings
// The order in which slots take the pixels of the rendered part of the image: strips of eight rows, column by column, so that
// neighbouring slots start on neighbouring pixels. Pixels are named by their indices in the full image: random numbers, and so the
// samples, do not depend on the part.

// Returns the pixel at a position in that order.
fn pixel_in_order(position: u32) -> u32 {
    let strip_pixels = STRIP_ROWS * settings.film_width;
    let strip = position / strip_pixels;
    let within = position % strip_pixels;
    let first_row = strip * STRIP_ROWS;
    let rows = min(STRIP_ROWS, settings.film_height - first_row);
    let row = settings.film_top + first_row + within % rows;
    return row * settings.image_width + settings.film_left + within / rows;
}

// Returns the position of a pixel in that order.
fn rank_of_pixel(pixel: u32) -> u32 {
    let column = pixel % settings.image_width - settings.film_left;
    let row = pixel / settings.image_width - settings.film_top;
    let first_row = row / STRIP_ROWS * STRIP_ROWS;
    let rows = min(STRIP_ROWS, settings.film_height - first_row);
    return first_row * settings.film_width + column * rows + row - first_row;
}
