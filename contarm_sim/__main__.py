"""`python -m contarm_sim`, and the entry point of `contarm`: small, so that an early Ctrl-C meets it."""

from __future__ import annotations

import signal
import sys


def main() -> None:
    """Run the command line."""
    try:
        from contarm_sim.cli.main import main as run

        run()
    except KeyboardInterrupt:
        sys.exit(130)
    finally:  # while Python takes itself apart, Ctrl-C is no longer worth a traceback
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, signal.SIG_DFL)


if __name__ == "__main__":
    main()
