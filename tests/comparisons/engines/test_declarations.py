"""What engines declare beside the least, each by an engine of someone else that does."""

from __future__ import annotations

import ast
import inspect
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.engines import protocol
from mbcheck.comparisons.engines.adapter import CLOSURE_TIME, adapt
from mbcheck.comparisons.engines.registry import remote_plugin
from mbcheck.comparisons.engines.setup import Setup, run
from mbcheck.comparisons.engines.validation import RENAMED
from mbcheck.examples.mujoco_engine import MujocoPlugin
from mbcheck.models import mjcf
from mbcheck.reference import get_scene
from mbcheck.reference.errors import EngineError
from mbcheck.reference.hula_hoop.equations import HulaHoop
from mbcheck.reference.scene import Case
from mbcheck.reference.speed_regulator.soft import soft_scene
from mbcheck.tests.support.example import bad, results

mujoco: Any = pytest.importorskip("mujoco")

HOOPS = [Case("hula_hoop", "test", HulaHoop(), {"theta": angle}) for angle in (0.1, 0.2, 0.3)]
ROTATION = get_scene("speed_regulator").case("rotation")
RK4 = MujocoPlugin.methods[0]
TIMES = np.array([0.25, 0.5])


# Options ------------------------------------------------------------------------------------


class Rounding(MujocoPlugin):
    """An engine whose results have so many digits as an option says."""

    name = "rounding"
    digits = 12.0

    def options(self, system: Any, method: Any) -> tuple[mbcheck.Option, ...]:
        return (mbcheck.Option("digits", "1", 12.0, (3.0, 12.0), "digits"),)

    def simulate(self, *call: Any) -> mbcheck.Motion:
        motion = super().simulate(*call)
        return replace(motion, positions=np.round(motion.positions, int(self.digits)))


def test_options_are_set_and_limit_accuracy() -> None:
    engine = adapt("rounding", Rounding())
    setup = Setup(engine, HOOPS[0], "tree", RK4, 2.0**-6)
    (option,) = engine.bind(setup.case, "tree").options(RK4)
    fine, coarse = (run(setup.with_option(option.name, value), TIMES) for value in (12.0, 3.0))
    assert 0 < np.max(np.abs(fine.values["y"] - coarse.values["y"])) < 1e-3
    assert engine.inner.digits == 12.0  # type: ignore[attr-defined]


def test_an_engine_that_reads_the_softness_of_loops_has_that_as_an_option() -> None:
    engine = adapt("plugin", MujocoPlugin())
    assert engine.bind(ROTATION, "connect_hard").options(RK4) == (CLOSURE_TIME,)
    assert engine.bind(ROTATION, "connect").options(RK4) == ()
    softer = engine.with_option("closure_time", 0.02)
    text = softer.bind(ROTATION, "connect_hard").text
    assert "-2500 -100" in text
    equations = softer.bind(ROTATION, "connect_hard").own_equations
    assert equations is not None
    assert equations.scene is not soft_scene()
    assert engine.bind(ROTATION, "connect_hard").system(ROTATION).mjcf != text


def test_options_reach_an_engine_in_another_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "rounds.py").write_text(
        "import numpy as np\nimport mbcheck\nfrom dataclasses import replace\n"
        "from mbcheck.examples.mujoco_engine import MujocoPlugin\n\n\n"
        "class Rounding(MujocoPlugin):\n    name, digits = 'rounds', 12.0\n"
        "    def options(self, system, method):\n"
        "        return (mbcheck.Option('digits', '1', 12.0, (3.0, 12.0), 'digits'),)\n"
        "    def simulate(self, *call):\n        motion = super().simulate(*call)\n"
        "        return replace(motion, positions=np.round(motion.positions, int(self.digits)))\n"
    )
    monkeypatch.chdir(tmp_path)
    engine = remote_plugin("rounds:Rounding")
    assert [one.name for one in engine.bind(HOOPS[0], "tree").options(RK4)] == ["digits"]
    setup = Setup(engine, HOOPS[0], "tree", RK4, 2.0**-6)
    fine, coarse = (run(setup.with_option("digits", value), TIMES) for value in (12.0, 3.0))
    assert np.array_equal(coarse.values["y"], np.round(coarse.values["y"], 3))
    assert 0 < np.max(np.abs(fine.values["y"] - coarse.values["y"])) < 1e-3


