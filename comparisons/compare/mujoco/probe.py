"""Compile a model and evaluate it, in a Python that has only MuJoCo and NumPy.

``python probe.py FOLDER`` reads one request in JSON from each line of standard input, writes its
answer to FOLDER/answer.npz, and prints the line ``ok`` or ``error: REASON``. Other installations of
Python run it, down to MuJoCo 3.2, so it imports nothing of mbcheck.
"""

from __future__ import annotations

import copy
import json
import os
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

KINDS = (
    "body", "joint", "geom", "site", "mesh", "hfield", "flex", "tendon", "equality", "actuator",
    "sensor", "key", "pair", "exclude",
)  # fmt: skip
"""Kinds of elements, as MuJoCo names its objects."""

ENUMERATIONS = {
    "jnt_type": "mjtJoint",
    "geom_type": "mjtGeom",
    "site_type": "mjtGeom",
    "eq_type": "mjtEq",
    "eq_objtype": "mjtObj",
    "actuator_trntype": "mjtTrn",
    "actuator_dyntype": "mjtDyn",
    "actuator_gaintype": "mjtGain",
    "actuator_biastype": "mjtBias",
    "sensor_type": "mjtSensor",
    "sensor_objtype": "mjtObj",
    "sensor_reftype": "mjtObj",
    "wrap_type": "mjtWrap",
    "efc_type": "mjtConstraint",
    "opt.integrator": "mjtIntegrator",
    "opt.cone": "mjtCone",
    "opt.solver": "mjtSolver",
    "opt.jacobian": "mjtJacobian",
    "opt.disableflags": "mjtDisableBit",
    "opt.enableflags": "mjtEnableBit",
}
"""Field -> the enumeration of its numbers, which releases change: answers and edits have its words.

Those of flags are bits."""

PARTS = (
    "xpos", "xmat", "ten_length", "ten_velocity", "actuator_length", "actuator_force",
    "qacc_smooth", "qfrc_bias", "qfrc_spring", "qfrc_damper", "qfrc_gravcomp", "qfrc_fluid",
    "qfrc_actuator",
)  # fmt: skip
"""Arrays of ``MjData``."""

INTEGRATORS = ("euler", "rk4", "implicit", "implicitfast")

MAX_RESTARTS = 30
"""Largest number of times that the solver starts again from its answer, until that has settled."""

ITERATIONS = 30
"""Iterations of the solver each time."""

SETTLED = 1e-14
"""Relative change of accelerations below which they have settled."""

PERTURBED = 1.001
"""Factor of the accelerations from which the solver starts a second time; the distance of both
answers is its error."""

Answer = dict[str, Any]


def compiled(model: Any) -> Answer:
    """Return a model as arrays: fields, options and their defaults, and names."""
    answer: Answer = {"version": mujoco.__version__}
    empty = mujoco.MjModel.from_xml_string("<mujoco/>")
    for group, owner in (("", model), ("opt.", model.opt), ("default.", empty.opt)):
        for name in dir(owner):
            value = None if name.startswith("_") else getattr(owner, name)
            if isinstance(value, (np.ndarray, int, float)):
                answer[group + name] = in_words(group + name, np.asarray(value))
    for kind in KINDS:
        number = int(getattr(mujoco.mjtObj, "mjOBJ_" + kind.upper()))
        short = {"joint": "jnt", "equality": "eq"}.get(kind, kind)
        count = len(getattr(model, f"name_{short}adr", ()))
        names = [mujoco.mj_id2name(model, number, i) or "" for i in range(count)]
        answer[f"names.{kind}"] = np.array(names, dtype=str)
    return answer


def written(file: str) -> Any:
    """Return the model that MuJoCo reads from what it writes of a file."""
    spec = mujoco.MjSpec.from_file(file)
    spec.compile()
    again = mujoco.MjSpec.from_string(spec.to_xml())
    again.modelfiledir = os.path.dirname(file)
    return again.compile()


def words_of(field: str) -> Mapping[int, str]:
    """Return the words of an enumeration by their numbers."""
    members = getattr(mujoco, ENUMERATIONS[field]).__members__.items()
    words = {int(number): name.partition("_")[2].lower() for name, number in members if "_" in name}
    return words  # counts of members, such as mjNDISABLE, may be equal to one of them


