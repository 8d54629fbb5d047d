//@ implements media_transmittance when varying
//@ use bind/settings
//@ use choice/sampler
//@ use choice/walker
//@ use scene/varying_media
// An estimate of the fraction of light that passes all media up to distance t, or WALK_CUT if a walk took too many steps.
fn transmittance(ray: Ray, t: f32, steps: ptr<function, u32>) -> f32 {
    let words = random_words(walker.pixel, walker.sample, walker.dimension, settings.seed);
    var through = 1.0;
    for (var i = 0u; i < ${media}u && through > 0.0; i++) {
        let medium = media[at_run_time(i)];
        let field = fields[at_run_time(i)];
        let here = ray_in_field(medium, field, ray);
        // The words themselves have chosen the light.
        var own = pcg4d(words + i + 1u);
        var last = AT_ORIGIN;
        var inside = next_interval(medium, ray, &last, t, steps);
        while is_interval(inside) {
            let share = share_through(medium, field, here, inside, &own, steps);
            if share == WALK_CUT {
                return WALK_CUT;
            }
            through *= share;
            own = pcg4d(own);
            inside = next_interval(medium, ray, &last, t, steps);
        }
        if inside.x < 0.0 {
            return WALK_CUT;
        }
    }
    return through;
}
