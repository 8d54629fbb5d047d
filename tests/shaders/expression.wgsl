//@ use ${module}
// An expression of each row of input.
alias In = ${given};
alias Out = ${gives};

fn run(row: u32) {
    let given = input[row];
    output[row] = ${expression};
}
