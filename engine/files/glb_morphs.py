"""Morph targets of GLB files: their names, their default weights, and the displacements they stand for."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from engine.errors import InputError
from engine.files.glb_rig_out import MEAN_KEY
from engine.files.glb_scene import Instance, numbers, numbers_of
from engine.files.gltf_data import GltfData
from engine.mesh import FloatArray

_LONGEST_NAME = 256
_MOST_TARGETS = 100_000
_LARGEST_WEIGHT = 1e6


@dataclass
class MorphTargets:
    """What the meshes of a scene call their targets; ``add`` it mesh by mesh.

    ``names`` are those of all meshes, each once, in the order they come; ``weights`` the ones they rest at; ``mean``
    the name of the target that is a mean.
    """

    names: list[str] = field(default_factory=list)
    weights: dict[str, float] = field(default_factory=dict)
    mean: str | None = None
    unnamed: int = 0
    read: int = 0
    _known: dict[int, list[str]] = field(default_factory=dict)
    _rested: set[int] = field(default_factory=set)

    def add(self, data: GltfData, instance: Instance) -> list[str]:
        """Return the names of the targets of a primitive, in their order.

        Raises
        ------
        InputError
            When the mesh's primitives have different numbers of targets, a name stands for two of them, or there are
            more targets than a face has.
        """
        targets = instance.primitive.get("targets", [])
        if not isinstance(targets, list):
            raise data.wrong(f"{instance.where}.targets", "is no list")
        self.read += len(targets)
        if self.read > _MOST_TARGETS:
            problem = f"more than {_MOST_TARGETS} targets are in the scene"
            raise data.wrong("meshes", problem, "join its parts, or export the face")
        mesh = data.item("meshes", instance.mesh)
        if instance.mesh not in self._known:
            self._known[instance.mesh] = self._named(data, instance, mesh, len(targets))
        names = self._known[instance.mesh]
        if len(names) != len(targets):
            problem = f"has {len(targets)} targets, another of its mesh {len(names)}"
            raise data.wrong(instance.where, problem)
        if instance.node not in self._rested:
            self._rested.add(instance.node)
            self._rest(data, instance, mesh, names)
        return names

    def _named(self, data: GltfData, instance: Instance, mesh: dict[str, Any], count: int) -> list[str]:
        names, unnamed = target_names(data, instance.mesh, mesh, instance.primitive, count)
        self.unnamed += unnamed
        self.names += [name for name in names if name not in set(self.names)]
        return names

    def _rest(self, data: GltfData, instance: Instance, mesh: dict[str, Any], names: list[str]) -> None:
        """Remember default weights (a node's win over its mesh's) and the mean."""
        listed = data.item("nodes", instance.node).get("weights", mesh.get("weights"))
        weights = None if listed is None else numbers(listed, len(names))
        if listed is not None and (weights is None or not (np.abs(weights) < _LARGEST_WEIGHT).all()):
            raise data.wrong(f"meshes[{instance.mesh}].weights", f"is not {len(names)} numbers")
        for name, weight in zip(names, [0.0] * len(names) if weights is None else weights.tolist(), strict=True):
            self.weights[name] = weight
        marked = mean_name(mesh)
        if marked in names:
            self.mean = marked


def target_names(
    data: GltfData, number: Any, mesh: dict[str, Any], primitive: dict[str, Any], count: int
) -> tuple[list[str], int]:
    """Return the names of a mesh's targets, and how many it does not tell: they are ``shape 1``, ...

    Raises
    ------
    InputError
        When a name stands for several of them.
    """
    given = next((found for found in map(_listed, (mesh, primitive)) if found is not None), [])
    names = [_word(given[k]) if k < len(given) and _word(given[k]) else f"shape {k + 1}" for k in range(count)]
    known: set[str] = set()
    double = next((name for name in names if name in known or known.add(name)), None)  # type: ignore[func-returns-value]
    if double is not None:
        problem = f"{double!r} stands for several shapes"
        raise data.wrong(f"meshes[{number}]", problem, "give every shape a name of its own")
    return names, sum(k >= len(given) or not _word(given[k]) for k in range(count))


def mean_name(mesh: dict[str, Any]) -> str | None:
    """Return the name of the target that a mesh says is its mean."""
    extras = mesh.get("extras")
    marked = extras.get(MEAN_KEY) if isinstance(extras, dict) else None
    return _word(marked) or None if isinstance(marked, str) else None


def displacement(data: GltfData, instance: Instance, number: int, count: int) -> FloatArray | None:
    """Return the displacements (count, 3) of a primitive's target where its node puts them; None where it has none.

    Raises
    ------
    InputError
        When the target has another number of vertices than the primitive.
    """
    where = f"{instance.where}.targets[{number}]"
    target = instance.primitive["targets"][number]
    if not isinstance(target, dict):
        raise data.wrong(where, "is no target")
    if "POSITION" not in target:
        return None
    try:
        values = numbers_of(*data.accessor(target["POSITION"], ("VEC3",)))
    except InputError as error:
        raise data.wrong(f"{where}, {error.subject.rpartition(', ')[2]}", error.problem, error.remedy) from error
    if len(values) != count:
        raise data.wrong(where, f"moves {len(values)} vertices, its primitive has {count}")
    with np.errstate(over="ignore", invalid="ignore"):
        moved: FloatArray = values @ instance.place[:3, :3].T
    return moved


def _listed(owner: dict[str, Any]) -> list[Any] | None:
    extras = owner.get("extras")
    names = extras.get("targetNames") if isinstance(extras, dict) else None
    return names if isinstance(names, list) else None


def _word(name: Any) -> str:
    """Return a name without what no list can show; empty where it is none."""
    text = str(name) if isinstance(name, str | int) and not isinstance(name, bool) else ""
    return "".join(letter if letter.isprintable() else " " for letter in text[:_LONGEST_NAME]).strip()
