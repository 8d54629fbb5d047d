//! The tables of docs/scaling.md follow from what was measured. `GPU_RT_RENEW=1` writes them anew.

use std::fs;
use std::path::Path;

use crate::common::renew;
use crate::common::scaling::{DOCUMENT, PLOT, inputs_of, plot, short, with_tables};

#[test]
fn the_tables_follow_from_the_measurements() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let document = fs::read_to_string(root.join(DOCUMENT)).expect("the document is read");
    let inputs = inputs_of(&document);
    let known = |of: f64| of.is_finite() && of > 0.0;
    let all_known =
        inputs.iter().all(|of| [of.pixels, of.start, of.sample, of.write, of.bytes, of.merge].into_iter().all(known));
    assert!(inputs.len() == 2 && all_known, "{inputs:?}");
    let expected = with_tables(&document).expect("the document has its sections");
    if renew() {
        fs::write(root.join(DOCUMENT), &expected).expect("the document is written");
        fs::write(root.join(PLOT), plot(&inputs)).expect("the plot is written");
    } else {
        assert!(document == expected, "GPU_RT_RENEW=1 writes the tables anew");
    }
    // Another pace gives other tables.
    let mut other = document.clone();
    let number = format!("| {} |", short(inputs[0].merge));
    assert!(other.contains(&number), "{number}");
    other = other.replace(&number, "| 9.99 |");
    assert!(with_tables(&other) != Some(other.clone()));
}