class Babbling(MujocoPlugin):
    """An engine whose answers are no answers."""

    def options(self, system: Any, method: Any) -> Any:
        return (("digits", 12.0),)

    def unsupported_reason(self, system: Any, method: Any) -> Any:
        return False


def test_answers_that_have_no_sense_are_refused() -> None:
    engine = adapt("babbling", Babbling())
    with pytest.raises(EngineError, match=r"tuple of mbcheck\.Option, not"):
        engine.bind(HOOPS[0], "tree").options(RK4)
    said = "unsupported_reason: unsupported_reason must return"
    with pytest.raises(mbcheck.UsageError, match=said):
        engine.bind(HOOPS[0], "tree").unsupported_reason(HOOPS[0], RK4)


def test_states_that_are_one_buffer_are_refused() -> None:
    class Viewing(MujocoPlugin):
        def simulate(self, *call: Any) -> mbcheck.Motion:
            motion = super().simulate(*call)
            last = (np.tile(x[-1], (len(x), 1)) for x in (motion.positions, motion.velocities))
            return replace(motion, **dict(zip(("positions", "velocities"), last, strict=True)))

    class Resetting(Viewing):
        def simulate(self, *call: Any) -> mbcheck.Motion:
            motion = super().simulate(*call)
            return replace(motion, clock=np.full(len(motion.positions), 2.0**-9))

    for plugin, said in ((Viewing, "copy each as it comes"), (Resetting, "clock shows")):
        engine = adapt("viewing", plugin())
        setup = Setup(engine, HOOPS[0], "tree", RK4, 2.0**-9)
        with pytest.raises(EngineError, match=said):
            run(setup, TIMES)


@pytest.mark.parametrize("name", ["options", "reactions", "describe_model", "unsupported_reason"])
def test_a_table_under_the_name_of_a_function_is_refused(name: str) -> None:
    with pytest.raises(mbcheck.UsageError, match=f"{name} must be a function.*rename it"):
        adapt("tables", type("Tables", (MujocoPlugin,), {name: {}}))


def test_what_does_not_inherit_is_refused() -> None:
    follower = type("Follower", (), {"name": "follower", "version": "1", "methods": (RK4,)})
    with pytest.raises(mbcheck.UsageError, match=r"no mbcheck\.Engine: inherit from it"):
        adapt("follower", follower)


def test_observables_at_which_nobody_looks_are_refused() -> None:
    class Chatty(MujocoPlugin):
        def simulate(self, *call: Any) -> mbcheck.Motion:
            motion = super().simulate(*call)
            return replace(motion, observables={"Y": motion.positions[:, 0]})

    with pytest.raises(EngineError, match=r"Motion\.observables holds 'Y'; known: y, theta, "):
        adapt("chatty", Chatty).bind(HOOPS[0], "tree").simulate(HOOPS[0], RK4, 2.0**-6, TIMES)


class Refusing(MujocoPlugin):
    """An engine that raises where it should return a reason."""

    def unsupported_reason(self, system: Any, method: Any) -> Any:
        raise mbcheck.Unsupported("no springs")


def test_unsupported_is_a_reason_too() -> None:
    model = adapt("refusing", Refusing()).bind(HOOPS[0], "tree")
    assert model.unsupported_reason(HOOPS[0], RK4) == "no springs"


class Single(mbcheck.Engine):
    """An engine of which one method has numbers of 32 bits."""

    name, version = "single", "1"
    methods = (mbcheck.Method("single", 1, precision="float32"), mbcheck.Method("double", 1))

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> mbcheck.Motion:
        states = (np.tile(row, (len(times), 1)) for row in (system.positions, system.velocities))
        q, v = states
        return mbcheck.Motion(q * (1 + 1.2e-7), v)


