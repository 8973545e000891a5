"""Exudyn models of the mechanisms in MJCF files: kinematic trees, and bodies joined by constraints.

The equations of motion are Exudyn's own: bodies, joints, springs and loads are added to it as the
file has them, but

- a joint with an armature moves as the drive does: its spring's pull is a load in time;
- the smallest moment of inertia that MuJoCo takes counts as 0, since Exudyn has point masses;
- bodies of a plane mechanism, as it stands, are bodies in the plane of x and y.

Joints are hinges and slides about or along any axis, ball joints and free joints, in the origin of
their body. A tendon acts between two bodies. But in a kinematic tree, slides are on bodies that do
not move.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from ..reference import get_scene
from ..reference.body.rotation import PLACES
from ..reference.errors import CannotJudgeError
from ..reference.quaternions import product
from ..reference.scene import Array
from .exudyn_system import (
    ExudynSystem,
    Hinge,
    Items,
    Model,
    exudyn,
    harmonic_load,
    items,
    parameters,
    weigh,
)
from .kinematics import Placed, movers, place
from .mechanism import Site, Term, mechanism
from .mjcf import Mjcf, export
from .placement import placed, placed_motion, right_handed, turn_quaternion, world_axes

NO_INERTIA = 2e-15
"""The moment of inertia [kg m^2] of point masses in the files: MuJoCo refuses less than 1e-15."""

UPRIGHT = np.eye(4)[0]
"""The quaternion of no rotation, from which Exudyn's coordinates count."""
UPRIGHT.flags.writeable = False


