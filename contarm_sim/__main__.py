"""`python -m contarm_sim`, and the entry point of `contarm`: small, so that an early Ctrl-C meets it."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line."""
    try:
        from contarm_sim.cli.main import main as run
    except KeyboardInterrupt:
        sys.exit(130)
    run()


if __name__ == "__main__":
    main()
