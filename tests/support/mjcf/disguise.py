"""Copies of a model that move like it: saved by MuJoCo, or with other names and orders."""

from __future__ import annotations

import random
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco

KEPT = ("class", "childclass", "file", "type", "objtype", "reftype")
"""Attributes whose values are no names of elements."""

SHUFFLED = ("worldbody", "body", "actuator", "equality", "sensor", "contact")
"""Elements whose children may stand in any order, but for joints and what comes before them."""

IN_ORDER = ("joint", "freejoint", "inertial")


def disguised(text: str, seed: int = 1) -> str:
    """Return a model with all names changed, siblings in another order, and no keyframes.

    Those have columns by the order of joints. Skins are left out, which name bodies in their text.
    """
    root = ET.fromstring(re.sub("<keyframe>.*</keyframe>", "", text, flags=re.DOTALL))
    for deformable in root.findall("deformable"):
        for skin in deformable.findall("skin"):
            deformable.remove(skin)
    shuffler = random.Random(seed)
    named = {one.get("name") for one in root.iter() if one.get("name")} - {None}
    for element in root.iter():
        for key, value in element.attrib.items():
            if value in named and key not in KEPT:
                element.set(key, f"other_{value}")
        if element.tag in SHUFFLED:
            joints = [one for one in element if one.tag in IN_ORDER]
            others = [one for one in element if one not in joints]
            shuffler.shuffle(others)
            element[:] = [*joints, *others]
    return ET.tostring(root, encoding="unicode")


def saved(path: Path) -> str:
    """Return a model as MuJoCo writes it."""
    model = mujoco.MjModel.from_xml_path(str(path))
    copy = path.with_name("mbcheck_saved.xml")
    mujoco.mj_saveLastXML(str(copy), model)
    return copy.read_text(encoding="utf-8")
