"""The grasp of `contarm demo grasp` with another log each time: mass, friction and start off by up to 20 %.

A grasp counts if all checks of the demonstration hold: lifted by 60 mm, carried by the arm alone, no slip over 5 mm, no
link deeper than 0.5 mm, put down within 5 mm. The start is off by up to 20 % of the log's radius in X, Y and Z.
"""

import sys
import time

from contarm_sim.demos import grasp
from contarm_sim.demos.grasp_script import grasp_arm

COUNT = int(sys.argv[1]) if len(sys.argv) > 1 else 20


def main():
    begin, held, worst = time.process_time(), 0, {}
    for seed in range(COUNT):
        checks = grasp.checks(grasp.run(grasp.varied(grasp_arm(), seed)))
        held += all(check.passed for check in checks)
        for check in checks:
            choose = min if check.least else max
            worst[check.what] = (choose(check.value, worst.get(check.what, (check.value,))[0]), check.unit)
        missed = ", ".join(check.what for check in checks if not check.passed)
        print(f"seed {seed:3d}: {'fails: ' + missed if missed else 'holds'}", flush=True)
    for what, (value, unit) in worst.items():
        print(f"{what:52} {value:10.3g} {unit:4} at worst")
    print(f"{held} of {COUNT} hold; {(time.process_time() - begin) / COUNT:.1f} s of processor time each")
    return held == COUNT


if __name__ == "__main__":
    sys.exit(not main())
