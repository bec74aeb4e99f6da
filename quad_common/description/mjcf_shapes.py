"""
Shapes of MJCF's bodies in the terms of URDF, which knows boxes, cylinders, spheres and meshes.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import yourdfpy
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

_SHOWN = 2
"""Last of the groups of shapes that MuJoCo's viewer shows unless it is told otherwise."""

_MESHES = ('.obj', '.stl')
"""Endings of mesh files that URDF's readers know as well as MuJoCo."""

_ALIKE = 1.25
"""Ratio of two half axes of an ellipsoid up to which it is taken for round."""

_OF_BOX = (np.pi / 6.0) ** (1.0 / 3.0)
"""Size of a box over the axes of the ellipsoid that has the same volume."""


class LinkShapes:
    """
    The shapes of a compiled model.

    Parameters
    ----------
    path : Path
        Its file.
    spec : mujoco.MjSpec
        What the file says, compiled.
    model : mujoco.MjModel
        What MuJoCo made of it, with every shape.
    """

    def __init__(self, path: Path, spec: Any, model: Any) -> None:
        self._folder = path.resolve().parent
        self._mesh_folder = self._folder / (spec.meshdir or '')
        self._model = model
        # Compiling numbers them as they stand; older versions do not tell the number.
        self._meshes = list(spec.meshes)
        self._paired = {int(k) for k in (*model.pair_geom1, *model.pair_geom2)}

    def of_body(self, body: int, frame: Array) -> tuple[list[Any], list[Any]]:
        """
        List what is seen of a body, and what it collides with.

        Parameters
        ----------
        body : int
            Index of the body.
        frame : ndarray, shape (4, 4)
            Frame of the body in that of its link.

        Returns
        -------
        visuals : list of yourdfpy.Visual
            What MuJoCo shows by itself, groups 0 to 2, in its colors.
        collisions : list of yourdfpy.Collision
            What touches anything, by its bits or by a pair that names it.
        """
        model = self._model
        visuals, collisions = [], []
        first = int(model.body_geomadr[body])
        for geom in range(first, first + int(model.body_geomnum[body])):
            shapes = [(frame @ pose, geometry) for pose, geometry in self._shapes_of(geom)]
            if model.geom_group[geom] <= _SHOWN:
                material = self._material(geom)
                visuals += [
                    yourdfpy.urdf.Visual(origin=pose, geometry=geometry, material=material)
                    for pose, geometry in shapes
                ]
            bits = int(model.geom_contype[geom]) | int(model.geom_conaffinity[geom])
            if bits or geom in self._paired:
                collisions += [
                    yourdfpy.urdf.Collision(name=None, origin=pose, geometry=geometry)
                    for pose, geometry in shapes
                ]
        return visuals, collisions

    def _shapes_of(self, geom: int) -> Iterator[tuple[Array, Any]]:
        """Yield URDF's shapes for one of MJCF's, each with its pose in the body's frame."""
        model = self._model
        kind, kinds = mujoco.mjtGeom(int(model.geom_type[geom])), mujoco.mjtGeom
        size = np.array(model.geom_size[geom], dtype=float)
        pose = pose_from(model.geom_pos[geom], model.geom_quat[geom])
        if kind == kinds.mjGEOM_SPHERE:
            yield pose, _sphere(size[0])
        elif kind == kinds.mjGEOM_CYLINDER:
            yield pose, _cylinder(size[0], 2.0 * size[1])
        elif kind == kinds.mjGEOM_BOX:
            yield pose, _box(2.0 * size)
        elif kind == kinds.mjGEOM_CAPSULE:
            yield from _capsule(pose, size[0], size[1])
        elif kind == kinds.mjGEOM_ELLIPSOID:
            yield from _ellipsoid(pose, size)
        elif kind in (kinds.mjGEOM_MESH, kinds.mjGEOM_SDF):
            yield self._mesh(geom, pose)
        # Planes and height fields are ground, which no robot carries.

    def _mesh(self, geom: int, pose: Array) -> tuple[Array, Any]:
        """Return a mesh by its file, where its corners are in MuJoCo; without one its box."""
        model = self._model
        index = int(model.geom_dataid[geom])
        address = int(model.mesh_pathadr[index])
        name = '' if address < 0 else model.paths[address:].split(b'\0', 1)[0].decode()
        scale = np.array(model.mesh_scale[index], dtype=float)
        inside = _in_file(self._meshes[index], scale)
        if inside is None or Path(name).suffix.lower() not in _MESHES:
            middle = np.eye(4)
            middle[:3, 3] = model.geom_aabb[geom, :3]
            return pose @ middle, _box(2.0 * model.geom_aabb[geom, 3:])
        # MuJoCo moves the corners to the middle of the mesh, and its shape with them.
        moved = pose_from(model.mesh_pos[index], model.mesh_quat[index])
        mesh = yourdfpy.urdf.Mesh(
            filename=str(self._file(name)), scale=None if np.all(scale == 1.0) else scale
        )
        return pose @ np.linalg.inv(moved) @ inside, yourdfpy.urdf.Geometry(mesh=mesh)

    def _file(self, name: str) -> Path:
        """Find a mesh's file; whether its name begins with its folder depends on the version."""
        inside = self._mesh_folder / name, self._mesh_folder / Path(name).name
        beside = self._folder / name
        return next((path for path in (inside[0], beside, inside[1]) if path.is_file()), beside)

    def _material(self, geom: int) -> Any:
        model = self._model
        material = int(model.geom_matid[geom])
        color = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
        rgba = np.round(np.array(color, dtype=float), 6)
        name = 'rgba_' + '_'.join(f'{value:g}' for value in rgba)
        return yourdfpy.urdf.Material(name=name, color=yourdfpy.urdf.Color(rgba))


