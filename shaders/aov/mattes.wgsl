//@ use bind/film
//@ use bind/matte_ids
//@ use bind/window
//@ use scene/primitives
//@ use step/pixel_order
// Counts the names that camera samples see (Cryptomatte). A sample counts when it hits, so that rejected ones do, too.

// The most exchanges for a sample. A weak exchange may fail at an empty place, and is then repeated.
const MOST_EXCHANGES: u32 = 64u;

// Counts the hit of a camera ray in the tables of its pixel. An id keeps the first empty place that it finds. So all samples of an id find one place,
// and the counts depend on no order unless there are more ids than places.
fn count_mattes(path: ptr<function, Path>) {
    let pixel = rank_of_pixel((*path).pixel) - window.first_pixel;
    let object = primitive_order(path_hit(path));
    for (var kind = 0u; kind < ${matte_kinds}u; kind++) {
        let id = matte_ids[object][kind];
        var place = 0u;
        var is_counted = false;
        for (var i = 0u; i < MOST_EXCHANGES && place < MATTE_SLOTS && !is_counted; i++) {
            let found = atomicCompareExchangeWeak(&film[pixel].mattes[kind][2u * place], 0u, id);
            is_counted = found.exchanged || found.old_value == id;
            place += select(1u, 0u, is_counted || found.old_value == 0u);
        }
        let word = select(MATTE_WORDS - 1u, 2u * place + 1u, is_counted);
        atomicAdd(&film[pixel].mattes[kind][word], 1u);
    }
}
