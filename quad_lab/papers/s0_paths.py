"""
S0's figures 6 to 8: Dijkstra's algorithm on a graph, and paths over a mesh around obstacles.

What is lost: weights of the graph in figure 6 but for those that the text names, and where the
obstacles of figures 7 and 8 are. Chosen are weights that agree with everything that the text says
of the search, and obstacles that leave the choices of which it speaks.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_lab.papers.comparison import Exhibit, at_least, at_most, same, words
from quad_lab.papers.drawing import COLORS, name_axes, panels
from quad_lab.tools.dijkstra import DijkstraResult, shortest_path
from quad_planner.methods.mesh_moves import MOVES
from quad_planner.methods.mesh_planner import MeshPlanner, PreparedMesh
from quad_planner.parameters import PlannerParameters

Array = NDArray[np.float64]

GRAPH = {
    1: {2: 15, 3: 8, 4: 5},
    2: {1: 15, 3: 2, 5: 3},
    3: {1: 8, 2: 2, 4: 4},
    4: {1: 5, 3: 4, 6: 20},
    5: {2: 3, 6: 4},
    6: {4: 20, 5: 4},
}
"""The graph of S0 fig. 6: 1-2, 1-3 and 1-4 are printed, 3-2 follows, the others are chosen."""

_EDGES = [(u, v) for u, ends in GRAPH.items() for v in ends if u < v]

_PLACES = {1: (0.0, 1.0), 2: (1.0, 2.0), 3: (1.1, 1.0), 4: (1.0, 0.0), 5: (2.2, 2.0), 6: (3.0, 1.0)}

_CELLS = 20
"""Cells of a map along one width of the mesh."""

_Box = tuple[float, float, float, float]
"""Left, bottom, width and height, in widths of the mesh."""

_ROOM = (15, 10)
"""Size of figure 7's room, in widths of the mesh."""
_BOXES: tuple[_Box, ...] = (
    (2.4, 2.2, 1.8, 2.4),
    (6.3, 0.0, 1.2, 3.4),
    (6.0, 6.1, 2.0, 3.9),
    (8.3, 6.4, 1.4, 1.0),
    (11.0, 2.3, 1.5, 3.4),
)
_ENDS = ((1.0, 1.0), (14.0, 9.0))
"""Left bottom corner to right top corner, as in S0 sec. 6."""

_CORNER = (5, 6)
"""Size of figure 8's part of a room."""
_POSTS: tuple[_Box, ...] = ((2.85, 2.35, 0.1, 0.1), (1.05, 2.55, 0.1, 0.1))
_NUMBERED = {1: (1, 1), 2: (2, 2), 3: (2, 3), 6: (3, 3), 7: (1, 3), 8: (3, 4)}
"""Crossings of figure 8 by the paper's numbers."""


def path_exhibits() -> list[Exhibit]:
    """Find the paths of figures 6, 7 and 8."""
    return [_graph_exhibit(), _room_exhibit(), _choice_exhibit()]


def _graph_exhibit() -> Exhibit:
    found = shortest_path(lambda u: GRAPH[u].items(), 1, 6)
    second = shortest_path(lambda u: GRAPH[u].items(), 1, 2)
    fourth = shortest_path(lambda u: GRAPH[u].items(), 1, 4)
    assert found is not None
    assert second is not None
    assert fourth is not None
    rows = (
        words(
            'vertices in the order in which they are visited, V',
            '1 4 3 2 5 6',
            _text(found.visited),
        ),
        same('distance of vertex 4', 5, fourth.cost, '', 0.0, 0),
        same('distance of vertex 2', 10, second.cost, '', 0.0, 0),
        words('path to vertex 2', '1 3 2', _text(second.path)),
        words('path to the goal', '1 3 2 5 6', _text(found.path)),
    )
    note = 'Weights 4-3, 4-6, 2-5 and 5-6 are lost, and chosen to agree with the text.'
    return Exhibit(
        'S0',
        'Fig. 6',
        "the graph of Dijkstra's algorithm",
        rows,
        note,
        lambda figure: _draw_graph(figure, found),
    )


def _text(vertices: tuple[int, ...]) -> str:
    return ' '.join(map(str, vertices))


