//@ use bind/counters
//@ use bind/window
// Ends a submission: the host reads the number with the counters, and knows that the kernels before this one have run.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn receipt(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x == 0u {
        counters.receipt = window.receipt;
    }
}
