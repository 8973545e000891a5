"""Exudyn models of the mechanisms in MJCF files: kinematic trees, and bodies joined by constraints.

The equations of motion are Exudyn's own: bodies, joints, springs and loads are added to it as the
file has them, but

- a joint with an armature moves as the drive does: its spring's pull is a load in time;
- a moment of inertia that stands for none in the file is 0, since Exudyn has point masses;
- bodies of a plane mechanism, as it stands, are bodies in the plane of x and y.

Joints are hinges and slides about or along any axis, ball joints and free joints, in the origin of
their body. A tendon acts between two bodies.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

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
from .kinematics import movers, place
from .mechanism import Body, Joint, Site, Term, mechanism
from .mjcf import Mjcf, export
from .placement import placed, placed_motion, right_handed, turn_quaternion, world_axes

NO_INERTIA = 2e-15
"""The moment of inertia [kg m^2] that stands for none: MuJoCo refuses less than 1e-15."""

UPRIGHT = np.eye(4)[0]
"""The quaternion of no rotation, from which Exudyn's coordinates count."""
UPRIGHT.flags.writeable = False


class ExudynSource:
    """What an Exudyn model is built from: the mechanism in an MJCF file, placed in the world.

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

    def reactions(self, first: Mapping[str, int], count: int, axes: Array) -> Array | None:
        """Return the model's reactions (k, m) from multipliers, by the first one of each joint."""
        named = self.model.reactions.values()
        rows = np.zeros((len(named), count))
        for row, (element, axis) in zip(rows, named, strict=True):
            row[first[element] : first[element] + axes.shape[1]] = axes[axis]
        return rows if len(rows) else None

    def linear(self, rows: Mapping[str, Array], at_zero: Mapping[str, float]) -> dict[str, Any]:
        """Return what `ExudynSystem` takes of joints that are linear in Exudyn's coordinates.

        Parameters
        ----------
        rows : mapping of joint to array (N,)
        at_zero : mapping of joint to its value where Exudyn's coordinates are 0
        """
        readout = np.zeros((len(self.scene.coordinates), len(next(iter(rows.values())))))
        origin = np.zeros(len(readout))
        for i, reach in self.sums():
            for name in reach.keys() & rows.keys():
                readout[i] += reach[name] * rows[name]
                origin[i] += reach[name] * at_zero[name]
        seen = [name for name in rows if name in self.scene.observed]

        def outputs(coordinates: Array, rates: Array) -> dict[str, Array]:
            places = {name: rows[name] @ coordinates + at_zero[name] for name in seen}
            return places | {f"{name}_dot": rows[name] @ rates for name in seen}

        return {"readout": readout, "origin": origin, "outputs": outputs}


def to_axis(axis: Array) -> Array:
    """Return a rotation (3, 3) that takes z to a unit axis."""
    x = np.cross(np.eye(3)[np.argmin(np.abs(axis))], axis)
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


