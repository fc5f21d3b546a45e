"""``python -m humanoid_bt`` is the command line."""

import sys

from humanoid_bt.cli import main

if __name__ == "__main__":
    sys.exit(main())