class ExudynSource:
    """The mechanism in an MJCF file, placed in the world, of which an Exudyn model is built.

    Attributes
    ----------
    scene : Scene
    model : Mjcf
    parameters : Parameters
    placement : str
        See `placement.world_axes`.
    whole : Mechanism
        As the file has it, with the joints that move as the drive does.
    start : Placed
        The mechanism in the scene's origin, where each joint is at its ``ref``.
    bodies : list of int
        Numbers of the bodies that the drive does not move.
    joints : mapping of int to Joint
        The joint of each of these bodies.
    """

    def __init__(self, scene: str, model: Mjcf, parameters: Any, placement: str) -> None:
        self.scene, self.model = get_scene(scene), model
        self.parameters, self.placement = parameters, placement
        self.whole = whole = mechanism(placed(export(model, parameters), placement))
        values = self.scene.completed({})
        origin = np.array([values[name] for name in self.scene.coordinates])
        self.start = place(whole, self.motion(origin, 0 * origin)[0])
        own = {
            i: [whole.joints[k] for k in body.joints] for i, body in enumerate(whole.bodies) if i
        }
        self.bodies = [i for i, joints in own.items() if not any(one.armature for one in joints)]
        for i in self.bodies:
            if len(own[i]) != 1 or np.any(own[i][0].anchor):
                raise CannotJudgeError(
                    f"body {whole.bodies[i].name} has not one joint in its origin"
                )
        self.joints = {i: own[i][0] for i in self.bodies}
        self.refs = {one.name: one.ref for one in whole.joints}

    def motion(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Return positions (n_q,) and velocities (n_v,) of all joints of the file."""
        values = dict(zip(self.scene.state_names, np.append(q, v), strict=True))
        motion = placed_motion(self.model.joints(self.parameters, 0.0, values), self.placement)
        names = [one.name for one in self.whole.joints]
        positions, velocities = (np.hstack([motion[name][i] for name in names]) for i in (0, 1))
        return positions, velocities

    def sums(self) -> Iterator[tuple[int, Mapping[str, float]]]:
        """Yield the scene's coordinates that are sums of hinges and slides, and these sums."""
        spatial = {
            name for one in self.scene.quaternions for name in (*one.coordinates, *one.place)
        }
        for i, name in enumerate(self.scene.coordinates):
            if name not in spatial:
                yield i, self.model.readout.get(name, {name: 1.0})

    def loads(self) -> Iterator[tuple[Term, dict[str, float], float, list[tuple[float, float]]]]:
        """Yield each term, the joints in it, their constant force at 0, and its waves (N, rad/s).

        A joint that moves as the drive does starts at its largest excursion.
        """
        stiffness = {t.name: -t.per_length for t in self.whole.terms if t.kind == "spring"}
        omega = {one.name: float(np.sqrt(stiffness[one.name] / one.armature))
                 for one in self.whole.joints if one.armature}  # fmt: skip
        for term in self.whole.terms:
            reach = {name: factor for name, factor in term.joints.items() if name not in omega}
            rest = sum(factor * self.refs[name] for name, factor in reach.items())
            waves = [(term.per_length * factor * self.refs[name], omega[name])
                     for name, factor in term.joints.items() if name in omega]  # fmt: skip
            if reach:
                yield term, reach, term.constant + term.per_length * rest, waves

    def tensor(self, body: int) -> Array:
        """Return the inertia tensor (3, 3) of a body about its centre of mass."""
        tensor = self.whole.bodies[body].inertia
        return 0 * tensor if np.max(tensor) == NO_INERTIA else tensor

    def carrier(self, joint: str) -> int:
        """Return the body that a joint moves."""
        return next(i for i, one in self.joints.items() if one.name == joint)

    def axis(self, body: int) -> Array:
        """Return the axis (3,) in the world of the joint of a body, in the scene's origin."""
        return self.start.rotations[body] @ self.joints[body].axis

    def twisted(self, reach: Mapping[str, float]) -> tuple[int, int] | None:
        """Return the two bodies whose relative angle is a sum of hinges; None of other joints.

        Bodies that do not turn count as the world.

        Raises
        ------
        CannotJudgeError
            If a sum of hinges is not the angle between two bodies.
        """
        shares: dict[int, float] = defaultdict(float)
        last = max(map(self.carrier, reach))
        if self.joints[last].kind != "hinge":
            return None
        for name, factor in reach.items():
            i = self.carrier(name)
            share = round(factor * float(self.axis(i) @ self.axis(last)), 9)
            shares[i] += share
            shares[self.whole.bodies[i].parent] -= share
        ends = {i: share for i, share in shares.items() if share and movers(self.whole)[i][0]}
        bases = [i for i, share in ends.items() if share == -1.0]
        if ends != dict.fromkeys(bases, -1.0) | {last: 1.0} or len(bases) > 1:
            raise CannotJudgeError(f"{dict(reach)} is not the angle between two bodies")
        return (*bases, 0)[0], last

    def reactions(self, multipliers: Mapping[str, tuple[int, Array]], count: int) -> Array | None:
        """Return the matrix (k, m) from m = ``count`` multipliers to the model's k reactions.

        Parameters
        ----------
        multipliers : mapping of joint or loop to (number, array (3, j))
            The first of its j multipliers, and their directions in the axes of the model.
        count : int
        """
        named = self.model.reactions.values()
        rows = np.zeros((len(named), count))
        for row, (element, axis) in zip(rows, named, strict=True):
            first, directions = multipliers[element]
            row[first : first + directions.shape[1]] = directions[axis]
        return rows if len(rows) else None

    def linear(self, rows: Mapping[str, Array], size: int) -> dict[str, Any]:
        """Return ``readout``, ``origin`` and ``outputs`` of `ExudynSystem`.

        Parameters
        ----------
        rows : mapping of joint to array (N,)
            Joints, less their ``ref``, as sums of the N = ``size`` coordinates of Exudyn.
        size : int
        """
        readout = np.zeros((len(self.scene.coordinates), size))
        origin = np.zeros(len(readout))
        for i, reach in self.sums():
            for name in reach.keys() & rows.keys():
                readout[i] += reach[name] * rows[name]
                origin[i] += reach[name] * self.refs[name]
        seen = [name for name in rows if name in self.scene.observed]

        def outputs(coordinates: Array, rates: Array) -> dict[str, Array]:
            places = {name: rows[name] @ coordinates + self.refs[name] for name in seen}
            return places | {f"{name}_dot": rows[name] @ rates for name in seen}

        return {"readout": readout, "origin": origin, "outputs": outputs}


def to_axis(axis: Array) -> Array:
    """Return a rotation (3, 3) that takes z to a unit axis."""
    x = np.cross(np.eye(3)[np.argmin(np.abs(axis))], axis)
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


def add_loads(
    mbs: Any, source: ExudynSource, places: list[dict[str, Any]], rows: Mapping[str, Array]
) -> tuple[Any, ...]:
    """Add springs, dampers and actuators of joints that are linear in Exudyn's coordinates.

    Parameters
    ----------
    places : list of N dict
        Node and number within the node of each coordinate.
    rows : mapping of joint to array (N,)
        The joint, less its ``ref``, as a sum of coordinates. Terms of other joints are left out.

    Returns
    -------
    functions that must live as long as the system
    """
    functions: tuple[Any, ...] = ()
    still = items.MarkerNodeCoordinate(
        nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0
    )
    for term, reach, force, waves in source.loads():
        if not reach.keys() <= rows.keys():
            continue
        row = np.sum([factor * rows[name] for name, factor in reach.items()], axis=0)
        markers = []
        for i in np.flatnonzero(row):
            markers.append(mbs.AddMarker(items.MarkerNodeCoordinate(**places[i])))
            if force:
                mbs.AddLoad(items.LoadCoordinate(markerNumber=markers[-1], load=force * row[i]))
            for amplitude, omega in waves:
                functions += harmonic_load(mbs, markers[-1], float(amplitude * row[i]), omega)
        spring = {"stiffness": -term.per_length, "damping": -term.per_rate}
        if len(markers) == 1 or np.sum(row) == 0:  # one coordinate, or the difference of two
            ends = [*(markers[1:] or [mbs.AddMarker(still)]), markers[0]]
            spring_damper = items.ObjectConnectorCoordinateSpringDamper
            mbs.AddObject(spring_damper(markerNumbers=ends, **spring))
            continue
        nodes = [place["nodeNumber"] for place in places if not place["coordinate"]]
        square = np.outer(row, row)
        matrices = {f"{name}Matrix": value * square for name, value in spring.items()}
        mbs.AddObject(items.ObjectGenericODE2(nodeNumbers=nodes, massMatrix=0 * square, **matrices))
    return functions


def build_tree(source: ExudynSource) -> ExudynSystem:
    """Return minimal coordinates: those of the joints, in a kinematic tree."""
    container, bodies, whole = exudyn.SystemContainer(), source.bodies, source.whole
    mbs, count = container.AddSystem(), len(bodies)
    node = mbs.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=[0] * count,
            initialCoordinates=[0] * count,
            initialCoordinates_t=[0] * count,
            numberOfODE2Coordinates=count,
        )
    )
    frames = {0: np.eye(3)} | {i: to_axis(source.joints[i].axis) for i in bodies}
    kinds = {"hinge": exudyn.JointType.RevoluteZ, "slide": exudyn.JointType.PrismaticZ}
    links = [(whole.bodies[i], frames[i], frames[whole.bodies[i].parent].T) for i in bodies]
    mbs.AddObject(
        items.ObjectKinematicTree(
            nodeNumber=node,
            jointTypes=[kinds[source.joints[i].kind] for i in bodies],
            linkParents=[bodies.index(body.parent) if body.parent else -1 for body, _, _ in links],
            jointTransformations=exudyn.Matrix3DList(
                [back @ body.rotation @ frame for body, frame, back in links]
            ),
            jointOffsets=exudyn.Vector3DList(
                [(back @ body.position).tolist() for body, _, back in links]
            ),
            linkMasses=[body.mass for body, _, _ in links],
            linkCOMs=exudyn.Vector3DList(
                [(body.centre @ frame).tolist() for body, frame, _ in links]
            ),
            linkInertiasCOM=exudyn.Matrix3DList(
                [frames[i].T @ source.tensor(i) @ frames[i] for i in bodies]
            ),
            gravity=whole.gravity.tolist(),
        )
    )
    names = [source.joints[i].name for i in bodies]
    rows = dict(zip(names, np.eye(count), strict=True))
    functions = add_loads(
        mbs, source, [{"nodeNumber": node, "coordinate": k} for k in range(count)], rows
    )
    mbs.Assemble()
    places = [[one.name for one in whole.joints].index(name) for name in names]
    refs = np.array([source.refs[name] for name in names])

    def at(q: Array, v: Array) -> tuple[Array, Array]:
        positions, velocities = source.motion(q, v)
        return positions[places] - refs, velocities[places]

    return ExudynSystem(
        mbs, at, container=container, functions=functions, **source.linear(rows, count)
    )


