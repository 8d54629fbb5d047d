//@ use choice/evaluation
//@ use choice/followed_channel
//@ use choice/light_absorption
//@ use choice/mix
//@ use choice/normal_map
//@ use choice/one_sided
//@ use choice/both_sides
//@ use choice/roulette
//@ use choice/tint
//@ use geometry/offset
//@ use scene/at_run_time
//@ use scene/interaction
//@ use scene/materials
//@ use scene/responses
//@ use light_path/reversal
//@ use light_path/density_ratio
//@ use light_path/lens_connection
//@ use step/light_depth
//@ use light_path/light_sample
// An event of a light path. What light does there is what camera paths compute: the BSDF is evaluated in their order, with the side of
// the camera as the incoming one, since not every BSDF is reciprocal. With i the direction to the light and o that to the camera, and the
// normals n_s of shading and n_g of the surface, the throughput gets the factor f |n_s i| |n_g o| / (|n_g i| pdf(o)) (Veach 1997, section 5.3).

// An event: the surface and what is known before a direction is drawn.
struct LightEvent {
    hit: Hit,
    surface: Surface,
    frame: ShadingFrame,
    evaluated: EvaluatedMaterial,
    view: CameraView,
    // From which light arrives, unit.
    to_light: vec3<f32>,
    cos_light: f32,
    // A first event scatters into a specular or a narrow lobe, and sends nothing to the lens.
    is_first: bool,
    is_rough: bool,
}

// An event in one order.
struct Order {
    interaction: Interaction,
    response: Response,
    // Whether the direction is on the right side of the surface.
    is_kept: bool,
    // Where a ray in that direction starts.
    origin: vec3<f32>,
}

// The drawn direction in the light's order, and the orders: the light's, and the camera's for the sampled direction and for that to the lens.
struct Orders {
    of_light: Order,
    of_sample: Order,
    of_lens: Order,
    drawn: Scatter,
}

// The logarithm of a ratio without camera paths.
const ONLY_LIGHT_PATHS: f32 = 0x1p100f;

// The logarithm of the density with which camera paths find the light of the first event: by BSDF sampling, and by light sampling.
fn log_of_both_densities(path: ptr<function, Path>, order: Order, points: f32, to_light: vec3<f32>) -> f32 {
    let light = start_of_light_path(path);
    let sampled = density_of_sampling(light, order.origin, to_light) / points;
    return log_of_density(select(order.response.pdf, 0.0, is_delta_light(lights[light].code)) + sampled);
}

// The orders of an event. `u` draws the direction.
fn orders_of_event(event: LightEvent, u: vec4<f32>) -> Orders {
    let surface = event.surface;
    let material = event.evaluated.material;
    var orders: Orders;
    for (var i = 0u; i < turns_of_loop(3u); i++) {
        let to_camera = select(orders.drawn.direction, event.view.direction, i == 2u);
        let incoming = select(-to_camera, -event.to_light, i == 0u);
        let own = shading_frame(event.hit, surface, incoming);
        let interaction = interaction_at(event.hit, surface, own, event.evaluated, incoming);
        var drawn = orders.drawn;
        if i == 0u {
            drawn = keep_side(scatter_by_material(material, interaction, u), interaction.normal, own.shading);
        }
        let outgoing = select(event.to_light, drawn.direction, i == 0u);
        var response = no_response();
        if event.is_rough {
            response = response_of_material(material, interaction, outgoing);
        }
        let is_kept = keep_side(scatter_towards(outgoing, vec3<f32>(1.0), LOBE_WIDE), interaction.normal, own.shading).event == SCATTERED && !is_behind(surface, own.front);
        let origin = spawn_ray(event.hit, surface, own.facing, own.shading, own.point, outgoing).origin;
        orders = Orders(orders.of_sample, orders.of_lens, Order(interaction, response, is_kept, origin), drawn);
    }
    return orders;
}

// Sends a ray to the lens.
fn connect_to_lens(path: ptr<function, Path>, event: LightEvent, order: Order) {
    let surface = event.surface;
    let view = event.view;
    let cos_camera = abs(dot(view.direction, surface.normal));
    let side = select(-surface.normal, surface.normal, dot(view.direction, surface.normal) > 0.0);
    let origin = leave_surface(surface.point, surface.error, side, side);
    let tinted = tint_through(order.response.value, event.evaluated, view.direction, event.frame.shading);
    let value = absorb_to_lens(tinted, surface, view.direction, view.distance);
    send_to_lens(path, view, origin, value * (cos_camera / event.cos_light), cos_camera, order.response.pdf / event.cos_light);
}