def add_loads(
    mbs: Any, source: ExudynSource, nodes: list[Any], rows: Mapping[str, Array]
) -> tuple[Any, ...]:
    """Add springs, dampers and actuators of joints that are linear in Exudyn's coordinates.

    Parameters
    ----------
    nodes : list of node numbers, which have as many coordinates each
    rows : mapping of joint to array (N,)
        The joint, less its ``ref``, as a sum of coordinates.

    Returns
    -------
    functions that must live as long as the system
    """
    functions: tuple[Any, ...] = ()
    per_node = len(next(iter(rows.values()))) // len(nodes)
    still = items.MarkerNodeCoordinate(
        nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0
    )
    for term, reach, force, waves in source.loads():
        row = np.sum([factor * rows[name] for name, factor in reach.items()], axis=0)
        markers = []
        for i in np.flatnonzero(row):
            place = {"nodeNumber": nodes[i // per_node], "coordinate": int(i % per_node)}
            markers.append(mbs.AddMarker(items.MarkerNodeCoordinate(**place)))
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
    functions = add_loads(mbs, source, [node], rows)
    mbs.Assemble()
    places = [[one.name for one in whole.joints].index(name) for name in names]
    refs = np.array([source.refs[name] for name in names])

    def at(q: Array, v: Array) -> tuple[Array, Array]:
        positions, velocities = source.motion(q, v)
        return positions[places] - refs, velocities[places]

    return ExudynSystem(
        mbs, at, container=container, functions=functions, **source.linear(rows, source.refs)
    )


def build_plane(source: ExudynSource) -> ExudynSystem:
    """Return bodies in the plane, (x, y, angle) of each centre of mass, joined by constraints."""
    container, bodies, whole = exudyn.SystemContainer(), source.bodies, source.whole
    mbs, size = container.AddSystem(), 3 * len(bodies)
    first = {i: 3 * k for k, i in enumerate(bodies)}
    centres = {i: Site(i, whole.bodies[i].centre) for i in bodies}
    nodes, numbers = [], {0: mbs.AddObject(items.ObjectGround())}
    for i in bodies:
        (x, y, _), turn = source.start.point(centres[i]), source.start.rotations[i]
        angle = float(np.arctan2(turn[1, 0], turn[0, 0]))
        nodes.append(mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[x, y, angle])))
        numbers[i] = mbs.AddObject(
            items.ObjectRigidBody2D(
                mass=whole.bodies[i].mass,
                inertia=float(source.tensor(i)[2, 2]),
                nodeNumber=nodes[-1],
            )
        )

    fixed = mbs.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0)
    )

    def add_hinge(*sites: Site) -> None:
        markers = [
            mbs.AddMarker(
                items.MarkerBodyPosition(
                    bodyNumber=numbers[site.body],
                    localPosition=(site.position - whole.bodies[site.body].centre).tolist(),
                )
            )
            for site in sites
        ]
        mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=markers))

    rows, multipliers, count = {}, {}, 0
    for i, one in source.joints.items():
        body, row, axis = whole.bodies[i], np.zeros(size), source.axis(i)
        multipliers[f"body:{body.name}"], count = count, count + 2
        if one.hinge:
            row[first[i] + 2] = axis[2]
            if body.parent:
                row[first[body.parent] + 2] = -axis[2]
            add_hinge(Site(body.parent, body.position), Site(i, np.zeros(3)))
        else:  # along x or y of the world
            row[first[i] : first[i] + 2] = axis[:2]
            for k in (int(np.argmin(np.abs(axis[:2]))), 2):
                node = nodes[bodies.index(i)]
                marker = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=k))
                mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[fixed, marker]))
        rows[one.name] = row
    for closure in whole.closures:
        multipliers[f"connect:{closure.name}"], count = count, count + 2
        add_hinge(closure.first, closure.second)
    weigh(mbs, [numbers[i] for i in bodies], whole.gravity.tolist())
    functions = add_loads(mbs, source, nodes, rows)
    mbs.Assemble()
    opened = np.array([one.ref for one in whole.joints])

    def at(q: Array, v: Array) -> tuple[Array, Array]:
        positions, velocities = source.motion(q, v)
        now, (coordinates, rates) = place(whole, positions), np.zeros((2, size))
        for i, k in first.items():
            turning = now.turning(i)[2]
            shift = now.point(centres[i]) - source.start.point(centres[i])
            coordinates[k : k + 3] = *shift[:2], turning @ (positions - opened)
            rates[k : k + 3] = *(now.jacobian(centres[i]) @ velocities)[:2], turning @ velocities
        return coordinates, rates

    return ExudynSystem(
        mbs,
        at,
        container=container,
        functions=functions,
        multipliers=source.reactions(multipliers, count, np.eye(3)[:, :2]),
        **source.linear(rows, source.refs),
    )


class Marking(NamedTuple):
    """Where markers stand on bodies in space.

    Attributes
    ----------
    numbers : mapping of int to Exudyn's number of a body
    origins : mapping of int to array (3,)
        The reference point of each body in its frame.
    """

    mbs: Any
    numbers: Mapping[int, Any]
    origins: Mapping[int, Array]

    def point(self, site: Site) -> Any:
        """Return a marker at a point, along the frame of its body."""
        at = (site.position - self.origins[site.body]).tolist()
        number = self.numbers[site.body]
        return self.mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=number, localPosition=at))

    def frames(self, *ends: tuple[Site, Array]) -> dict[str, Any]:
        """Return the markers of frames, each a point and a rotation (3, 3) in its body."""
        if "localHT" not in parameters(Items.module, "MarkerBodyRigid"):  # before 1.12.244
            turns = {f"rotationMarker{k}": turn for k, (_, turn) in enumerate(ends)}
            return {"markerNumbers": [self.point(site) for site, _ in ends], **turns}
        markers = []
        for site, turn in ends:
            at = site.position - self.origins[site.body]
            frame = np.block([[turn, at[:, None]], [np.eye(4)[3]]])
            number = self.numbers[site.body]
            markers.append(
                self.mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=number, localHT=frame))
            )
        return {"markerNumbers": markers}