class Assembly:
    """Bodies in an Exudyn system, and the joints between them.

    A body on a slide has one coordinate, its displacement (ObjectMass1D).

    Parameters
    ----------
    source : ExudynSource
    origins : mapping of int to array (3,)
        The reference point of each body, in the frame of the body.
    size : int
        Number of coordinates of a body that turns.
    add_body : callable ``(Assembly, body) -> (node, number)``
        Adds such a body.

    Attributes
    ----------
    mbs : exudyn.MainSystem
    numbers : mapping of int to Exudyn's number of a body
    turns : mapping of int to array (3, 3)
        The rotation from the frame of a body to that of Exudyn's body.
    places : list of N dict
        Node and number within the node of each coordinate.
    first : mapping of int to int
        The first coordinate of each body.
    slides : mapping of joint to array (N,)
        The displacement of each slide as a sum of coordinates.
    """

    def __init__(
        self,
        source: ExudynSource,
        origins: Mapping[int, Array],
        size: int,
        add_body: Callable[[Assembly, int], tuple[Any, Any]],
    ) -> None:
        self.source, self.origins = source, origins
        self.container = exudyn.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.numbers = {0: self.mbs.AddObject(items.ObjectGround())}
        self.turns, self.first = {0: np.eye(3)}, dict[int, int]()
        self.places: list[dict[str, Any]] = []
        on_slides = [i for i, one in source.joints.items() if one.kind == "slide"]
        for i in source.bodies:
            self.turns[i], self.first[i] = np.eye(3), len(self.places)
            add, count = (Assembly.add_slider, 1) if i in on_slides else (add_body, size)
            node, self.numbers[i] = add(self, i)
            self.places += [{"nodeNumber": node, "coordinate": k} for k in range(count)]
        units = np.eye(len(self.places))
        self.slides = {source.joints[i].name: units[self.first[i]] for i in on_slides}
        bodies = [self.numbers[i] for i in source.bodies]
        weigh(self.mbs, bodies, source.whole.gravity.tolist())

    def add_slider(self, body: int) -> tuple[Any, Any]:
        """Add the body of a slide; return its node and its number.

        Raises
        ------
        CannotJudgeError
            If the slide is on a body that moves.
        """
        whole, start = self.source.whole, self.source.start
        if any(movers(whole)[whole.bodies[body].parent]):
            raise CannotJudgeError(f"body {whole.bodies[body].name} slides on a body that moves")
        ahead = to_axis(self.source.joints[body].axis)[:, [2, 0, 1]]  # Exudyn's slide along x
        self.turns[body] = ahead.T
        node = self.mbs.AddNode(items.Node1D(referenceCoordinates=[0]))
        slider = items.ObjectMass1D(
            mass=whole.bodies[body].mass,
            nodeNumber=node,
            referencePosition=start.point(self.origin(body)).tolist(),
            referenceRotation=start.rotations[body] @ ahead,
        )
        return node, self.mbs.AddObject(slider)

    def origin(self, body: int) -> Site:
        """Return the reference point of a body."""
        return Site(body, self.origins[body])

    def point(self, site: Site, kind: str = "MarkerBodyRigid") -> Any:
        """Return a marker at a point of a body, along the frame of Exudyn's body."""
        at = self.turns[site.body] @ (site.position - self.origins[site.body])
        marker = getattr(items, kind)(bodyNumber=self.numbers[site.body], localPosition=at)
        return self.mbs.AddMarker(marker)

    def frames(self, *ends: tuple[Site, Array]) -> dict[str, Any]:
        """Return the markers of frames, each a point and a rotation (3, 3) in its body."""
        turns = [self.turns[site.body] @ turn for site, turn in ends]
        if "localHT" not in parameters(Items.module, "MarkerBodyRigid"):  # before 1.12.244
            rotations = {f"rotationMarker{k}": turn for k, turn in enumerate(turns)}
            return {"markerNumbers": [self.point(site) for site, _ in ends], **rotations}
        markers = []
        for (site, _), turn in zip(ends, turns, strict=True):
            at = self.turns[site.body] @ (site.position - self.origins[site.body])
            frame = np.block([[turn, at[:, None]], [np.eye(4)[3]]])
            marker = items.MarkerBodyRigid(bodyNumber=self.numbers[site.body], localHT=frame)
            markers.append(self.mbs.AddMarker(marker))
        return {"markerNumbers": markers}

    def joined(self, body: int) -> tuple[Site, Site]:
        """Return the points of its parent and of a body that its joint joins."""
        one = self.source.whole.bodies[body]
        return Site(one.parent, one.position), Site(body, np.zeros(3))

    def system(
        self, place_body: Callable[[Placed, Array, Array, int], tuple[Any, Any]], **more: Any
    ) -> ExudynSystem:
        """Return the assembled system.

        Parameters
        ----------
        place_body : callable ``(mechanism, q, v, body) -> (coordinates, rates)``
            Of a body that turns, at positions and velocities of joints; bodies come in order.
        **more
            What else `ExudynSystem` takes.
        """
        self.mbs.Assemble()
        whole, source = self.source.whole, self.source

        def at(q: Array, v: Array) -> tuple[Array, Array]:
            positions, velocities = source.motion(q, v)
            now, (coordinates, rates) = place(whole, positions), np.zeros((2, len(self.places)))
            for i, k in self.first.items():
                if source.joints[i].kind == "slide":
                    site, axis = self.origin(i), source.axis(i)
                    coordinates[k] = axis @ (now.point(site) - source.start.point(site))
                    rates[k] = axis @ now.jacobian(site) @ velocities
                    continue
                there, speed = place_body(now, positions, velocities, i)
                coordinates[k : k + len(there)], rates[k : k + len(there)] = there, speed
            return coordinates, rates

        return ExudynSystem(self.mbs, at, container=self.container, **more)


