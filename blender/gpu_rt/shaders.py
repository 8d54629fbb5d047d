"""What the shader nodes of a material mean, as one surface: a transparent share, what emits, and closures with their shares.

A value is three numbers, or an operation and its values: ("from", socket, groups) is what an output says, ("grey", value) its brightness, and
("fresnel", ior) Fresnel's reflectance. Nothing here changes the file, so that the panel may ask, too.
"""

import operator
from collections import namedtuple
from math import sqrt

ZERO, HALF, GREY, ONE = ((number,) * 3 for number in (0.0, 0.5, 0.8, 1.0))
# Outputs that depend on the view, which no image can hold.
OF_VIEW = {"View Vector", "View Z Depth", "View Distance", "Incoming", "Camera", "Window", "Reflection"}
MATT_OR_GLOSSY = {"BSDF_DIFFUSE", "BSDF_TRANSLUCENT", "BSDF_GLOSSY"}
KNOWN = {*MATT_OR_GLOSSY, "BSDF_METALLIC", "BSDF_GLASS", "BSDF_REFRACTION", "BSDF_SHEEN", "BSDF_PRINCIPLED"}

# `solid` is the share of closures, and `parts` are pairs of a share of it and a closure.
Surface = namedtuple("Surface", "through solid emission parts", defaults=(ZERO, ZERO, ZERO, ()))
Closure = namedtuple("Closure", "kind node path")


def is_number(value):
    return not isinstance(value[0], str)


def mul(a, b):
    if is_number(a) and is_number(b):
        return tuple(map(operator.mul, a, b))
    a, b = (a, b) if is_number(a) else (b, a)
    if a in (ZERO, ONE):
        return b if a == ONE else ZERO
    return ("mul", mul(a, b[1]), b[2]) if is_number(a) and b[0] == "mul" and is_number(b[1]) else ("mul", a, b)


def add(a, b):
    if is_number(a) and is_number(b):
        return tuple(map(operator.add, a, b))
    return b if a == ZERO else a if b == ZERO else ("add", a, b)


def sub(a, b):
    if is_number(a) and is_number(b):
        return tuple(map(operator.sub, a, b))
    # 1 - (1 - x)
    return a if b == ZERO else b[2] if b[:2] == ("sub", a) else ("sub", a, b)


def div(a, b):
    if is_number(b):
        return mul(a, tuple(1 / x if x else 0.0 for x in b))
    return a if a == ZERO else ONE if a == b else a[1 if a[2] == b else 2] if a[0] == "mul" and b in a else ("div", a, b)


OPERATIONS = {"mul": mul, "add": add, "sub": sub, "div": div}


def mix(a, b, share):
    return a if a == b else add(mul(a, sub(ONE, share)), mul(b, share))


def replaced(value, of, by):
    """The value with one of its parts replaced."""
    if value == of or is_number(value) or value[0] not in OPERATIONS:
        return by if value == of else value
    return OPERATIONS[value[0]](*(replaced(part, of, by) for part in value[1:]))


def fresnels(value):
    if is_number(value) or value[0] not in OPERATIONS:
        return {value} if value[0] == "fresnel" else set()
    return set().union(*map(fresnels, value[1:]))


def mean_fresnel(ior):
    """The mean of Fresnel's reflectance over matt light."""
    total, ior = 0.0, max(ior, 1e-3)
    for cosine in ((step + 0.5) / 64 for step in range(64)):
        root = sqrt(max(ior * ior - 1 + cosine * cosine, 0.0))
        s, p = (cosine - root) / (cosine + root), (ior * ior * cosine - root) / (ior * ior * cosine + root)
        total += (s * s + p * p) * cosine / 64
    return (total,) * 3


