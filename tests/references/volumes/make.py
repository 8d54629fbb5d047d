"""Makes the images of blob.ron by other renderers, and its grid.

    target/bpy/bin/python tests/references/volumes/make.py cycles    # after `make bpy`: blob.vdb and cycles.exr
    python tests/references/volumes/make.py mitsuba                  # after `pip install mitsuba==3.9.1 OpenEXR numpy`: mitsuba.exr

Each image is the mean of several seeds, and has the variance of that mean in its layer `variance`. The .json beside it says how it was made.
tests/images/volume_references.rs compares them with our own.

Mitsuba's texels lie in the middles of the cells of a grid's box, and its values go on unchanged beyond the outer ones: so the box of its grid is
half a voxel wider than the voxels of the file, whose outer layers are 0. Its lamp shines on one side, ours and that of Cycles on both; nothing is
above it. Cycles rounds grids to 16 bits unless it is told not to, and its axes are others: z is up. Pixels of Cycles are independent with its
tables of Sobol points, and not by default, where noise is blue.
"""

import json
import math
import sys
import time
from pathlib import Path

import numpy as np
import OpenEXR

FOLDER = Path(__file__).resolve().parent
VOXELS, SIZE_OF_VOXEL, SCALE = 24, 0.1, 5.0
LOW = -0.5 * (VOXELS - 1) * SIZE_OF_VOXEL  # where the first voxel is
ALBEDO, ANISOTROPY = (0.9, 0.7, 0.5), 0.4
FLOOR, SKY, LAMP = (0.5, 0.4, 0.3), (0.3, 0.4, 0.5), (14.0, 12.0, 10.0)
FLOOR_AT, FLOOR_SIDE, LAMP_AT, LAMP_SIDE = (0.0, -1.3, 0.0), 8.0, (1.0, 3.5, 0.5), 1.5
EYE, TARGET, VERTICAL_FOV = (1.2, 1.4, 5.0), (0.0, -0.1, 0.0), 32.0
WIDTH, HEIGHT = 64, 48


def values():
    """The grid, by x, y and z: a ball with waves in it, which has no symmetry. Its outer layers are 0."""
    x, y, z = (np.mgrid[0:VOXELS, 0:VOXELS, 0:VOXELS] - 0.5 * (VOXELS - 1)) / (0.5 * VOXELS)
    ball = np.clip(3.0 * (0.85 - np.sqrt(x * x + y * y + z * z)), 0.0, 1.0)
    waves = 0.55 + 0.45 * np.sin(5.0 * x + 1.0) * np.sin(4.0 * y + 9.0 * x * z) * np.cos(7.0 * z - 2.0 * y)
    rough = 0.7 + 0.3 * np.sin(3000.0 * x + 5000.0 * y + 7000.0 * z)
    return (ball * waves * rough).astype(np.float32)


def quad(middle, side):
    x, y, z = middle
    return [(x + a * side / 2, y, z + b * side / 2) for a, b in ((-1, 1), (1, 1), (1, -1), (-1, -1))]


def save(name, images, started, how):
    images = np.array(images, np.float64)
    variance = images.var(axis=0, ddof=1) / len(images)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    layers = {"RGB": images.mean(0), "variance": variance}
    OpenEXR.File(header, {key: np.ascontiguousarray(layer, np.float32) for key, layer in layers.items()}).write(str(FOLDER / f"{name}.exr"))
    means = images.mean(axis=(1, 2))
    made = {
        **how,
        "seeds": len(images),
        "seconds": round(time.time() - started, 1),
        "mean_rgb": means.mean(0).tolist(),
        "error_of_mean_by_pixels": (np.sqrt(variance.sum((0, 1))) / (WIDTH * HEIGHT)).tolist(),
        "error_of_mean_by_seeds": (means.std(0, ddof=1) / math.sqrt(len(images))).tolist(),
    }
    (FOLDER / f"{name}.json").write_text(json.dumps(made, indent=1) + "\n")
    print(json.dumps(made, indent=1))


def mitsuba(spp=1024, seeds=16):
    import mitsuba as mi

    variant = "scalar_rgb"
    mi.set_variant(variant)
    to = mi.ScalarTransform4f
    rgb = lambda colour: {"type": "rgb", "value": list(colour)}
    low, across = LOW - 0.5 * SIZE_OF_VOXEL, VOXELS * SIZE_OF_VOXEL
    box = to().translate([low] * 3).scale(across)
    grid = mi.VolumeGrid(np.ascontiguousarray(values().transpose(2, 1, 0)[..., None]))
    flat = lambda at, side, turn: to().translate(list(at)).rotate([1, 0, 0], turn).scale(0.5 * side)
    scene = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "volpathmis", "max_depth": -1, "rr_depth": 64},
        "sensor": {
            "type": "perspective", "fov": VERTICAL_FOV, "fov_axis": "y",
            "to_world": to().look_at(origin=list(EYE), target=list(TARGET), up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT, "rfilter": {"type": "box"}},
            "sampler": {"type": "independent"},
        },
        "sky": {"type": "constant", "radiance": rgb(SKY)},
        "floor": {"type": "rectangle", "to_world": flat(FLOOR_AT, FLOOR_SIDE, -90), "bsdf": {"type": "diffuse", "reflectance": rgb(FLOOR)}},
        "lamp": {"type": "rectangle", "to_world": flat(LAMP_AT, LAMP_SIDE, 90), "emitter": {"type": "area", "radiance": rgb(LAMP)}},
        "blob": {
            "type": "cube", "to_world": box @ to().scale(0.5).translate([1, 1, 1]), "bsdf": {"type": "null"},
            "interior": {
                "type": "heterogeneous", "albedo": rgb(ALBEDO), "scale": SCALE,
                "sigma_t": {"type": "gridvolume", "grid": grid, "to_world": box, "filter_type": "trilinear", "wrap_mode": "clamp", "raw": True},
                "phase": {"type": "hg", "g": ANISOTROPY},
            },
        },
    })
    started = time.time()
    images = [np.array(mi.render(scene, spp=spp, seed=seed)) for seed in range(seeds)]
    save("mitsuba", images, started, {"renderer": f"Mitsuba {mi.__version__}, volpathmis", "variant": variant, "spp": spp})


