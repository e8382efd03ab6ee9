"""Run taskbuilder from a checkout: `python cli.py validate handover`."""

import sys

from taskbuilder.cli import main

if __name__ == "__main__":
    sys.exit(main())