def build_plane(source: ExudynSource) -> ExudynSystem:
    """Return bodies in the plane, (x, y, angle) of each centre of mass, joined by constraints."""
    bodies, whole, start = source.bodies, source.whole, source.start

    def add(built: Assembly, i: int) -> tuple[Any, Any]:
        (x, y, _), turn = start.point(built.origin(i)), start.rotations[i]
        angle = float(np.arctan2(turn[1, 0], turn[0, 0]))
        node = built.mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[x, y, angle]))
        mass, inertia = whole.bodies[i].mass, float(source.tensor(i)[2, 2])
        body = items.ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=node)
        return node, built.mbs.AddObject(body)

    centres = {i: whole.bodies[i].centre for i in (0, *bodies)}
    built = Assembly(source, centres, 3, add)
    rows, multipliers, across = dict(built.slides), {}, np.eye(3)[:, :2]
    hinges = [i for i in bodies if source.joints[i].hinge]
    for i in hinges:
        row = np.zeros(len(built.places))
        row[built.first[i] + 2] = source.axis(i)[2]
        if whole.bodies[i].parent in hinges:
            row[built.first[whole.bodies[i].parent] + 2] = -source.axis(i)[2]
        rows[source.joints[i].name] = row
    joints = {f"body:{whole.bodies[i].name}": built.joined(i) for i in hinges}
    joints |= {f"connect:{one.name}": (one.first, one.second) for one in whole.closures}
    for k, (name, sites) in enumerate(joints.items()):
        multipliers[name] = 2 * k, across
        markers = [built.point(site, "MarkerBodyPosition") for site in sites]
        built.mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=markers))
    functions = add_loads(built.mbs, source, built.places, rows)
    opened = np.array([one.ref for one in whole.joints])

    def place_body(now: Placed, q: Array, v: Array, i: int) -> tuple[Any, Any]:
        site, turning = built.origin(i), now.turning(i)[2]
        shift = now.point(site) - start.point(site)
        return [*shift[:2], turning @ (q - opened)], [*(now.jacobian(site) @ v)[:2], turning @ v]

    return built.system(
        place_body,
        functions=functions,
        reactions=source.reactions(multipliers, 2 * len(joints)),
        **source.linear(rows, len(built.places)),
    )


