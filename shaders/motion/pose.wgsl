//@ use bind/motions
// The poses of objects at the time of a path's sample (motion/time).

// That time: 0 where the shutter opens, below 1 where it closes.
var<private> now: f32;

// A number between those of two keys. A row has the time in its last word; a key has one row, or two.
struct BetweenKeys {
    before: vec4<u32>,
    after: vec4<u32>,
    // The row of the key before, and the share of the way to the one after.
    row: u32,
    share: f32,
}

// The last of the keys whose time has come, but for the very last one, and the next.
fn between_keys(first: u32, keys: u32, rows: u32) -> BetweenKeys {
    var low = 0u;
    var high = keys - 1u;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        let has_come = bitcast<f32>(motions[first + rows * middle].w) <= now;
        low = select(low, middle, has_come);
        high = select(middle, high, has_come);
    }
    let row = first + rows * low;
    let before = motions[row];
    let after = motions[row + rows];
    let begin = bitcast<f32>(before.w);
    return BetweenKeys(before, after, row, (now - begin) / (bitcast<f32>(after.w) - begin));
}

fn vector_of_row(row: vec4<u32>) -> vec3<f32> {
    return bitcast<vec3<f32>>(row.xyz);
}

fn vector_between(between: BetweenKeys) -> vec3<f32> {
    let before = vector_of_row(between.before);
    return before + between.share * (vector_of_row(between.after) - before);
}

// The turn of a step. That of a spin is half its angle, in turns, around the step's axis.
fn turn_of_step(kind: u32, axis: vec3<f32>, value: vec3<f32>, between: BetweenKeys) -> vec4<f32> {
    if kind == SPIN {
        let point = circle_point(value.x);
        return vec4<f32>(point.y * axis, point.x);
    }
    let before = vec4<f32>(vector_of_row(between.before), bitcast<f32>(motions[between.row + 1u].x));
    let after = vec4<f32>(vector_of_row(between.after), bitcast<f32>(motions[between.row + 3u].x));
    return turn_between(before, after, between.share);
}

// The pose of an object, by its place in the order of the scene. A turn moves the object's own point by its arm, which grows with the shifts
// before.
fn pose_of(order: u32) -> Pose {
    var pose = Pose(vec3<f32>(0.0), 1.0, vec4<f32>(0.0, 0.0, 0.0, 1.0), (order & MOVES) != 0u);
    if !pose.moves {
        return pose;
    }
    let motion = motions[1u + (order & ~MOVES)].xy;
    for (var i = 0u; i < motion.y; i++) {
        let head = motions[motion.x + 2u * i];
        let tail = motions[motion.x + 2u * i + 1u];
        let kind = head.w & KIND_OF_STEP;
        let arm = vector_of_row(head) + pose.shift;
        let between = between_keys(tail.w, head.w >> KEYS_SHIFT, select(1u, 2u, kind == TURN));
        let value = vector_between(between);
        if kind == SHIFT {
            pose.shift += value;
        } else if kind == RESIZE {
            pose.shift += value.x * arm;
            pose.scale += value.x * pose.scale;
        } else {
            let turn = turn_of_step(kind, vector_of_row(tail), value, between);
            pose.shift += change_by_turn(turn, arm);
            pose.turn = joined_turns(turn, pose.turn);
        }
    }
    pose.turn *= inverseSqrt(dot(pose.turn, pose.turn));
    return pose;
}