def build_space(source: ExudynSource) -> ExudynSystem:
    """Return bodies with Euler parameters, (x, y, z, q_w, q_x, q_y, q_z), joined by constraints.

    The place of a body is that of its joint, or, in a plane mechanism, of its centre of mass.
    Exudyn adds the constraint |q| = 1 of each body.
    """
    container, bodies, whole = exudyn.SystemContainer(), source.bodies, source.whole
    mbs, size = container.AddSystem(), 7 * len(bodies)
    first = {i: 7 * k for k, i in enumerate(bodies)}
    shift = 0.0 if whole.layout.is_spatial else 1.0
    origins = {i: shift * whole.bodies[i].centre for i in (0, *bodies)}
    nodes, numbers = [], {0: mbs.AddObject(items.ObjectGround())}
    for i in bodies:
        node, numbers[i] = add_body(mbs, whole.bodies[i], source.tensor(i), origins[i])
        nodes.append(node)
    marking = Marking(mbs, numbers, origins)
    multipliers, count, rows, at_zero = {}, len(bodies), {}, {}
    for i, one in source.joints.items():
        body, turn = whole.bodies[i], to_axis(one.axis)
        base, own = Site(body.parent, body.position), Site(i, np.zeros(3))
        frames = (base, body.rotation @ turn), (own, turn)
        multipliers[f"body:{body.name}"] = count
        if one.kind == "hinge":
            mbs.AddObject(items.ObjectJointRevoluteZ(**marking.frames(*frames)))
            count += 5
        elif one.kind == "ball":
            ends = [marking.point(base), marking.point(own)]
            mbs.AddObject(items.ObjectJointSpherical(markerNumbers=ends))
            count += 3
        elif one.kind == "slide":
            constrained = [1, 1, 0, 1, 1, 1]
            if whole.closures:  # hinges keep the loop in its plane
                constrained[int(np.argmax(np.abs(turn[2, :2])))] = 0
            joint = items.ObjectJointGeneric(**marking.frames(*frames), constrainedAxes=constrained)
            mbs.AddObject(joint)
            count += 6
            rows[one.name] = np.zeros(size)
            rows[one.name][first[i] : first[i] + 3] = source.axis(i)
            here = source.start.point(Site(i, origins[i]))
            at_zero[one.name] = one.ref - float(source.axis(i) @ here)
    for closure in whole.closures:
        multipliers[f"connect:{closure.name}"], count = count, count + 3
        ends = [marking.point(closure.first), marking.point(closure.second)]
        mbs.AddObject(items.ObjectJointSpherical(markerNumbers=ends))
    weigh(mbs, [numbers[i] for i in bodies], whole.gravity.tolist())
    hinges, functions = add_springs(source, marking, nodes, first)
    mbs.Assemble()
    more = source.linear(rows or {"": np.zeros(size)}, at_zero)
    turn = turn_quaternion(right_handed(world_axes(source.placement)))
    for attitude in source.scene.quaternions:
        rows_of = [source.scene.coordinates.index(name) for name in attitude.coordinates]
        k = first[source.carrier(attitude.name)]
        more["readout"][rows_of, k + 3 : k + 7] = turn.T
        more["origin"][rows_of] = turn.T @ UPRIGHT
        for axis, name in zip(
            world_axes(source.placement).T, attitude.place, strict=bool(attitude.place)
        ):
            more["readout"][source.scene.coordinates.index(name), k : k + 3] = axis

    def at(q: Array, v: Array) -> tuple[Array, Array]:
        positions, velocities = source.motion(q, v)
        now, attitudes = place(whole, positions), {0: UPRIGHT}
        coordinates, rates = np.zeros((2, size))
        for i, k in first.items():
            body, origin = whole.bodies[i], Site(i, origins[i])
            joint = positions[whole.layout.positions[body.joints[0]]]
            attitudes[i] = attitude_of(source.joints[i], body, attitudes[body.parent], joint)
            spin = [0.0, *(now.turning(i) @ velocities / 2)]
            coordinates[k : k + 7] = *now.point(origin), *(attitudes[i] - UPRIGHT)
            rates[k : k + 7] = *(now.jacobian(origin) @ velocities), *product(spin, attitudes[i])
        return coordinates, rates

    return ExudynSystem(
        mbs,
        at,
        container=container,
        functions=functions,
        hinges=hinges,
        multipliers=source.reactions(multipliers, count, world_axes(source.placement).T),
        **more,
    )