// The throughput after a specular event; 0 if no camera path goes back.
fn throughput_of_specular(path: ptr<function, Path>, event: LightEvent, orders: Orders) -> vec3<f32> {
    let drawn = orders.drawn;
    if !orders.of_sample.is_kept || !is_reversible(orders.of_light.interaction, drawn.direction, orders.of_sample.interaction) {
        return vec3<f32>(0.0);
    }
    let normal = event.surface.normal;
    let ratio = specular_ratio(event.evaluated.material, orders.of_light.interaction, normal, drawn.direction, event.to_light);
    (*path).log_ratio += log_of_density(ratio);
    if event.is_first && is_delta_light(lights[start_of_light_path(path)].code) {
        (*path).log_ratio = ONLY_LIGHT_PATHS;
    }
    return (*path).throughput * drawn.weight / ratio;
}

// The throughput after an event of another lobe.
fn throughput_of_rough(path: ptr<function, Path>, event: LightEvent, orders: Orders) -> vec3<f32> {
    let cos_light = event.cos_light;
    let cos_camera = abs(dot(orders.drawn.direction, event.surface.normal));
    let pdf = orders.of_light.response.pdf * select(1.0, orders.of_light.response.narrow, event.is_first);
    let from_light = log_of_density(pdf) - log_of_density(cos_camera);
    var from_camera = log_of_density(orders.of_sample.response.pdf);
    if NARROW_LOBES && event.is_first {
        let points = points_of_event(event.evaluated, event.hit);
        from_camera = log_of_both_densities(path, orders.of_sample, points, event.to_light);
    }
    (*path).log_ratio += from_light + log_of_density(cos_light) - from_camera;
    return (*path).throughput * orders.of_sample.response.value * (cos_camera / (cos_light * pdf));
}

// The material at the path's hit scatters the path or ends it. The event also sends a ray to the lens.
fn scatter_light_path(path: ptr<function, Path>) {
    let ray = (*path).ray;
    let hit = path_hit(path);
    let surface = surface_of_event(path, hit);
    let frame = shading_frame(hit, surface, ray.direction);
    let evaluated = follow_channel(path, evaluate_material(hit, surface, frame.front));
    absorb_ray(path, hit.t);
    (*path).throughput = absorb_behind((*path).throughput, surface, frame.front);
    let is_first = (*path).depth == FIRST_LIGHT_EVENT;
    let is_rough = is_non_specular(evaluated);
    let to_light = -ray.direction;
    let cos_light = abs(dot(to_light, surface.normal));
    let view = view_of_event(path, surface.point);
    let event = LightEvent(hit, surface, frame, evaluated, view, to_light, cos_light, is_first, is_rough);
    let u = scatter_random(path, evaluated);
    let orders = orders_of_event(event, u);
    let drawn = orders.drawn;
    if !is_first && is_rough && orders.of_lens.is_kept {
        connect_to_lens(path, event, orders.of_lens);
    }

    // The next ray.
    var throughput = vec3<f32>(0.0);
    if drawn.event == SCATTERED && drawn.lobe == LOBE_SPECULAR {
        throughput = throughput_of_specular(path, event, orders);
    } else if drawn.event == SCATTERED && (!is_first || (NARROW_LOBES && drawn.lobe == LOBE_NARROW)) && orders.of_sample.is_kept {
        throughput = throughput_of_rough(path, event, orders);
    }
    throughput = tint_through(throughput, evaluated, drawn.direction, frame.shading);
    (*path).throughput = russian_roulette(path, throughput);
    (*path).status = PATH_ENDED;
    if any((*path).throughput != vec3<f32>(0.0)) && is_within_depth((*path).depth + 1u) {
        (*path).ray = spawn_ray(hit, surface, frame.facing, frame.shading, frame.point, drawn.direction);
        (*path).status = RAY_READY;
        absorb_ahead(path, surface, drawn.direction);
        (*path).depth += 1u;
    }
}