def _draw_graph(figure: Figure, found: DijkstraResult[int, int]) -> None:
    figure.set_size_inches(6.8, 3.6)
    for step, axes in enumerate(panels(figure, 2, 3)):
        visited = found.visited[: step + 1]
        axes.axis('off')
        axes.set_xlim(-0.3, 3.3)
        axes.set_ylim(-0.35, 2.35)
        on_path = set(pairwise(found.path)) if step == 5 else set()
        for u, v in _EDGES:
            a, b = np.array(_PLACES[u]), np.array(_PLACES[v])
            is_path = bool({(u, v), (v, u)} & on_path)
            axes.plot(
                *np.array([a, b]).T,
                color=COLORS[0] if is_path else '0.6',
                linewidth=2.2 if is_path else 0.9,
            )
            middle = 0.5 * (a + b)
            axes.text(
                middle[0],
                middle[1],
                str(GRAPH[u][v]),
                fontsize=7,
                ha='center',
                va='center',
                bbox={'facecolor': 'white', 'edgecolor': 'none', 'pad': 0.6},
            )
        for u, place in _PLACES.items():
            fill = '#ff8c00' if u == visited[-1] else '#dbe6fb' if u in visited else 'white'
            axes.plot(*place, 'o', color='0.2', markerfacecolor=fill, markersize=13)
            axes.text(place[0], place[1], str(u), fontsize=8, ha='center', va='center')
        axes.set_title(f'V = {{{", ".join(map(str, visited))}}}', fontsize=8)


def _scene(size: tuple[int, int], boxes: tuple[_Box, ...]) -> tuple[MeshPlanner, PreparedMesh]:
    """Make a map of boxes, and lay the mesh of TITAN-VIII over it."""
    robot = load_robot('titan_viii')
    clearance = robot.footprint_radius + PlannerParameters().safety_distance
    planner = MeshPlanner(robot.mesh_size, clearance_radius=clearance)
    cells = np.zeros((size[1] * _CELLS, size[0] * _CELLS), dtype=np.int8)
    for left, bottom, width, height in boxes:
        low, high = round(bottom * _CELLS), round((bottom + height) * _CELLS)
        cells[low:high, round(left * _CELLS) : round((left + width) * _CELLS)] = 100
    grid = OccupancyGrid(cells, planner.mesh_size / _CELLS, Pose2D(0.0, 0.0, 0.0))
    return planner, planner.prepare(grid)


def _plan(planner: MeshPlanner, mesh: PreparedMesh, ends: tuple[tuple[float, float], ...]) -> Plan:
    """Plan between crossings, given in widths of the mesh."""
    (x0, y0), (x1, y1) = ends
    size = planner.mesh_size
    heading = math.pi / 4.0
    return planner.plan(
        mesh, Pose2D(x0 * size, y0 * size, heading), Pose2D(x1 * size, y1 * size, heading)
    )


def _room_exhibit() -> Exhibit:
    planner, mesh = _scene(_ROOM, _BOXES)
    plan = _plan(planner, mesh, _ENDS)
    corners = plan.corners / planner.mesh_size
    off = np.abs(corners - np.round(corners)).max() * planner.mesh_size
    clearance = min(
        _distance_to_box(point, box) * planner.mesh_size
        for point in _dense(corners)
        for box in _BOXES
    )
    gap = mesh.allowed[int(6.9 * _CELLS), int(8.15 * _CELLS)]
    rows = (
        same('width of the mesh, S0 eq. 5', 628.0, 1e3 * planner.mesh_size, 'mm', 0.5, 1),
        at_most('turning points, off a crossing', 'at crossing points', 1e3 * off, 'mm', 0.01),
        at_most(
            "length of the path, over scipy's shortest on the same mesh",
            'the shortest',
            1e3 * (plan.length - _least_length(mesh, planner.mesh_size)),
            'mm',
            0.01,
        ),
        at_least('distance from the obstacles', 'avoids obstacles', 1e3 * clearance, 'mm', 0.0, 0),
        words(
            'between two obstacles nearer than the robot needs',
            'one combined obstacle',
            'a passage' if gap else 'one combined obstacle',
        ),
    )
    return Exhibit(
        'S0',
        'Fig. 7',
        'the suitable path in an environment',
        rows,
        'Places of the obstacles are lost, and chosen.',
        lambda figure: _draw_room(figure, mesh, corners),
    )


def _dense(corners: Array) -> Iterator[Array]:
    for a, b in pairwise(corners):
        yield from a + np.linspace(0.0, 1.0, 200)[:, None] * (b - a)


def _distance_to_box(point: Array, box: _Box) -> float:
    left, bottom, width, height = box
    dx = max(left - point[0], 0.0, point[0] - left - width)
    dy = max(bottom - point[1], 0.0, point[1] - bottom - height)
    return math.hypot(dx, dy)


def _least_length(mesh: PreparedMesh, size: float) -> float:
    """Return the length of the shortest path over the mesh by scipy [m]."""
    columns = mesh.candidates.shape[1]
    edges = [(u, u + step) for u in range(mesh.exits.size) for step in _steps(mesh, u)]
    starts, ends = np.array(edges).T
    along = np.isin(np.abs(ends - starts), (1, columns))
    lengths = np.where(along, size, math.sqrt(2.0) * size)
    count = mesh.candidates.size
    graph = csr_array((lengths, (starts, ends)), shape=(count, count))
    source, goal = (round(y) * columns + round(x) for x, y in _ENDS)
    return float(dijkstra(graph, indices=source)[goal])