def mean_of_rays(out):
    """What stands for an output that differs by the ray. None for others."""
    node, number = out.node, getattr(out.node.inputs[0], "default_value", 0.0) if len(out.node.inputs) else 0.0
    if node.type == "FRESNEL":
        return mean_fresnel(number)
    if node.type == "LAYER_WEIGHT":
        # 1 - cos^blend where it is not Fresnel's.
        blend = 2 * number if number < 0.5 else 0.5 / max(1 - number, 1e-5)
        return mean_fresnel(1 / max(1 - number, 1e-5)) if out.identifier == "Fresnel" else (1 - 2 / (blend + 2),) * 3
    if node.type == "LIGHT_PATH":
        return ONE if out.identifier == "Is Camera Ray" else ZERO
    return ZERO if out.identifier == "Backfacing" else None


def source(socket, path):
    """The output that an input has its value from, with the groups around it: the input itself where nothing is linked, and None where a
    muted node or a group passes nothing on."""
    while socket is not None:
        link = next((link for link in socket.links if link.is_valid and not link.is_muted), None)
        if link is None:
            return socket, path
        node, out = link.from_node, link.from_socket
        if node.type == "GROUP_INPUT" and path:
            ends, path = path[-1].inputs, path[:-1]
        elif node.mute:
            ends = [inner.from_socket for inner in node.internal_links if inner.to_socket == out]
            out = ends[0] if ends else out
        elif node.type == "REROUTE":
            out, = ends = node.inputs
        elif node.type == "GROUP":
            inner = [inner for inner in (node.node_tree.nodes if node.node_tree else ()) if inner.type == "GROUP_OUTPUT"]
            ends, path = next((end.inputs for end in inner if end.is_active_output), ()), (*path, node)
        else:
            return out, path
        socket = next((end for end in ends if end.identifier == out.identifier), None)
    return None, path


def before(value):
    """The outputs that a value depends on, each once, with the groups around them."""
    if is_number(value) or value[0] != "from":
        parts = () if is_number(value) or value[0] == "fresnel" else value[1:]
        return list(dict.fromkeys(found for part in parts for found in before(part)))
    found, waiting = {}, [value[1:]]
    while waiting:
        out, path = waiting.pop()
        if out is not None and out.is_output and (out, path) not in found:
            found[out, path] = True
            waiting += [source(socket, path) for socket in out.node.inputs]
    return list(found)


