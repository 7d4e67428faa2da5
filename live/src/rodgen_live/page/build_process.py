"""Builder of a module in a process of its own, so that the caller stays responsive.

    python -m rodgen_live.page.build_process

It reads a pickled structure; afterwards its module is in the cache. Every stage is a line of
standard output. It can be ended by SIGTERM, and then ends its compiler.
"""

from __future__ import annotations

import pickle
import signal
import sys

from rodgen.emit.targets import STEPS, required_parts
from rodgen.errors import InputError
from rodgen.loading.build import build_fastest
from rodgen.native.library import BuildError
from rodgen.progress import report_stages_to

PARTS = (*required_parts("c"), *STEPS)  # of a module: what a run may ask for


def main() -> None:
    """Build the module of the structure that is read from standard input."""
    # As an exception it reaches whoever waits for the compiler, which has a session of its own; as
    # Ctrl-C, not before it is known which compiler was started.
    signal.signal(signal.SIGINT, signal.default_int_handler)  # of a server in the background: none
    signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
    structure = pickle.load(sys.stdin.buffer)
    try:
        with report_stages_to(lambda stage: print(stage, flush=True)):
            build_fastest(structure, PARTS)
    except KeyboardInterrupt:
        sys.exit("it was ended")
    except (BuildError, InputError) as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
