"""An inextensible continuum arm of one to six sections: closed forms, its MuJoCo twin, and the measured difference.

The public names are few and load late, so that `import contarm_sim` costs nothing:

    Arm                   the parameters (SI units): sections, muscles and the world they stand in
    Section, Routing, World   what an arm consists of, beside the law of its muscles
    Object                what it can touch: World(objects=(Object(...),))
    Host                  a user's own MJCF that it is attached to
    McKibben, Tendon, Ideal   the laws: pneumatic muscles, elastic cables, tensions as asked for
    presets               arms to begin with: paper, two, three, tendon
    load_arm              an Arm from TOML
    kinematics            closed forms: arc, dome (inverse), muscles, chain
    spec                  the arm as a mujoco.MjSpec to attach to other models
    arm_spec, scene_spec  the arm alone, and in its scene, as a mujoco.MjSpec to compile
    Reference             a motion, or poses at rest: times, tip positions, bends
    simulate              follow a reference in MuJoCo: a Trajectory
    simulate_many         the same of many arms, references or controllers at once
    poses_at_rest         rest poses of a reference in MuJoCo: a Trajectory
    equilibrium           the static pose under a Load (of Wrench, Muscles)
    equilibria            the same of many cases at once
    load                  a Trajectory that `contarm run` left, or of a .npz
    compare               a trajectory beside the closed forms
    Recording             what was commanded of a real arm and measured; load_recording, save_recording
    fit                   an arm and a rig that predict recordings, with intervals; Free, load_fit
    replay                a recording beside what a fitted arm predicts; covariance_of a fit, for bands
    excite                what to command next, so that a fit knows most
    Rig                   what stands around it: frame, Marker, Actuation
    Controller            what drives an arm; subclass it, with Plan and Feedback
    planning              poses and courses that keep clear of objects
    studies               what the commands compute, as functions
    sweeps                many cases of an arm, as a table
    ContarmError          the root of all errors; InputError, EquilibriumError, DivergenceError;
                          Interrupted, InterruptedMany (Ctrl-C)
"""

TYPE_CHECKING = False  # true to type checkers, which know it by its name; `typing` would take as long as all the rest

if TYPE_CHECKING:  # a public name is a line here, one in __all__ and one in _HOMES; a test compares them
    from contarm_sim import envs as envs
    from contarm_sim import kinematics as kinematics
    from contarm_sim import mechanics as mechanics
    from contarm_sim import mjcf as mjcf
    from contarm_sim import paths as paths
    from contarm_sim import planning as planning
    from contarm_sim import studies as studies
    from contarm_sim import sweeps as sweeps
    from contarm_sim.control.base import Controller as Controller
    from contarm_sim.control.feedback import Feedback as Feedback
    from contarm_sim.control.feedback import Seen as Seen
    from contarm_sim.control.plan import Plan as Plan
    from contarm_sim.errors import ContarmError as ContarmError
    from contarm_sim.errors import DivergenceError as DivergenceError
    from contarm_sim.errors import EquilibriumError as EquilibriumError
    from contarm_sim.errors import InputError as InputError
    from contarm_sim.errors import Interrupted as Interrupted
    from contarm_sim.errors import InterruptedMany as InterruptedMany
    from contarm_sim.identify.excite import excite as excite
    from contarm_sim.identify.fit import fit as fit
    from contarm_sim.identify.fit_folder import load_fit as load_fit
    from contarm_sim.identify.freedom import Free as Free
    from contarm_sim.identify.recordings.file import load_recording as load_recording
    from contarm_sim.identify.recordings.recording import Recording as Recording
    from contarm_sim.identify.recordings.rig import Actuation as Actuation
    from contarm_sim.identify.recordings.rig import Marker as Marker
    from contarm_sim.identify.recordings.rig import Rig as Rig
    from contarm_sim.identify.recordings.saved import save_recording as save_recording
    from contarm_sim.identify.replays.covariance import covariance_of as covariance_of
    from contarm_sim.identify.replays.replay import replay as replay
    from contarm_sim.mjcf import arm_spec as arm_spec
    from contarm_sim.mjcf import scene_spec as scene_spec
    from contarm_sim.mjcf import spec as spec
    from contarm_sim.model import presets as presets
    from contarm_sim.model.arm import Arm as Arm
    from contarm_sim.model.arm_file import load_arm as load_arm
    from contarm_sim.model.host import Host as Host
    from contarm_sim.model.ideal import Ideal as Ideal
    from contarm_sim.model.load import Load as Load
    from contarm_sim.model.load import Muscles as Muscles
    from contarm_sim.model.load import Wrench as Wrench
    from contarm_sim.model.mckibben import McKibben as McKibben
    from contarm_sim.model.objects import Object as Object
    from contarm_sim.model.routing import Routing as Routing
    from contarm_sim.model.section import Section as Section
    from contarm_sim.model.tendon import Tendon as Tendon
    from contarm_sim.model.world import World as World
    from contarm_sim.motion.rest import poses_at_rest as poses_at_rest
    from contarm_sim.motion.simulate import simulate as simulate
    from contarm_sim.motion.simulate_many import simulate_many as simulate_many
    from contarm_sim.paths.reference import Reference as Reference
    from contarm_sim.results.compare import compare as compare
    from contarm_sim.results.run_folder import load as load
    from contarm_sim.results.trajectory import Trajectory as Trajectory
    from contarm_sim.statics.equilibria import equilibria as equilibria
    from contarm_sim.statics.equilibrium import equilibrium as equilibrium

    __version__: str