def build_space(source: ExudynSource) -> ExudynSystem:
    """Return bodies with Euler parameters, (x, y, z, q_w, q_x, q_y, q_z), joined by constraints.

    The place of a body is that of its joint, or, in a plane mechanism, of its centre of mass.
    Exudyn adds the constraint |q| = 1 of each body.
    """
    bodies, whole, axes = source.bodies, source.whole, world_axes(source.placement)
    shift = 0.0 if whole.layout.is_spatial else 1.0
    origins = {i: shift * whole.bodies[i].centre for i in (0, *bodies)}
    built = Assembly(source, origins, 7, add_body)
    mbs, multipliers, count = built.mbs, {}, len(bodies) - len(built.slides)
    for i, one in source.joints.items():
        (base, own), turn = built.joined(i), to_axis(one.axis)
        multipliers[f"body:{whole.bodies[i].name}"] = count, axes.T
        if one.hinge:
            ends = (base, whole.bodies[i].rotation @ turn), (own, turn)
            mbs.AddObject(items.ObjectJointRevoluteZ(**built.frames(*ends)))
            count += 5
        elif one.kind == "ball":
            markers = [built.point(base), built.point(own)]
            mbs.AddObject(items.ObjectJointSpherical(markerNumbers=markers))
            count += 3
    upright = right_handed(axes)
    for closure in whole.closures:  # in the plane, in which hinges and slides keep the bodies
        multipliers[f"connect:{closure.name}"], count = (count, -np.eye(3)[:, :2]), count + 6
        frames = [
            (site, source.start.rotations[site.body].T @ upright)
            for site in (closure.second, closure.first)
        ]
        joint = items.ObjectJointGeneric(**built.frames(*frames), constrainedAxes=[1, 1, *[0] * 4])
        mbs.AddObject(joint)
    functions = add_loads(mbs, source, built.places, built.slides)
    hinges = add_springs(source, built)
    more = source.linear(built.slides, len(built.places))
    turn = turn_quaternion(upright)
    for attitude in source.scene.quaternions:
        rows_of = [source.scene.coordinates.index(name) for name in attitude.coordinates]
        k = built.first[source.carrier(attitude.name)]
        more["readout"][rows_of, k + 3 : k + 7] = turn.T
        more["origin"][rows_of] = turn.T @ UPRIGHT
        for axis, name in zip(axes.T, attitude.place, strict=bool(attitude.place)):
            more["readout"][source.scene.coordinates.index(name), k : k + 3] = axis

    def place_body(now: Placed, q: Array, v: Array, i: int) -> tuple[Any, Any]:
        site, attitude = built.origin(i), attitude_of(source, q, i)
        spin = [0.0, *(now.turning(i) @ v / 2)]
        rates = *(now.jacobian(site) @ v), *product(spin, attitude)
        return [*now.point(site), *(attitude - UPRIGHT)], rates

    return built.system(
        place_body,
        functions=functions,
        hinges=hinges,
        reactions=source.reactions(multipliers, count),
        **more,
    )


