// The camera of the page: where it is, and the settings that follow. Lengths are those of render space, in which the scene that the page was made of has
// a size of about 1 around the origin.

// The farthest from there: coordinates are rounded by 2^-24 of it.
const FARTHEST = 1000;
const LEAST_DISTANCE = 1e-5;
// The least angle between the view and the vertical.
const LEAST_ANGLE = 0.01;

const add = (a, b, by = 1) => a.map((v, i) => v + by * b[i]);
const times = (a, by) => a.map(v => v * by);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => times(a, 1 / Math.hypot(...a));
// Rodrigues' rotation.
const turned = (v, axis, angle) => {
  const [sin, cos] = [Math.sin(angle), Math.cos(angle)];
  return add(add(times(v, cos), cross(axis, v), sin), axis, dot(axis, v) * (1 - cos));
};

export class Camera {
  constructor({ camera, size }) {
    Object.assign(this, { start: camera, full: size });
    this.reset();
  }

  reset() {
    const { right, up, backward, distance } = this.start;
    Object.assign(this, { place: [0, 0, 0], right, up, backward, distance, moved: false });
  }

  target() {
    return add(this.place, this.backward, -this.distance);
  }

  // Places the camera at this distance behind its target.
  look(backward, distance, target) {
    const place = add(target, backward, distance);
    if (Math.hypot(...place) > FARTHEST) return;
    const right = unit(cross(this.start.vertical, backward));
    Object.assign(this, { place, right, backward, distance, up: cross(backward, right), moved: true });
  }

  // Turns it around its target, by angles in radians.
  orbit(x, y) {
    const target = this.target(), { vertical } = this.start;
    const angle = Math.acos(Math.min(Math.max(dot(this.backward, vertical), -1), 1));
    const within = Math.min(Math.max(angle + y, LEAST_ANGLE), Math.PI - LEAST_ANGLE) - angle;
    const right = unit(cross(vertical, this.backward));
    this.look(unit(turned(turned(this.backward, right, within), vertical, x)), this.distance, target);
  }

  // Moves it and its target across the view, in heights of the view.
  pan(x, y) {
    const { pixel, parallel } = this.start;
    const height = (parallel ? this.zoom() : this.distance) * pixel * this.full[1];
    this.look(this.backward, this.distance, add(add(this.target(), this.right, x * height), this.up, y * height));
  }

  // The size of a pixel relative to that at the start: parallel rays see the same size from everywhere.
  zoom() {
    return this.start.parallel ? this.distance / this.start.distance : 1;
  }

  // Moves it towards its target: to this share of the distance.
  dolly(share) {
    this.look(this.backward, Math.max(this.distance * share, LEAST_DISTANCE), this.target());
  }

  // Whether an image of this size is that of the host.
  isStart(size) {
    return !this.moved && size.every((side, axis) => side === this.full[axis]);
  }

  // The settings of an image of this size, by name. At the start they are those of the host, to the bit.
  settings(size) {
    if (this.isStart(size)) return {};
    const { pixel, lens_radius, focus, mirror, distance } = this.start;
    const width = (pixel * this.zoom() * this.full[1]) / size[1];
    return {
      camera_place: this.place,
      forward: times(this.backward, -1),
      pixel_x: times(this.right, mirror ? -width : width),
      pixel_y: times(this.up, -width),
      lens_x: times(this.right, lens_radius),
      lens_y: times(this.up, lens_radius),
      // The plane that is sharp stays at the same share of the way to the target.
      inverse_focus: [1 / (focus * (this.distance / distance))],
    };
  }
}
