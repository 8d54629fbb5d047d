"""The camera of the scene file."""

import math

from . import ron
from .axes import placed
from .process import Failure


def fields(scene, depsgraph, size, blur):
    """The fields `image` and `camera`, and where the image begins in that of the scene file: it is a part of it, if the lens is shifted."""
    camera = scene.camera.evaluated_get(depsgraph) if scene.camera else None
    if camera is None or camera.type != "CAMERA":
        raise Failure("The scene has no camera: add one, or choose one in Scene > Camera")
    lens = camera.data
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
    if lens.type == "PANO":
        (across, down), whole = (0, 0), size
    projection = _projection(camera.name, lens, whole, pixel, frame)
    if not abs(camera.matrix_world.determinant()) > 0:
        raise Failure(f"The camera {camera.name} has a scale of 0: press Alt S")
    matrix = camera.matrix_world.normalized()
    up = matrix.col[1].xyz
    aperture = aperture_of(camera, depsgraph)
    distance = aperture.get("focus_distance", 1.0)
    view = lambda matrix: {
        "look_from": placed(matrix.translation),
        "look_at": placed(matrix.translation - matrix.col[2].xyz.normalized() * distance),
    }
    made = {
        "image": {"width": whole[0], "height": whole[1]},
        "camera": view(matrix) | {"up": placed(up)} | projection | aperture | blur.of_camera(view, up),
    }
    return made, (abs(across) + across, abs(down) + down)


def aperture_of(camera, depsgraph):
    """The fields of the camera that say how it blurs what is not in focus."""
    lens, matrix = camera.data, camera.matrix_world.normalized()
    if not lens.dof.use_dof or lens.type != "PERSP":
        return {}
    distance, focused = lens.dof.focus_distance, lens.dof.focus_object
    if focused:
        distance = abs((matrix.translation - focused.evaluated_get(depsgraph).matrix_world.translation).dot(matrix.col[2].xyz))
    # The f-number is a share of the focal length, which is in millimetres.
    return {"aperture": 1e-3 * lens.lens / lens.dof.aperture_fstop, "focus_distance": max(distance, 1e-6)}


def _projection(name, lens, size, pixel, frame):
    """The field of the camera that says how directions are laid out on an image of this size. `frame` has the corners of Blender's frame, in which a
    pixel has this size."""
    width, height = size
    if lens.type == "PERSP":
        return {"vertical_fov": 2 * math.degrees(math.atan(height * pixel / 2 / -frame[0].z))}
    if lens.type == "ORTHO":
        return {"projection": ron.Orthographic(height=height * pixel)}
    # In Blender 5 the panorama is the camera's own; before, that of Cycles.
    own = lens if hasattr(lens, "panorama_type") else lens.cycles
    # Blender's numbers have seven digits: -pi is more than 180 degrees.
    degrees = lambda *names: tuple(round(math.degrees(getattr(own, name)), 4) for name in names)
    if own.panorama_type == "EQUIRECTANGULAR":
        horizontal, vertical = degrees("longitude_min", "longitude_max"), degrees("latitude_min", "latitude_max")
        return {"projection": ron.Equirectangular(horizontal=horizontal, vertical=vertical)}
    if own.panorama_type == "FISHEYE_EQUIDISTANT":
        if width == height:
            return {"projection": ron.Fisheye(model=ron.Equidistant, fov=degrees("fisheye_fov")[0])}
        # Blender's angle is that of the width and of the height: it stretches the image.
        focal = {"fx": width / own.fisheye_fov, "fy": height / own.fisheye_fov, "cx": width / 2, "cy": height / 2}
        return {"projection": ron.Calibrated(**focal, distortion=ron.KannalaBrandt(k1=0.0))}
    if own.panorama_type == "FISHEYE_EQUISOLID":
        # The side of the image that the sensor fits.
        sides = {"HORIZONTAL": width, "VERTICAL": height, "AUTO": max(width, height)}
        sensor = lens.sensor_height if lens.sensor_fit == "VERTICAL" else lens.sensor_width
        share = sensor / sides[lens.sensor_fit] * height / 2 / (2 * own.fisheye_lens)
        if share > 1:
            raise Failure(f"The camera {name} sees all around within its sensor: give it a longer lens")
        return {"projection": ron.Fisheye(model=ron.Equisolid, fov=math.degrees(4 * math.asin(share)))}
    kind = own.panorama_type.lower().replace("_", " ")
    raise Failure(f"The camera {name} is a panorama ({kind}) that gpu-rt lacks: choose Equirectangular, Fisheye Equidistant or Fisheye Equisolid")
