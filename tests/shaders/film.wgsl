//@ use step/count
//@ use step/film
// Adds runs to the film.
alias In = RunRecord;
alias Out = u32;

fn run(row: u32) {
    let record = input[row];
    output[row] = add_run(record.pixel, record);
    count(PATHS, output[row]);
    count(RAYS, record.rays);
}