def test_quaternions_have_the_length_that_their_method_can_keep() -> None:
    engine, case = adapt("single", Single()), get_scene("rigid_body").case("free_euler")
    single, double = engine.methods
    engine.bind(case, "ball").simulate(case, single, 0.25, TIMES)
    with pytest.raises(EngineError, match="a quaternion has the length"):
        engine.bind(case, "ball").simulate(case, double, 0.25, TIMES)


# Loops: reactions, inverse dynamics, sensors ---------------------------------------------------


class Telling(MujocoPlugin):
    """An engine that tells reactions and inverse dynamics, and has sensors."""

    name = "telling"
    sign = 1.0
    late = 0.0

    def reactions(self, system: Any, time: float, q: Any, v: Any) -> dict[str, float]:
        self.call(mujoco.mj_forward, system, time, q, v)
        mujoco.mj_rnePostConstraint(self.model, self.data)
        on_rod = -self.data.cfrc_int[self.model.body("rod").id, 3:]
        forces = {"body:rod": self.sign * on_rod, "connect:closure": self.data.efc_force[:3]}
        return {name: forces[place] @ way for name, (place, way) in system.reactions.items()}

    def inverse_dynamics(self, system: Any, time: float, q: Any, v: Any, a: Any) -> Any:
        self.call(mujoco.mj_forward, system, time, q, v)
        self.data.qacc[:] = a
        mujoco.mj_inverse(self.model, self.data)
        return self.data.qfrc_inverse - self.data.qfrc_actuator

    def simulate(self, system: Any, *rest: Any) -> mbcheck.Motion:
        motion = super().simulate(system, *rest)
        place = system.joints.index("y") if "y" in system.joints else None
        seen = {} if place is None else {"y": motion.positions[:, place] + self.late}
        return replace(motion, observables=seen)


def quantities(engine: mbcheck.Engine, kind: str, case: str) -> dict[str, set[str]]:
    """Return the verdicts of a kind of check by quantity."""
    verdicts: dict[str, set[str]] = {}
    for item in results(engine, "speed_regulator", (kind,), case):
        if item.verdict == "skipped":  # one of the models has no loop
            continue
        verdicts.setdefault(item.quantity, set()).add(item.verdict)
    return verdicts


def test_reactions_are_checked_where_an_engine_tells_them() -> None:
    names = {"reaction_a_x", "reaction_a_y", "reaction_b_x", "reaction_b_y"}
    assert not names & set(quantities(MujocoPlugin(), "algebra", "rotation"))
    right = quantities(Telling(), "algebra", "rotation")
    assert names < set(right)
    assert set.union(*right.values()) == {"pass"}
    wrong = Telling()
    wrong.sign = -1.0
    verdicts = quantities(wrong, "algebra", "rotation")
    assert {name for name in names if verdicts[name] != {"pass"}} == {
        "reaction_a_x",
        "reaction_a_y",
    }


def test_inverse_dynamics_tells_the_modes_of_a_soft_loop() -> None:
    scene = get_scene("speed_regulator")
    case = next(case for case in scene.cases if "frequency" in case.kinds)
    silent = results(MujocoPlugin(), scene.name, ("frequency",), case.name)
    assert {item.verdict for item in silent if item.model == "connect"} <= {"skipped"}
    telling = results(Telling(), scene.name, ("frequency",), case.name)
    assert not bad(telling)
    assert "pass" in {item.verdict for item in telling if item.model == "connect"}


def test_sensors_are_checked() -> None:
    wrong = Telling()
    wrong.late = 1e-3
    assert "deviation" in quantities(wrong, "step", "rotation")["y"]
    right = adapt("telling", Telling())
    setup = Setup(right, ROTATION, "connect", RK4, 2.0**-9)
    values = run(setup, TIMES).values
    assert np.array_equal(
        values["y"], run(replace(setup, engine=adapt("p", MujocoPlugin())), TIMES).values["y"]
    )