def _steps(mesh: PreparedMesh, crossing: int) -> Iterator[int]:
    """Give the differences between a crossing's number and those that may be walked to from it."""
    columns = mesh.exits.shape[1]
    for number, (right, up) in enumerate(MOVES):
        if mesh.exits.flat[crossing] >> number & 1:
            yield up * columns + right


def _draw_room(figure: Figure, mesh: PreparedMesh, corners: Array) -> None:
    figure.set_size_inches(6.0, 4.0)
    (axes,) = panels(figure, 1, 1)
    _draw_map(axes, mesh, _BOXES, _ROOM)
    axes.plot(*corners.T, '-o', color=COLORS[0], linewidth=2.0, markersize=4, label='path')
    axes.plot(*corners[0], 's', color=COLORS[2], markersize=8, label='start')
    axes.plot(*corners[-1], '*', color=COLORS[1], markersize=12, label='goal')
    axes.legend(fontsize=7, loc='upper left')


def _draw_map(
    axes: Axes, mesh: PreparedMesh, boxes: tuple[_Box, ...], size: tuple[int, int]
) -> None:
    axes.imshow(
        np.where(mesh.allowed, 1.0, 0.88),
        cmap='gray',
        vmin=0.0,
        vmax=1.0,
        origin='lower',
        extent=(0.0, size[0], 0.0, size[1]),
    )
    for left, bottom, width, height in boxes:
        axes.add_patch(Rectangle((left, bottom), width, height, color='0.45'))
    axes.set_xticks(range(size[0] + 1))
    axes.set_yticks(range(size[1] + 1))
    axes.set_aspect('equal')
    name_axes(axes, 'x [widths of the mesh]', 'y [widths of the mesh]')


def _choice_exhibit() -> Exhibit:
    planner, mesh = _scene(_CORNER, _POSTS)
    plan = _plan(planner, mesh, (_NUMBERED[1], _NUMBERED[8]))
    corners = plan.corners / planner.mesh_size
    columns = mesh.candidates.shape[1]
    x, y = _NUMBERED[2]
    free = set(_steps(mesh, y * columns + x))
    towards = {n: (_NUMBERED[n][1] - y) * columns + _NUMBERED[n][0] - x for n in (3, 6, 7)}
    rows = (
        words('move from 1', 'along the diagonal, to 2', _move(corners, 1)),
        words('the diagonals from 2 to 6 and 7', 'prevented', _count(free, towards, (6, 7))),
        words('move from 2', 'straight, to 3', _move(corners, 2)),
        words('move from 3', 'along the diagonal, to 8', _move(corners, 3)),
    )
    return Exhibit(
        'S0',
        'Fig. 8',
        'choosing the next turning point',
        rows,
        'Places of the obstacles are lost, and chosen. The robot keeps out of what is grey.',
        lambda figure: _draw_choice(figure, mesh, corners),
    )


def _move(corners: Array, number: int) -> str:
    """Say how the path leaves a numbered crossing."""
    at = [tuple(corner) for corner in np.round(corners, 6).tolist()]
    numbers = {tuple(map(float, place)): n for n, place in _NUMBERED.items()}
    here = tuple(map(float, _NUMBERED[number]))
    if here not in at[:-1]:
        return 'not on the path'
    there = at[at.index(here) + 1]
    kind = 'straight' if 0.0 in (there[0] - here[0], there[1] - here[1]) else 'along the diagonal'
    return f'{kind}, to {numbers.get(there, "another")}'


def _count(free: set[int], towards: dict[int, int], numbers: tuple[int, ...]) -> str:
    open_ones = [str(n) for n in numbers if towards[n] in free]
    return f'free to {", ".join(open_ones)}' if open_ones else 'prevented'


def _draw_choice(figure: Figure, mesh: PreparedMesh, corners: Array) -> None:
    figure.set_size_inches(4.2, 4.2)
    (axes,) = panels(figure, 1, 1)
    _draw_map(axes, mesh, _POSTS, _CORNER)
    for number in (6, 7):
        pair = np.array([_NUMBERED[2], _NUMBERED[number]], dtype=float)
        axes.plot(*pair.T, ':', color=COLORS[1], linewidth=1.4)
    axes.plot(*corners.T, '-', color=COLORS[0], linewidth=2.0)
    for number, place in _NUMBERED.items():
        axes.plot(*place, 'o', color='0.2', markerfacecolor='white', markersize=12)
        axes.text(*place, str(number), fontsize=8, ha='center', va='center')
