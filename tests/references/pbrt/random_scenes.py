"""Renders random grey scenes by gpu-rt and by pbrt-r4 (make.py says how to get it), and prints those whose images differ by more than noise:
`python random_scenes.py FIRST LAST`, in a folder for them. A seed is a scene.

What pbrt renders otherwise by itself is left out: caustics of delta lights, scales before the camera, rough layers beside lamps, and lamps that are
parts of quadrics or their mirror images.
"""

import os
import random
import shutil
import subprocess
import sys
from pathlib import Path

HEAD = """Integrator "volpath" "integer maxdepth" {depth}
Film "rgb" "integer xresolution" 64 "integer yresolution" 48 "bool savefp16" false "float iso" {iso}{crop}
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
{mirror}LookAt {x:.3f} {y:.3f} {z:.3f} 0 0 0 {tilt:.3f} 1 0
Camera {camera}
WorldBegin
"""
MESH = 'Shape "trianglemesh" "point3 P" [-.8 -.6 0 .9 -.5 .2 0 .8 -.3 .2 .1 .9] "integer indices" [0 1 2 0 3 1 1 3 2 2 3 0]'
SQUARE = 'Shape "bilinearmesh" "point3 P" [-.7 -.7 0 .7 -.7 0 -.7 .7 0 .7 .7 0]'
DELTA = (
    'LightSource "point" "point3 from" [2 3 3] "rgb I" [6 6 6]\n',
    'LightSource "spot" "point3 from" [2 3 3] "point3 to" [0 0 0] "float coneangle" 25 "float conedeltaangle" 10 "rgb I" [20 20 20]\n',
    'LightSource "distant" "point3 from" [1 2 2] "point3 to" [0 0 0] "rgb L" [1 1 1]\n',
)