def attitude_of(one: Joint, body: Body, parent: Array, position: Array) -> Array:
    """Return the unit quaternion of a body in the world, by that of its parent and its joint."""
    if one.kind == "free":
        return position[3:]
    turn = position if one.kind == "ball" else UPRIGHT
    if one.hinge:
        half = (position[0] - one.ref) / 2
        turn = np.append(np.cos(half), np.sin(half) * one.axis)
    return np.array(product(parent, product(turn_quaternion(body.rotation) @ UPRIGHT, turn)))


def add_body(mbs: Any, body: Body, tensor: Array, origin: Array) -> tuple[Any, Any]:
    """Add a body, its inertia tensor (3, 3) about its centre of mass; return node and number."""
    arm = body.centre - origin
    about = tensor + body.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    xx, yy, zz, xy, xz, yz = (float(about[place]) for place in PLACES)
    node = mbs.AddNode(items.NodeRigidBodyEP(referenceCoordinates=[0, 0, 0, *UPRIGHT]))
    number = mbs.AddObject(
        items.ObjectRigidBody(
            mass=body.mass,
            inertia=[xx, yy, zz, yz, xz, xy],
            centerOfMass=arm.tolist(),
            nodeNumber=node,
        )
    )
    return node, number


def add_springs(
    source: ExudynSource, marking: Marking, nodes: list[Any], first: Mapping[int, int]
) -> tuple[tuple[Hinge, ...], tuple[Any, ...]]:
    """Add springs, dampers and actuators between bodies in space.

    Returns
    -------
    hinges : tuple of Hinge
        The scene's coordinates that are angles, each counted by a torsion spring.
    functions that must live as long as the system
    """
    mbs, whole, functions = marking.mbs, source.whole, ()
    angles = {ends: i for i, reach in source.sums() if (ends := source.twisted(reach))}
    torsion = dict.fromkeys(angles, np.zeros(3))
    for term, reach, force, waves in source.loads():
        numbers = np.array([-term.per_length, -term.per_rate, -force])
        if ends := source.twisted(reach):
            torsion[ends] = torsion.get(ends, 0) + numbers
            continue
        (i,) = map(source.carrier, reach)
        body, one = whole.bodies[i], source.joints[i]
        markers = [
            marking.point(Site(body.parent, body.position)),
            marking.point(Site(i, np.zeros(3))),
        ]
        if one.kind == "ball":
            damping = -term.per_rate * np.diag([0, 0, 0, 1, 1, 1])
            spring = items.ObjectConnectorRigidBodySpringDamper(
                markerNumbers=markers, damping=damping
            )
        else:
            spring = items.ObjectConnectorLinearSpringDamper(
                markerNumbers=markers,
                axisMarker0=(body.rotation @ one.axis).tolist(),
                stiffness=-term.per_length,
                damping=-term.per_rate,
                force=-force,
            )
            for k, share in enumerate(source.axis(i).tolist()):
                place = {"nodeNumber": nodes[first[i] // 7], "coordinate": k}
                marker = mbs.AddMarker(items.MarkerNodeCoordinate(**place))
                for amplitude, omega in waves:
                    functions += harmonic_load(mbs, marker, float(amplitude * share), omega)
        mbs.AddObject(spring)
    hinges = []
    for ends, (stiffness, damper, torque) in torsion.items():
        axis = source.axis(ends[1])
        frames = [
            (Site(k, marking.origins[k]), source.start.rotations[k].T @ to_axis(axis)) for k in ends
        ]
        count = {}
        if ends in angles:
            count["nodeNumber"] = mbs.AddNode(
                items.NodeGenericData(initialCoordinates=[0.0], numberOfDataCoordinates=1)
            )
            hinges.append(
                Hinge(
                    angles[ends],
                    tuple(source.start.rotations[k].T @ axis for k in ends),
                    tuple(first[k] + 3 if k else None for k in ends),
                )
            )
        mbs.AddObject(
            items.ObjectConnectorTorsionalSpringDamper(
                **marking.frames(*frames),
                **count,
                stiffness=stiffness,
                damping=damper,
                torque=torque,
            )
        )
    return tuple(hinges), functions


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
        reactions={name: i for i, name in enumerate(mjcf.reactions)},
        **more,
    )