def attitude_of(source: ExudynSource, q: Array, i: int) -> Array:
    """Return the unit quaternion of a body in the world at positions (n_q,) of joints."""
    if not i:
        return UPRIGHT
    body, one = source.whole.bodies[i], source.joints[i]
    position = q[source.whole.layout.positions[body.joints[0]]]
    if one.kind == "free":
        return position[3:]
    turn = position if one.kind == "ball" else UPRIGHT
    if one.hinge:
        half = (position[0] - one.ref) / 2
        turn = np.append(np.cos(half), np.sin(half) * one.axis)
    base = product(attitude_of(source, q, body.parent), turn_quaternion(body.rotation) @ UPRIGHT)
    return np.array(product(base, turn))


def add_body(built: Assembly, i: int) -> tuple[Any, Any]:
    """Add a body in space; return its node and its number."""
    body, origin = built.source.whole.bodies[i], built.origins[i]
    arm = body.centre - origin
    about = built.source.tensor(i) + body.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    xx, yy, zz, xy, xz, yz = (float(about[place]) for place in PLACES)
    node = built.mbs.AddNode(items.NodeRigidBodyEP(referenceCoordinates=[0, 0, 0, *UPRIGHT]))
    item = items.ObjectRigidBody(
        mass=body.mass,
        inertia=[xx, yy, zz, yz, xz, xy],
        centerOfMass=arm.tolist(),
        nodeNumber=node,
    )
    return node, built.mbs.AddObject(item)