# Loops that are soft by a rule of one's own ---------------------------------------------------

OWN_SOFTNESS = (0.01, 1.0)


class OwnSoftness(MujocoPlugin):
    """An engine that reads the file, but for the softness of its loop, and tells what that is."""

    name, closure = "own_softness", "soft"
    softness: tuple[float, float] | None = OWN_SOFTNESS

    def at(self, system: Any, *state: Any) -> Any:
        softer = system.mjcf.replace('solref="0.02 1"', 'solref="0.01 1"')
        assert softer != system.mjcf
        return super().at(replace(system, mjcf=softer), *state)

    def describe_model(self, system: Any) -> mbcheck.ModelDescription:
        assert system.mjcf
        if self.softness is None:
            raise mbcheck.Unsupported("its softness depends on the step")
        return mbcheck.ModelDescription(
            equations=(soft_scene(self.softness), system.case.parameters)
        )


def test_a_softness_of_ones_own_is_judged_by_its_equations_where_they_are_told() -> None:
    assert quantities(OwnSoftness(), "algebra", "rotation")["model_error"] == {"pass"}
    for kind in ("algebra", "step"):
        assert set.union(*quantities(OwnSoftness(), kind, "rotation").values()) == {"pass"}
    wrong = OwnSoftness()
    wrong.softness = (0.0101, 1.0)
    assert "deviation" in quantities(wrong, "step", "rotation")["scheme_residual"]
    silent = OwnSoftness()
    silent.softness = None
    assert not quantities(silent, "algebra", "rotation")
    reason = adapt("silent", silent).bind(ROTATION, "connect").unsupported_reason(ROTATION, RK4)
    assert reason == "its softness depends on the step"
    opened = get_scene("speed_regulator").case("opened_loop")
    assert (
        adapt("own", OwnSoftness()).bind(opened, "connect").unsupported_reason(opened, RK4) is None
    )


# Reasons, and the public names -----------------------------------------------------------------


class Reluctant(MujocoPlugin):
    """An engine that says beforehand what it cannot do."""

    name = "reluctant"

    def unsupported_reason(self, system: Any, method: Any) -> str | None:
        return "no body may drive" if system.drivers else None


def test_reasons_are_told_before_a_run() -> None:
    engine = adapt("reluctant", Reluctant())
    assert engine.bind(HOOPS[0], "tree").unsupported_reason(HOOPS[0], RK4) == "no body may drive"
    assert engine.bind(HOOPS[0], "forced").unsupported_reason(HOOPS[0], RK4) is None
    assert "unsupported_reason" not in adapt("plugin", MujocoPlugin()).functions


@pytest.mark.parametrize("folder", ["mujoco", "exudyn"])
def test_built_in_engines_take_public_names_alone(folder: str, clone: Path) -> None:
    """What they import of mbcheck anyone may; models and what is true are libraries below."""
    assert set(protocol.__all__) <= set(mbcheck.__all__)
    files = list((clone / f"comparisons/engines/{folder}").glob("*.py"))
    assert files
    for path in files:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level == 2:
                assert node.module == "protocol", path.name
                assert {one.name for one in node.names} <= set(mbcheck.__all__)
            elif isinstance(node, ast.ImportFrom) and node.level > 2:
                assert str(node.module).split(".")[0] in ("models", "reference"), path.name


# Names of before ----------------------------------------------------------------------------


@pytest.mark.parametrize("old", RENAMED)
def test_an_engine_written_for_old_names_is_told_the_new_ones(old: str) -> None:
    with pytest.raises(mbcheck.UsageError, match=f"{old} is now {RENAMED[old]}: rename it"):
        adapt("older", type("Older", (MujocoPlugin,), {old: lambda *call: None}))
    assert RENAMED[old] in dir(mbcheck.Engine)


def test_the_old_name_of_a_description_is_told() -> None:
    with pytest.raises(AttributeError, match=r"is now mbcheck\.ModelDescription"):
        assert mbcheck.OwnModel


