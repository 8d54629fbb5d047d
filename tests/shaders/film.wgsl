//@ use step/count
//@ use step/film
// Adds runs to the film.
@group(0) @binding(21) var<storage, read> input: array<RunRecord>;
@group(0) @binding(22) var<storage, read_write> output: array<u32>;

fn run(row: u32) {
    let record = input[row];
    output[row] = add_run(record.pixel, record);
    count(PATHS, output[row]);
    count(RAYS, record.rays);
}
