//@ implements queued_slot when !queues
//@ use bind/window
// An invocation has the slot of its number among those of the submission.
fn queued_slot(index: u32) -> u32 {
    return window.first_slot + index;
}
