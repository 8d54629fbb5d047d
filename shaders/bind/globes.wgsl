//@ use data/primitive
@group(0) @binding(20) var<${space_of_globes}> globes: array<Globe${size_of_globes}>;
