"""``python -m hradiosity.bench``: measure speed and accuracy, or compare two kept runs."""

import sys

from hradiosity.suites.bench.command import main

if __name__ == "__main__":
    sys.exit(main())