__all__ = [
    "Actuation", "Arm", "ContarmError", "Controller", "DivergenceError", "EquilibriumError", "Feedback", "Free",
    "Host", "Ideal", "InputError", "Interrupted", "InterruptedMany", "Load", "Marker", "McKibben", "Muscles",
    "Object", "Plan", "Recording", "Reference", "Rig", "Routing", "Section", "Seen", "Tendon", "Trajectory",
    "World", "Wrench",
    "arm_spec", "compare", "covariance_of", "envs", "equilibria", "equilibrium", "excite", "fit", "kinematics",
    "load", "load_arm", "load_fit", "load_recording", "mechanics", "mjcf", "paths", "planning", "poses_at_rest",
    "presets", "replay", "save_recording", "scene_spec", "simulate", "simulate_many", "spec", "studies", "sweeps",
]  # fmt: skip

_HOMES = {
    "Arm": "model.arm",
    "Host": "model.host",
    "Ideal": "model.ideal",
    "McKibben": "model.mckibben",
    "Object": "model.objects",
    "Tendon": "model.tendon",
    "Routing": "model.routing",
    "Section": "model.section",
    "World": "model.world",
    "load_arm": "model.arm_file",
    "ContarmError": "errors",
    "DivergenceError": "errors",
    "EquilibriumError": "errors",
    "InputError": "errors",
    "Interrupted": "errors",
    "InterruptedMany": "errors",
    "arm_spec": "mjcf",
    "scene_spec": "mjcf",
    "spec": "mjcf",
    "simulate": "motion.simulate",
    "simulate_many": "motion.simulate_many",
    "poses_at_rest": "motion.rest",
    "equilibria": "statics.equilibria",
    "equilibrium": "statics.equilibrium",
    "Load": "model.load",
    "Muscles": "model.load",
    "Wrench": "model.load",
    "Actuation": "identify.recordings.rig",
    "Marker": "identify.recordings.rig",
    "Rig": "identify.recordings.rig",
    "Free": "identify.freedom",
    "covariance_of": "identify.replays.covariance",
    "excite": "identify.excite",
    "fit": "identify.fit",
    "load_fit": "identify.fit_folder",
    "replay": "identify.replays.replay",
    "Recording": "identify.recordings.recording",
    "load_recording": "identify.recordings.file",
    "save_recording": "identify.recordings.saved",
    "compare": "results.compare",
    "load": "results.run_folder",
    "Reference": "paths.reference",
    "Trajectory": "results.trajectory",
    "Controller": "control.base",
    "Feedback": "control.feedback",
    "Plan": "control.plan",
    "Seen": "control.feedback",
}
_MODULES = {
    name: name for name in ("envs", "kinematics", "mechanics", "mjcf", "paths", "planning", "studies", "sweeps")
}
_MODULES["presets"] = "model.presets"

if not TYPE_CHECKING:  # to a type checker, a name that is not imported above does not exist

    def __getattr__(name):
        from importlib import import_module, metadata

        if name in _HOMES:
            return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
        if name in _MODULES:
            return import_module(f"{__name__}.{_MODULES[name]}")
        if name == "__version__":
            return metadata.version("contarm-sim")
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__():
        return sorted({*globals(), *__all__})
