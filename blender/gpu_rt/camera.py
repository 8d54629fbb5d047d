"""The camera of the scene file."""

import math

from .axes import placed
from .process import Failure


def fields(scene, depsgraph, size, blur):
    """The fields `image` and `camera`, and where the image begins in that of the scene file: it is a part of it, if the lens is shifted."""
    camera = scene.camera.evaluated_get(depsgraph) if scene.camera else None
    if camera is None or camera.type != "CAMERA":
        raise Failure("The scene has no camera: add one, or choose one in Scene > Camera")
    lens = camera.data
    if lens.type != "PERSP":
        raise Failure(f"The camera {camera.name} is not perspective, which gpu-rt needs: change its Lens > Type")
    if scene.render.pixel_aspect_x != scene.render.pixel_aspect_y:
        raise Failure("gpu-rt has square pixels: set Output > Format > Aspect to 1")
    if scene.render.use_multiview:
        raise Failure("gpu-rt renders no stereoscopy: turn it off in Output > Stereoscopy")
    width, height = size
    frame = lens.view_frame(scene=scene)
    left, right = (end(corner.x for corner in frame) for end in (min, max))
    bottom, top = (end(corner.y for corner in frame) for end in (min, max))
    pixel = (top - bottom) / height
    # The middle of the frame is not before the lens if that is shifted: then the frame is a part of a larger one whose middle is.
    across, down = round((left + right) / 2 / pixel), round(-(bottom + top) / 2 / pixel)
    whole = (width + 2 * abs(across), height + 2 * abs(down))
    angle = 2 * math.degrees(math.atan(whole[1] * pixel / 2 / -frame[0].z))
    if not abs(camera.matrix_world.determinant()) > 0:
        raise Failure(f"The camera {camera.name} has a scale of 0: press Alt S")
    matrix = camera.matrix_world.normalized()
    at, back, up = matrix.translation, matrix.col[2].xyz, matrix.col[1].xyz
    distance = 1.0
    aperture = {}
    if lens.dof.use_dof:
        focused = lens.dof.focus_object
        if focused:
            distance = abs((at - focused.evaluated_get(depsgraph).matrix_world.translation).dot(back))
        else:
            distance = lens.dof.focus_distance
        # The f-number is a share of the focal length, which is in millimetres.
        aperture = {"aperture": 1e-3 * lens.lens / lens.dof.aperture_fstop, "focus_distance": max(distance, 1e-6)}
    view = lambda matrix: {
        "look_from": placed(matrix.translation),
        "look_at": placed(matrix.translation - matrix.col[2].xyz.normalized() * max(distance, 1e-6)),
    }
    made = {
        "image": {"width": whole[0], "height": whole[1]},
        "camera": view(matrix) | {"up": placed(up), "vertical_fov": angle} | aperture | blur.of_camera(view, up),
    }
    return made, (abs(across) + across, abs(down) + down)
