fn disk_tangents(surface: Surface, disk: Quad, frame: Frame) -> Tangents {
    return Tangents(disk.u, disk.v);
}