def cycles(spp=1024, seeds=16):
    import bpy
    from mathutils import Matrix, Vector

    bpy.utils.expose_bundled_modules()
    import openvdb

    grid = openvdb.FloatGrid()
    grid.name, grid.gridClass = "density", openvdb.GridClass.FOG_VOLUME
    grid.copyFromArray(values())
    grid.transform = openvdb.createLinearTransform([[SIZE_OF_VOXEL, 0, 0, 0], [0, SIZE_OF_VOXEL, 0, 0], [0, 0, SIZE_OF_VOXEL, 0], [LOW] * 3 + [1]])
    openvdb.write(str(FOLDER / "blob.vdb"), grids=[grid])

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    blender = lambda point: Vector((point[0], -point[2], point[1]))  # z is up

    def shader(owner, kind, socket="Surface", **inputs):
        owner.use_nodes = True
        nodes = owner.node_tree.nodes
        nodes.clear()
        output = nodes.new("ShaderNodeOutputWorld" if kind == "ShaderNodeBackground" else "ShaderNodeOutputMaterial")
        new = nodes.new(kind)
        for name, value in inputs.items():
            new.inputs[name.replace("_", " ")].default_value = (*value, 1.0) if isinstance(value, tuple) else value
        owner.node_tree.links.new(new.outputs[0], output.inputs[socket])
        return owner

    def place(data, material=None):
        if material:
            data.materials.append(material)
        placed = bpy.data.objects.new(data.name, data)
        scene.collection.objects.link(placed)
        return placed

    def flat(name, at, side, kind, **inputs):
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([blender(corner) for corner in quad(at, side)], [], [(0, 1, 2, 3)])
        place(mesh, shader(bpy.data.materials.new(name), kind, **inputs))

    scene.world = shader(bpy.data.worlds.new("sky"), "ShaderNodeBackground", Color=SKY)
    flat("floor", FLOOR_AT, FLOOR_SIDE, "ShaderNodeBsdfDiffuse", Color=FLOOR)
    flat("lamp", LAMP_AT, LAMP_SIDE, "ShaderNodeEmission", Color=tuple(x / LAMP[0] for x in LAMP), Strength=LAMP[0])
    medium = shader(bpy.data.materials.new("medium"), "ShaderNodeVolumePrincipled", "Volume", Color=ALBEDO, Density=SCALE, Anisotropy=ANISOTROPY)
    volume = bpy.data.volumes.new("blob")
    volume.filepath = str(FOLDER / "blob.vdb")
    volume.render.precision, volume.render.clipping = "FULL", 0.0
    place(volume, medium).matrix_world = Matrix.Rotation(math.radians(90), 4, "X")
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit, camera.angle_y = "VERTICAL", math.radians(VERTICAL_FOV)
    scene.camera = place(camera)
    scene.camera.location = blender(EYE)
    scene.camera.rotation_euler = (blender(TARGET) - blender(EYE)).to_track_quat("-Z", "Y").to_euler()
    scene.render.engine = "CYCLES"
    for setting, value in {
        "device": "CPU", "samples": spp, "use_adaptive_sampling": False, "use_denoising": False, "pixel_filter_type": "BOX", "filter_width": 1.0,
        "sampling_pattern": "TABULATED_SOBOL", "light_sampling_threshold": 0.0, "sample_clamp_direct": 0.0, "sample_clamp_indirect": 0.0,
        "max_bounces": 1024, "diffuse_bounces": 1024, "volume_bounces": 1024, "transparent_max_bounces": 1024, "volume_biased": False,
    }.items():
        setattr(scene.cycles, setting, value)
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = WIDTH, HEIGHT, 100
    scene.view_settings.view_transform = "Raw"
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth, settings.exr_codec = "OPEN_EXR", "RGB", "32", "ZIP"
    path = FOLDER / "one.exr"
    scene.render.filepath = str(path)
    started, images = time.time(), []
    for seed in range(seeds):
        scene.cycles.seed = seed + 1
        bpy.ops.render.render(write_still=True)
        images.append(OpenEXR.File(str(path)).channels()["RGB"].pixels.copy())
    path.unlink()
    save("cycles", images, started, {"renderer": f"Cycles of Blender {bpy.app.version_string}, unbiased volumes", "spp": spp})


{"mitsuba": mitsuba, "cycles": cycles}[sys.argv[1]](*map(int, sys.argv[2:]))
