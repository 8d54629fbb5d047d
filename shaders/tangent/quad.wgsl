fn quad_tangents(surface: Surface, quad: Quad, frame: Frame) -> Tangents {
    return Tangents(quad.u, quad.v);
}
