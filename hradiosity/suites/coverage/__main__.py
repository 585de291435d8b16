"""``python -m hradiosity.suites.coverage``."""

import sys

from hradiosity.suites.coverage.command import main

if __name__ == "__main__":
    sys.exit(main())
