//@ use scene/responses
// The events of a light path, which a camera path follows backwards.

struct RecordedEvent {
    // What was hit, or IN_MEDIUM, and where.
    code: u32,
    point: vec3<f32>,
    // The direction of light before the event.
    incoming: vec3<f32>,
    // How the event scatters.
    lobe: u32,
    weight: vec3<f32>,
}

const MOST_EVENTS: u32 = 16u;
const IN_MEDIUM: u32 = 0xfffffff0u;
var<private> recorded: array<RecordedEvent, MOST_EVENTS>;
// The events of the light path so far; which path it is, and its light. A dispatch may begin in the middle of a path.
var<private> recorded_events: u32;
var<private> recorded_path: vec2<u32>;
var<private> recorded_light: u32;
// Whether a camera path is following them, and how many it still has to follow.
var<private> is_following: bool;
var<private> events_to_follow: u32;
// What the light path's density is over that of the camera path, as a logarithm.
var<private> log_ratio_at_lens: f32;

fn hit_point(path: ptr<function, Path>) -> vec3<f32> {
    return (*path).ray.origin + (*path).t * (*path).ray.direction;
}

fn record_event_of_light(path: ptr<function, Path>, drawn: Scatter) {
    let number = (*path).depth - FIRST_LIGHT_EVENT;
    if number == 0u {
        recorded_path = vec2<u32>((*path).pixel, (*path).sample);
    }
    recorded[number] = RecordedEvent((*path).status, hit_point(path), (*path).ray.direction, drawn.lobe, drawn.weight);
    recorded_events = number + 1u;
}

fn record_event_in_medium(path: ptr<function, Path>, point: vec3<f32>, albedo: vec3<f32>) {
    let number = (*path).depth - FIRST_LIGHT_EVENT;
    recorded[number] = RecordedEvent(IN_MEDIUM, point, (*path).ray.direction, LOBE_WIDE, albedo);
    recorded_events = number + 1u;
}

// In place of the camera path's own sample: the way back, with the weight that a sample of that direction has. A specular event has the
// weight of the light path's.
fn follow_recorded(own: Scatter, material: Material, interaction: Interaction, is_first: bool) -> Scatter {
    if events_to_follow == 0u {
        return own;
    }
    events_to_follow -= 1u;
    let event = recorded[events_to_follow];
    let direction = -event.incoming;
    if event.lobe == LOBE_SPECULAR && !is_first {
        return scatter_towards(direction, event.weight, LOBE_SPECULAR);
    }
    let response = response_of_material(material, interaction, direction);
    return scatter_towards(direction, response.value / response.pdf, LOBE_WIDE);
}
