//@ use bind/lights
//@ use bind/light_nodes
//@ use lib/octahedral
//@ use scene/at_run_time
// Lights chosen by what they can bring to a point: down a tree over them, at each node to the child on the left with the
// left one's share of both importances (Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree
// Splitting", HPG 2018; src/flatten/light_tree.rs). The sky is the second of the first pair, a node around everything.

// The intensity of a node's lights over the squared distance, times the largest cosine that any of their normals can have
// to the point (section 4.2): a bound of the irradiance, but for a distance that nodes around the point do not have. The
// point's own normal is not asked, so that a path that meets a light need not remember it.
fn light_node_importance(node: LightNode, from_point: vec3<f32>) -> f32 {
    let to_point = from_point - node.center;
    let distance2 = dot(to_point, to_point);
    let radius2 = node.radius * node.radius;
    // Between the axis and the direction to the point.
    var cosine = dot(unit_from_octahedral(node.axis), to_point) * inverseSqrt(max(distance2, 0x1p-100f));
    cosine = select(cosine, abs(cosine), (node.child & LIGHT_NODE_TWO_SIDED) != 0u);
    let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    // The angle less the spread, where it is beyond.
    let spread_sine = sqrt(max(1.0 - node.cos_spread * node.cos_spread, 0.0));
    let beyond = cosine < node.cos_spread;
    let less_cosine = select(1.0, cosine * node.cos_spread + sine * spread_sine, beyond);
    let less_sine = select(0.0, sine * node.cos_spread - cosine * spread_sine, beyond);
    // Less what the node takes of the directions from the point. In it, all is possible.
    let seen_sine2 = radius2 / max(distance2, radius2);
    let seen_cosine = sqrt(1.0 - seen_sine2);
    let turned = less_cosine * seen_cosine + less_sine * sqrt(seen_sine2);
    let open = distance2 <= radius2 || less_cosine >= seen_cosine;
    return node.intensity * max(select(turned, 1.0, open), 0.0) / max(max(distance2, radius2), 0x1p-80f);
}

// Where there are other lights, the sky is chosen at least and at most so often: what of either is hidden is not asked.
const LEAST_OF_SKY: f32 = 0.1;

// The probability of the first of a pair. Either keeps a chance where both can matter, however little.
fn light_node_share(pair: u32, from_point: vec3<f32>) -> f32 {
    let left = light_node_importance(light_nodes[pair], from_point);
    let right = light_node_importance(light_nodes[pair + 1u], from_point);
    var least = 0x1p-20f;
    //@ if emitting_sky
    least = select(least, LEAST_OF_SKY, (light_nodes[pair + 1u].child & LIGHT_NODE_SKY) != 0u);
    //@ end
    if left == 0.0 || right == 0.0 {
        // Where nothing matters, anything is right.
        return select(select(0.0, 1.0, left > 0.0), 0.5, left == right);
    }
    return clamp(left / (left + right), least, 1.0 - least);
}

// Levels for which one uniform serves: at each it loses as many of its 24 digits as the choice tells. Beyond, the other one
// goes on, or lights deep in a large tree would be chosen more or less often than their probability says.
const LEVELS_OF_ONE_UNIFORM: u32 = 10u;

fn choose_light(from_point: vec3<f32>, u: vec2<f32>) -> LightChoice {
    var rest = u.x;
    var probability = 1.0;
    var child = at_run_time(0u);
    for (var level = 0u; (child & LIGHT_NODE_LEAF) == 0u; level++) {
        let pair = child & LIGHT_NODE_INDEX;
        let share = light_node_share(pair, from_point);
        rest = select(rest, u.y, level == LEVELS_OF_ONE_UNIFORM);
        // Rounded up to 1, the rest would take the second of a pair that has no chance.
        rest = min(rest, 1.0 - 0x1p-24f);
        let second = rest >= share;
        let taken = select(share, 1.0 - share, second);
        probability *= taken;
        rest = select(rest, rest - share, second) / taken;
        child = light_nodes[pair + u32(second)].child;
    }
    return LightChoice(child & LIGHT_NODE_INDEX, probability);
}

// The probability that a light is chosen: down the same way.
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