# Several solvers ----------------------------------------------------------------------------


class Solvers(MujocoPlugin):
    """An engine of which one solver adds an acceleration."""

    name, added = "solvers", 1.0

    def accelerations(self, system: Any, time: float, q: Any, v: Any, method: Any = None) -> Any:
        wrong = method is not None and method.name == "Euler"
        return super().accelerations(system, time, q, v) + self.added * wrong


@pytest.mark.parametrize("as_object", [True, False])
def test_accelerations_of_each_solver_are_checked(
    as_object: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "several.py").write_text(
        "from typing import Any\nfrom mbcheck.examples.mujoco_engine import MujocoPlugin\n"
        f"{inspect.getsource(Solvers)}"
    )
    monkeypatch.chdir(tmp_path)
    engine = Solvers() if as_object else "several:Solvers"
    report = mbcheck.check(
        engines=[engine], kinds=["algebra", "parts"], ids=["*/semicircle_3hz_60n/*"]
    )
    verdicts = {(r.kind, r.method, r.verdict) for r in report.results}
    assert {("algebra", "RK4", "pass"), ("algebra", "Euler", "deviation")} <= verdicts
    assert not {one for one in verdicts if one[1] == "RK4" and one[2] != "pass"}
    assert None not in {method for _, method, _ in verdicts}


def test_a_solver_is_no_argument_of_an_engine_that_takes_none() -> None:
    model = adapt("plugin", MujocoPlugin()).bind(HOOPS[0], "tree")
    at = np.zeros(1), np.array([[0.01, 0.2, 0.3, 4.0]])
    assert np.array_equal(model.accelerations(*at), model.accelerations(*at, RK4))
    solvers = adapt("solvers", Solvers()).bind(HOOPS[0], "tree")
    euler = MujocoPlugin.methods[1]
    assert np.max(np.abs(solvers.accelerations(*at, euler) - model.accelerations(*at))) > 0.5


# Compliant joints ---------------------------------------------------------------------------


class Compliant(MujocoPlugin):
    """An engine whose joints give way: here as if the platform were heavier."""

    name, compliant_joints = "compliant", True

    def at(self, system: Any, *state: Any) -> Any:
        model = mjcf.models("hula_hoop")[system.model]
        text = mjcf.export(model, heavier(system.case.parameters, 1.25))
        return super().at(replace(system, mjcf=text), *state)


class Described(Compliant):
    """The same, with its equations."""

    share = 1.25

    def describe_model(self, system: Any) -> mbcheck.ModelDescription:
        own = heavier(system.case.parameters, self.share)
        return mbcheck.ModelDescription(equations=(get_scene("hula_hoop"), own))


def heavier(p: HulaHoop, share: float) -> HulaHoop:
    """Return parameters with a heavier platform."""
    return p.replace(main_mass=share * p.main_mass)


def test_joints_that_give_way_are_skipped_or_judged_by_their_equations() -> None:
    kinds = ("parts", "algebra", "step", "trajectory")
    found = results(Compliant(), "hula_hoop", kinds, "semicircle_3hz_60n")
    assert {item.verdict for item in found} == {"skipped"}
    assert all("its joints give way by a rule of its own" in item.reason for item in found)
    found = results(Described(), "hula_hoop", kinds, "semicircle_3hz_60n")
    assert {item.kind for item in found} == {"algebra", "step", "trajectory"}
    assert not bad(found)
    assert "model_error" in {item.quantity for item in found}
    wrong = type("Wrong", (Described,), {"share": 1.0})
    found = results(wrong(), "hula_hoop", ("algebra",), "semicircle_3hz_60n")
    assert "deviation" in {item.verdict for item in found}


def test_an_engine_with_rigid_joints_describes_no_model_of_a_file() -> None:
    rigid = type("Rigid", (Described,), {"compliant_joints": False})
    with pytest.raises(mbcheck.UsageError, match="compliant_joints = True, or closure"):
        adapt("rigid", rigid)
