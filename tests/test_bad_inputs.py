"""Thousands of bad inputs, made from the parameters' own descriptions: each is one short line, and nothing is written.

What is damaged at random (seeded) may by chance still be right; then it must be read without complaint.
"""

import json

import numpy as np
from bad_inputs import HUGE, LONG, TINY, WRONG, damaged_at_random, parameters, refused, short
from references import along

from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import arm_from_dict, load_arm
from contarm_sim.model.load import Load, Muscles, Wrench, load_from_dict
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.template import arm_template
from contarm_sim.motion.simulate import simulate
from contarm_sim.paths.waypoints import read_csv
from contarm_sim.results.trajectory import ARRAYS, Trajectory


def _wrong_for(name, item):
    bounds = item.metadata.get("bounds")
    if bounds is not None:
        values = [*WRONG, *([] if item.default is None else [None])]
        return [*values, *TINY, *([0.0, 0] if bounds["above"] == 0 else [])]
    if "choices" in item.metadata:
        return [value for value in WRONG if not isinstance(value, np.ndarray)] + [None, "Parallel"]
    if name == "links":
        return [*WRONG, 0, 1, 401, 2.0, 24.5, -3, None]
    sized = [[1] * 2, [1] * 5, ["1"] * 3, ["1"] * 4, [True] * 3, [True] * 4, [HUGE] * 3, [1e10] * 4, "123", "1234", 0.0]
    return [*WRONG, *sized, *([] if item.default is None else [None])]


def _right(value, size):
    """Tell a sequence of as many numbers, which is right in some places; and empty ones of wrenches."""
    if not isinstance(value, (tuple, list, range, np.ndarray)) or np.shape(np.array(value, dtype=object)) != (size,):
        return False
    return all(isinstance(x, (int, float)) for x in value)


def test_constructors():
    cases = []
    for table, name, item in parameters():
        kind = Arm if not table or name == "path" else McKibben
        for value in _wrong_for(name, item):
            cases.append((f"{kind.__name__}({name}={short(value)})", lambda k=kind, n=name, v=value: k(**{n: v})))
    for name in ("xi", "force", "moment"):
        values = [v for v in WRONG if not (name == "xi" and isinstance(v, np.ndarray) and v.dtype.kind == "O")]
        cases += [(f"Wrench({name}={short(v)})", lambda n=name, v=v: Wrench(**{"xi": 1.0, n: v})) for v in values]
    cases += [(f"Wrench(force={v})", lambda v=v: Wrench(xi=1, force=v)) for v in ([1, "a", 2, 3], [1, 2], [1, 2, None])]
    for name in ("wrenches", "follower_moment", "actuation_moment", "muscles"):
        values = [v for v in WRONG if not _right(v, {"wrenches": 0, "actuation_moment": 2}.get(name, 3))]
        cases += [(f"Load({name}={short(v)})", lambda n=name, v=v: Load(**{n: v})) for v in values]
    cases += [(f"Muscles(kind={short(v)})", lambda v=v: Muscles(kind=v)) for v in WRONG]
    for kind in ("off", "deltas", "tensions", "pressures", "bend"):
        sizes = {"off": (0,), "bend": (2,)}.get(kind, (1, 2, 3000))  # the others: one for each muscle
        values = [v for v in WRONG if not any(_right(v, size) for size in sizes)]
        cases += [(f"Muscles({kind}, {short(v)})", lambda k=kind, v=v: Muscles(kind=k, values=v)) for v in values]
    count, failed = refused(cases)
    assert not failed, "\n".join(failed)
    assert count > 1000


def test_tables_of_parameters(tmp_path):
    """TOML: every key with every wrong text, unknown keys, and files damaged at random."""
    file = tmp_path / "arm.toml"
    texts = ['""', '"x"', '"1"', '"1 V"', '"3 m kg"', "true", "nan", "inf", "-inf", "1e300", "1" + "0" * 400, "[]",
             "[1]", '["1"]', "{}", "{a = 1}", "1979-05-27", "[[1], [2]]", f'"{LONG}"', "[1, 2, 3, 4, 5]",
             "", "1 2", "'''a\nb'''"]  # fmt: skip
    lines = [(table, name, text) for table, name, _ in parameters() for text in texts]
    lines += [("", name, "1") for name in ("lenght", '"a\\nb"', LONG, "muscle", "é")] + [("muscle", "lenght", "1")]

    def load(content):
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
        return load_arm(file)

    cases = [
        (f"[{t}] {n[:30]} = {x[:30]}", lambda c=f"[{t}]\n{n} = {x}" if t else f"{n} = {x}": load(c))
        for t, n, x in lines
    ]
    for depth in (100, 100_000):
        cases.append((f"{depth} brackets", lambda d=depth: load("a = " + "[" * d)))
    cases += [("too large", lambda: load("# " + "x" * 2**20)), ("binary", lambda: load(bytes(range(256))))]
    count, failed = refused(cases)
    assert not failed, "\n".join(failed)
    more, failed = refused(damaged_at_random(arm_template(Arm()).encode(), load, 500), made_by_chance=True)
    assert not failed, "\n".join(failed)
    assert count + more > 1000