def pose_from(position: ArrayLike, quaternion: ArrayLike) -> Array:
    """Return a pose (4, 4) of a position [m] and MuJoCo's quaternion, whose w is first."""
    w, x, y, z = np.asarray(quaternion, dtype=float)
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat([x, y, z, w]).as_matrix()
    pose[:3, 3] = position
    return pose


def _in_file(mesh: Any, scale: Array) -> Array | None:
    """
    Place the frame of a file's corners in that of the mesh, which may have a reference of its own.

    None if the file's corners, scaled first, cannot be turned there: that shears them.
    """
    reference = pose_from(mesh.refpos, mesh.refquat)
    turn = reference[:3, :3].T
    if not (np.allclose(turn, np.eye(3)) or np.allclose(scale, scale[0])):
        return None
    pose = np.eye(4)
    pose[:3, :3] = turn
    pose[:3, 3] = -scale * (turn @ reference[:3, 3])
    return pose


def _capsule(pose: Array, radius: float, half: float) -> Iterator[tuple[Array, Any]]:
    """Yield a cylinder and the balls at its ends."""
    yield pose, _cylinder(radius, 2.0 * half)
    for side in (-1.0, 1.0):
        end = np.eye(4)
        end[2, 3] = side * half
        yield pose @ end, _sphere(radius)


def _ellipsoid(pose: Array, half: Array) -> Iterator[tuple[Array, Any]]:
    """Yield the nearest of the other shapes: a ball, a long one of balls, or a box."""
    short, middle, long = np.sort(half)
    if long <= _ALIKE * short:
        yield pose, _sphere(float(np.cbrt(half.prod())))
    elif middle <= _ALIKE * short:
        radius = float(np.sqrt(short * middle))
        along = np.eye(4)
        longest = int(np.argmax(half))
        along[:3, :3] = np.eye(3)[:, [longest - 2, longest - 1, longest]]
        yield from _capsule(pose @ along, radius, float(long - radius))
    else:
        yield pose, _box(2.0 * _OF_BOX * half)


def _sphere(radius: float) -> Any:
    return yourdfpy.urdf.Geometry(sphere=yourdfpy.urdf.Sphere(float(radius)))


def _cylinder(radius: float, length: float) -> Any:
    return yourdfpy.urdf.Geometry(cylinder=yourdfpy.urdf.Cylinder(float(radius), float(length)))


def _box(size: Array) -> Any:
    return yourdfpy.urdf.Geometry(box=yourdfpy.urdf.Box(np.array(size, dtype=float)))
