"""`python -m taskbuilder`."""

import sys

from taskbuilder.cli import main

if __name__ == "__main__":
    sys.exit(main())
