"""Write a spec as MJCF text that compiles to the same numbers.

MuJoCo's own writer rounds to six digits. It is kept for structure, and every rounded number is replaced
by the spec's exact one; a value that does not agree with the rounded one is left alone.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np

from contarm_sim.mjcf.build import arm_spec, scene_spec
from contarm_sim.mjcf.host import CLASS
from contarm_sim.mjcf.muscles import Actuation
from contarm_sim.mjcf.names import BASE
from contarm_sim.mjcf.overlaps import STRAIGHT, refuse_overlaps
from contarm_sim.model.arm import Arm

_MUSCLE = re.compile(r"(section_\d+_)?muscle_\d+")
"""Names of what belongs to the arm's muscles."""

_RENAMED = {"diaginertia": "inertia"}
_ATTRIBUTES_OF = {"general": "actuator", "spatial": "tendon", "fixed": "tendon", "inertial": "body"}


def exact_xml(spec: mujoco.MjSpec, folder: Path | None = None) -> str:
    """Return the spec as MJCF with full-precision numbers.

    Args:
        folder: where it is going to be, into which the files of its meshes are copied; default: they stay where they
            are, and are named by their whole paths.
    """
    spec.compile()
    root = ElementTree.fromstring(spec.to_xml())
    if folder is not None:
        _bring(spec, root, folder)
    option = root.find("option")
    if option is not None:
        _restore(option, spec.option)
    _restore_section(root, spec)
    _tell_classes_apart(root)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def write_models(arm: Arm, folder: Path, actuation: Actuation = "lengths") -> None:
    """Write arm.xml and scene.xml into an existing folder, and the files of meshes beside them.

    Raises:
        InputError: an unknown actuation, objects that the engine cannot make, or that overlap the straight arm.
    """
    own, scene = arm_spec(arm, actuation), scene_spec(arm, actuation)
    _refuse_overlaps(arm, own)
    for spec, name in ((own, "arm.xml"), (scene, "scene.xml")):
        (folder / name).write_text(exact_xml(spec, folder))


def _refuse_overlaps(arm: Arm, spec: mujoco.MjSpec) -> None:
    """Refuse what overlaps in the keyframe `straight`, which the files begin with."""
    if arm.world.touchable:
        model = spec.compile()
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        mujoco.mj_forward(model, data)
        refuse_overlaps(arm, model, data, STRAIGHT)


def _bring(spec: mujoco.MjSpec, root: ElementTree.Element, folder: Path) -> None:
    """Copy the files of a spec's meshes into a folder, each under its mesh's name, and name them so in its MJCF.

    In a host, whose own files stay where they are, all are named by their whole paths.
    """
    files, hosted = {mesh.name: Path(mesh.file) for mesh in spec.meshes}, bool(spec.meshdir)
    for element in root.iter("mesh"):
        file = files.get(element.get("name", ""), Path())
        if element.get("file") is None or (hosted and not file.is_absolute()):
            continue
        copied = f"{element.get('name')}{file.suffix.lower()}"
        shutil.copyfile(file, folder / copied)
        if not hosted:
            element.set("file", copied)


def _tell_classes_apart(root: ElementTree.Element) -> None:
    """Rename the arm's defaults classes where its host has classes of these names, such as `collision`."""
    every = {element.get("class"): element for element in root.iter("default")}
    if CLASS not in every:
        return
    own = [element.get("class") for element in every[CLASS] if element.tag == "default"]
    taken = [element.get("class") for element in root.iter("default") if element not in list(every[CLASS])]
    renamed = {name: f"{CLASS}_{name}" for name in own if name in taken}
    muscles = [*root.findall("actuator"), *root.findall("tendon")]
    parts = [each for kind in muscles for each in kind if _MUSCLE.match(each.get("name", ""))]
    for body in root.iter("body"):
        if body.get("name") == BASE:
            parts += body.iter()
    for part in [*every[CLASS], *parts]:
        if part.get("class") in renamed:
            part.set("class", renamed[part.get("class")])


def _restore_section(element: ElementTree.Element, spec: mujoco.MjSpec) -> None:
    for child in element:
        name = child.get("name")
        if child.tag == "default" and child.get("class"):
            default = spec.find_default(child.get("class"))
            for part in child:
                _restore(part, getattr(default, _ATTRIBUTES_OF.get(part.tag, part.tag), None))
        elif child.tag == "inertial":
            _restore(child, spec.body(element.get("name")))
        elif name is not None:
            find = getattr(spec, _ATTRIBUTES_OF.get(child.tag, child.tag), None)
            if callable(find):
                _restore(child, find(name))
            if child.tag == "fixed":
                for joint, wrap in zip(child, spec.tendon(name).path, strict=True):
                    _restore(joint, wrap)
            if child.tag == "spatial":  # the compiler's own, rounded; it finds it again
                child.attrib.pop("springlength", None)
        _restore_section(child, spec)


def _restore(element: ElementTree.Element, source: Any) -> None:
    for attribute, text in element.attrib.items():
        name = _RENAMED.get(attribute, "ipos" if (element.tag, attribute) == ("inertial", "pos") else attribute)
        try:
            rounded = np.array(text.split(), dtype=float)
            value = np.asarray(getattr(source, name))
            exact = value.astype(float).ravel()[: rounded.size]
        except (AttributeError, TypeError, ValueError):
            continue
        if value.dtype == np.float32:  # colours and the like: six digits say more than the number holds
            continue
        if exact.size == rounded.size and np.allclose(exact, rounded, rtol=1e-5, atol=1e-12):
            element.set(
                attribute, " ".join(f"{x:.17g}" if f"{x:.15g}" != repr(float(x)) else f"{x:.15g}" for x in exact)
            )
