"""The words of a scene file."""


def text(words):
    """A text in quotes. Names of Blender may hold any character."""
    words = "".join(letter if letter.isprintable() else " " for letter in words)
    return '"' + words.replace("\\", "\\\\").replace('"', '\\"') + '"'


def point(vector):
    return "(" + ", ".join(repr(float(number)) for number in vector) + ")"


def placed(vector):
    """A point or a direction of Blender in the axes of the scene file. Blender's z is up, and its images of the world have +x in the
    middle. The scene file has y up, and -z in the middle."""
    x, y, z = vector
    return (-y, z, -x)
