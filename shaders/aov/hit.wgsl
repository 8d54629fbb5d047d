//@ implements aov_hit when aov_hit
//@ each hit_channel
//@ use aov/${name}
//@ end
//@ each matte
//@ use aov/${name}
//@ end
// Channels of the first surface that a camera ray hits. Media do not matter to them.
fn record_hit(path: ptr<function, Path>) {
    if (*path).depth != 0u || (*path).status >= FIRST_STATUS {
        return;
    }
    //@ each hit_sum
    (*path).aov[${number}u] += ${name};
    //@ end
    //@ each matte
    count_${name}(path);
    //@ end
}

//@ without
// The film has no channel of the surface that camera rays hit.
fn record_hit(path: ptr<function, Path>) {
}
