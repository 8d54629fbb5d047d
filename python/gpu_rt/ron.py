"""Writes scenes as the text of a scene file (RON).

A dict with names is a struct, and the dict of materials is a map. A tuple is a tuple, a list a list, but for a list of numbers: scene
files have points and colours as tuples, and no list of numbers. The words of scene files
that begin with a capital are attributes of this module: `ron.Sphere(center=(0, 1, 0), radius=1, material="glass")`,
`ron.Rgb(0.7, 0.2, 0.1)`. docs/scene.md lists them.
"""

from __future__ import annotations

import os
from typing import Any, Mapping

import numpy as np


class Word:
    """A word of the scene file, alone or with what is in its brackets."""

    def __init__(self, name: str, brackets: str = "") -> None:
        self._name, self._brackets = name, brackets

    def __call__(self, *values: Any, **fields: Any) -> Word:
        """The word with values or fields in brackets."""
        parts = [_text(value) for value in values] + [f"{name}: {_text(value)}" for name, value in fields.items()]
        return Word(self._name, f"({', '.join(parts)})")

    def __repr__(self) -> str:
        return self._name + self._brackets


def __getattr__(name: str) -> Word:
    if not name[:1].isupper():
        raise AttributeError(f"no word of scene files is named {name}: they begin with a capital")
    return Word(name)


def dumps(scene: Mapping[str, Any]) -> str:
    """The text of a scene file, a line for each field and each object. TypeError for a value that has no form there."""
    return "Scene(\n" + "".join(f"    {name}: {_field(name, value)},\n" for name, value in scene.items()) + ")\n"


def _field(name: str, value: Any) -> str:
    if name == "materials" and isinstance(value, Mapping):
        return "{\n" + "".join(f"        {_text(str(key))}: {_text(material)},\n" for key, material in value.items()) + "    }"
    if isinstance(value, list):
        return "[\n" + "".join(f"        {_text(item)},\n" for item in value) + "    ]"
    return _text(value)


def _text(value: Any) -> str:
    if isinstance(value, np.longdouble):
        value = float(value)
    elif isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, Word):
        return repr(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        # Subclasses, such as those of enum, have other forms.
        return (int if isinstance(value, int) else float).__repr__(value)
    if isinstance(value, os.PathLike):
        value = os.fsdecode(value)
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, tuple) or isinstance(value, list) and value and all(map(_is_number, value)):
        return f"({', '.join(map(_text, value))})"
    if isinstance(value, list):
        return f"[{', '.join(map(_text, value))}]"
    if isinstance(value, Mapping):
        return f"({', '.join(f'{name}: {_text(field)}' for name, field in value.items())})"
    raise TypeError(f"a scene file has no form for {value!r}")


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
