"""What it costs to start: `import contarm_sim` and `contarm --help`, beside `python -c pass`.

Each is started in turn, many times, so that other work on the machine meets all of them alike; the quickest counts.
"""

import json
import subprocess
import sys
import time

COMMANDS = {
    "python": ["-c", "pass"],
    "import": ["-c", "import contarm_sim"],
    "arm": ["-c", "import contarm_sim; contarm_sim.Arm()"],
    "help": ["-m", "contarm_sim", "--help"],
}
ROUNDS = 20


def main():
    best = dict.fromkeys(COMMANDS, float("inf"))
    for _ in range(ROUNDS):
        for name, words in COMMANDS.items():
            start = time.perf_counter()
            subprocess.run([sys.executable, *words], check=True, stdout=subprocess.DEVNULL)
            best[name] = min(best[name], time.perf_counter() - start)
    found = {f"{name}_ms": round(1e3 * seconds, 1) for name, seconds in best.items()}
    found |= {f"{name}_over_python": round(best[name] / best["python"], 2) for name in COMMANDS if name != "python"}
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
