//@ alternative light_choice when several_lights
//@ use bind/lights
//@ use bind/light_nodes
//@ use scene/at_run_time
// Chooses a light by its estimated contribution to a point. The choice descends a tree over the lights. At each node, the
// probability of the left child is its share of the sum of both children's importances (Conty Estevez and Kulla, "Importance
// Sampling of Many Lights with Adaptive Tree Splitting", HPG 2018; src/flatten/light_tree.rs). A sampled sky is the second node
// of the first pair, and surrounds everything. Directional lights do so too: alone, or as the first node of a pair with the sky.

// The importance of a node: the intensity of its lights over the squared distance, times the largest cosine that any of their
// normals can have to the point (section 4.2). Apart from the distance, this is an upper bound of the irradiance. The distance
// is that to the node's centre, and at least the node's radius, because a node around the point has no distance to it. The
// point's own normal is not used, so a path that hits a light need not store the normal of its last event.
fn light_node_importance(node: LightNode, from_point: vec3<f32>) -> f32 {
    let to_point = from_point - node.center;
    let distance2 = dot(to_point, to_point);
    let radius2 = node.radius * node.radius;
    // The cosine of the angle between the axis and the direction to the point.
    var cosine = dot(unit_from_octahedral(node.axis), to_point) * inverseSqrt(max(distance2, 0x1p-100f));
    cosine = select(cosine, abs(cosine), (node.child & LIGHT_NODE_TWO_SIDED) != 0u);
    let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    // That angle minus the half angle of the cone of the lights' normals, and 0 within the cone.
    let half_angle_sine = sqrt(max(1.0 - node.cos_half_angle * node.cos_half_angle, 0.0));
    let beyond = cosine < node.cos_half_angle;
    let less_cosine = select(1.0, cosine * node.cos_half_angle + sine * half_angle_sine, beyond);
    let less_sine = select(0.0, sine * node.cos_half_angle - cosine * half_angle_sine, beyond);
    // From this, subtract half the angle that the node fills as seen from the point. Inside the node, every direction is possible.
    // A quotient and a root may round to more than 1.
    let seen_sine2 = min(radius2 / max(distance2, radius2), 1.0);
    let seen_cosine = min(sqrt(1.0 - seen_sine2), 1.0);
    let largest_cosine = less_cosine * seen_cosine + less_sine * sqrt(seen_sine2);
    let open = distance2 <= radius2 || less_cosine >= seen_cosine;
    // Beams emit nothing beyond the cone.
    if node.radius < 0.0 && !open {
        return 0.0;
    }
    return node.intensity * max(select(largest_cosine, 1.0, open), 0.0) / max(max(distance2, radius2), 0x1p-80f);
}

// In a scene with other lights, the sky has at least this probability and at most 1 minus this, because importances ignore
// occlusion.
const LEAST_OF_SKY: f32 = 0.1;

// The probability of the first node of a pair. If both nodes can contribute, however little, both keep some probability.
fn light_node_share(pair: u32, from_point: vec3<f32>) -> f32 {
    let left = light_node_importance(light_nodes[pair], from_point);
    let right = light_node_importance(light_nodes[pair + 1u], from_point);
    let least = select(0x1p-20f, LEAST_OF_SKY, (light_nodes[pair + 1u].child & LIGHT_NODE_SKY) != 0u);
    if left == 0.0 || right == 0.0 {
        // If only one of them can contribute, it is chosen. If neither can, the choice does not matter.
        return select(select(0.0, 1.0, left > 0.0), 0.5, left == right);
    }
    return clamp(left / (left + right), least, 1.0 - least);
}

// The number of levels that share one uniform number. Each level uses up some of its 24 bits. Deeper levels use the second
// uniform number; otherwise lights deep in a large tree would be chosen more or less often than their probability says.
const LEVELS_OF_ONE_UNIFORM: u32 = 10u;

fn choose_light(from_point: vec3<f32>, u: vec2<f32>) -> LightChoice {
    var rest = u.x;
    var probability = 1.0;
    var child = at_run_time(0u);
    for (var level = 0u; (child & LIGHT_NODE_LEAF) == 0u; level++) {
        let pair = child & LIGHT_NODE_INDEX;
        let share = light_node_share(pair, from_point);
        rest = select(rest, u.y, level == LEVELS_OF_ONE_UNIFORM);
        // If rounding made `rest` 1, the second node would be chosen even at probability 0.
        rest = min(rest, 1.0 - 0x1p-24f);
        let second = rest >= share;
        let taken = select(share, 1.0 - share, second);
        probability *= taken;
        rest = select(rest, rest - share, second) / taken;
        child = light_nodes[pair + u32(second)].child;
    }
    return LightChoice(child & LIGHT_NODE_INDEX, probability);
}

// The probability that choose_light chooses a given light, by the same descent.
fn light_probability(index: u32, from_point: vec3<f32>) -> f32 {
    var probability = 1.0;
    var trail = lights[index].trail;
    var child = at_run_time(0u);
    while (child & LIGHT_NODE_LEAF) == 0u {
        let pair = child & LIGHT_NODE_INDEX;
        let share = light_node_share(pair, from_point);
        let second = (trail & 1u) != 0u;
        probability *= select(share, 1.0 - share, second);
        trail >>= 1u;
        child = light_nodes[pair + u32(second)].child;
    }
    return probability;
}
