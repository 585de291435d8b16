"""``python -m hradiosity``."""

import sys

from hradiosity.cli import main

if __name__ == "__main__":
    sys.exit(main())