def in_words(field: str, values: Any) -> Any:
    """Return the values of a field, words in place of numbers of an enumeration."""
    if field not in ENUMERATIONS:
        return values
    words = words_of(field)
    if field.endswith("flags"):
        return np.array([word for bit, word in words.items() if values & bit], dtype=str)
    named = [words.get(int(one), f"number {one}") for one in values.flat]
    return np.array(named, dtype=str).reshape(values.shape)


def edited(model: Any, edits: Sequence[tuple[str, Any, Any]], derive: bool) -> Any:
    """Return a copy of a model with fields, or rows of them, set to values."""
    copied = copy.deepcopy(model)
    for field, row, value in edits:
        name = field.removeprefix("opt.")
        owner = copied if name == field else copied.opt
        old = getattr(owner, name)
        if field in ENUMERATIONS:
            words = [value] if isinstance(value, str) else value
            value = sum(number for number, word in words_of(field).items() if word in words)
        if np.ndim(old) == 0:
            setattr(owner, name, type(old)(value))
        else:
            old[slice(None) if row is None else row] = value
    if derive:
        for joint in np.flatnonzero(copied.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)):
            body, place = copied.jnt_bodyid[joint], copied.jnt_qposadr[joint]
            pose = np.hstack([copied.body_pos[body], copied.body_quat[body]])
            copied.qpos0[place : place + 7] = copied.qpos_spring[place : place + 7] = pose
        mujoco.mj_setConst(copied, mujoco.MjData(copied))
        return edited(copied, edits, False)  # some of which that has written anew
    return copied


def data_at(model: Any, state: Mapping[str, Any], start: Any = 0.0) -> Any:
    """Return data at a state, whose solver starts from accelerations."""
    data = mujoco.MjData(model)
    for name, value in state.items():
        getattr(data, name)[:] = value
    data.qacc_warmstart[:] = start
    return data


def solved(model: Any, state: Mapping[str, Any], start: Any = 0.0) -> Any:
    """Return data at a state, constraints solved from accelerations until nothing changes."""
    data = data_at(model, state)
    mujoco.mj_forward(model, data)
    data.qacc_warmstart[:] = start
    last, before = data.qacc.copy(), np.inf
    for _ in range(MAX_RESTARTS):
        mujoco.mj_forward(model, data)
        change = abs(data.qacc - last).max(initial=0.0)
        if change >= before or change <= SETTLED * abs(data.qacc).max(initial=0.0):
            break
        last, before = data.qacc.copy(), change
        data.qacc_warmstart[:] = last
    return data


def evaluated(model: Any, states: Sequence[Mapping[str, Any]], brief: bool) -> Iterator[Answer]:
    """Yield what a model does at states; in brief accelerations and mass matrices alone.

    The solver starts twice, the answer is the first and its error the distance of both: ``_floor``.
    """
    settings: list[tuple[str, Any, Any]] = [
        ("opt.tolerance", None, 0.0),
        ("opt.solver", None, ["newton"]),
        ("opt.iterations", None, ITERATIONS),
        ("opt.noslip_iterations", None, 0),  # they depend on the order of joints
    ]
    exact = edited(model, settings, False)
    integrators = () if brief else INTEGRATORS
    others = {one: edited(exact, [("opt.integrator", None, [one])], False) for one in integrators}
    for state in states:
        data = solved(exact, state)
        answer = {"qacc": data.qacc.copy(), "mass": matrix(mujoco.mj_mulM, exact, data)}
        if brief:
            yield answer
            continue
        answer["qacc_floor"] = abs(data.qacc - solved(exact, state, PERTURBED * data.qacc).qacc)
        answer |= {**smooth(model, state), **constraint_rows(exact, data), **contacts(data)}
        for name, other in others.items():
            ends = [stepped(other, state, start * data.qacc) for start in (1.0, PERTURBED)]
            answer[f"step_{name}"], answer[f"step_{name}_floor"] = ends[0], abs(ends[1] - ends[0])
        yield answer


