//@ use data/path
//@ use bind/window
//@ use step/film_sum
//@ use step/pixel_order
// Channels beside the radiance (`--aov`). The kernel that finds a sample's value adds it to the film at once, so that the path need not
// carry it. The film adds integers, so that the order does not matter.

// The place of the path's pixel in the tile of the film.
fn film_place(path: ptr<function, Path>) -> u32 {
    return place_in_order((*path).pixel) - window.first_pixel;
}

// Adds a vector to three sums of a pixel.
fn add_vector_to_film(place: u32, first_sum: u32, value: vec3<f32>) {
    for (var i = 0u; i < 3u; i++) {
        add_to_film(place, first_sum + i, value[i], SUM_FRACTION);
    }
}