def add_springs(source: ExudynSource, built: Assembly) -> tuple[Hinge, ...]:
    """Add springs, dampers and actuators of hinges and ball joints between bodies in space.

    Returns
    -------
    hinges : tuple of Hinge
        The scene's coordinates that are angles, each counted by a torsion spring.
    """
    mbs, start = built.mbs, source.start
    angles = {ends: i for i, reach in source.sums() if (ends := source.twisted(reach))}
    torsion = dict.fromkeys(angles, np.zeros(3))
    for term, reach, force, _ in source.loads():
        if ends := source.twisted(reach):
            numbers = np.array([-term.per_length, -term.per_rate, -force])
            torsion[ends] = torsion.get(ends, 0) + numbers
        elif not reach.keys() <= built.slides.keys():  # the damper of a ball joint
            markers = [built.point(site) for site in built.joined(*map(source.carrier, reach))]
            about = -term.per_rate * np.diag([0, 0, 0, 1, 1, 1])
            damper = items.ObjectConnectorRigidBodySpringDamper
            mbs.AddObject(damper(markerNumbers=markers, damping=about))
    hinges = []
    for ends, (stiffness, damping, torque) in torsion.items():
        axis = source.axis(ends[1])
        axes = tuple(start.rotations[k].T @ axis for k in ends)
        frames = [(built.origin(k), start.rotations[k].T @ to_axis(axis)) for k in ends]
        count = {}
        if ends in angles:
            count["nodeNumber"] = mbs.AddNode(
                items.NodeGenericData(initialCoordinates=[0.0], numberOfDataCoordinates=1)
            )
            attitudes = tuple(built.first[k] + 3 if k else None for k in ends)
            hinges.append(Hinge(angles[ends], axes, attitudes))
        spring = items.ObjectConnectorTorsionalSpringDamper(
            **built.frames(*frames), **count, stiffness=stiffness, damping=damping, torque=torque
        )
        mbs.AddObject(spring)
    return tuple(hinges)


def model_of(
    scene: str, mjcf: Mjcf, build: Callable[[ExudynSource], ExudynSystem], **more: Any
) -> Model:
    """Return the Exudyn model of a mechanism in an MJCF file, built in one of the ways above."""
    in_space = build_space if build is build_plane else build

    def placed_system(p: Any, placement: str) -> ExudynSystem:
        return (in_space if placement else build)(ExudynSource(scene, mjcf, p, placement))

    return Model(
        placed_system,
        constrained=build is not build_tree,
        reactions=tuple(mjcf.reactions),
        **more,
    )
