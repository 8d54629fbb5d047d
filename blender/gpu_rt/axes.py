"""The axes of Blender and of the scene file."""


def placed(vector):
    """A point or a direction of Blender in the axes of the scene file. Blender's z is up, and its images of the world have +x in the
    middle. The scene file has y up, and -z in the middle."""
    x, y, z = vector
    return (-y, z, -x)