def test_paths(tmp_path):
    file = tmp_path / "path.csv"

    def load(content):
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_csv(file)

    heads = [
        "x,y",
        "x,y,y,z",
        "a,b,c",
        "x y z",
        "x [s],y,z",
        "x [],y,z [kg]",
        "time,t,x,y,z",
        "x[mm],x[m],y,z",
        '"x\ny",y,z',
        LONG,
    ]
    cells = [
        "",
        "x",
        "nan",
        "inf",
        "-inf",
        "1e400",
        "1e10",
        LONG,
        "1 2",
        "0x1",
        "é",
        "1,2",
        '"1\n2"',
        "1;2",
        "--1",
        "1e",
        "True",
    ]
    cases = [(f"head {h[:20]!r}", lambda c=f"{h}\n0,0,1,0\n1,0,1,1\n": load(c)) for h in heads]
    for form in ("x,y,z\n0,0,0.3\n0,{},0.3\n", "t,x,y,z\n{},0,0,0.3\n", "0,0,0.3\n0,0.1,{}\n", "x [mm],y,z\n{},0,0\n"):
        cases += [(f"cell {c[:20]!r} in {form!r}", lambda f=form, c=c: load(f.format(c))) for c in cells]
    for form in ("x;y;z\n0;0;0.3\n0;{};0.3\n", "t\tx\ty\tz\n{}\t0\t0\t0,3\n"):
        cases += [
            (f"cell {c[:20]!r} in {form!r}", lambda f=form, c=c: load(f.format(c))) for c in cells if c not in ("1,2",)
        ]
    cases += [(f"binary {i}", lambda i=i: load(np.random.default_rng(i).bytes(200))) for i in range(50)]
    count, failed = refused(cases)
    assert not failed, "\n".join(failed)
    good = "t,x [mm],y [mm],z [mm]\n" + "".join(f"{i},{10 * i},0,300\n" for i in range(20))
    more, failed = refused(damaged_at_random(good.encode(), load, 400), made_by_chance=True)
    assert not failed, "\n".join(failed)
    assert count + more > 500


def test_load_cases():
    wrong = [v for v in WRONG if isinstance(v, (str, bool, float, int, list, dict, type(None)))] + [None]
    cases = [(f"case {short(v)}", lambda v=v: load_from_dict(v, "f")) for v in wrong if v != {}]
    for key in ("wrenches", "follower_moment", "actuation_moment", "muscles", "unknown", LONG, "a\nb"):
        values = [v for v in wrong if not (key == "wrenches" and v == [])]
        cases += [(f"{key[:20]}: {short(v)}", lambda k=key, v=v: load_from_dict({k: v}, "f")) for v in values]
    for key in ("gravity", "payload"):
        cases += [
            (f"{key}: {short(v)}", lambda k=key, v=v: arm_from_dict(load_from_dict({k: v}, "f")[1])) for v in wrong
        ]
    for key in ("xi", "force", "moment", "other"):
        for v in wrong:
            case = {"wrenches": [{"xi": 1} | {key: v}]}
            cases.append((f"wrench {key}: {short(v)}", lambda case=case: load_from_dict(case, "f")))
    for key in ("kind", "values", "other"):
        for v in wrong:
            case = {"muscles": {"kind": "bend"} | {key: v}}
            cases.append((f"muscles {key}: {short(v)}", lambda case=case: load_from_dict(case, "f")))
    count, failed = refused(cases)
    assert not failed, "\n".join(failed)
    assert count > 200


def test_recordings(tmp_path):
    """Every array replaced by every wrong one, and the file damaged at random."""
    arm, file = Arm(links=4), tmp_path / "t.npz"
    simulate(arm, along(arm, "circle", 0.1, max_bend=0.3)).save(file)
    whole = file.read_bytes()
    with np.load(file) as stored:
        good = dict(stored)

    def load(content):
        if isinstance(content, dict):
            np.savez(file, **content)
        else:
            file.write_bytes(content)
        return Trajectory.load(file)

    cases = []
    for name in (*ARRAYS, "step_error"):
        array = good[name].astype(float)
        longer = np.vstack([array, array])[:, :1] if array.ndim > 1 else np.tile(array, 2)
        bad = [array[:-1], array[None], array[..., :0], array.astype(str), array.astype(bool), array + 1j, longer,
               np.array(1.0), np.full(array.shape, -np.inf), array.astype("M8[s]"), np.zeros(0),
               np.full(array.shape, "x"), array.reshape(-1)[:-1]]  # fmt: skip
        if name not in ("step_error", "pressure"):
            bad += [np.full(array.shape, np.inf)]
        if name != "step_error":
            bad += [np.full(array.shape, np.nan)]
        cases += [(f"{name} {i}", lambda n=name, b=b: load(good | {n: b})) for i, b in enumerate(bad)]
        if name != "step_error":
            cases.append((f"without {name}", lambda n=name: load({k: v for k, v in good.items() if k != n})))
    cases += [("unknown", lambda: load(good | {"other": np.zeros(3)})), ("words", lambda: load(b"x" * 1000))]
    about = json.loads(str(good["about"]))
    for key in about:
        wrong = (HUGE, "x", [], {}, -1) if key not in ("versions", "controller", "actuation") else (HUGE, [], -1, 1.5)
        wrong = [
            v
            for v in wrong
            if not (key in ("timestep", "real_time_factor") and isinstance(v, int)) and not (key == "arm" and v == {})
        ]
        for v in wrong:
            changed = good | {"about": np.array(json.dumps(about | {key: v}))}
            cases.append((f"about {key} {short(v)}", lambda c=changed: load(c)))
    count, failed = refused(cases)
    assert not failed, "\n".join(failed)
    more, failed = refused(damaged_at_random(whole, load, 400), made_by_chance=True)
    assert not failed, "\n".join(failed)
    assert count + more > 500
