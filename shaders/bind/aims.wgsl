// Boxes around the surfaces that can be specular, at which light paths are aimed.
@group(0) @binding(34) var<${space_of_aims}> aims: array<Cuboid${size_of_aims}>;