class Reader:
    """Reads a material. `notes` has what is not as Cycles means it."""

    def __init__(self):
        self.notes, self._known = {}, {}

    def note(self, words):
        self.notes[words] = True

    def value(self, socket, path):
        """What an input of a node is."""
        out, path = source(socket, path)
        if out is None:
            return ZERO
        node = out.node
        if not out.is_output or node.type in ("RGB", "VALUE"):
            number = out.default_value
            return tuple(number)[:3] if hasattr(number, "__len__") else (number,) * 3
        inputs = {each.identifier: each for each in node.inputs}
        if node.type == "FRESNEL" or out.identifier == "Fresnel":
            number = self.value(node.inputs[0], path)
            if is_number(number):
                return "fresnel", number[0] if node.type == "FRESNEL" else 1 / max(1 - number[0], 1e-5)
        elif node.type == "MATH" and node.operation == "MULTIPLY" and not node.use_clamp:
            return mul(*(self.value(each, path) for each in node.inputs[:2]))
        elif node.type == "MIX" and (node.data_type, node.blend_type, node.clamp_result) == ("RGBA", "MULTIPLY", False):
            if self.value(inputs["Factor_Float"], path) == ONE:
                return mul(self.value(inputs["A_Color"], path), self.value(inputs["B_Color"], path))
        value = "from", out, path
        for inner, _ in before(value):
            if mean_of_rays(inner):
                self.note(f"{inner.node.bl_label}: the same for all rays")
            elif inner.identifier in OF_VIEW:
                self.note(f"{inner.node.bl_label}: grey 0.8 stands for what depends on the view")
                return GREY
        return mean_of_rays(out) or (("grey", value) if socket.type == "VALUE" and out.type == "RGBA" else value)

    def of_material(self, material):
        """The surface of a material, as Cycles means it."""
        if not getattr(material, "use_nodes", True) or not material.node_tree:
            return Surface(solid=ONE, parts=((ONE, Closure("BSDF_DIFFUSE", material, ())),))
        output = material.node_tree.get_output_node("CYCLES")
        surface = self.of_socket(output.inputs["Surface"], ()) if output else Surface()
        # Fresnel's share stays where there is a model for it: gloss over one matt closure, or over what is transparent.
        found = set().union(*map(fresnels, (surface.through, surface.emission, *(weight for weight, _ in surface.parts))))
        gloss = [weight for weight, closure in surface.parts if closure.kind == "BSDF_GLOSSY"]
        others = [closure.kind for _, closure in surface.parts if closure.kind != "BSDF_GLOSSY"]
        is_layer = gloss == list(found) and len(others) == 1 and others[0] in MATT_OR_GLOSSY and surface.solid == ONE
        is_pane = gloss == [ONE] and not others and found == {surface.solid}
        for fresnel in () if is_layer or is_pane else found:
            self.note("Fresnel: the same for all rays")
            by = lambda value: replaced(value, fresnel, mean_fresnel(fresnel[1]))
            surface = Surface(*map(by, surface[:3]), [(by(weight), closure) for weight, closure in surface.parts])
        return surface

    def of_socket(self, socket, path):
        found = source(socket, path)
        if found not in self._known:
            # A colour is light.
            is_colour = found[0] is not None and found[0].is_output and found[0].type != "SHADER"
            self._known[found] = Surface(emission=self.value(socket, path)) if is_colour else self._of_output(*found)
        return self._known[found]

    def _of_output(self, out, path):
        if out is None or not out.is_output:
            return Surface()
        node = out.node
        value = lambda name: self.value(node.inputs[name], path)
        if node.type == "MIX_SHADER":
            share = value(0)
            share = tuple(min(max(x, 0.0), 1.0) for x in share) if is_number(share) else share
            return joined(*(self.of_socket(node.inputs[index], path) for index in (1, 2)), lambda a, b: mix(a, b, share), share)
        if node.type == "ADD_SHADER":
            return joined(*(self.of_socket(each, path) for each in node.inputs), add, ONE)
        if node.type in ("EMISSION", "BACKGROUND"):
            return Surface(emission=mul(value("Color"), value("Strength")))
        if node.type == "BSDF_TRANSPARENT":
            return Surface(through=value("Color"))
        kind = "BSDF_GLOSSY" if node.type == "BSDF_ANISOTROPIC" else node.type
        if kind not in KNOWN:
            self.note(f"{node.bl_label}: a Diffuse BSDF of its colour stands for it")
            kind = "BSDF_DIFFUSE"
        surface = Surface(solid=ONE, parts=((ONE, Closure(kind, node, path)),))
        if kind == "BSDF_PRINCIPLED":
            alpha, light = value("Alpha"), mul(value("Emission Color"), value("Emission Strength"))
            surface = surface._replace(through=sub(ONE, alpha), solid=alpha, emission=mul(light, alpha))
        return surface

    def parameters(self, surface):
        """The inputs of a Principled BSDF that stands for a surface, and what else glTF has: `transmitted` is the share of matt light that
        leaves on the far side, in the colour Specular Tint. Glass is a `body` or a `pane`. Microfacets have `multiscatter`."""
        through, solid, emission, parts = surface
        fresnel = next(iter(fresnels(through)), None)
        is_coloured = is_number(through) and len(set(through)) > 1
        if fresnel:
            self.note("Fresnel: from behind, it reflects as from the front")
        if fresnel or (is_coloured and not parts and emission == ZERO):
            # What passes a pane is not bent. It reflects by Fresnel's equations, or without them nothing.
            own = {"Roughness": self.one(parts[0][1])["Roughness"], "IOR": (fresnel[1],) * 3} if fresnel else {"Roughness": ZERO, "IOR": ONE}
            return {**own, "Base Color": replaced(through, fresnel, ZERO), "Transmission Weight": ONE, "pane": True}
        if is_coloured:
            self.note("Transparent BSDF: grey stands for its colour")
        alpha = sub(ONE, (sum(through) / 3,) * 3 if is_number(through) else through)
        if is_number(alpha):
            # Only a surface emits, so that of light alone a little stays.
            least = 0.0 if emission == ZERO else 1 / 32
            if alpha[0] < least:
                self.note("Transparent BSDF: where it emits, it lets 31/32 pass at most")
            alpha = (min(max(alpha[0], least), 1.0),) * 3
        scale = div(solid, alpha) if parts else ONE
        if is_number(scale) and scale[0] > 1.001:
            self.note("Add Shader: it returns no more light than there is")
        parts = [(mul(weight, scale), closure) for weight, closure in parts]
        if {closure.kind for _, closure in parts} <= MATT_OR_GLOSSY:
            found = self.matt_and_glossy(parts)
        elif len(parts) == 1:
            found = self.one(parts[0][1])
        else:
            self.note(f"Mix of {' and '.join(sorted({closure.node.bl_label for _, closure in parts}))}: their values are mixed")
            found = self.mixed(parts)
        if "MULTI_GGX" in {getattr(node, "distribution", "") for _, (kind, node, _) in parts if kind != "BSDF_PRINCIPLED"}:
            found["multiscatter"] = True
        for name in ("Normal", "Coat Normal"):
            links = [(each.node.inputs[name], each.path) for _, each in parts if name in getattr(each.node, "inputs", ())]
            for out, path in [source(*link) for link in links if link[0].is_linked][:1]:
                if out is not None and out.is_output and out.node.type == "NORMAL_MAP":
                    found[name] = "from", out, path
                else:
                    self.note("its bumps: only a Normal Map is read")
        if found.get("Transmission Weight") == ONE and (alpha, emission) != (ONE, ZERO):
            # What is glass and nothing else has neither.
            found["Transmission Weight"] = (0.9999,) * 3
        elif "body" in found:
            # The program takes the colour for that of the body, and gives each of its two surfaces the root.
            colour = found["Base Color"]
            found["Base Color"] = mul(colour, colour if is_number(colour) else colour[1] if colour[0] == "mul" and is_number(colour[1]) else ONE)
        return {"Base Color": ZERO, "Specular IOR Level": ZERO, "Roughness": ONE, **found, "Alpha": alpha, "Emission Color": div(emission, alpha)}

    def matt_and_glossy(self, parts):
        """Gloss as a layer that reflects the same from all sides, or as Fresnel has it, over what is matt."""
        weights, colours, roughness = dict.fromkeys(MATT_OR_GLOSSY, ZERO), dict.fromkeys(MATT_OR_GLOSSY, ZERO), ZERO
        for weight, closure in parts:
            values, kind = self.one(closure), closure.kind
            weights[kind], colours[kind] = add(weights[kind], weight), add(colours[kind], mul(weight, values["Base Color"]))
            roughness = add(roughness, mul(weight, values["Roughness"])) if kind == "BSDF_GLOSSY" else roughness
        (near, far, gloss), (of_near, of_far, layer) = ([of[kind] for kind in ("BSDF_DIFFUSE", "BSDF_TRANSLUCENT", "BSDF_GLOSSY")] for of in (colours, weights))
        found, matt = {"Roughness": div(roughness, layer)}, sub(ONE, layer)
        if layer[0] == "fresnel":
            found.update({"IOR": (layer[1],) * 3, "Specular IOR Level": HALF, "Specular Tint": div(gloss, layer)})
        elif layer != ZERO:
            layer = (min(max(gloss), 1.0),) * 3 if is_number(gloss) else layer
            # With an infinite index the layer reflects its share and no less.
            found.update({"IOR": (1000.0,) * 3, "Specular IOR Level": mul(layer, HALF), "Specular Tint": div(gloss, layer)})
            matt = sub(ONE, layer)
        near, far = div(near, matt), div(far, matt)
        if far == ZERO:
            return {**found, "Base Color": near}
        if not all(map(is_number, (of_near, of_far, layer))):
            self.note("Translucent BSDF: its share varies, so that colours above 0.5 are cut")
        if layer != ZERO:
            self.note("Translucent BSDF: it has the tint of the gloss")
        share = HALF if not (is_number(of_near) and is_number(of_far)) else div(of_far, add(of_near, of_far))
        if is_number(near) and is_number(far):
            share = (max(far) / (max(far) + max(near)),) * 3
        found.update({"Base Color": div(near, sub(ONE, share)), "transmitted": share[0]})
        return found if layer != ZERO else {**found, "Specular Tint": div(far, share)}

    def one(self, closure):
        """The inputs of a Principled BSDF that stands for one closure, beside its normals, alpha and emission."""
        kind, node, path = closure
        if not path and not hasattr(node, "inputs"):
            return {"Base Color": tuple(node.diffuse_color)[:3], "Roughness": ONE}
        values = {each.name: self.value(each, path) for each in node.inputs if each.type in ("VALUE", "RGBA")}
        if kind == "BSDF_PRINCIPLED":
            return {name: value for name, value in values.items() if name not in ("Alpha", "Weight") and not name.startswith("Emission")}
        for name in ("Anisotropy", "Thin Film Thickness", "Roughness"):
            if values.get(name, ZERO) != ZERO and (name != "Roughness" or node.type == "BSDF_DIFFUSE"):
                self.note(f"{node.bl_label}: its {name.lower()}")
        colour = next((values[each.name] for each in node.inputs if each.type == "RGBA"), GREY)
        found = {"Base Color": colour, "Roughness": values.get("Roughness", ONE)}
        if getattr(node, "fresnel_type", "") == "PHYSICAL_CONDUCTOR":
            self.note(f"{node.bl_label}: only its Base Color is read")
        if kind in ("BSDF_GLOSSY", "BSDF_METALLIC"):
            return {**found, "Metallic": ONE}
        if kind == "BSDF_SHEEN":
            return {"Base Color": ZERO, "Sheen Weight": ONE, "Sheen Tint": colour, "Sheen Roughness": found["Roughness"], "Roughness": ONE}
        if kind not in ("BSDF_GLASS", "BSDF_REFRACTION"):
            return {**found, "transmitted": 1.0} if kind == "BSDF_TRANSLUCENT" else found
        ior = values["IOR"]
        for is_off, words in (
            (not is_number(colour) or min(colour) < 0.9, "what it reflects has no colour"),
            (kind == "BSDF_REFRACTION" and ior != ONE, "it reflects, too"),
            (is_number(ior) and ior[0] < 1, "its IOR is 1.5, as none below 1 is read"),
            (node.distribution == "MULTI_GGX" and found["Roughness"] != ZERO, "what its microfacets scatter more than once is lost"),
        ):
            if is_off:
                self.note(f"{node.bl_label}: {words}")
        return {**found, "IOR": ior, "Transmission Weight": ONE, "body": True}

    def mixed(self, parts):
        """The means of the inputs of several closures."""
        each = [(weight, {"Specular IOR Level": ZERO, "Specular Tint": ONE, "IOR": (1.5,) * 3, **self.one(closure)}) for weight, closure in parts]
        found = {}
        for name in dict.fromkeys(name for _, values in each for name in values):
            known = [(weight, values.get(name, ZERO)) for weight, values in each]
            if name in ("body", "transmitted"):
                found[name] = name == "body" or sum(weight[0] * value for weight, value in known if is_number(weight) and value != ZERO)
            elif len({value for _, value in known}) == 1:
                found[name] = known[0][1]
            else:
                found[name] = ZERO
                for weight, value in known:
                    found[name] = add(found[name], mul(weight, value))
        return found


def joined(a, b, join, share):
    """Two surfaces as one: `join` takes their values, and `share` is that of the second."""
    solid = join(a.solid, b.solid)
    if a.parts and b.parts:
        share = share if join is not add and a.solid == b.solid else div(mul(share, b.solid), solid)
        weights = {}
        for of, each in ((sub(ONE, share), a), (share, b)):
            for weight, closure in each.parts:
                weights[closure] = add(weights.get(closure, ZERO), mul(weight, of))
        parts = [(weight, closure) for closure, weight in weights.items()]
    else:
        parts = a.parts or b.parts
    return Surface(join(a.through, b.through), solid, join(a.emission, b.emission), parts)