def stepped(model: Any, state: Mapping[str, Any], start: Any) -> Any:
    """Return positions, velocities and activations after a step, see `data_at`."""
    data = data_at(model, state, start)
    mujoco.mj_step(model, data)
    return np.concatenate([data.qpos, data.qvel, data.act])


def smooth(model: Any, state: Mapping[str, Any]) -> Answer:
    """Return kinematics, mass matrix and forces at a state, without constraints."""
    at_rest, data = (data_at(model, one) for one in ({"qpos": state["qpos"]}, state))
    mujoco.mj_forward(model, at_rest)
    mujoco.mj_forward(model, data)
    answer: Answer = {"gravity": at_rest.qfrc_bias}
    for name in PARTS:
        if hasattr(data, name):  # releases tell fewer forces apart
            answer[name.removeprefix("qfrc_")] = getattr(data, name)
    return {name: np.array(value, dtype=float) for name, value in answer.items()}


def matrix(product: Any, model: Any, data: Any, rows: int | None = None) -> Any:
    """Return the matrix (rows, nv) of a product of MuJoCo with vectors; without rows it is M."""
    columns = np.zeros((model.nv, model.nv if rows is None else rows))
    for i, unit in enumerate(np.eye(model.nv)):
        product(model, data, columns[i], unit)
    return columns.T


def constraint_rows(model: Any, data: Any) -> Answer:
    """Return the rows of constraints at a state: type, element, and numbers of each."""
    jacobian = matrix(mujoco.mj_mulJacVec, model, data, data.nefc) if data.nefc else []
    return {
        "row_type": in_words("efc_type", data.efc_type),
        "row_id": data.efc_id.copy(),
        "row_pos": data.efc_pos.copy(),
        "row_inverse_inertia": 1 / data.efc_D,
        "row_aref": data.efc_aref.copy(),
        "row_frictionloss": data.efc_frictionloss.copy(),
        "row_stiffness": data.efc_KBIP.reshape(-1, 4)[:, 0].copy(),
        "row_jacobian": np.reshape(jacobian, (data.nefc, model.nv)),
    }


def contacts(data: Any) -> Answer:
    """Return the contacts at a state."""
    every = [data.contact[i] for i in range(data.ncon)]
    names = ("dist", "dim", "includemargin", "pos", "frame", "friction", "solref", "solimp")
    rows = [np.hstack([getattr(one, name) for name in names]) for one in every]
    return {
        "contact_geoms": np.array([[one.geom1, one.geom2] for one in every]).reshape(-1, 2),
        "contact_numbers": np.array(rows).reshape(len(every), 27),
    }


def touching(model: Any, states: Sequence[Mapping[str, Any]]) -> Answer:
    """Return which geoms touch at each state, and the depth of the shallowest contact [m]."""
    geoms = np.zeros((len(states), model.ngeom), dtype=bool)
    shallowest = np.full(len(states), np.inf)
    for i, state in enumerate(states):
        data = data_at(model, state)
        mujoco.mj_fwdPosition(model, data)
        for contact in (data.contact[k] for k in range(data.ncon)):
            geoms[i, [contact.geom1, contact.geom2]] = True
            shallowest[i] = min(shallowest[i], abs(contact.dist))
    return {"geoms": geoms, "shallowest": shallowest}


def main() -> None:
    """Answer requests until there are none left."""
    model = None
    for line in sys.stdin:
        request = json.loads(line)
        try:
            if "file" in request:
                model = mujoco.MjModel.from_xml_path(request["file"])
                answer = compiled(model)
            elif "written" in request:
                answer = compiled(written(request["written"]))
            elif "touching" in request:
                answer = touching(model, request["touching"])
            else:
                own = edited(model, request["edits"], bool(request["edits"]))
                every = enumerate(evaluated(own, request["states"], request["brief"]))
                answer = {f"{i}.{key}": value for i, one in every for key, value in one.items()}
            np.savez(f"{sys.argv[1]}/answer.npz", **answer)
        except Exception as error:
            print("error:", " ".join(f"{error}".split()) or type(error).__name__, flush=True)
        else:
            print("ok", flush=True)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main()
