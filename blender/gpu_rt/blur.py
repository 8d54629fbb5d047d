"""Motion blur: where the camera and the objects are while the shutter is open. Times of the scene file are in frames."""

import math

from . import ron
from .axes import placed

# The most groups of objects, as each has a file of its own.
MOST = 256


class Blur:
    def __init__(self, scene, depsgraph, frame):
        """Has the file at the frame afterwards."""
        self.times, self.camera, self.notes = [], [], []
        # The middle of a group and its motion; and the numbers of groups by objects.
        self.groups, self.group_of = [], {}
        render = scene.render
        if not render.use_motion_blur or render.motion_blur_shutter <= 0:
            return
        position = getattr(render, "motion_blur_position", None) or scene.cycles.motion_blur_position
        begin = {"START": 0.0, "CENTER": -0.5, "END": -1.0}[position] * render.motion_blur_shutter
        blurred = [each for each in scene.objects if each.cycles.use_motion_blur]
        # Cycles moves straight between so many times.
        steps = 2 ** max([each.cycles.motion_steps for each in blurred], default=1)
        self.times = [begin + render.motion_blur_shutter * step / steps for step in range(steps + 1)]
        places = []
        for time in self.times:
            whole = math.floor(frame + time)
            scene.frame_set(whole, subframe=frame + time - whole)
            self.camera.append(scene.camera.evaluated_get(depsgraph).matrix_world.normalized())
            places.append({key(each): each.matrix_world.copy() for each in depsgraph.object_instances if is_blurred(each)})
        scene.frame_set(math.floor(frame), subframe=frame - math.floor(frame))
        known, lost = {}, set()
        for instance in depsgraph.object_instances:
            at = [place.get(key(instance)) for place in places]
            now = instance.matrix_world.copy()
            if None in at or all(each == at[0] for each in at) or now.determinant() == 0:
                continue
            # What moves alike is one group. It turns around the middle of its first object.
            by = [each @ now.inverted() for each in at]
            alike = tuple(round(number, 5) for each in by for row in each for number in row)
            if alike not in known and len(known) == MOST:
                lost.add(instance.object.name)
                continue
            if alike not in known:
                known[alike] = len(known)
                self.groups.append((now.translation.copy(), by))
            self.group_of[key(instance)] = known[alike]
        if lost:
            self.notes.append(f"the blur of {len(lost)} objects, such as {min(lost)}: only {MOST} motions that differ are rendered")

    def of_camera(self, view, up):
        """The fields of the camera that say how it moves. `view` gives those of a matrix."""
        if not self.times:
            return {}
        # Its keys have no up: it stays as upright as it is at the frame.
        if any(up.cross(matrix.col[2].xyz).angle(matrix.col[0].xyz, 0) > math.radians(0.1) for matrix in self.camera):
            self.notes.append("the blur of the camera's roll")
        shutter = {"shutter": (self.times[0], self.times[-1])}
        if all(matrix == self.camera[0] for matrix in self.camera):
            return shutter
        return shutter | {"moving": [(time, view(matrix)) for time, matrix in zip(self.times, self.camera)]}

    def moving(self, index, made):
        """An object of the scene file, at the frame, as it moves with a group."""
        middle, by = self.groups[index]
        keys = []
        for time, matrix in zip(self.times, by):
            to, turn, scale = (matrix @ middle), matrix.to_quaternion(), matrix.to_scale()
            axis, angle = turn.to_axis_angle()
            keys.append((time, [
                ron.Translate(placed(-middle)), ron.Scale(max(sum(scale) / 3, 1e-6)),
                ron.Rotate(axis=placed(axis) if angle else (0.0, 1.0, 0.0), degrees=math.degrees(angle)), ron.Translate(placed(to)),
            ]))
        return ron.Moving(keys=keys, object=made)


def key(instance):
    parent = instance.parent.name_full if instance.parent else ""
    return instance.object.name_full, parent, tuple(instance.persistent_id)


def is_blurred(instance):
    return instance.show_self and instance.object.type == "MESH" and instance.object.cycles.use_motion_blur