class Maker:
    def __init__(self, seed):
        self.r, self.names = random.Random(seed), 0

    def grey(self, low=0.2, high=0.8):
        return "[{0:.3f} {0:.3f} {0:.3f}]".format(self.r.uniform(low, high))

    def turn(self):
        u = self.r.uniform
        return f"Rotate {u(0, 360):.2f} {u(-1, 1):.3f} {u(-1, 1):.3f} {u(0.1, 1):.3f}\n"

    def name(self):
        self.names += 1
        return f"n{self.names}"

    def material(self, is_matt):
        u, grey = self.r.uniform, self.grey
        matt = ["diffuse", "both", "mapped", "squares"]
        kind = self.r.choice(matt if is_matt else matt + ["mirror", "brushed", "glass", "frosted", "pane", "glazed", "mix"])
        name = self.name()
        ior = f'"float eta" {u(1.1, 2):.3f}'
        return {
            "diffuse": f'Material "diffuse" "rgb reflectance" {grey()}\n',
            "both": f'Material "diffusetransmission" "rgb reflectance" {grey(0.1, 0.5)} "rgb transmittance" {grey(0.1, 0.5)}\n',
            "mapped": f'Texture "{name}" "spectrum" "imagemap" "string filename" "texels.exr" "float uscale" {u(0.5, 3):.3f} "float udelta" {u(0, 1):.3f} '
            f'"float scale" {u(0.3, 1):.3f}\nMaterial "diffuse" "texture reflectance" "{name}"\n',
            "squares": f'Texture "{name}" "spectrum" "checkerboard" "float uscale" {self.r.randint(1, 6)} "float vscale" {self.r.randint(1, 6)} '
            f'"rgb tex1" {grey()} "rgb tex2" {grey()}\nMaterial "diffuse" "texture reflectance" "{name}"\n',
            "mirror": f'Material "conductor" "rgb reflectance" {grey()}\n',
            "brushed": 'Material "conductor" "rgb eta" [1.5 1.5 1.5] "rgb k" [4 4 4] '
            f'"float uroughness" {u(0.01, 0.5):.3f} "float vroughness" {u(0.01, 0.5):.3f}\n',
            "glass": f'Material "dielectric" {ior}\n',
            "frosted": f'Material "dielectric" {ior} "float roughness" {u(0.01, 0.4):.3f}\n',
            "pane": f'Material "thindielectric" {ior}\n',
            "glazed": f'Material "coateddiffuse" "rgb reflectance" {grey()} "float roughness" 0 {ior} "float thickness" {u(0, 0.02):.4f}\n',
            "mix": f'MakeNamedMaterial "{name}a" "string type" "diffuse" "rgb reflectance" {grey()}\n'
            f'MakeNamedMaterial "{name}b" "string type" "conductor" "rgb reflectance" {grey()} "float roughness" 0.1\n'
            f'Material "mix" "string materials" ["{name}a" "{name}b"] "float amount" {u(0, 1):.3f}\n',
        }[kind]

    def shape(self, material, is_whole=False):
        u = self.r.uniform
        if "dielectric" in material or "uroughness" in material:
            return 'Shape "sphere" "float radius" 0.7\n'
        part = f' "float phimax" {u(90, 360):.1f}' if not is_whole and self.r.random() < 0.5 else ""
        ends = f' "float zmin" {u(-0.8, -0.1):.3f} "float zmax" {u(0.05, 0.8):.3f}' if part else ""
        hole = f' "float innerradius" {u(0.1, 0.3):.3f}' if part else ""
        return self.r.choice([
            f'Shape "sphere" "float radius" {u(0.3, 0.9):.3f}{ends}{part}\n',
            f'Shape "disk" "float radius" {u(0.4, 1):.3f} "float height" {u(-0.3, 0.3):.3f}{hole}{part}\n',
            f'Shape "cylinder" "float radius" {u(0.2, 0.6):.3f} "float zmin" -0.5 "float zmax" {u(0, 0.8):.3f}{part}\n',
            f"{MESH}\n",
            f"{SQUARE}\n",
        ])

    def place(self, scales=("",)):
        u = self.r.uniform
        return f"Translate {u(-2, 2):.3f} {u(-1.5, 1.5):.3f} {u(-1.5, 1.5):.3f}\n" + self.turn() + self.r.choice(scales)

    def lamp(self):
        sides = self.r.choice(["true", "false"])
        material = f'Material "diffuse" "rgb reflectance" {self.grey()}\n'
        reverse = "ReverseOrientation\n" if self.r.random() < 0.3 else ""
        light = f'AreaLightSource "diffuse" "rgb L" {self.grey(1, 5)} "bool twosided" {sides}\n'
        return f"AttributeBegin\n{light}{self.place()}{reverse}{material}{self.shape(material, True)}AttributeEnd\n"

    def thing(self, is_matt):
        u = self.r.uniform
        material = self.material(is_matt)
        scales = ["", "", f"Scale {u(0.5, 1.5):.3f} {u(0.5, 1.5):.3f} {u(0.5, 1.5):.3f}\n", "Scale 1 1 -1\n"]
        place, shape = self.place(scales), self.shape(material)
        if self.r.random() < 0.3:
            name = self.name()
            return f'ObjectBegin "{name}"\n{material}{self.turn()}{shape}ObjectEnd\nAttributeBegin\n{place}ObjectInstance "{name}"\nAttributeEnd\n'
        return f"AttributeBegin\n{material}{place}{shape}AttributeEnd\n"

    def scene(self):
        r, u = self.r, self.r.uniform
        crop = f' "float cropwindow" [{u(0, 0.3):.2f} {u(0.6, 1):.2f} {u(0, 0.3):.2f} {u(0.6, 1):.2f}]' if r.random() < 0.3 else ""
        lens = ' "float lensradius" 0.1 "float focaldistance" 5' if r.random() < 0.3 else ""
        cameras = [f'"perspective" "float fov" {u(35, 70):.2f}{lens}', f'"perspective" "float fov" {u(35, 70):.2f} "float screenwindow" [-1 1.2 -.8 .85]']
        if not crop:
            cameras += ['"orthographic" "float screenwindow" [-3.2 3.2 -2.4 2.4]', '"spherical" "string mapping" "equirectangular"']
        mirror = r.choice(["Scale -1 1 1\n", ""])
        view = {"x": u(-3, 3), "y": u(-1, 3), "z": u(4, 6), "tilt": u(-0.3, 0.3)}
        head = HEAD.format(depth=r.randint(2, 7), iso=r.choice([100, 150]), crop=crop, mirror=mirror, camera=r.choice(cameras), **view)
        image = f'AttributeBegin\n{self.turn()}LightSource "infinite" "string filename" "square.exr" "float scale" {u(0.3, 1):.3f}\nAttributeEnd\n'
        sky = image if r.random() < 0.4 else f'LightSource "infinite" "rgb L" {self.grey(0.1, 0.5)}\n'
        has_delta = r.random() < 0.4
        lights = [r.choice(DELTA)] if has_delta else []
        lights += [self.lamp() for _ in range(r.randint(0, 2))]
        return head + sky + "".join(lights + [self.thing(has_delta) for _ in range(r.randint(3, 6))])


def run(*command):
    return subprocess.run(command, capture_output=True, text=True)


for image in ["square.exr", "texels.exr"]:
    if not Path(image).exists():
        shutil.copy(Path(__file__).parent / image, image)
for seed in range(int(sys.argv[1]), int(sys.argv[2])):
    scene, ours, theirs = f"{seed}.pbrt", f"{seed}-ours.exr", f"{seed}-theirs.exr"
    Path(scene).write_text(Maker(seed).scene())
    found = run(os.environ.get("GPU_RT", "gpu-rt"), "render", scene, "--spp", "64", "-o", ours, "--force", "--quiet")
    if found.returncode:
        print(seed, found.stderr.strip(), flush=True)
        continue
    run("pbrt-r4", scene, "--spp", "512", "--outfile", theirs, "--quiet")
    found = run(os.environ.get("GPU_RT", "gpu-rt"), "compare", ours, theirs)
    verdict = (found.stdout + found.stderr).strip().splitlines()[-1]
    if "noise only" not in verdict:
        print(seed, verdict, flush=True)
