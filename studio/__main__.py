"""``quasiface`` and ``python -m studio``."""

from __future__ import annotations

import os
import sys
import warnings

from studio import cli


def main() -> int:
    """Run the command of this process and return its exit code."""
    # Scripts read stderr line by line: what goes wrong is told in our words, not in those of a library.
    os.environ.setdefault("OPENCV_LOG_LEVEL", "OFF")
    if not sys.warnoptions:
        warnings.simplefilter("ignore")
    return cli.main()


if __name__ == "__main__":
    sys.exit(main())
